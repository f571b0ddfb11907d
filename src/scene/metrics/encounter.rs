//! The ego and one other participant, at one step and over all of them: what every measure looks at.

use std::cell::OnceCell;

use nearmiss_base::geometry::{Footprint, Placed};

use super::along::{Exposure, Following, LaneBody, LaneSet};
use super::recorded::{Closest, Conflict, Starts};
use super::{Contact, Context, NoValue, Relation, Thresholds};
use crate::scenario::{Motion, ObstacleRole, Participant, Scene};

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
    thresholds: &'a Thresholds,
    place: Place<'a>,
}

/// The source of the remaining recording.
#[derive(Debug, Clone, Copy)]
enum Place<'a> {
    /// Prepared, with the places of the other and of the step.
    Context(&'a Context<'a>, usize, usize),
    /// Not prepared, with the other and the step.
    Scene(&'a Scene, Participant<'a>, i64),
    /// None.
    #[cfg(test)]
    Nowhere,
}

impl<'a> Encounter<'a> {
    /// The encounter of a scene's ego with `other` at `step`; nothing if one of them is not there.
    ///
    /// Measures that look along the road or into the recording prepare the scene anew for each such
    /// encounter: for more than a few of those, make a [`Context`] once and ask it.
    #[must_use]
    pub fn at(scene: &'a Scene, other: &Participant<'a>, step: i64) -> Option<Self> {
        Some(Self {
            ego: scene.ego.track.at(step)?,
            ego_body: scene.ego_footprint_at(step),
            other: other.at(step)?,
            other_body: other.footprint_at(step),
            thresholds: Thresholds::shipped(),
            place: Place::Scene(scene, *other, step),
        })
    }

    /// The same, measured with these thresholds instead of the shipped ones.
    #[must_use]
    pub fn under(self, thresholds: &'a Thresholds) -> Self {
        Self { thresholds, ..self }
    }

    /// The thresholds that it is measured with.
    #[must_use]
    pub fn thresholds(&self) -> &'a Thresholds {
        self.thresholds
    }

    pub(super) fn in_context(
        (ego, ego_body): (&'a Motion, &'a Footprint),
        (other, other_body): (&'a Motion, &'a Footprint),
        context: &'a Context<'a>,
        participant: usize,
        index: usize,
    ) -> Self {
        Self {
            ego,
            ego_body,
            other,
            other_body,
            thresholds: context.thresholds,
            place: Place::Context(context, participant, index),
        }
    }

    #[cfg(test)]
    pub(super) fn nowhere(
        (ego, ego_body): (&'a Motion, &'a Footprint),
        (other, other_body): (&'a Motion, &'a Footprint),
    ) -> Self {
        Self {
            ego,
            ego_body,
            other,
            other_body,
            thresholds: Thresholds::shipped(),
            place: Place::Nowhere,
        }
    }

    /// Whether the other is a region of an occupancy set, which has a place and no velocity.
    #[must_use]
    pub fn is_with_occupancy(&self) -> bool {
        match self.place {
            Place::Context(context, participant, index) => {
                let other = &context.participants()[participant];
                other.obstacle.is_occupancy_at(context.step(index))
            }
            Place::Scene(_, other, step) => other.obstacle.is_occupancy_at(step),
            #[cfg(test)]
            Place::Nowhere => false,
        }
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
        let known = match self.place {
            Place::Context(context, participant, index) => context.distances(participant)[index],
            _ => None,
        };
        known.unwrap_or_else(|| self.ego_placed().distance(&self.other_placed()))
    }

    /// The contact at the step or on the way to it from the step before, if there is one.
    #[must_use]
    pub fn contact(&self) -> Option<Contact> {
        match self.place {
            Place::Context(context, participant, index) => {
                context.contact_at(participant, index).copied()
            }
            Place::Scene(scene, other, step) => Contact::at(scene, &other, step),
            #[cfg(test)]
            Place::Nowhere => None,
        }
    }

    /// Position and motion of the other relative to the ego.
    #[must_use]
    pub fn relation(&self) -> Relation {
        let known = match self.place {
            Place::Context(context, participant, index) => context.relation(participant, index),
            _ => None,
        };
        known.unwrap_or_else(|| Relation::new(self))
    }

    /// Asks the whole recording: `question` is given the places of the other and of the step.
    pub(super) fn ask<T>(
        &self,
        question: impl FnOnce(&Context<'_>, usize, usize) -> Result<T, NoValue>,
    ) -> Result<T, NoValue> {
        match self.place {
            Place::Context(context, participant, index) => question(context, participant, index),
            Place::Scene(scene, other, step) => {
                let context = Context::under(scene, self.thresholds);
                let mut all = context.participants().iter();
                let place = all.position(|p| p.obstacle.id == other.obstacle.id);
                let (participant, index) = place.zip(context.index(step)).ok_or(NoValue::Absent)?;
                question(&context, participant, index)
            }
            #[cfg(test)]
            Place::Nowhere => Err(NoValue::Absent),
        }
    }
}

