//! Severity: which moment of a recording matters, and how much. The workbench, `--at worst`, the list, figures and
//! `find` all go by it.
//!
//! A moment is graded by what happened, then by what would have happened, and only then by how near it was. From the
//! most severe grade to the least:
//!
//! 0. **contact**: the bodies touch; the harder first, by closing speed (Shelby 2011).
//! 1. **conflict**: a course that ends in contact within 3 s unless one reacts and then brakes with 3.4 m/s² or more (both
//!    limits: surrogate safety measures device of SUMO); the harder braking first.
//! 2. **near miss**: one crosses the other's path or cuts in within 1 s or 1 m; the closer first.
//! 3. **course**: a course that ends in contact within 3 s; the harder braking first.
//! 4. **later**: a course that ends in contact within 5 s (our own limit), the sooner first; then who crosses or cuts in
//!    within 2 s (SUMO's limit of the post-encroachment time); the closer first.
//! 5. **none** of these, in this order: a course that ends in contact within 10 s, the sooner first; one that follows
//!    the other; bodies that would touch on straight lines where neither road nor drive goes; the nearest that moves; who
//!    stands.
//!
//! A *course* is what both bodies do with the speeds of the moment. Where they also touch if both keep to their place
//! across the ego's road, and where there is no road, it is straight on, headings kept ([`super::plane`]);
//! else it is along the way that they drove ([`course`]), where that leads to contact: round a bend to who drives
//! ahead, and to others where they are on a straight course, too, and do not stop before it with the braking of the
//! moment. So oncoming traffic that follows its own lane round a bend is on no course, and neither is what is parked
//! beside it. The braking that a course needs is Δv / 2(t − r) of bodies that close with Δv and touch after t, the
//! deceleration rate to avoid a crash (Almqvist et al. 1991) after a reaction r (MDRAC of SUMO): 1 s, but
//! at most t / 2. So of two courses that need the same braking at once, the one with less time is graver. A *crossing*
//! has a post-encroachment time (Allen 1978) and directions at least 30° apart, or would be a contact if one did not
//! stop within a metre of the other's way. A *cut-in* comes to overlap the other across the road; it passes closely by
//! the time that the one behind needs for the gap. Traffic that stands, is parked or passes in its own lane is not
//! severe for being near.

mod course;
mod moment;

use std::cell::OnceCell;

use super::{Context, Encounter, plane};
use course::{Course, DrivenPath};
use nearmiss_base::geometry::Vector;

pub use moment::{CriticalMoment, Grade, Hazard, SEVERITY_NAMES};

/// A course within this time and with at least this braking is a conflict, seconds and m/s².
const CONFLICT: (f64, f64) = (3.0, 3.4);

/// Who passes within this is near, seconds or metres.
const NEAR_MISS: f64 = 1.0;

/// A course within this time is worth a look, seconds.
const HORIZON: f64 = 5.0;

/// Who passes later than this is no danger, seconds.
const LATEST_PASS: f64 = 2.0;

/// What is slower stands, m/s.
const STANDING: f64 = 0.5;

/// The most severe moment with each obstacle, the most severe first; obstacles that are never there with the ego have
/// none.
#[must_use]
pub fn critical_moments(context: &Context<'_>) -> Vec<CriticalMoment> {
    let moments = Moments::new(context);
    let participants = 0..context.participants().len();
    let worst = participants.filter_map(|participant| {
        let pair = moments.with(participant);
        // Before the first contact nothing is worked out.
        match context.contacts(participant).first() {
            Some(contact) => pair.at(contact.step),
            None => pair.worst(context.steps()),
        }
    });
    let mut all: Vec<_> = worst.collect();
    all.sort_by(CriticalMoment::compare);
    all
}

/// The moments of a recording, obstacle by obstacle and step by step.
#[derive(Debug)]
pub struct Moments<'c, 's> {
    context: &'c Context<'s>,
    ego: DrivenPath,
}

