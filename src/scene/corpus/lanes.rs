//! The lanelets under road users and what they are to each other, looked up once for all pairs of a scenario.

use std::cell::{OnceCell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;

use nearmiss_base::geometry::Pose;

use crate::scenario::{LaneRelation, LaneRelations, LaneletNetwork};

/// The lanelets of a scenario under whoever is asked about.
pub(super) struct LanesUnder<'n> {
    pub network: &'n LaneletNetwork,
    by_pose: RefCell<HashMap<[u64; 3], Option<Rc<Lanelets<'n>>>>>,
    known: RefCell<HashMap<Vec<i64>, Rc<Lanelets<'n>>>>,
}

/// The lanelets under a body, and what others are to them.
pub(super) struct Lanelets<'n> {
    network: &'n LaneletNetwork,
    pub ids: Vec<i64>,
    relations: OnceCell<LaneRelations<'n>>,
}

impl<'n> LanesUnder<'n> {
    pub fn new(network: &'n LaneletNetwork) -> Self {
        Self {
            network,
            by_pose: RefCell::default(),
            known: RefCell::default(),
        }
    }

    /// Those under the centre of a body, as it is driven; nothing off the road.
    pub fn at(&self, pose: &Pose) -> Option<Rc<Lanelets<'n>>> {
        if self.network.lanelets.is_empty() {
            return None;
        }
        let place = [pose.position.x, pose.position.y, pose.heading].map(f64::to_bits);
        let mut by_pose = self.by_pose.borrow_mut();
        let under = by_pose.entry(place).or_insert_with(|| {
            let ids = self.network.lanelets_driven(pose);
            (!ids.is_empty()).then(|| {
                let mut known = self.known.borrow_mut();
                let new = || {
                    Rc::new(Lanelets {
                        network: self.network,
                        ids: ids.clone(),
                        relations: OnceCell::new(),
                    })
                };
                Rc::clone(known.entry(ids.clone()).or_insert_with(new))
            })
        });
        under.clone()
    }
}

impl Lanelets<'_> {
    /// What lanelets are to these; the closest relation of several.
    pub fn relation_to(&self, ids: &[i64]) -> Option<LaneRelation> {
        let relations = { &self.relations }.get_or_init(|| self.network.lane_relations(&self.ids));
        ids.iter().map(|id| relations.relation_to(*id)).min()
    }
}