/// The ego and one other, by step of the ego.
#[derive(Debug, Default)]
pub(super) struct Pair {
    distances: OnceCell<Vec<Option<f64>>>,
    pub(super) contacts: OnceCell<Vec<Contact>>,
    relations: OnceCell<Vec<Option<Relation>>>,
    closest: OnceCell<Vec<Option<Closest>>>,
    along: OnceCell<Vec<Option<LaneBody>>>,
    following: OnceCell<Vec<Result<Following, NoValue>>>,
    exposure: OnceCell<Vec<Exposure>>,
    conflict: OnceCell<Conflict>,
    starts: OnceCell<Starts>,
    /// The lanes of a static obstacle.
    standing_lanes: OnceCell<LaneSet>,
}

impl Context<'_> {
    /// Exact distances of the bodies, metres, by step.
    pub(super) fn distances(&self, participant: usize) -> &[Option<f64>] {
        self.pair(participant).distances.get_or_init(|| {
            let distance = |index| {
                let (ego, other) = self.placed(participant, index)?;
                Some(ego.distance(&other))
            };
            (0..self.length()).map(distance).collect()
        })
    }

    pub(super) fn relation(&self, participant: usize, index: usize) -> Option<Relation> {
        let rows = self.pair(participant).relations.get_or_init(|| {
            let relation = |index| {
                let encounter = self.encounter(participant, self.step(index))?;
                Some(Relation::new(&encounter))
            };
            (0..self.length()).map(relation).collect()
        });
        rows[index]
    }

    /// The closest that the recorded bodies come from a step on, at steps and between them.
    pub(super) fn closest(&self, participant: usize, index: usize) -> Option<Closest> {
        let rows = self
            .pair(participant)
            .closest
            .get_or_init(|| Closest::rows(self, participant));
        rows[index]
    }

    /// The other along the ego's route.
    pub(super) fn along(&self, participant: usize, index: usize) -> Result<LaneBody, NoValue> {
        let road = self.road().map_err(|_| NoValue::NoRoute)?;
        let rows = self.pair(participant).along.get_or_init(|| {
            let along = |index| {
                let (motion, body) = self.other(participant, index)?;
                road.along(motion, body)
            };
            if self.stands(participant) {
                return vec![along(0); self.length()];
            }
            // No pair exists at steps without the ego.
            let asked = |index: usize| self.ego[index].and_then(|_| along(index));
            (0..self.length()).map(asked).collect()
        });
        rows[index].ok_or(NoValue::OffRoute)
    }

    /// The other ahead in the ego's lane, or why it is not.
    pub(super) fn following(&self, participant: usize, index: usize) -> Result<Following, NoValue> {
        let rows = self.pair(participant).following.get_or_init(|| {
            let rows = 0..self.length();
            rows.map(|index| Following::find(self, participant, index))
                .collect()
        });
        rows[index]
    }

    pub(super) fn exposure(&self, participant: usize, index: usize) -> Result<Exposure, NoValue> {
        self.road().map_err(|_| NoValue::NoRoute)?;
        let rows = self
            .pair(participant)
            .exposure
            .get_or_init(|| Exposure::rows(self, participant));
        Ok(rows[index])
    }

    pub(super) fn conflict(&self, participant: usize) -> &Conflict {
        let conflict = &self.pair(participant).conflict;
        conflict.get_or_init(|| Conflict::new(self, participant))
    }

    /// The latest starts of manoeuvres that avoid this one.
    pub(super) fn starts_before(&self, participant: usize) -> &Starts {
        let starts = &self.pair(participant).starts;
        starts.get_or_init(|| Starts::new(self, participant..participant + 1))
    }

    /// The latest starts of manoeuvres that avoid all obstacles.
    pub(super) fn starts(&self) -> &Starts {
        self.starts
            .get_or_init(|| Starts::new(self, 0..self.participants().len()))
    }

    /// The lanes that the other stands on.
    pub(super) fn lanes_of(&self, participant: usize, index: usize) -> LaneSet {
        let (Ok(road), Some((motion, body))) = (self.road(), self.other(participant, index)) else {
            return LaneSet::default();
        };
        let lanes = || road.lanes_under(self.scene, &body.at(motion.pose));
        if self.stands(participant) {
            return *self.pair(participant).standing_lanes.get_or_init(lanes);
        }
        lanes()
    }

    pub(super) fn stands(&self, participant: usize) -> bool {
        self.participants()[participant].obstacle.role == ObstacleRole::Static
    }
}
