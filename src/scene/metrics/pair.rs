//! The ego and one other over all steps: rows shared by several measures, each computed on first use.

use std::cell::OnceCell;

use super::along::{Exposure, Following, LaneBody, LaneSet};
use super::recorded::{Closest, Conflict, Starts};
use super::{Contact, Context, NoValue, Relation};
use crate::scenario::ObstacleRole;

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
