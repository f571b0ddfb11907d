//! How close recorded bodies come, when they first overlap, and the times in the area that both sweep.
//!
//! Source: Allen, Shin and Cooper, Analysis of traffic conflicts and collisions, 1978. The area is that of the
//! swept bodies, so it follows what was driven and needs no map.
//!
//! Encroachment time: how long the ego's body is in the conflict area, as recorded.
//!
//! The conflict area is all places that both bodies sweep in their whole recordings; the time runs from when the
//! ego first touches it to when it last does, at a step or between two, where it goes evenly. One value for
//! the pair, the same at every step. Source: Allen, Shin and Cooper 1978.
//!
//! Post-encroachment time: from one leaving the conflict area to the other entering it, as recorded.
//!
//! PET = t_entry(second) − t_exit(first), whichever is first. The conflict area is all places that both bodies sweep
//! in their whole recordings; exit is when a body last touches it and entry when it first does, at a step or between
//! two, where bodies go evenly. One value for the pair, the same at every step; who follows another has none, as both
//! are in it together. Source: Allen, Shin and Cooper 1978.
//!
//! Distance of the closest encounter: the smallest distance of the recorded bodies from now on.
//!
//! At a step; 0 where the bodies touch, also between two steps. At the first step it is the minimum distance of the whole recording (MDC). Source: Eggert
//! 2014 (DCE).
//!
//! Time to the closest encounter: when the recorded bodies are at their smallest distance from now on.
//!
//! At a step, or where the bodies touch between two; the first of several moments alike. Source: Eggert 2014 (TTCE).
//!
//! Recorded time to collision, TTC*: the time until the recorded bodies first overlap.
//!
//! At a step or between two: 0 while they overlap. Unlike `ttc` it predicts nothing. Source: the TTC* of CommonRoad-CriMe (Lin and Althoff 2023).

use nearmiss_base::geometry::{Bounds, Vector};

use super::super::{Danger, Encounter, Measure, Reading};
use super::Swept;
use crate::metrics::{Contact, Context, NoValue};

/// When the two are in their conflict area: first and last time of each, at steps and between them.
#[derive(Debug, Clone, Copy)]
pub(in crate::metrics) struct Conflict(Result<Passages, NoValue>);

#[derive(Debug, Clone, Copy)]
struct Passages {
    ego: Inside,
    other: Inside,
}

/// When a participant is in the conflict area.
#[derive(Debug, Clone, Copy)]
struct Inside {
    /// In steps.
    first: f64,
    last: f64,
    /// Whether the recording begins before, and ends after.
    enters: bool,
    leaves: bool,
}

impl Conflict {
    /// The conflict of the ego with another over both whole recordings.
    pub fn new(context: &Context<'_>, participant: usize) -> Self {
        Self(Passages::find(context, participant))
    }

    /// Time steps from entering to leaving of the ego.
    pub fn encroachment(&self) -> Result<f64, NoValue> {
        let ego = self.0?.ego;
        if ego.enters && ego.leaves {
            Ok(ego.last - ego.first)
        } else {
            Err(NoValue::CutOff)
        }
    }

    /// Time steps from the leaving of the first to the entering of the second.
    pub fn post_encroachment(&self) -> Result<f64, NoValue> {
        let (_, first, second) = self.in_turn()?;
        Ok(second.first - first.last)
    }

    /// Whether the ego is the first to leave, the first and the second, where both moments are recorded.
    fn in_turn(&self) -> Result<(bool, Inside, Inside), NoValue> {
        let Passages { ego, other } = self.0?;
        let (first, second) = if ego.last < other.first {
            (ego, other)
        } else if other.last < ego.first {
            (other, ego)
        } else {
            return Err(NoValue::Together);
        };
        if first.leaves && second.enters {
            Ok((ego.last < other.first, first, second))
        } else {
            Err(NoValue::CutOff)
        }
    }
}

impl Passages {
    fn find(context: &Context<'_>, participant: usize) -> Result<Self, NoValue> {
        if context.stands(participant) {
            return Err(NoValue::NoConflictArea);
        }
        let ego = context.ego_swept();
        let who = context.participants()[participant];
        let discs = context.motions(participant).iter().map(|(step, motion)| {
            let half = Vector::repeat(who.footprint_at(*step).reach());
            let middle = motion.pose.position;
            Bounds {
                min: middle - half,
                max: middle + half,
            }
        });
        if !ego.moves() || !near(ego, discs) {
            return Err(NoValue::NoConflictArea);
        }
        let other = context.swept(participant);
        if !other.moves() {
            return Err(NoValue::NoConflictArea);
        }
        Ok(Self {
            ego: inside(ego, &other).ok_or(NoValue::NoConflictArea)?,
            other: inside(&other, ego).ok_or(NoValue::NoConflictArea)?,
        })
    }
}

/// Whether a participant comes near the area; between two steps it is in the box around both.
fn near(area: &Swept, places: impl Iterator<Item = Bounds>) -> bool {
    let mut before: Option<Bounds> = None;
    let mut places = places.map(|here| {
        let both = before.map_or(here, |b| b.union(&here));
        before = Some(here);
        both
    });
    places.any(|both| area.near(&both))
}

fn inside(body: &Swept, other: &Swept) -> Option<Inside> {
    let (first, last) = body.inside(other)?;
    let (begin, end) = body.times()?;
    Some(Inside {
        first,
        last,
        enters: begin < first,
        leaves: last < end,
    })
}

/// One leaves the area that both bodies sweep before the other enters it; seconds since time step 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passing {
    /// Whether the ego is there first.
    pub ego_first: bool,
    /// When the first leaves.
    pub left: f64,
    /// When the second enters.
    pub entered: f64,
}

