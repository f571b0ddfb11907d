//! Contacts of the ego: when its body and another's touch, at a step or between two, and where.
//!
//! Between two steps positions go evenly along straight lines and headings evenly the shorter way round: see
//! [`nearmiss_base::geometry::Sweep`]. What is touched only between two steps is touched all the same, unless it overlaps by no
//! more than the ways between the steps are uncertain: a recording tells nothing of motions faster than half its rate, and
//! evenly joined steps are off by up to π²/32 of the second difference of the steps around (a sine at that rate). Who
//! passes the other from one side to the opposite one passes through it at any speed: there only what is uncertain across
//! that direction counts, against how far they overlap across it.
//!
//! How hard they touch: [`super::impact`]. Velocities are those recorded; between two steps they change evenly.

use std::f64::consts::FRAC_PI_2;

use nearmiss_base::geometry::{Placed, Point, Pose, Sweep, Vector, angle_between};

use super::Context;
use super::context::BodyAtStep;
use super::impact::{DEEP, Impact, Striking};
use crate::scenario::{Motion, ObstacleType, Participant, Scene, driven_way};

/// The ego's body touches another one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The other's id.
    pub obstacle: i64,
    /// The first recorded step at or after the moment at which they touch.
    pub step: i64,
    /// That moment, seconds since time step 0.
    pub time: f64,
    /// Whether they still overlap at the step. Otherwise they touch only between it and the step before.
    pub overlaps: bool,
    /// Whether what is touched is a region that the obstacle may be in, of an occupancy set, and not its body.
    pub is_possible: bool,
    /// How hard they touch.
    pub impact: Impact,
    /// The ego at that moment.
    pub ego: Pose,
    /// The other at that moment.
    pub other: Pose,
}

impl Contact {
    /// What it is called: one with a region is possible.
    #[must_use]
    pub fn name(&self) -> &'static str {
        if self.is_possible {
            "possible contact"
        } else {
            "contact"
        }
    }

    /// The contact at a step or on the way to it from the step before, if there is one.
    #[must_use]
    pub fn at(scene: &Scene, other: &Participant<'_>, step: i64) -> Option<Self> {
        let there = |step| bodies(scene, other, step);
        let here = there(step)?;
        let steps = Steps::of(scene, other, step);
        steps.contact(&there, step.checked_sub(1).and_then(there), here)
    }

    /// The same in a simulated drive, whose bodies move between its steps as they are joined.
    #[must_use]
    pub fn in_drive(scene: &Scene, other: &Participant<'_>, step: i64) -> Option<Self> {
        let there = |step| bodies(scene, other, step);
        let steps = Steps {
            is_simulated: true,
            ..Steps::of(scene, other, step)
        };
        steps.contact(&there, step.checked_sub(1).and_then(there), there(step)?)
    }

    /// How far the bodies would overlap at most between a step and those before and after it, metres, where that is no
    /// contact: a recording does not tell the way between its steps so exactly.
    #[must_use]
    pub fn uncertain_overlap(scene: &Scene, other: &Participant<'_>, step: i64) -> Option<f64> {
        // Ways of a region that it may be in are no ways of a body.
        if other.obstacle.is_occupancy_at(step) {
            return None;
        }
        let overlaps = [step - 1, step].map(|step| Self::uncertain_after(scene, other, step));
        let deepest = overlaps.into_iter().flatten().reduce(f64::max);
        deepest.filter(|deepest| *deepest > 0.0)
    }

    fn uncertain_after(scene: &Scene, other: &Participant<'_>, step: i64) -> Option<f64> {
        if Self::at(scene, other, step + 1).is_some() {
            return None;
        }
        let before = bodies(scene, other, step)?;
        let here = bodies(scene, other, step + 1)?;
        let ways = ways(before, here, scene.scenario.dt())?;
        let share = ways[0].first_touch(&ways[1])?;
        Some(deepest_overlap(&ways, share))
    }

    /// The first contact of the recording with a participant.
    ///
    /// ```
    /// use nearmiss_formats::bundled;
    /// use nearmiss_scene::metrics::Contact;
    /// use nearmiss_scene::scenario::Scene;
    ///
    /// # let entry = &bundled()[0];
    /// # let scenario = entry.read()?;
    /// # let ego = entry.recorded_ego(&scenario)?.expect("recorded beside it");
    /// # let scene = Scene::new(scenario, ego);
    /// for contact in scene.participants().filter_map(|other| Contact::first(&scene, &other)) {
    ///     println!("{} at {:.2} s with {:.1} m/s", contact.obstacle, contact.time, contact.impact.closing_speed);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn first(scene: &Scene, other: &Participant<'_>) -> Option<Self> {
        scene.steps().find_map(|step| Self::at(scene, other, step))
    }
}

