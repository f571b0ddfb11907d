//! The samples in ../shared: what the readers see in them is what is known of them.

use crate::support::recorded::shared;

use super::*;

#[test]
fn the_sample_of_waymo() {
    let Some(folder) = shared("waymo-motion") else {
        return;
    };
    let names = found(&folder);
    assert_eq!(
        names,
        ["motion_data_one_scenario.tfrecord#637f20cafde22ff8"]
    );
    let path = folder.join(&names[0]);
    let (scenario, ego) = own_ego(&path);
    // 83 tracks, of which the one at place 82 records.
    assert_eq!(scenario.obstacles.len(), 82);
    assert_eq!((ego.id, ego.track.steps()), (2406, 0..91));
    let lanes = scenario.network.lanelets.iter();
    let crossing =
        |l: &&nearmiss::scenario::Lanelet| l.types.iter().any(|t| t.name() == "crosswalk");
    // One of the 199 lanes is a single point, and said to be left out.
    assert_eq!(lanes.clone().filter(|l| !crossing(l)).count(), 198);
    assert_eq!(lanes.filter(crossing).count(), 4);
    assert!(messages(&scenario).contains("lane 529 has 1 points"));
    assert_eq!(scenario.network.lights.len(), 12);
    let lasts = scenario
        .network
        .lights
        .iter()
        .map(|l| l.cycle.iter().map(|p| p.duration).sum::<i64>());
    assert!(lasts.into_iter().all(|steps| steps == 91));
    // Readers of CommonRoad refuse others.
    let network = &scenario.network;
    for sign in &network.signs {
        let refer = |lane: &nearmiss::scenario::Lanelet| lane.signs.contains(&sign.id);
        assert!(network.lanelets.iter().any(refer), "sign {}", sign.id);
    }
    assert!(messages(&scenario).contains("stop signs of no lane in the map left out: 5"));
    survives_conversion(&scenario);
    any_track_can_be_the_ego(&path, 2406, 1580);
}

#[test]
fn the_sample_of_argoverse() {
    let Some(folder) = shared("argoverse2") else {
        return;
    };
    let names = found(&folder);
    assert_eq!(names.len(), 1);
    let (scenario, ego) = own_ego(&folder.join(&names[0]));
    // 58 tracks with that of the recording vehicle, 71 lanes and 6 crossings.
    assert_eq!(scenario.obstacles.len(), 57);
    assert_eq!(ego.track.steps(), 0..110);
    assert_eq!(scenario.network.lanelets.len(), 77);
    near(scenario.header.time_step_size, 0.1);
    survives_conversion(&scenario);
}
