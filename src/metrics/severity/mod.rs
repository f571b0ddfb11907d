//! Severity: which moment of a recording matters, and how much. The workbench, `--at worst`, the list, figures and
//! `find` all go by it.
//!
//! A moment is graded by what happened, then by what would have happened, and only then by how near it was. From the
//! most severe grade to the least:
//!
//! 0. **contact**: the bodies touch; the harder first, by closing speed (Shelby 2011).
//! 1. **conflict**: a course that ends in contact within 3 s unless somebody brakes with 3 m/s² or more (both limits:
//!    surrogate safety measures device of SUMO); the harder braking first.
//! 2. **near miss**: one crosses the other's path or cuts in within 1 s or 1 m; the closer first.
//! 3. **course**: a course that ends in contact within 3 s; the harder braking first.
//! 4. **ahead**: a course that ends in contact within 5 s (our own limit), the sooner first; then a **pass**: one crosses
//!    or cuts in within 2 s (SUMO's limit of the post-encroachment time); the closer first.
//! 5. nothing of note, in this order: a course that ends in contact within 10 s, the sooner first; bodies that would touch
//!    on straight lines where neither road nor drive goes; one that follows the other; the nearest that moves; who stands.
//!
//! A *course* is what both bodies do with the speeds of the moment, headings kept ([`super::time_to_collision`]), where
//! the road bears it out: they touch also if both keep to the way that they drove ([`course`]) or to their place across
//! the ego's road. So oncoming traffic that follows its own lane round a bend is on no course, and neither is what is
//! parked beside it. The braking that a course needs is Δv / 2t, the deceleration rate to avoid a crash (Almqvist et al.
//! 1991) of bodies that close with Δv and touch after t. A *crossing* has a post-encroachment time (Allen 1978) and
//! directions at least 30° apart, or would be a contact if one did not stop within a metre of the other's way. A *cut-in*
//! comes to overlap the other across the road; it passes closely by the time that the one behind needs for the gap.
//! Traffic that stands, is parked or passes in its own lane is not severe for being near.

mod course;
mod pass;

use std::cmp::Ordering;
use std::fmt;

use super::{Context, Encounter, time_to_collision};
use crate::geometry::Vector;
use course::{Course, DrivenPath};

/// What makes a moment matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hazard {
    /// The bodies touch.
    Contact {
        /// The speed of one relative to the other, m/s.
        closing_speed: f64,
        /// Whether what is touched is a region that the obstacle may be in, and not its body.
        is_possible: bool,
    },
    /// Both are on courses that end in contact.
    Course {
        /// Time to contact, seconds.
        seconds: f64,
        /// The braking that avoids it, m/s².
        braking: f64,
    },
    /// One crosses the path of the other.
    Crossing {
        /// Post-encroachment time, seconds; nothing where one waits for the other.
        seconds: Option<f64>,
        /// Their smallest distance, metres.
        metres: f64,
    },
    /// One comes before the other.
    CutIn {
        /// The time that the one behind needs for the gap, seconds.
        seconds: f64,
        /// The gap, metres.
        metres: f64,
    },
    /// Nothing but near.
    Near {
        /// Their distance, metres.
        metres: f64,
    },
}

impl fmt::Display for Hazard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Contact {
                is_possible: true, ..
            } => write!(f, "possible contact with a predicted occupancy"),
            Self::Contact { closing_speed, .. } => write!(f, "contact at {closing_speed:.1} m/s"),
            Self::Course { seconds, braking } => {
                write!(
                    f,
                    "contact in {seconds:.1} s as they go; avoided with {braking:.1} m/s²"
                )
            }
            Self::Crossing {
                seconds: Some(seconds),
                metres,
            } => write!(f, "crosses {seconds:.1} s apart, {metres:.1} m"),
            Self::Crossing { metres, .. } => write!(f, "crosses {metres:.1} m apart"),
            Self::CutIn { seconds, metres } => {
                write!(f, "cuts in {seconds:.1} s, {metres:.1} m ahead")
            }
            Self::Near { metres } => write!(f, "nearest, {metres:.1} m"),
        }
    }
}

/// How severe a moment is. The less, the more severe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Grade {
    /// The bodies touch.
    Contact,
    /// On a course to contact that takes hard braking soon.
    Conflict,
    /// A crossing or cut-in within a second or a metre.
    NearMiss,
    /// On a course to contact within 3 s.
    Course,
    /// On a course to contact within 5 s.
    Ahead,
    /// A crossing or cut-in within 2 s.
    Pass,
    /// On a course to contact within 10 s.
    LaterCourse,
    /// Straight on there would be contact, but that is not where the road goes.
    StraightCourse,
    /// One follows the other.
    Following,
    /// Near, and at least one moves.
    Near,
    /// Both stand, or the other is parked.
    Standing,
}

impl Grade {
    /// The severity as a number, 0 (contact) to 5 (nothing of note).
    #[must_use]
    pub fn number(self) -> u8 {
        match self {
            Self::Contact => 0,
            Self::Conflict => 1,
            Self::NearMiss => 2,
            Self::Course => 3,
            Self::Ahead | Self::Pass => 4,
            Self::LaterCourse
            | Self::StraightCourse
            | Self::Following
            | Self::Near
            | Self::Standing => 5,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Conflict => "conflict",
            Self::NearMiss => "near miss",
            Self::Course => "course",
            Self::Ahead => "ahead",
            Self::Pass => "pass",
            Self::LaterCourse
            | Self::StraightCourse
            | Self::Following
            | Self::Near
            | Self::Standing => "none",
        }
    }
}