/// The ego and another at a step, where both are there.
fn bodies<'s>(
    scene: &'s Scene,
    other: &'s Participant<'_>,
    step: i64,
) -> Option<[BodyAtStep<'s>; 2]> {
    let ego = (scene.ego.track.at(step)?, scene.ego_footprint_at(step));
    Some([ego, (other.at(step)?, other.footprint_at(step))])
}

/// The ways of both from a step to the next one, so many seconds later; nothing where one jumps.
fn ways<'a>(
    before: [BodyAtStep<'a>; 2],
    here: [BodyAtStep<'a>; 2],
    dt: f64,
) -> Option<[Sweep<'a>; 2]> {
    let ([was, other_was], [ego, other]) = (before.map(placed), here.map(placed));
    Some([driven_way(was, ego, dt)?, driven_way(other_was, other, dt)?])
}

/// The deepest overlap on the ways from a share of them on, metres.
fn deepest_overlap(ways: &[Sweep<'_>; 2], share: f64) -> f64 {
    let overlap = |look: usize| {
        let share = share + (1.0 - share) * look as f64 / OVERLAP_SAMPLES as f64;
        ways[0].at(share).overlap(&ways[1].at(share))
    };
    (0..=OVERLAP_SAMPLES).map(overlap).fold(0.0, f64::max)
}

fn placed<'a>((motion, body): BodyAtStep<'a>) -> Placed<'a> {
    body.at(motion.pose)
}

/// Two neighbouring steps of the ego and another.
struct Steps {
    obstacle: i64,
    /// What both are.
    kinds: [ObstacleType; 2],
    /// Whether the obstacle is a region of an occupancy set at the later one.
    is_possible: bool,
    /// Whether nothing is uncertain between them.
    is_simulated: bool,
    /// The later one.
    step: i64,
    /// Seconds between them.
    dt: f64,
}

/// The ego and another at a step, where both are there.
type StateAtStep<'a> = dyn Fn(i64) -> Option<[BodyAtStep<'a>; 2]> + 'a;

/// A motion that a recording just tells is off between its steps by this share of the second difference: π²/32.
const UNCERTAIN: f64 = std::f64::consts::PI * std::f64::consts::PI / 32.0;

/// Looks for the deepest overlap on a way.
const OVERLAP_SAMPLES: usize = 32;

impl Steps {
    fn of(scene: &Scene, other: &Participant<'_>, step: i64) -> Self {
        Self {
            obstacle: other.obstacle.id,
            kinds: [scene.ego_kind(), other.obstacle.kind],
            is_possible: other.obstacle.is_occupancy_at(step),
            is_simulated: false,
            step,
            dt: scene.scenario.dt(),
        }
    }

    /// How far the place of the bodies between the two steps is uncertain where they touch, metres: in every direction, or
    /// along an axis.
    fn uncertainty(&self, there: &StateAtStep<'_>, axis: Option<Vector>) -> f64 {
        let around = [-1, 0].map(|offset| {
            let middle = self.step + offset;
            let (a, b, c) = (there(middle - 1)?, there(middle)?, there(middle + 1)?);
            let reach = b.map(|body| body.1.reach());
            let lever = b[1].0.pose.position - b[0].0.pose.position;
            Some([0, 1].map(|which| {
                let [a, b, c] = [&a, &b, &c].map(|bodies| bodies[which].0.pose);
                let position = (c.position - b.position) - (b.position - a.position);
                let turn =
                    angle_between(b.heading, c.heading) - angle_between(a.heading, b.heading);
                let (off, arm) = match axis {
                    None => (position.norm(), reach[which]),
                    // What turns moves across the line between the two.
                    Some(axis) => {
                        let arm = lever.perp(&axis).abs() + reach[0].min(reach[1]);
                        (position.dot(&axis).abs(), arm.min(reach[which]))
                    }
                };
                off + turn.abs() * arm
            }))
        });
        let most = |which: usize| {
            around
                .iter()
                .flatten()
                .map(|d| d[which])
                .fold(0.0, f64::max)
        };
        UNCERTAIN * (most(0) + most(1))
    }

