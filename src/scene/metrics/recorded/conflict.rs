//! The conflict area of the ego and another, which both bodies sweep in the recording, and the times in it.
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

use nearmiss_base::geometry::{Bounds, Vector};

use super::super::{Danger, Encounter, Measure, Mirrored, Reading};
use super::Swept;
use crate::metrics::{Context, NoValue};

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
        let Passages { ego, other } = self.0?;
        let (first, second) = if ego.last < other.first {
            (ego, other)
        } else if other.last < ego.first {
            (other, ego)
        } else {
            return Err(NoValue::Together);
        };
        if first.leaves && second.enters {
            Ok(second.first - first.last)
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

impl Context<'_> {
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

pub(in crate::metrics) const ENCROACHMENT_TIME: Measure = Measure {
    id: "et",
    name: "encroachment time",
    unit: "s",
    danger: Danger::High,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "time of the ego in the area that both bodies sweep (Allen 1978)",
    compute: encroachment_time,
};

fn encroachment_time(encounter: &Encounter<'_>) -> Reading {
    let time = encounter.ask(|c, other, _| Ok(c.conflict(other).encroachment()? * c.dt()));
    time.into()
}

pub(in crate::metrics) const POST_ENCROACHMENT_TIME: Measure = Measure {
    id: "pet",
    name: "post-encroachment time",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "between leaving and entering the area that both bodies sweep (Allen 1978)",
    compute: post_encroachment_time,
};

fn post_encroachment_time(encounter: &Encounter<'_>) -> Reading {
    let time = encounter.ask(|c, other, _| Ok(c.conflict(other).post_encroachment()? * c.dt()));
    time.into()
}
