//! One change on its way through the gate: shared input of all checks, other obstacles, and the findings.

use std::ops::ControlFlow;

use nearmiss_base::geometry::{Footprint, Placed, Point, Pose, Sweep, angle_between};
use nearmiss_scene::scenario::{
    Motion, Obstacle, ObstacleRole, Prediction, Scenario, Steps, driven_way,
};

use super::{Gate, checks};
use crate::generation::{Capability, Change, Refusal};

/// Continues, or ends at the first refusal.
pub(super) type Flow = ControlFlow<()>;

/// Numbers that differ by less are the same: what is left when coordinates of maps are added up in another order.
const NUMBER_TOLERANCE: f64 = 1e-9;

/// The share of a limit by which it may be exceeded, as in [`crate::planner::Tolerance`].
pub(super) const SHARE: f64 = 1e-4;

/// Findings so far.
#[derive(Debug)]
pub(super) struct Findings {
    /// Refusals of the change.
    pub refusals: Vec<Refusal>,
    /// Violations in the recording.
    pub recording: Vec<Refusal>,
    stop: bool,
}

impl Findings {
    pub fn new(stop: bool) -> Self {
        Self {
            refusals: Vec::new(),
            recording: Vec::new(),
            stop,
        }
    }

    /// Whether to report what is `exempt`: a search over thousands of motions does not need what the recording breaks.
    pub fn asks(&self, exempt: bool) -> bool {
        !(exempt && self.stop)
    }

    /// Keeps a refusal; of what is `exempt` as the recording's.
    pub fn say(&mut self, exempt: bool, refusal: Refusal) -> Flow {
        if exempt {
            if self.asks(exempt) {
                self.recording.push(refusal);
            }
            return Flow::Continue(());
        }
        self.refusals.push(refusal);
        if self.stop {
            Flow::Break(())
        } else {
            Flow::Continue(())
        }
    }
}

/// A change, its obstacle, and that obstacle's limits.
#[derive(Debug)]
pub(super) struct Run<'a> {
    pub gate: &'a Gate<'a>,
    /// The scenario with the other changed motions, if there are some.
    pub around: &'a Scenario,
    pub obstacle: &'a Obstacle,
    pub footprint: &'a Footprint,
    pub can: Capability,
    /// The changed motion, with finite numbers only.
    pub motions: &'a [(i64, Motion)],
    /// Which of its states are left as recorded.
    kept: Vec<bool>,
    /// The step of the contact with the ego.
    pub contact: Option<i64>,
}

/// A step from one changed state to the next: that before and that after.
#[derive(Debug, Clone, Copy)]
pub(super) struct Transition<'a> {
    /// Place of its first state.
    pub place: usize,
    /// Time step of its first state.
    pub step: i64,
    pub from: &'a Motion,
    pub to: &'a Motion,
}

impl Transition<'_> {
    /// m/s².
    pub fn acceleration(&self, dt: f64) -> f64 {
        (self.to.velocity - self.from.velocity) / dt
    }

    /// How far the heading turns, radians.
    pub fn turned(&self) -> f64 {
        angle_between(self.from.pose.heading, self.to.pose.heading)
    }
}

impl<'a> Run<'a> {
    /// Nothing where there is nothing that more could be asked of; the refusals say why.
    pub fn begin(
        gate: &'a Gate<'a>,
        change: &'a Change,
        around: &'a Scenario,
        contact: Option<i64>,
        found: &mut Findings,
    ) -> Option<Self> {
        let (obstacle, footprint, can) = match checks::who(gate.scenario, gate.style, change) {
            Ok(who) => who,
            Err(refusal) => {
                let _ = found.say(false, refusal);
                return None;
            }
        };
        let motions = change.motions.as_slice();
        if checks::is_no_motion(motions, found).is_break() || !found.refusals.is_empty() {
            return None;
        }
        // The first state is the recorded one, whatever acceleration the change continues with.
        let kept = motions.iter().enumerate().map(|(place, (step, motion))| {
            let alike = if place == 0 { is_placed_alike } else { same };
            obstacle.track().at(*step).is_some_and(|r| alike(r, motion))
        });
        Some(Self {
            gate,
            around,
            obstacle,
            footprint,
            can,
            motions,
            kept: kept.collect(),
            contact,
        })
    }

    /// Every check, the cheap ones first.
    pub fn all(&self, found: &mut Findings) -> Flow {
        self.start(found)?;
        self.gaps(found)?;
        self.rolling(found)?;
        self.joint_steering(found)?;
        self.overlaps(found)?;
        self.kinematics(found)?;
        self.road(found)
    }

    pub fn dt(&self) -> f64 {
        self.gate.scenario.dt()
    }

    /// Whether the state at a place is the recorded one.
    pub fn is_kept(&self, place: usize) -> bool {
        self.kept.get(place).copied().unwrap_or(false)
    }

    /// Whether the step from the state at a place to the next is left as recorded.
    pub fn is_exempt(&self, place: usize) -> bool {
        self.is_kept(place) && self.is_kept(place + 1)
    }

    /// The place of the first changed state.
    pub fn first_changed(&self) -> Option<usize> {
        self.kept.iter().position(|kept| !kept)
    }