impl<'c, 's> Moments<'c, 's> {
    /// Those of the ego of a context.
    #[must_use]
    pub fn new(context: &'c Context<'s>) -> Self {
        let ego = &context.scene().ego.track;
        Self {
            context,
            ego: DrivenPath::from_motions(ego.iter().map(|(step, motion)| (step, *motion))),
        }
    }

    /// Those with the participant at a place of [`Context::participants`].
    #[must_use]
    pub fn with(&self, participant: usize) -> PairMoments<'_, 's> {
        let motions = self.context.motions(participant);
        PairMoments {
            pair: PairPaths {
                context: self.context,
                participant,
                ego: &self.ego,
                other: DrivenPath::from_motions(motions.iter().copied()),
            },
            passes: OnceCell::new(),
        }
    }
}

/// The moments of the ego with one obstacle.
#[derive(Debug)]
pub struct PairMoments<'c, 's> {
    pair: PairPaths<'c, 's>,
    /// What passed closely in the whole recording.
    passes: OnceCell<Vec<Graded>>,
}

impl PairMoments<'_, '_> {
    /// How severe a step is; nothing where one of the two is not there.
    #[must_use]
    pub fn at(&self, step: i64) -> Option<CriticalMoment> {
        let pair = &self.pair;
        let context = pair.context;
        let other = context.participants()[pair.participant].obstacle;
        let encounter = context.encounter(pair.participant, step)?;
        let moment = |(step, grade, order, hazard)| CriticalMoment {
            obstacle: other.id,
            step,
            grade,
            hazard,
            order,
        };
        if let Some(contact) = encounter.contact() {
            let hazard = Hazard::Contact {
                closing_speed: contact.closing_speed,
                is_possible: contact.is_possible,
            };
            // Bodies that touch before regions that do, which have no speed.
            let order = if contact.is_possible {
                contact.time
            } else {
                -contact.closing_speed
            };
            return Some(moment((step, Grade::Contact, order, hazard)));
        }
        let metres = encounter.distance();
        let (grade, order) = pair.nearness(&encounter);
        let near = moment((step, grade, order, Hazard::Near { metres }));
        // A region has no course.
        let course = (!encounter.is_with_occupancy())
            .then(|| pair.graded(&encounter, step))
            .flatten()
            .map(|(grade, order, course)| {
                let hazard = Hazard::Course {
                    seconds: course.seconds,
                    braking: course.braking(),
                };
                moment((step, grade, order, hazard))
            });
        let passes = self.passes().iter().filter(|pass| pass.0 == step);
        let others = course.into_iter().chain(passes.copied().map(moment));
        others.chain([near]).min_by(CriticalMoment::compare)
    }

    /// The moment that matters of these steps, which are in the order of time, see [`CriticalMoment::precedes`].
    #[must_use]
    pub fn worst(&self, steps: impl Iterator<Item = i64>) -> Option<CriticalMoment> {
        let mut worst: Option<CriticalMoment> = None;
        for moment in steps.filter_map(|step| self.at(step)) {
            if moment.grade == Grade::Contact {
                return Some(moment);
            }
            if worst.is_none_or(|worst| moment.precedes(&worst)) {
                worst = Some(moment);
            }
        }
        worst
    }

    fn passes(&self) -> &[Graded] {
        self.passes.get_or_init(|| {
            let pair = &self.pair;
            let other = pair.context.participants()[pair.participant].obstacle;
            if other.is_set_based() {
                Vec::new()
            } else {
                moment::passes(pair)
            }
        })
    }
}

/// What a moment is graded as: step, grade, order in it, why.
type Graded = (i64, Grade, f64, Hazard);

/// The ego and another over the whole recording.
#[derive(Debug)]
struct PairPaths<'c, 's> {
    context: &'c Context<'s>,
    participant: usize,
    ego: &'c DrivenPath,
    other: DrivenPath,
}