    /// The contact at the later step or on the way there; who is already touched at the earlier one is touched at the
    /// later one only if the bodies overlap there.
    fn contact(
        &self,
        there: &StateAtStep<'_>,
        before: Option<[BodyAtStep<'_>; 2]>,
        here: [BodyAtStep<'_>; 2],
    ) -> Option<Contact> {
        let [ego, other] = here.map(placed);
        let reach = ego.footprint.reach() + other.footprint.reach();
        let near = (other.pose.position - ego.pose.position).norm() <= reach;
        let overlaps = near && ego.distance(&other) <= 0.0;
        let touch = before.and_then(|before| {
            let ways = ways(before, here, self.dt)?;
            let share = ways[0].first_touch(&ways[1]).filter(|share| *share > 0.0)?;
            let certain = overlaps || self.is_simulated || {
                let deepest = deepest_overlap(&ways, share);
                let is_at = |share| [ways[0].at(share), ways[1].at(share)];
                deepest > self.uncertainty(there, None)
                    || [0, 1].into_iter().any(|of| {
                        passes_through(of, is_at(0.0), is_at(share), is_at(1.0)).is_some_and(
                            |(across, beside)| across > self.uncertainty(there, Some(beside)),
                        )
                    })
            };
            certain.then_some((share, before))
        });
        if !overlaps && touch.is_none() {
            return None;
        }
        // Between the steps velocities change evenly, as the positions do.
        let (share, before) = touch.unwrap_or((1.0, here));
        let velocity = |which: usize| {
            let (was, is) = (before[which].0, here[which].0);
            let was = was.velocity_vector();
            was + (is.velocity_vector() - was) * share
        };
        let pose = |which: usize| {
            let (was, is): (&Motion, &Motion) = (before[which].0, here[which].0);
            was.pose.towards(&is.pose, share)
        };
        let deep = (share + DEEP).min(1.0);
        let striking = |which: usize| {
            let body = if deep < 0.5 {
                before[which].1
            } else {
                here[which].1
            };
            let (was, is) = (before[which].0.pose, here[which].0.pose);
            let turn = angle_between(was.heading, is.heading);
            // A larger turn within a step is a flip of the heading.
            let turned = if turn.abs() > FRAC_PI_2 { 0.0 } else { turn };
            Striking {
                body: body.at(was.towards(&is, deep)),
                velocity: velocity(which),
                turning: turned / self.dt,
                kind: self.kinds[which],
            }
        };
        Some(Contact {
            obstacle: self.obstacle,
            step: self.step,
            time: (self.step as f64 - (1.0 - share)) * self.dt,
            overlaps,
            is_possible: self.is_possible,
            impact: Impact::between(&[striking(0), striking(1)]),
            ego: pose(0),
            other: pose(1),
        })
    }
}

/// How far the bodies overlap across the direction in which one passes the other from one side to the opposite one,
/// metres, and that axis; nothing where it does not pass. However its speed changes on the way, it passes through the other.
/// The sides are those of the body with the given place: a body that turns in place may pass another one, too.
fn passes_through(
    of: usize,
    before: [Placed<'_>; 2],
    touching: [Placed<'_>; 2],
    after: [Placed<'_>; 2],
) -> Option<(f64, Vector)> {
    let touched = touching[of].pose;
    let [before, touching, after] = [before, touching, after].map(|bodies| {
        let frame = bodies[of].pose;
        bodies.map(|body| body.footprint.at(local(&frame, &body.pose)))
    });
    let apart = |[ego, other]: &[Placed<'_>; 2]| other.pose.position - ego.pose.position;
    let along = (apart(&after) - apart(&before)).try_normalize(1e-6)?;
    let across = Vector::new(-along.y, along.x);
    // How far the other is behind the ego along an axis, and before it.
    let between = |bodies: &[Placed<'_>; 2], axis: &Vector| {
        let extents = bodies.each_ref();
        let [ego, other] = extents.map(|body| body.extent(&Point::origin(), axis));
        (ego.0 - other.1, other.0 - ego.1)
    };
    let passes = between(&before, &along).0 > 0.0 && between(&after, &along).1 > 0.0;
    let (one, other) = between(&touching, &across);
    let axis = touched.forward() * across.x + touched.left() * across.y;
    passes.then_some((-one.max(other), axis))
}

/// A pose of the world in the frame of another.
fn local(frame: &Pose, pose: &Pose) -> Pose {
    Pose {
        position: frame.to_local(&pose.position),
        heading: pose.heading - frame.heading,
    }
}

impl Context<'_> {
    /// The contacts with the participant at a place of [`Self::participants`], one for each step at which or on the
    /// way to which the bodies touch, in order of time.
    #[must_use]
    pub fn contacts(&self, participant: usize) -> &[Contact] {
        self.pair(participant).contacts.get_or_init(|| {
            let other = &self.participants()[participant];
            let there = |step: i64| {
                let index = self.index(step)?;
                Some([self.ego[index]?, self.other(participant, index)?])
            };
            let mut before = None;
            let contact = |index: usize| {
                let here = there(self.step(index));
                let before = std::mem::replace(&mut before, here);
                Steps::of(self.scene, other, self.step(index)).contact(&there, before, here?)
            };
            (0..self.length()).filter_map(contact).collect()
        })
    }

    /// The contact at a place of a step or on the way to it.
    pub(super) fn contact_at(&self, participant: usize, index: usize) -> Option<&Contact> {
        let all = self.contacts(participant);
        let found = all.binary_search_by_key(&self.step(index), |contact| contact.step);
        found.ok().map(|place| &all[place])
    }
}