impl Context<'_> {
    /// The moments of the post-encroachment time with a participant, where there is one.
    #[must_use]
    pub fn passing(&self, participant: usize) -> Option<Passing> {
        let (ego_first, first, second) = self.conflict(participant).in_turn().ok()?;
        Some(Passing {
            ego_first,
            left: first.last * self.dt(),
            entered: second.first * self.dt(),
        })
    }

    fn ego_swept(&self) -> &Swept {
        self.ego_swept.get_or_init(|| {
            let steps = self.steps().zip(&self.ego);
            let bodies = steps.filter_map(|(step, here)| here.map(|(m, b)| (step, m.pose, b)));
            Swept::from_poses(bodies, self.dt(), self.origin())
        })
    }

    fn swept(&self, participant: usize) -> Swept {
        let motions = self.motions(participant).iter();
        let participant = self.participants()[participant];
        let bodies = motions.map(|(step, m)| (*step, m.pose, participant.footprint_at(*step)));
        Swept::from_poses(bodies, self.dt(), self.origin())
    }

    /// Near everything, so that no digits are lost far from the map's origin.
    fn origin(&self) -> Vector {
        let first = self.ego.iter().flatten().next();
        first.map_or_else(Vector::zeros, |(m, _)| m.pose.position.coords)
    }
}

pub(in crate::metrics) const ENCROACHMENT_TIME: Measure = Measure::new(
    "et",
    "encroachment time",
    "s",
    Danger::High,
    "time of the ego in the area that both bodies sweep (Allen 1978)",
    |e| {
        e.ask(|c, other, _| Ok(c.conflict(other).encroachment()? * c.dt()))
            .into()
    },
)
.reading_ahead();

pub(in crate::metrics) const POST_ENCROACHMENT_TIME: Measure = Measure::new(
    "pet",
    "post-encroachment time",
    "s",
    Danger::Low,
    "between leaving and entering the area that both bodies sweep (Allen 1978)",
    |e| {
        e.ask(|c, other, _| Ok(c.conflict(other).post_encroachment()? * c.dt()))
            .into()
    },
)
.reading_ahead();

/// The future distance between two recorded bodies; moments are places of steps, with a share of the way to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::metrics) struct Closest {
    /// The smallest distance from now on, metres.
    pub distance: f64,
    /// The first moment at which it is as small.
    pub at: f64,
    /// The first moment at which the bodies touch.
    pub contact: Option<f64>,
}

/// Distances that differ by less are alike, metres: of two that stand, the first step counts.
const DISTANCE_TOLERANCE: f64 = 1e-6;

impl Closest {
    /// By step; nothing at steps where one of the two is not there.
    pub fn rows(context: &Context<'_>, participant: usize) -> Vec<Option<Self>> {
        let distances = context.distances(participant);
        let mut contacts = context.contacts(participant).iter().rev().peekable();
        let mut rows = vec![None; distances.len()];
        let mut ahead: Option<Self> = None;
        for (index, &distance) in distances.iter().enumerate().rev() {
            let Some(distance) = distance else { continue };
            let step = context.step(index);
            // What is touched on the way to a later step is touched before that.
            let after = |contact: &&Contact| contact.step > step;
            while let Some(contact) = contacts.next_if(after) {
                let steps = contact.time / context.dt() - context.steps().start as f64;
                ahead = Some(Self::touching(steps.max(index as f64)));
            }
            let here = Self {
                distance,
                at: index as f64,
                contact: ahead.and_then(|ahead| ahead.contact),
            };
            let here = match ahead {
                _ if distance == 0.0 => Self::touching(index as f64),
                Some(ahead) if ahead.distance < distance - DISTANCE_TOLERANCE => ahead,
                Some(ahead) => Self {
                    distance: ahead.distance.min(distance),
                    ..here
                },
                None => here,
            };
            ahead = Some(here);
            rows[index] = ahead;
        }
        rows
    }

    fn touching(at: f64) -> Self {
        Self {
            distance: 0.0,
            at,
            contact: Some(at),
        }
    }
}

/// What follows from the future distance.
fn of_closest(
    encounter: &Encounter<'_>,
    value: fn(&Context<'_>, usize, &Closest) -> Result<f64, NoValue>,
) -> Reading {
    let found = encounter.ask(|c, other, i| {
        let closest = c.closest(other, i).ok_or(NoValue::Absent)?;
        value(c, i, &closest)
    });
    found.into()
}

pub(in crate::metrics) const CLOSEST_DISTANCE: Measure = Measure::new(
    "dce",
    "distance of the closest encounter",
    "m",
    Danger::Low,
    "smallest recorded distance from now on (Eggert 2014)",
    |e| of_closest(e, |_, _, closest| Ok(closest.distance)),
)
.reading_ahead();

pub(in crate::metrics) const TIME_TO_CLOSEST: Measure = Measure::new(
    "ttce",
    "time to the closest encounter",
    "s",
    Danger::Low,
    "recorded time until dce (Eggert 2014)",
    |e| of_closest(e, |c, i, closest| Ok(c.time(i, closest.at))),
)
.reading_ahead();

pub(in crate::metrics) const FIRST_OVERLAP: Measure = Measure::new(
    "ttc_star",
    "time to the recorded overlap",
    "s",
    Danger::Low,
    "recorded time until the bodies overlap (TTC* of CriMe)",
    |e| {
        of_closest(e, |c, i, closest| {
            let contact = closest.contact.ok_or(NoValue::NoRecordedOverlap)?;
            Ok(c.time(i, contact))
        })
    },
)
.reading_ahead();