    /// The steps from each state to the next, without gaps.
    pub fn ways(&self) -> impl Iterator<Item = Transition<'a>> {
        let pairs = self.motions.windows(2).enumerate();
        pairs.filter_map(|(place, pair)| {
            let (step, next) = (pair[0].0, pair[1].0);
            (step.checked_add(1) == Some(next)).then_some(Transition {
                place,
                step,
                from: &pair[0].1,
                to: &pair[1].1,
            })
        })
    }

    /// Steps that count, and steps that are exempt.
    pub fn steps(&self) -> (usize, usize) {
        let all = self.ways().count();
        let exempt = self.ways().filter(|way| self.is_exempt(way.place)).count();
        (all - exempt, exempt)
    }

    /// The largest share of the friction circle that a changed step uses.
    pub fn friction(&self) -> f64 {
        let dt = self.dt();
        let share = |way: Transition<'_>| {
            let across = f64::midpoint(way.from.velocity, way.to.velocity) * way.turned() / dt;
            way.acceleration(dt).hypot(across) / self.can.limits.acceleration
        };
        let changed = self.ways().filter(|way| !self.is_exempt(way.place));
        changed.map(share).fold(0.0, f64::max)
    }

    /// Steps by which it ends before the recording.
    pub fn early(&self) -> i64 {
        let last = self.motions.last().map_or(0, |(step, _)| *step);
        let recorded = self.obstacle.track().steps().end - 1;
        recorded.saturating_sub(last).max(0)
    }
}

/// Whether two motions are the same: place, heading, speed and acceleration.
pub(super) fn same(a: &Motion, b: &Motion) -> bool {
    is_placed_alike(a, b) && (a.acceleration - b.acceleration).abs() <= NUMBER_TOLERANCE
}

/// Whether place, heading and speed are the same.
fn is_placed_alike(a: &Motion, b: &Motion) -> bool {
    let mut differences = a.differences(b).into_iter();
    differences.all(|(_, difference)| difference <= NUMBER_TOLERANCE)
}

/// Largest difference between two numbers that should be equal.
pub(super) const MOST_DIFFERENT: f64 = NUMBER_TOLERANCE;

/// A region in which an obstacle is for a while.
#[derive(Debug, Clone)]
struct Region {
    obstacle: i64,
    time: Steps,
    body: Footprint,
    middle: Point,
    reach: f64,
}

/// The regions of all obstacles that have some.
#[derive(Debug, Clone)]
pub(in crate::generation) struct Regions(Vec<Region>);

impl Regions {
    /// Those of a scenario; regions that enclose nothing are left out.
    pub fn new(scenario: &Scenario) -> Self {
        let mut regions = Vec::new();
        for obstacle in &scenario.obstacles {
            let Prediction::Occupancies(occupancies) = &obstacle.prediction else {
                continue;
            };
            for occupancy in occupancies {
                let Ok(body) = Footprint::new(occupancy.region.clone()) else {
                    continue;
                };
                let corners = body.corners();
                let sum = corners.iter().fold(Point::origin(), |s, p| s + p.coords);
                let middle = sum / corners.len().max(1) as f64;
                let reach = corners.iter().map(|p| (p - middle).norm());
                regions.push(Region {
                    obstacle: obstacle.id,
                    time: occupancy.time,
                    reach: reach.fold(0.0, f64::max),
                    middle,
                    body,
                });
            }
        }
        Self(regions)
    }

    fn overlapped<'s>(&'s self, body: &'s Placed<'_>, step: i64) -> impl Iterator<Item = i64> + 's {
        let there = self.0.iter().filter(move |r| {
            (r.time.from..=r.time.to).contains(&step)
                && (r.middle - body.pose.position).norm() <= r.reach + body.footprint.reach()
        });
        let here = Pose::new(0.0, 0.0, 0.0);
        let hit = there.filter(move |r| body.distance(&r.body.at(here)) <= 0.0);
        hit.map(|r| r.obstacle)
    }
}

/// Whether two bodies overlap or touch: exact distance 0.
pub(super) fn touch(a: &Placed<'_>, b: &Placed<'_>) -> bool {
    let far = a.footprint.reach() + b.footprint.reach();
    (a.pose.position - b.pose.position).norm_squared() <= far * far && a.distance(b) <= 0.0
}

/// The obstacles that a body touches at a step or on the way there from where it was a step before, without itself.
pub(in crate::generation) fn overlapped<'s>(
    scenario: &'s Scenario,
    regions: &'s Regions,
    before: Option<Placed<'s>>,
    body: &'s Placed<'_>,
    itself: i64,
    step: i64,
) -> impl Iterator<Item = i64> + 's {
    let others = scenario
        .obstacles
        .iter()
        .filter(move |o| {
            matches!(o.role, ObstacleRole::Static | ObstacleRole::Dynamic) && o.id != itself
        })
        .filter(move |o| !o.is_occupancy_at(step));
    let way = before.map(|before| Sweep::new(before, *body));
    let on_the_way = move |other: &Obstacle, there: Placed<'_>| {
        let before = other.placed_at(step.checked_sub(1)?)?;
        let touch = way?.first_touch(&driven_way(before, there, scenario.dt())?)?;
        (touch > 0.0).then_some(touch)
    };
    let bodies = others.filter(move |o| {
        o.placed_at(step)
            .is_some_and(|p| touch(body, &p) || on_the_way(o, p).is_some())
    });
    let regions = regions.overlapped(body, step);
    bodies
        .map(|o| o.id)
        .chain(regions.filter(move |id| *id != itself))
}
