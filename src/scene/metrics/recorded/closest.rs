//! The closest that recorded bodies come at each step or later, when, and when they first overlap.
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

use super::super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};
use crate::metrics::{Contact, Context};

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

pub(in crate::metrics) const CLOSEST_DISTANCE: Measure = Measure {
    id: "dce",
    name: "distance of the closest encounter",
    unit: "m",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "smallest recorded distance from now on (Eggert 2014)",
    compute: closest_distance,
};

fn closest_distance(encounter: &Encounter<'_>) -> Reading {
    let closest = encounter.ask(|c, other, i| c.closest(other, i).ok_or(NoValue::Absent));
    closest.map(|c| c.distance).into()
}

pub(in crate::metrics) const TIME_TO_CLOSEST: Measure = Measure {
    id: "ttce",
    name: "time to the closest encounter",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "recorded time until dce (Eggert 2014)",
    compute: time_to_closest,
};

fn time_to_closest(encounter: &Encounter<'_>) -> Reading {
    let time = encounter.ask(|c, other, i| {
        let closest = c.closest(other, i).ok_or(NoValue::Absent)?;
        Ok(c.time(i, closest.at))
    });
    time.into()
}

pub(in crate::metrics) const FIRST_OVERLAP: Measure = Measure {
    id: "ttc_star",
    name: "time to the recorded overlap",
    unit: "s",
    danger: Danger::Low,
    mirrored: Mirrored::Kept,
    reads_ahead: true,
    source: "recorded time until the bodies overlap (TTC* of CriMe)",
    compute: first_overlap,
};

fn first_overlap(encounter: &Encounter<'_>) -> Reading {
    let time = encounter.ask(|c, other, i| {
        let closest = c.closest(other, i).ok_or(NoValue::Absent)?;
        let contact = closest.contact.ok_or(NoValue::NoRecordedOverlap)?;
        Ok(c.time(i, contact))
    });
    time.into()
}
