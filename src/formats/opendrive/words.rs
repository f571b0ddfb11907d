//! The words of OpenDRIVE for what lanelets are and how their borders are marked.

use nearmiss_scene::scenario::{Lanelet, LaneletType, LineMarking, RoadUser};

/// The type of a lane.
pub fn lane_type(lanelet: &Lanelet) -> &'static str {
    let is = |wanted: LaneletType| lanelet.types.contains(&wanted);
    let by_type = [
        (LaneletType::Shoulder, "shoulder"),
        (LaneletType::Sidewalk, "sidewalk"),
        (LaneletType::Crosswalk, "sidewalk"),
        (LaneletType::BicycleLane, "biking"),
        (LaneletType::BusLane, "bus"),
        (LaneletType::BusStop, "stop"),
        (LaneletType::Tram, "tram"),
        (LaneletType::Parking, "parking"),
        (LaneletType::Border, "border"),
        (LaneletType::Restricted, "restricted"),
        (LaneletType::RestrictedArea, "restricted"),
        (LaneletType::AccessRamp, "onRamp"),
        (LaneletType::ExitRamp, "offRamp"),
    ];
    if let Some((_, word)) = by_type.iter().find(|(t, _)| is(*t)) {
        return word;
    }
    let users = || {
        lanelet
            .users_one_way
            .iter()
            .chain(&lanelet.users_bidirectional)
    };
    let only =
        |wanted: &[RoadUser]| users().next().is_some() && users().all(|u| wanted.contains(u));
    if only(&[RoadUser::Pedestrian]) {
        "sidewalk"
    } else if only(&[RoadUser::Bicycle, RoadUser::Pedestrian]) {
        "biking"
    } else if lanelet.users_bidirectional.contains(&RoadUser::Vehicle)
        || lanelet.users_bidirectional.contains(&RoadUser::Car)
    {
        "bidirectional"
    } else {
        "driving"
    }
}

/// The type of a road.
pub fn road_type(lanelets: &[&Lanelet]) -> &'static str {
    let any = |wanted: LaneletType| lanelets.iter().any(|l| l.types.contains(&wanted));
    if any(LaneletType::Interstate) || any(LaneletType::Highway) {
        "motorway"
    } else if any(LaneletType::Country) {
        "rural"
    } else if lanelets.iter().all(|l| matches!(lane_type(l), "sidewalk")) {
        "pedestrian"
    } else if lanelets.iter().all(|l| lane_type(l) == "biking") {
        "bicycle"
    } else if any(LaneletType::Urban) || any(LaneletType::Intersection) {
        "town"
    } else {
        "unknown"
    }
}

/// A marking of a border: its type and weight.
pub fn road_mark(marking: LineMarking) -> (&'static str, &'static str) {
    match marking {
        LineMarking::Dashed => ("broken", "standard"),
        LineMarking::Solid => ("solid", "standard"),
        LineMarking::SolidSolid => ("solid solid", "standard"),
        LineMarking::DashedDashed => ("broken broken", "standard"),
        LineMarking::SolidDashed => ("solid broken", "standard"),
        LineMarking::DashedSolid => ("broken solid", "standard"),
        LineMarking::Curb | LineMarking::LoweredCurb => ("curb", "standard"),
        LineMarking::BroadDashed => ("broken", "bold"),
        LineMarking::BroadSolid => ("solid", "bold"),
        LineMarking::NoMarking | LineMarking::Unknown => ("none", "standard"),
    }
}

/// The marking that a type and weight tell.
pub fn marking(kind: &str, weight: &str) -> LineMarking {
    match (kind, weight) {
        ("broken", "bold") => LineMarking::BroadDashed,
        ("solid", "bold") => LineMarking::BroadSolid,
        ("broken", _) => LineMarking::Dashed,
        ("solid", _) => LineMarking::Solid,
        ("solid solid", _) => LineMarking::SolidSolid,
        ("broken broken", _) => LineMarking::DashedDashed,
        ("solid broken", _) => LineMarking::SolidDashed,
        ("broken solid", _) => LineMarking::DashedSolid,
        ("curb", _) => LineMarking::Curb,
        ("none", _) => LineMarking::NoMarking,
        _ => LineMarking::Unknown,
    }
}
