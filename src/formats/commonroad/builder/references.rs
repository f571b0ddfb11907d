//! Elements of a scenario that others can refer to.

use std::collections::HashSet;

use nearmiss_scene::scenario::LaneletNetwork;

/// Kind of element that a reference points to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Target {
    Lanelet,
    Sign,
    Light,
    Incoming,
}

/// The elements of a network that can be referred to.
pub struct Targets(HashSet<(Target, i64)>);

impl Targets {
    pub fn new(network: &LaneletNetwork) -> Self {
        let incomings = network
            .intersections
            .iter()
            .flat_map(|i| &i.incomings)
            .map(|i| (Target::Incoming, i.id));
        let lanelets = network.lanelets.iter().map(|l| (Target::Lanelet, l.id));
        let signs = network.signs.iter().map(|s| (Target::Sign, s.id));
        let lights = network.lights.iter().map(|l| (Target::Light, l.id));
        Self(
            lanelets
                .chain(signs)
                .chain(lights)
                .chain(incomings)
                .collect(),
        )
    }

    pub fn has(&self, target: Target, id: i64) -> bool {
        self.0.contains(&(target, id))
    }
}
