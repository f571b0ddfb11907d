//! Severity: which moment of a recording matters, and how much. The workbench, `--at worst`, the list, figures and
//! `find` all go by it.
//!
//! A moment is graded by what happened, then by what would have happened, and only then by how near it was. From the
//! most severe grade to the least:
//!
//! 0. **contact**: the bodies touch; the more likely a serious injury the first ([`super::injury`]).
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

use std::cell::OnceCell;
use std::cmp::Ordering;
use std::fmt;

use nearmiss_base::geometry::{Placed, Vector};

use super::{Context, Encounter, plane};
use crate::metrics::recorded::conflict;
use course::Course;
pub use course::DrivenPath;

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
                closing_speed: contact.impact.closing_speed,
                p_serious: contact.impact.p_serious.ok(),
                is_possible: contact.is_possible,
            };
            // Bodies that touch before regions that do, which have no speed.
            let order = if contact.is_possible {
                contact.time
            } else {
                -contact.impact.rank
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
                    along_paths: course.along_paths,
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
                passes(pair)
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
        let straight = plane::TIME_TO_COLLISION
            .compute(encounter)
            .value()
            .map(|seconds| Course {
                seconds,
                closing_speed: (velocities[1] - velocities[0]).norm(),
                crosses: false,
                along_paths: false,
            });
        if let Some(straight) = straight
            && (self.without_road() || self.keep_to_their_place(step))
        {
            return Some(Self::as_they_go(straight));
        }
        // Along their ways bodies meet later than straight on, or earlier.
        let driven = course::meet(self.ego, &self.other, encounter, step);
        match (straight, driven) {
            (Some(straight), Some(driven)) => Some(Self::as_they_go(Course {
                // On a straight road both are one.
                along_paths: (straight.seconds - driven.seconds).abs() >= 0.05,
                ..driven
            })),
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

/// The hardest braking of road vehicles: gravity at a coefficient of friction of 1, m/s².
const MAX_BRAKING: f64 = 9.81;

/// Contacts are never said to be sooner, seconds: bodies that do not touch yet are not "in contact in 0.0 s".
const SOONEST: f64 = 0.1;

/// What makes a moment matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hazard {
    /// The bodies touch.
    Contact {
        /// The speed of one relative to the other, m/s.
        closing_speed: f64,
        /// The risk of a serious injury, where a curve tells it.
        p_serious: Option<f64>,
        /// Whether what is touched is a region that the obstacle may be in, and not its body.
        is_possible: bool,
    },
    /// Both are on courses that end in contact.
    Course {
        /// Time to contact, seconds.
        seconds: f64,
        /// The braking that avoids it after a reaction, m/s².
        braking: f64,
        /// Whether they keep their speed along the paths that they drove, not velocity and heading as `ttc` has it.
        along_paths: bool,
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
            Self::Course {
                seconds,
                braking,
                along_paths,
            } => {
                write!(
                    f,
                    "contact in {:.1} s at constant {}; ",
                    seconds.max(SOONEST),
                    if *along_paths {
                        "speed on their paths"
                    } else {
                        "velocity"
                    }
                )?;
                if *braking <= MAX_BRAKING {
                    write!(f, "avoided with {braking:.1} m/s² after a reaction")
                } else {
                    write!(f, "no braking avoids it")
                }
            }
            Self::Crossing {
                seconds: Some(seconds),
                metres,
            } => write!(f, "crosses {seconds:.1} s apart, {metres:.1} m"),
            Self::Crossing { metres, .. } => write!(f, "crosses, {metres:.1} m away"),
            Self::CutIn { seconds, metres } => {
                write!(f, "cuts in {seconds:.1} s, {metres:.1} m ahead")
            }
            // Not the nearest: who stands or is parked comes after who moves.
            Self::Near { metres } => write!(f, "{metres:.1} m apart"),
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
    /// One follows the other.
    Following,
    /// Straight on there would be contact, but that is not where the road goes.
    StraightCourse,
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
            | Self::Following
            | Self::StraightCourse
            | Self::Near
            | Self::Standing => 5,
        }
    }
}

/// What the numbers of severities are called, from 0.
pub const SEVERITY_NAMES: [&str; 6] = [
    "contact",
    "conflict",
    "near miss",
    "course",
    "later",
    "none",
];

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

    /// The number of its grade, and what orders it among those of the grade: the less, the more severe.
    #[must_use]
    pub fn rank(&self) -> (u8, f64) {
        (self.grade as u8, self.order)
    }

    /// By what it is ordered among those of its grade: a word for it, the value and the unit; nothing of a region, which has
    /// no speed.
    #[must_use]
    pub fn measured(&self) -> Option<(&'static str, f64, &'static str)> {
        Some(match (self.grade, self.hazard) {
            (
                _,
                Hazard::Contact {
                    is_possible: true, ..
                },
            ) => return None,
            (
                _,
                Hazard::Contact {
                    p_serious: Some(risk),
                    ..
                },
            ) => ("serious", 100.0 * risk, "%"),
            (_, Hazard::Contact { closing_speed, .. }) => ("hit", closing_speed, "m/s"),
            (Grade::Conflict | Grade::Course | Grade::StraightCourse, _) => {
                ("brake", -self.order, "m/s²")
            }
            (_, Hazard::Course { seconds, .. }) => ("in", seconds, "s"),
            (Grade::Following, _) => ("gap", self.order, "s"),
            (_, Hazard::Crossing { metres, .. } | Hazard::CutIn { metres, .. })
                if self.order < metres =>
            {
                ("gap", self.order, "s")
            }
            _ => ("gap", self.order, "m"),
        })
    }

    /// Whether it is the moment that matters of the two, which are of the same pair and in the order of time: the first
    /// contact, however hard a later one is, for after it nothing is as recorded; else the more severe one.
    #[must_use]
    pub fn precedes(&self, earlier: &Self) -> bool {
        earlier.grade != Grade::Contact && self.compare(earlier).is_lt()
    }

    /// The more severe one first, of moments of different recordings.
    #[must_use]
    pub fn compare_across(&self, other: &Self) -> Ordering {
        let grade = self.grade.cmp(&other.grade);
        grade.then(self.order.total_cmp(&other.order))
    }
}

