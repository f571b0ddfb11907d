//! What lanes are to each other.

use nearmiss::geometry::Pose;
use nearmiss::scenario::{LaneRelation, LaneletNetwork};

use crate::road::built::*;

/// Lanelet 1 with what lies around it.
fn crossroads() -> LaneletNetwork {
    let lanelets = vec![
        lanelet(1, &[(0.0, 0.0), (50.0, 0.0)]),
        lanelet(2, &[(50.0, 0.0), (100.0, 0.0)]),
        lanelet(3, &[(-50.0, 0.0), (0.0, 0.0)]),
        lanelet(5, &[(100.0, 0.0), (150.0, 0.0)]),
        lanelet(11, &[(0.0, 3.5), (50.0, 3.5)]),
        lanelet(12, &[(50.0, 7.0), (0.0, 7.0)]),
        lanelet(13, &[(50.0, 10.5), (0.0, 10.5)]),
        lanelet(21, &[(0.0, -3.5), (50.0, -3.5)]),
        lanelet(22, &[(0.0, -7.0), (50.0, -7.0)]),
        lanelet(30, &[(75.0, -100.0), (75.0, -40.0)]),
        lanelet(31, &[(75.0, -40.0), (75.0, 0.0), (75.0, 40.0)]),
        lanelet(
            41,
            &[(40.0, -30.0), (70.0, -5.0), (90.0, -0.6), (100.0, 0.0)],
        ),
        lanelet(51, &[(0.0, 0.0), (10.0, -0.6), (30.0, -5.0), (50.0, -30.0)]),
        lanelet(61, &[(300.0, 300.0), (350.0, 300.0)]),
    ];
    let on = [(3, 1), (1, 2), (2, 5), (30, 31), (41, 5), (3, 51)];
    let beside = [
        (1, 11, true),
        (11, 12, false),
        (13, 12, true),
        (21, 1, true),
        (22, 21, true),
    ];
    network(lanelets, &on, &beside)
}

#[test]
fn lanes_are_told_by_what_they_are_to_one() {
    let network = crossroads();
    let relations = network.lane_relations(&[1]);
    for (id, expected) in [
        (1, LaneRelation::Same),
        (2, LaneRelation::Ahead),
        (5, LaneRelation::Ahead),
        (3, LaneRelation::Behind),
        (11, LaneRelation::Left),
        (12, LaneRelation::Oncoming),
        (13, LaneRelation::Oncoming),
        (21, LaneRelation::Right),
        (22, LaneRelation::FurtherRight),
        (30, LaneRelation::Crossing),
        (31, LaneRelation::Crossing),
        (41, LaneRelation::Merging),
        (51, LaneRelation::Diverging),
        (61, LaneRelation::OtherRoad),
    ] {
        assert_eq!(relations.relation_to(id), expected, "{id}");
    }
    // Who turns into a lane from elsewhere is not behind on it.
    let joined = network.lane_relations(&[5]);
    assert_eq!(joined.relation_to(2), LaneRelation::Behind);
    assert_eq!(joined.relation_to(1), LaneRelation::Behind);
    assert_eq!(joined.relation_to(41), LaneRelation::Merging);
    // Seen from the other direction, sides are the other way round.
    let oncoming = network.lane_relations(&[12]);
    assert_eq!(oncoming.relation_to(13), LaneRelation::Right);
    assert_eq!(oncoming.relation_to(11), LaneRelation::Oncoming);
    assert_eq!(oncoming.relation_to(1), LaneRelation::Oncoming);
}

#[test]
fn where_lanes_lie_over_each_other_the_heading_decides() {
    let network = crossroads();
    let driven = |heading: f64| network.lanelets_driven(&Pose::new(75.0, 0.0, heading));
    assert_eq!(driven(0.1), [2]);
    assert_eq!(driven(1.5), [31]);
    assert_eq!(driven(3.1), [2, 31], "neither");
}

/// Maps of other formats have thousands of lanes over each other: this takes minutes if each is looked at against all.
#[test]
fn thousands_of_lanelets_in_one_place_are_told_apart() {
    const COUNT: i64 = 2000;
    let lanelets = (1..=COUNT).map(|id| lanelet(id, &[(0.0, 0.0), (50.0, 0.0), (100.0, 0.0)]));
    let across = lanelet(COUNT + 1, &[(50.0, -50.0), (50.0, 50.0)]);
    let beside = (2..=COUNT).map(|id| lanelet(COUNT + id, &[(0.0, 9.0), (100.0, 9.0)]));
    let lanelets: Vec<_> = lanelets.chain([across]).chain(beside).collect();
    let on: Vec<(i64, i64)> = (1..COUNT).map(|id| (id, id + 1)).collect();
    let network = network(lanelets, &on, &[]);
    let all: Vec<i64> = (1..=COUNT).collect();
    let relations = network.lane_relations(&all);
    assert_eq!(relations.relation_to(COUNT + 1), LaneRelation::Crossing);
    for id in 2..=COUNT {
        assert_eq!(relations.relation_to(COUNT + id), LaneRelation::OtherRoad);
    }
    let poses = (0..40).map(|i| Pose::new(f64::from(i) * 2.0 + 5.0, 0.2, 0.0));
    // Each lanelet is said to follow the one that it lies on: no way leads there.
    assert!(network.lane_graph(None).route_along(poses).is_err());
}
