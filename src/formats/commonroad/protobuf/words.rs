//! Names of enumeration values, in schema order (commonroad-io 2024.3 and 2026.1).

use nearmiss_scene::scenario::{
    LaneletType, LineMarking, ObstacleType, RoadUser, SignalColor, TrafficDirection,
};

pub(super) const LINE_MARKINGS: &[LineMarking] = &[
    LineMarking::Dashed,
    LineMarking::Solid,
    LineMarking::SolidSolid,
    LineMarking::DashedDashed,
    LineMarking::SolidDashed,
    LineMarking::DashedSolid,
    LineMarking::Curb,
    LineMarking::LoweredCurb,
    LineMarking::BroadDashed,
    LineMarking::BroadSolid,
    LineMarking::Unknown,
    LineMarking::NoMarking,
];

pub(super) const LANELET_TYPES: &[LaneletType] = &[
    LaneletType::Urban,
    LaneletType::Country,
    LaneletType::Highway,
    LaneletType::DriveWay,
    LaneletType::MainCarriageWay,
    LaneletType::AccessRamp,
    LaneletType::ExitRamp,
    LaneletType::Shoulder,
    LaneletType::BusLane,
    LaneletType::BusStop,
    LaneletType::BicycleLane,
    LaneletType::Sidewalk,
    LaneletType::Crosswalk,
    LaneletType::Interstate,
    LaneletType::Intersection,
    LaneletType::Border,
    LaneletType::Parking,
    LaneletType::Restricted,
    LaneletType::RestrictedArea,
    LaneletType::Unknown,
];

pub(super) const ROAD_USERS: &[RoadUser] = &[
    RoadUser::Vehicle,
    RoadUser::Car,
    RoadUser::Truck,
    RoadUser::Bus,
    RoadUser::PriorityVehicle,
    RoadUser::Motorcycle,
    RoadUser::Bicycle,
    RoadUser::Pedestrian,
    RoadUser::Train,
    RoadUser::Taxi,
];

/// In 2024 there is a 16 too, a vehicle of any kind, for which there is no word here.
pub(super) const OBSTACLE_TYPES: &[ObstacleType] = &[
    ObstacleType::Unknown,
    ObstacleType::Car,
    ObstacleType::Truck,
    ObstacleType::Bus,
    ObstacleType::Bicycle,
    ObstacleType::Pedestrian,
    ObstacleType::PriorityVehicle,
    ObstacleType::ParkedVehicle,
    ObstacleType::ConstructionZone,
    ObstacleType::Train,
    ObstacleType::RoadBoundary,
    ObstacleType::Motorcycle,
    ObstacleType::Taxi,
    ObstacleType::Building,
    ObstacleType::Pillar,
    ObstacleType::MedianStrip,
];

/// Names of environment obstacles in the map of 2024.
pub(super) const MAP_OBSTACLE_TYPES: &[ObstacleType] = &[
    ObstacleType::Unknown,
    ObstacleType::Building,
    ObstacleType::RoadBoundary,
    ObstacleType::Pillar,
    ObstacleType::MedianStrip,
];

pub(super) const SIGNAL_COLORS: &[SignalColor] = &[
    SignalColor::Red,
    SignalColor::RedYellow,
    SignalColor::Green,
    SignalColor::Yellow,
    SignalColor::Inactive,
];

pub(super) const DIRECTIONS: &[TrafficDirection] = &[
    TrafficDirection::Right,
    TrafficDirection::Straight,
    TrafficDirection::Left,
    TrafficDirection::LeftStraight,
    TrafficDirection::StraightRight,
    TrafficDirection::LeftRight,
    TrafficDirection::All,
];

pub(super) const TAGS: &[&str] = &[
    "interstate",
    "urban",
    "highway",
    "comfort",
    "critical",
    "evasive",
    "cut_in",
    "illegal_cutin",
    "intersection",
    "lane_change",
    "lane_following",
    "merging_lanes",
    "multi_lane",
    "oncoming_traffic",
    "no_oncoming_traffic",
    "parallel_lanes",
    "race_track",
    "roundabout",
    "rural",
    "simulated",
    "single_lane",
    "slip_road",
    "speed_limit",
    "traffic_jam",
    "turn_left",
    "turn_right",
    "two_lane",
    "emergency_braking",
];

/// The words of an environment.
pub(super) struct EnvironmentWords {
    pub times_of_day: &'static [&'static str],
    pub weathers: &'static [&'static str],
}

pub(super) const ENVIRONMENT_2020A: EnvironmentWords = EnvironmentWords {
    times_of_day: &["night", "day", "unknown"],
    weathers: &[
        "sunny",
        "light_rain",
        "heavy_rain",
        "fog",
        "snow",
        "hail",
        "unknown",
    ],
};

pub(super) const ENVIRONMENT_2024: EnvironmentWords = EnvironmentWords {
    times_of_day: &["night", "sunset", "afternoon", "noon", "morning", "unknown"],
    weathers: &[
        "clear",
        "light_rain",
        "mid_rain",
        "heavy_rain",
        "fog",
        "snow",
        "hail",
        "cloudy",
        "unknown",
    ],
};

pub(super) const UNDERGROUNDS: &[&str] =
    &["wet", "clean", "dirty", "damaged", "snow", "ice", "unknown"];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_has_one_number() {
        fn distinct<T: std::fmt::Debug>(words: &[T]) {
            let texts: std::collections::HashSet<_> =
                words.iter().map(|w| format!("{w:?}")).collect();
            assert_eq!(texts.len(), words.len(), "{words:?}");
        }
        distinct(LINE_MARKINGS);
        distinct(LANELET_TYPES);
        distinct(ROAD_USERS);
        distinct(OBSTACLE_TYPES);
        distinct(SIGNAL_COLORS);
        distinct(DIRECTIONS);
        distinct(TAGS);
        assert_eq!(LINE_MARKINGS.len(), LineMarking::ALL.len());
        assert_eq!(OBSTACLE_TYPES.len(), ObstacleType::ALL.len());
        assert_eq!(ROAD_USERS.len(), RoadUser::ALL.len());
        assert_eq!(SIGNAL_COLORS.len(), SignalColor::ALL.len());
        assert_eq!(DIRECTIONS.len(), TrafficDirection::ALL.len());
    }
}