impl PairPaths<'_, '_> {
    /// The course that both are on, with its grade and its order in it; nothing where they are on none.
    fn graded(&self, encounter: &Encounter<'_>, step: i64) -> Option<(Grade, f64, Course)> {
        let velocities = [encounter.ego, encounter.other].map(|motion| motion.velocity_vector());
        let straight = (plane::TIME_TO_COLLISION.compute)(encounter)
            .value()
            .map(|seconds| Course {
                seconds,
                closing_speed: (velocities[1] - velocities[0]).norm(),
                crosses: false,
            });
        if let Some(straight) = straight
            && (self.without_road() || self.keep_to_their_place(step))
        {
            return Some(Self::as_they_go(straight));
        }
        // Along their ways bodies meet later than straight on, or earlier.
        let driven = course::meet(self.ego, &self.other, encounter, step);
        match (straight, driven) {
            (Some(_), Some(driven)) => Some(Self::as_they_go(driven)),
            // Who drives up to another in a bend is on no straight course.
            (None, Some(driven)) if !driven.crosses => Some(Self::as_they_go(driven)),
            // They come after those that are straight.
            (None, Some(driven)) => {
                Some((Grade::LaterCourse, plane::HORIZON + driven.seconds, driven))
            }
            (Some(straight), None) if encounter.other.velocity.abs() >= STANDING => {
                Some((Grade::StraightCourse, -straight.braking(), straight))
            }
            (_, None) => None,
        }
    }

    /// The grade of a course that ends in contact as both go.
    fn as_they_go(course: Course) -> (Grade, f64, Course) {
        let (soon, hard) = CONFLICT;
        let grade = match course.seconds {
            seconds if seconds <= soon && course.braking() >= hard => Grade::Conflict,
            seconds if seconds <= soon => Grade::Course,
            seconds if seconds <= HORIZON => Grade::Ahead,
            _ => Grade::LaterCourse,
        };
        let order = match grade {
            Grade::Ahead | Grade::LaterCourse => course.seconds,
            _ => -course.braking(),
        };
        (grade, order, course)
    }

    /// Where there are no lanes nothing speaks against a straight course.
    fn without_road(&self) -> bool {
        self.context.scene().scenario.network.lanelets.is_empty()
    }

    /// Whether both touch if each keeps its speed along the ego's road and its place across it.
    fn keep_to_their_place(&self, step: i64) -> bool {
        let Some(index) = self.context.index(step) else {
            return false;
        };
        let along = self.context.along(self.participant, index);
        let (Ok(ego), Ok(other)) = (self.context.ego_along(index), along) else {
            return false;
        };
        let closing = ego.velocity.x - other.velocity.x;
        let closes = if other.rear >= ego.front {
            closing > 0.0
        } else {
            ego.rear >= other.front && closing < 0.0
        };
        closes && ego.clearance(&other) == 0.0
    }

    /// The grade of being near and nothing else, and the order in it.
    fn nearness(&self, encounter: &Encounter<'_>) -> (Grade, f64) {
        let metres = encounter.distance();
        let speeds = [encounter.ego, encounter.other].map(|motion| motion.velocity.abs());
        if self.context.stands(self.participant) || speeds[1] < STANDING {
            return (Grade::Standing, metres);
        }
        let [ego, other] = [encounter.ego, encounter.other].map(|motion| motion.pose.forward());
        let relation = encounter.relation();
        let overlap = relation.gap_lat == 0.0 && relation.gap_long != 0.0;
        let behind = if relation.gap_long > 0.0 {
            speeds[0]
        } else {
            speeds[1]
        };
        if overlap && same_direction(&ego, &other) && behind >= STANDING {
            return (Grade::Following, metres / behind);
        }
        (Grade::Near, metres)
    }
}

/// Directions less than 30° apart are the same.
fn same_direction(a: &Vector, b: &Vector) -> bool {
    const COS_30: f64 = 0.866_025_403_784_438_6;
    a.dot(b) > COS_30 * a.norm() * b.norm()
}