/// The most severe moment with one obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CriticalMoment {
    /// The obstacle.
    pub obstacle: i64,
    /// The step.
    pub step: i64,
    /// How severe it is.
    pub grade: Grade,
    /// Why.
    pub hazard: Hazard,
    /// The less, the more severe among those of the same grade.
    order: f64,
}

impl CriticalMoment {
    /// The more severe one first; of two alike in a recording the earlier.
    #[must_use]
    pub fn compare(&self, other: &Self) -> Ordering {
        self.compare_across(other).then(self.step.cmp(&other.step))
    }

    /// The more severe one first, of moments of different recordings.
    #[must_use]
    pub fn compare_across(&self, other: &Self) -> Ordering {
        let grade = self.grade.cmp(&other.grade);
        grade.then(self.order.total_cmp(&other.order))
    }
}

/// A course within this time and with at least this braking is a conflict, seconds and m/s².
const CONFLICT: (f64, f64) = (3.0, 3.0);

/// Who passes within this is near, seconds or metres.
const NEAR_MISS: f64 = 1.0;

/// A course within this time is worth a look, seconds.
const AHEAD: f64 = 5.0;

/// Who passes later than this is no danger, seconds.
const LATEST_PASS: f64 = 2.0;

/// What is slower stands, m/s.
const STANDING: f64 = 0.5;

/// The most severe moment with each obstacle, the most severe first; obstacles that are never there with the ego have
/// none.
#[must_use]
pub fn critical_moments(context: &Context<'_>) -> Vec<CriticalMoment> {
    let scene = context.scene();
    let ego = DrivenPath::of(scene.ego.track.iter().map(|(step, m)| (step, *m)));
    let participants = 0..context.participants().len();
    let mut all: Vec<_> = participants
        .filter_map(|participant| most_severe(context, participant, &ego))
        .collect();
    all.sort_by(CriticalMoment::compare);
    all
}

fn most_severe(
    context: &Context<'_>,
    participant: usize,
    ego: &DrivenPath,
) -> Option<CriticalMoment> {
    let obstacle = context.participants()[participant].obstacle.id;
    let contacts = context.contacts(participant).first();
    if let Some(contact) = contacts {
        return Some(CriticalMoment {
            obstacle,
            step: contact.step,
            grade: Grade::Contact,
            hazard: Hazard::Contact {
                closing_speed: contact.closing_speed,
                is_possible: contact.is_possible,
            },
            // Bodies that touch before regions that do, which have no speed.
            order: match contact.is_possible {
                true => contact.time,
                false => -contact.closing_speed,
            },
        });
    }
    let motions = context.motions(participant);
    let other = DrivenPath::of(motions.iter().copied());
    let pair = PairPaths {
        context,
        participant,
        ego,
        other: &other,
    };
    let mut worst: Option<CriticalMoment> = None;
    let mut take = |(step, grade, order, hazard)| {
        let moment = CriticalMoment {
            obstacle,
            step,
            grade,
            hazard,
            order,
        };
        if worst.is_none_or(|worst| moment.compare(&worst).is_lt()) {
            worst = Some(moment);
        }
    };
    for step in context.steps() {
        let Some(encounter) = context.encounter(participant, step) else {
            continue;
        };
        // A region has no course.
        let course = (!encounter.is_with_occupancy()).then(|| pair.graded(&encounter, step));
        if let Some((grade, order, course)) = course.flatten() {
            let hazard = Hazard::Course {
                seconds: course.seconds,
                braking: course.braking(),
            };
            take((step, grade, order, hazard));
        }
        let (grade, order) = pair.nearness(&encounter);
        let metres = encounter.distance();
        take((step, grade, order, Hazard::Near { metres }));
    }
    if !context.participants()[participant].obstacle.is_set_based() {
        pass::passes(&pair).into_iter().for_each(take);
    }
    worst
}

/// What a moment is graded as: step, grade, order in it, why.
type Graded = (i64, Grade, f64, Hazard);

/// The ego and another over the whole recording.
struct PairPaths<'c, 's> {
    context: &'c Context<'s>,
    participant: usize,
    ego: &'c DrivenPath,
    other: &'c DrivenPath,
}

impl PairPaths<'_, '_> {
    /// The course that both are on, with its grade and its order in it; nothing where they are on none.
    fn graded(&self, encounter: &Encounter<'_>, step: i64) -> Option<(Grade, f64, Course)> {
        let seconds = (time_to_collision::MEASURE.compute)(encounter).value();
        let Some(seconds) = seconds else {
            // Ways that bend: straight on there would be no contact.
            let driven = course::meet(self.ego, self.other, encounter, step)?;
            // They come after those that are straight, too.
            return Some((
                Grade::LaterCourse,
                time_to_collision::HORIZON + driven.seconds,
                driven,
            ));
        };
        let velocities = [encounter.ego, encounter.other].map(|motion| motion.velocity_vector());
        let straight = Course {
            seconds,
            closing_speed: (velocities[1] - velocities[0]).norm(),
            crosses: false,
        };
        let borne_out = self.without_road()
            || self.keep_to_their_place(step)
            || course::meet(self.ego, self.other, encounter, step).is_some();
        let (soon, hard) = CONFLICT;
        let grade = match borne_out {
            true if seconds <= soon && straight.braking() >= hard => Grade::Conflict,
            true if seconds <= soon => Grade::Course,
            true if seconds <= AHEAD => Grade::Ahead,
            true => Grade::LaterCourse,
            false if encounter.other.velocity.abs() >= STANDING => Grade::StraightCourse,
            false => return None,
        };
        let order = match grade {
            Grade::Ahead | Grade::LaterCourse => seconds,
            _ => -straight.braking(),
        };
        Some((grade, order, straight))
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
        let closes = match other.rear >= ego.front {
            true => closing > 0.0,
            false => ego.rear >= other.front && closing < 0.0,
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
