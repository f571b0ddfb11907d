//! The words behind the numbers of the enumerations, in the order of the schemas (commonroad-io 2024.3 and 2026.1).

use super::report::{At, Report};
use crate::scenario::commonroad::ReadError;
use crate::scenario::{
    LaneletType, LineMarking, ObstacleType, RoadUser, SignalColor, StateField, TrafficDirection,
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

/// Of environment obstacles in the map of 2024.
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

/// The quantity that a field of a state is; 26 and 27 (front and rear wheel speed) are in no XML and have no word here.
pub(super) fn state_field(number: u32) -> Option<StateField> {
    Some(match number {
        3 => StateField::Orientation,
        4 => StateField::Velocity,
        5 => StateField::SteeringAngle,
        6 => StateField::SteeringAngleSpeed,
        7 => StateField::YawRate,
        8 => StateField::SlipAngle,
        9 => StateField::RollAngle,
        10 => StateField::RollRate,
        11 => StateField::PitchAngle,
        12 => StateField::PitchRate,
        13 => StateField::VelocityY,
        14 => StateField::PositionZ,
        15 => StateField::VelocityZ,
        16 => StateField::RollAngleFront,
        17 => StateField::RollRateFront,
        18 => StateField::VelocityYFront,
        19 => StateField::PositionZFront,
        20 => StateField::VelocityZFront,
        21 => StateField::RollAngleRear,
        22 => StateField::RollRateRear,
        23 => StateField::VelocityYRear,
        24 => StateField::PositionZRear,
        25 => StateField::VelocityZRear,
        28 => StateField::LeftFrontWheelAngularSpeed,
        29 => StateField::RightFrontWheelAngularSpeed,
        30 => StateField::LeftRearWheelAngularSpeed,
        31 => StateField::RightRearWheelAngularSpeed,
        32 => StateField::DeltaYFront,
        33 => StateField::DeltaYRear,
        34 => StateField::Acceleration,
        35 => StateField::AccelerationY,
        36 => StateField::Jerk,
        37 => StateField::Curvature,
        38 => StateField::CurvatureChange,
        _ => return None,
    })
}

/// The word of a number; a number without one is noted.
pub(super) fn word<T: Copy>(
    report: &mut Report,
    at: &At<'_>,
    words: &[T],
    number: i32,
) -> Option<T> {
    let found = usize::try_from(number).ok().and_then(|n| words.get(n));
    if found.is_none() {
        report.warn(at, format!("{number} has no meaning here and was left out"));
    }
    found.copied()
}

/// The word of a number; a number without one is taken as `fallback`, and noted.
pub(super) fn word_or<T: Copy + std::fmt::Display>(
    report: &mut Report,
    at: &At<'_>,
    words: &[T],
    number: i32,
    fallback: T,
) -> T {
    let found = usize::try_from(number).ok().and_then(|n| words.get(n));
    found.copied().unwrap_or_else(|| {
        report.warn(
            at,
            format!("{number} has no meaning here; taken as {fallback}"),
        );
        fallback
    })
}

/// The words of numbers; those without one are taken as `fallback`, and noted.
pub(super) fn all<T: Copy + std::fmt::Display>(
    report: &mut Report,
    at: &At<'_>,
    name: &str,
    words: &[T],
    numbers: &[i32],
    fallback: T,
) -> Vec<T> {
    let numbered = numbers.iter().enumerate();
    numbered
        .map(|(i, number)| word_or(report, &at.nth(name, i), words, *number, fallback))
        .collect()
}

/// The tags of a scenario.
pub(super) fn tags(report: &mut Report, at: &At<'_>, numbers: &[i32]) -> Vec<String> {
    let numbered = numbers.iter().enumerate();
    numbered
        .filter_map(|(i, number)| word(report, &at.nth("tags", i), TAGS, *number))
        .map(str::to_string)
        .collect()
}

/// The word of a number that the schema requires.
pub(super) fn needed_word<T: Copy + std::fmt::Display>(
    report: &mut Report,
    at: &At<'_>,
    name: &str,
    words: &[T],
    number: Option<i32>,
    fallback: T,
) -> Result<T, ReadError> {
    let number = report.need(at, name, number)?;
    Ok(word_or(report, &at.field(name), words, number, fallback))
}

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
        let fields: Vec<_> = (0..100).filter_map(state_field).collect();
        distinct(&fields);
        assert_eq!(fields.len(), 34);
    }

    #[test]
    fn a_number_without_a_word_is_named() {
        let mut report = Report::about("x.pb");
        let root = At::root("");
        let types = all(
            &mut report,
            &root,
            "types",
            LANELET_TYPES,
            &[0, 99, -1],
            LaneletType::Unknown,
        );
        assert_eq!(
            types,
            [
                LaneletType::Urban,
                LaneletType::Unknown,
                LaneletType::Unknown
            ]
        );
        let said = report.into_diagnostics();
        assert_eq!(said.len(), 2);
        assert_eq!(said[0].element, "types[1]");
        assert!(said[0].message.starts_with("99 "), "{}", said[0].message);
    }
}
