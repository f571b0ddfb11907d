//! Other ids for the obstacles: each has that of another one.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::scenario::{EgoSource, Obstacle, ObstacleParts, Scenario, Scene};

/// From new ids to old ones. Several obstacles pass theirs round in one cycle, so that none keeps its own (Sattolo,
/// *An algorithm to generate a random cyclic permutation*, Information Processing Letters 22, 1986); one alone gets
/// an id that nothing in the scenario has.
pub(super) fn ids(scenario: &Scenario, seed: u64) -> BTreeMap<i64, i64> {
    let mut old: Vec<i64> = scenario.obstacles.iter().map(|o| o.id).collect();
    old.sort_unstable();
    old.dedup();
    if let [only] = old[..] {
        return BTreeMap::from([(free(scenario, seed), only)]);
    }
    let mut new = old.clone();
    let mut random = Random(seed);
    for last in (1..new.len()).rev() {
        new.swap(last, random.below(last));
    }
    new.into_iter().zip(old).collect()
}

/// An id above all others, at most 1000 above.
fn free(scenario: &Scenario, seed: u64) -> i64 {
    let network = &scenario.network;
    let crossings = network.intersections.iter();
    let highest = scenario
        .obstacles
        .iter()
        .map(|o| o.id)
        .chain(scenario.planning_problems.iter().map(|p| p.id))
        .chain(network.lanelets.iter().map(|l| l.id))
        .chain(network.signs.iter().map(|s| s.id))
        .chain(network.lights.iter().map(|l| l.id))
        .chain(crossings.flat_map(|c| c.incomings.iter().map(|i| i.id).chain([c.id])))
        .max();
    let above = 1 + Random(seed).below(1000) as i64;
    highest.unwrap_or(0).saturating_add(above)
}

/// The scene with new ids, by a map from new to old.
pub(super) fn renumbered(scene: &Scene, ids: &BTreeMap<i64, i64>) -> Scene {
    let new: BTreeMap<i64, i64> = ids.iter().map(|(new, old)| (*old, *new)).collect();
    let new = |id: i64| new.get(&id).copied().unwrap_or(id);
    let dt = scene.scenario.dt();
    let obstacle = |o: &Obstacle| {
        let parts = ObstacleParts {
            id: new(o.id),
            role: o.role,
            kind: o.kind,
            footprint: o.footprint.clone(),
            initial: o.initial.clone(),
            prediction: o.prediction.clone(),
            signals: o.signals.clone(),
        };
        Obstacle::new(parts, dt)
    };
    let mut scenario = (*scene.scenario).clone();
    scenario.obstacles = scene.scenario.obstacles.iter().map(obstacle).collect();
    let mut ego = scene.ego.clone();
    if let EgoSource::Obstacle(id) = ego.source {
        ego.id = new(id);
        ego.source = EgoSource::Obstacle(new(id));
    }
    Scene::new(Arc::new(scenario), ego)
}

/// Numbers that look random and are the same everywhere: SplitMix64 (Steele, Lea and Flood, *Fast splittable
/// pseudorandom number generators*, OOPSLA 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % end.max(1) as u64) as usize
    }
}