/// Who waits for another that crosses would have touched it within this time, seconds.
const YIELDED: f64 = 3.0;

/// Bodies that never come nearer than this do not pass closely, metres: 2 s at 40 m/s.
const MAX_DISTANCE: f64 = 80.0;

/// What of the pair passed closely.
fn passes(pair: &PairPaths<'_, '_>) -> Vec<Graded> {
    let mut all = Vec::new();
    all.extend(crossing(pair));
    all.extend(cut_ins(pair));
    all
}

/// The crossing of both paths, at the step at which the bodies are nearest.
fn crossing(pair: &PairPaths<'_, '_>) -> Option<Graded> {
    let context = pair.context;
    let steps = context.steps().zip(context.distances(pair.participant));
    let present = steps.filter_map(|(step, distance)| Some((step, (*distance)?)));
    let (step, metres) = present.min_by(|a, b| a.1.total_cmp(&b.1))?;
    if metres > MAX_DISTANCE {
        return None;
    }
    let nearest = context.encounter(pair.participant, step)?;
    let [ego, other] = [nearest.ego, nearest.other].map(|motion| motion.pose.forward());
    let seconds = (!same_direction(&ego, &other))
        .then(|| conflict::POST_ENCROACHMENT_TIME.compute(&nearest).value())
        .flatten();
    // An area that both sweep for long is left and entered far apart.
    let fastest = nearest.ego.velocity.abs().max(nearest.other.velocity.abs());
    let seconds = seconds.map(|seconds| seconds.max(metres / fastest.max(STANDING)));
    let close = match seconds {
        Some(seconds) => seconds.min(metres),
        // Without an area that both sweep, one waited: how near it came counts, if it would have come to contact.
        None if metres <= NEAR_MISS && yielded(pair, step) => metres,
        None => return None,
    };
    let grade = grade(seconds.unwrap_or(f64::INFINITY), metres)?;
    Some((step, grade, close, Hazard::Crossing { seconds, metres }))
}

/// Whether shortly before a step both were on courses along their ways that end in contact.
fn yielded(pair: &PairPaths<'_, '_>, step: i64) -> bool {
    let context = pair.context;
    let before = (YIELDED / context.dt()).ceil() as i64;
    let steps = (step - before).max(context.steps().start)..=step;
    steps.rev().any(|step| {
        let encounter = context.encounter(pair.participant, step);
        encounter.is_some_and(|encounter| {
            let course = course::meet(pair.ego, &pair.other, &encounter, step);
            course.is_some_and(|course| course.crosses && course.seconds <= YIELDED)
        })
    })
}

/// Each step at which one of the two comes onto the way of the other, before or behind it.
fn cut_ins(pair: &PairPaths<'_, '_>) -> Vec<Graded> {
    let mut found = Vec::new();
    let mut before = None;
    for step in pair.context.steps() {
        let encounter = pair.context.encounter(pair.participant, step);
        let Some(encounter) = encounter.filter(near_and_along) else {
            before = None;
            continue;
        };
        let (ego, other) = (encounter.ego_placed(), encounter.other_placed());
        let wide = half_width(&ego) + half_width(&other);
        let on = [
            pair.other.aside(&ego.pose.position),
            pair.ego.aside(&other.pose.position),
        ]
        .map(|aside| aside.map(|aside| aside < wide));
        let was: Option<[Option<bool>; 2]> = before.replace(on);
        let comes = |(was, on)| (was, on) == (Some(false), Some(true));
        if !was.is_some_and(|was| was.into_iter().zip(on).any(comes)) {
            continue;
        }
        let metres = encounter.distance();
        let between = other.pose.position - ego.pose.position;
        let behind = if between.dot(&ego.pose.forward()) > 0.0 {
            encounter.ego
        } else {
            encounter.other
        };
        let seconds = metres / behind.velocity.abs();
        if let Some(grade) = grade(seconds, metres) {
            let hazard = Hazard::CutIn { seconds, metres };
            found.push((step, grade, seconds.min(metres), hazard));
        }
    }
    found
}

/// Whether both move the same way, and one could be where the other is soon.
fn near_and_along(encounter: &Encounter<'_>) -> bool {
    let speeds = [encounter.ego, encounter.other].map(|motion| motion.velocity.abs());
    let [ego, other] = [encounter.ego, encounter.other].map(|motion| motion.pose.forward());
    let reachable = encounter.distance() <= LATEST_PASS * speeds[0].max(speeds[1]);
    let moving = speeds.into_iter().all(|speed| speed >= STANDING);
    reachable && moving && same_direction(&ego, &other)
}

/// Half of how wide a body is across its heading, metres.
fn half_width(body: &Placed<'_>) -> f64 {
    let across = body.footprint.corners().iter().map(|corner| corner.y.abs());
    across.fold(0.0, f64::max)
}

fn grade(seconds: f64, metres: f64) -> Option<Grade> {
    match seconds.min(metres) {
        close if close <= NEAR_MISS => Some(Grade::NearMiss),
        _ if seconds <= LATEST_PASS => Some(Grade::Pass),
        _ => None,
    }
}
