//! Writes scenarios as CommonRoad 2018b: what that version has no place for is left out, and told.

use std::collections::BTreeMap;

use nearmiss_base::geometry::Footprint;
use nearmiss_scene::scenario::{
    Bound, Lanelet, LaneletNetwork, LineMarking, Obstacle, ObstacleParts, ObstacleRole, Scenario,
};

use super::WriteError;
use super::writer::{Version, written};

/// The scenario as an XML file of version 2018b, in UTF-8, and what is left out of it, one sentence each.
///
/// # Errors
/// None in practice: writing goes to memory.
pub fn write_2018b(scenario: &Scenario) -> Result<(Vec<u8>, Vec<String>), WriteError> {
    let mut lost = LeftOut::default();
    let network = &scenario.network;
    let limit = |lanelet: &Lanelet| {
        let signs = network.signs.iter();
        let own = signs.filter(|sign| lanelet.signs.contains(&sign.id));
        let limits = own.filter_map(|sign| sign.limit());
        Some((lanelet.id, limits.reduce(f64::min)?))
    };
    let limits = network.lanelets.iter().filter_map(limit).collect();
    let others = network.signs.iter().filter(|sign| sign.limit().is_none());
    lost.add(others.count(), "traffic signs other than speed limits");
    lost.add(network.areas.len(), "drivable areas");
    lost.add(network.lights.len(), "traffic lights");
    lost.add(network.intersections.len(), "intersections");
    let fitted = network.lanelets.iter().map(|l| lanelet(l, &mut lost));
    let lanelets: Vec<Lanelet> = fitted.collect();
    let mut obstacles = Vec::with_capacity(scenario.obstacles.len());
    for obstacle in &scenario.obstacles {
        match obstacle.role {
            ObstacleRole::Static | ObstacleRole::Dynamic => {
                obstacles.push(self::obstacle(obstacle, scenario.dt(), &mut lost));
            }
            _ => lost.add(1, "phantom and environment obstacles"),
        }
    }
    let environment = scenario
        .location
        .as_ref()
        .and_then(|l| l.environment.as_ref());
    lost.add(usize::from(environment.is_some()), "environment");
    let old = Scenario {
        header: scenario.header.clone(),
        location: None,
        tags: scenario.tags.clone(),
        network: LaneletNetwork::new(lanelets, Vec::new(), Vec::new(), Vec::new()),
        obstacles,
        planning_problems: scenario.planning_problems.clone(),
        recorded_ego: None,
        diagnostics: Vec::new(),
        hash: scenario.hash,
    };
    let bytes = written(&old, &Version::V2018b { limits })?;
    Ok((bytes, lost.sentences()))
}

/// What has no place, and how many there are.
#[derive(Default)]
struct LeftOut(BTreeMap<&'static str, usize>);

impl LeftOut {
    fn add(&mut self, count: usize, what: &'static str) {
        *self.0.entry(what).or_default() += count;
    }

    fn sentences(&self) -> Vec<String> {
        let some = self.0.iter().filter(|(_, count)| **count > 0);
        some.map(|(what, count)| format!("version 2018b has no place for {what}: {count} left out"))
            .collect()
    }
}

fn lanelet(lanelet: &Lanelet, lost: &mut LeftOut) -> Lanelet {
    let users = lanelet.users_one_way.len() + lanelet.users_bidirectional.len();
    lost.add(lanelet.types.len() + users, "types and users of lanelets");
    lost.add(usize::from(lanelet.stop_line.is_some()), "stop lines");
    Lanelet {
        id: lanelet.id,
        left: bound(&lanelet.left, lost),
        right: bound(&lanelet.right, lost),
        predecessors: lanelet.predecessors.clone(),
        successors: lanelet.successors.clone(),
        adjacent_left: lanelet.adjacent_left,
        adjacent_right: lanelet.adjacent_right,
        ..Lanelet::default()
    }
}

/// Lines are solid, dashed or not known.
fn bound(bound: &Bound, lost: &mut LeftOut) -> Bound {
    let marking = match bound.marking {
        LineMarking::Solid | LineMarking::BroadSolid => LineMarking::Solid,
        LineMarking::Dashed | LineMarking::BroadDashed => LineMarking::Dashed,
        _ => LineMarking::Unknown,
    };
    lost.add(
        usize::from(marking != bound.marking),
        "line markings other than solid and dashed",
    );
    Bound {
        marking,
        ..bound.clone()
    }
}

fn obstacle(obstacle: &Obstacle, dt: f64, lost: &mut LeftOut) -> Obstacle {
    lost.add(obstacle.signals.len(), "signals of vehicles");
    // A truck is the boxes of which it consists.
    let plain = |body: &Footprint| Footprint::new(body.shape().plain().into_owned()).ok();
    let parts = ObstacleParts {
        id: obstacle.id,
        role: obstacle.role,
        kind: obstacle.kind,
        footprint: obstacle.footprint.as_ref().and_then(plain),
        initial: obstacle.initial.clone(),
        prediction: obstacle.prediction.clone(),
        signals: Vec::new(),
    };
    Obstacle::new(parts, dt)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::commonroad::read;

    #[test]
    fn bundled_scenarios_come_back_with_their_traffic_lanes_limits_and_tasks() {
        for entry in crate::bundled() {
            let scenario = entry.read().unwrap();
            let (bytes, lost) = write_2018b(&scenario).unwrap();
            let text = String::from_utf8(bytes.clone()).unwrap();
            assert!(text.contains("commonRoadVersion=\"2018b\""));
            for later in ["<scenarioTags", "<trafficSign", "<laneletType", "Obstacle "] {
                assert!(!text.contains(later), "{}: {later}", entry.name);
            }
            let again = read(&bytes, "a.xml").unwrap();
            assert_eq!(again.tags, scenario.tags);
            assert_eq!(again.dt(), scenario.dt());
            assert_eq!(again.planning_problems, scenario.planning_problems);
            assert_eq!(again.obstacles.len(), scenario.obstacles.len());
            for obstacle in &scenario.obstacles {
                let found = again.obstacle(obstacle.id).unwrap();
                assert_eq!((found.kind, found.role), (obstacle.kind, obstacle.role));
                assert!(found.states().eq(obstacle.states()), "{}", obstacle.id);
            }
            let limit = |of: &Scenario, lanelet: &Lanelet| {
                let own = of.network.signs.iter();
                let own = own.filter(|sign| lanelet.signs.contains(&sign.id));
                own.filter_map(|sign| sign.limit()).reduce(f64::min)
            };
            for lanelet in &scenario.network.lanelets {
                let found = again.network.lanelet(lanelet.id).unwrap();
                assert_eq!(found.left.points, lanelet.left.points);
                assert_eq!(found.successors, lanelet.successors);
                assert_eq!(limit(&again, found), limit(&scenario, lanelet));
            }
            let has_lights = !scenario.network.lights.is_empty();
            let said = lost.iter().any(|said| said.contains("traffic lights"));
            assert_eq!(said, has_lights, "{lost:?}");
        }
    }
}
