//! What the tags of a lanelet say: its kind, its users, its speed limit.

use nearmiss_scene::scenario::{LaneletType, RoadUser};

/// What a lanelet is, and who uses it.
pub fn kind(subtype: &str, location: &str) -> (Vec<LaneletType>, Vec<RoadUser>) {
    match subtype {
        "highway" => (vec![LaneletType::Highway], vec![RoadUser::Vehicle]),
        "crosswalk" => (vec![LaneletType::Crosswalk], vec![RoadUser::Pedestrian]),
        "walkway" => (vec![LaneletType::Sidewalk], vec![RoadUser::Pedestrian]),
        "shared_walkway" => (
            vec![LaneletType::Sidewalk],
            vec![RoadUser::Pedestrian, RoadUser::Bicycle],
        ),
        "bicycle_lane" => (vec![LaneletType::BicycleLane], vec![RoadUser::Bicycle]),
        "bus_lane" => (vec![LaneletType::BusLane], vec![RoadUser::Bus]),
        "emergency_lane" => (vec![LaneletType::Shoulder], vec![RoadUser::Vehicle]),
        "parking" => (vec![LaneletType::Parking], vec![RoadUser::Vehicle]),
        _ if location == "nonurban" => (vec![LaneletType::Country], vec![RoadUser::Vehicle]),
        _ => (vec![LaneletType::Urban], vec![RoadUser::Vehicle]),
    }
}

/// A speed limit, m/s: kilometres an hour where no unit is said.
pub fn limit(text: &str) -> Option<f64> {
    let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit());
    let value: f64 = digits.trim().parse().ok()?;
    let metres = match text.trim_start_matches(digits).trim() {
        "mph" => value * 0.447_04,
        "m/s" | "mps" => value,
        _ => value / 3.6,
    };
    (metres > 0.0 && metres < 100.0).then_some((metres * 1e4).round() / 1e4)
}
