//! The closest that recorded bodies come at each step or later, in one pass from the last step to the first; a contact
//! counts also where it is between two steps.

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
const ALIKE: f64 = 1e-6;

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
                Some(ahead) if ahead.distance < distance - ALIKE => ahead,
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
