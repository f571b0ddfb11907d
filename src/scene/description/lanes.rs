//! The lane of each participant in words: what it is to the ego's.

use std::cell::RefCell;
use std::rc::Rc;

use crate::scenario::{LaneRelation, LaneRelations, Motion, Scene};
use nearmiss_base::geometry::Pose;

/// Names the lanes of participants.
pub(super) struct Lanes<'s> {
    scene: &'s Scene,
    /// Of the ego where it was asked about last.
    last: RefCell<Option<Known<'s>>>,
}

/// The ego's pose, its lanelets, and what others are to them.
type Known<'s> = (Pose, Vec<i64>, Rc<LaneRelations<'s>>);

/// The words for a participant that is on no lanelet.
pub(super) const OFF_THE_ROAD: &str = "off the road";

impl<'s> Lanes<'s> {
    pub fn new(scene: &'s Scene) -> Self {
        Self {
            scene,
            last: RefCell::default(),
        }
    }

    /// Of the ego only that it is on no lane is worth a word; nothing where the map has no lanes.
    pub fn of_ego(&self, ego: &Motion) -> Option<&'static str> {
        let network = &self.scene.scenario.network;
        let off = network.lanelets_at(&ego.pose.position).is_empty();
        (off && !network.lanelets.is_empty()).then_some(OFF_THE_ROAD)
    }

    /// What the lane under `other` is to the ego's; nothing where the map has no lanes.
    pub fn of(&self, ego: &Motion, other: &Motion) -> Option<&'static str> {
        let network = &self.scene.scenario.network;
        if network.lanelets.is_empty() {
            return None;
        }
        let theirs = network.lanelets_driven(&other.pose);
        if theirs.is_empty() {
            return Some(OFF_THE_ROAD);
        }
        match self.relations(ego) {
            Some(relations) => theirs
                .iter()
                .map(|id| relations.of(*id))
                .min()
                .map(LaneRelation::words),
            None => Some("on the road"),
        }
    }

    /// Nothing where the ego is off the road. Those of one step have the same ego, those of steps in a row mostly the
    /// same lanelets.
    fn relations(&self, ego: &Motion) -> Option<Rc<LaneRelations<'s>>> {
        let network = &self.scene.scenario.network;
        let mut last = self.last.borrow_mut();
        let known = match last.take() {
            Some(known) if known.0 == ego.pose => known,
            before => {
                let ours = network.lanelets_driven(&ego.pose);
                let same = before.filter(|(_, lanelets, _)| *lanelets == ours);
                let relations = same
                    .map(|(.., relations)| relations)
                    .unwrap_or_else(|| Rc::new(network.lane_relations(&ours)));
                (ego.pose, ours, relations)
            }
        };
        let relations = (!known.1.is_empty()).then(|| known.2.clone());
        *last = Some(known);
        relations
    }
}
