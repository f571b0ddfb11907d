//! The ego and one other participant at one step: what every measure looks at.

use super::Relation;
use crate::geometry::{Footprint, Placed};
use crate::scenario::{Motion, Participant, Scene};

/// The ego and another participant, at one moment.
#[derive(Debug, Clone, Copy)]
pub struct Encounter<'a> {
    /// The ego's motion.
    pub ego: &'a Motion,
    /// The ego's body.
    pub ego_body: &'a Footprint,
    /// The other's motion.
    pub other: &'a Motion,
    /// The other's body.
    pub other_body: &'a Footprint,
}

impl<'a> Encounter<'a> {
    /// The encounter of a scene's ego with `other` at `step`; nothing if one of them is not there.
    #[must_use]
    pub fn at(scene: &'a Scene, other: &Participant<'a>, step: i64) -> Option<Self> {
        Some(Self {
            ego: scene.ego.track.at(step)?,
            ego_body: scene.ego_footprint_at(step),
            other: other.at(step)?,
            other_body: other.footprint_at(step),
        })
    }

    /// The ego where it stands.
    #[must_use]
    pub fn ego_placed(&self) -> Placed<'a> {
        self.ego_body.at(self.ego.pose)
    }

    /// The other where it stands.
    #[must_use]
    pub fn other_placed(&self) -> Placed<'a> {
        self.other_body.at(self.other.pose)
    }

    /// Exact distance between the two bodies, metres; 0 when they touch.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.ego_placed().distance(&self.other_placed())
    }

    /// Where the other is and how it moves, seen from the ego.
    #[must_use]
    pub fn relation(&self) -> Relation {
        Relation::of(self)
    }
}
