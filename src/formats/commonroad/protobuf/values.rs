//! Strings, numbers, points, repeated elements and enumerations from messages, with the names of the latter in schema order.

use std::borrow::Cow;

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::plausibility::MOST_PARTS;
use nearmiss_scene::scenario::{
    LaneletType, LineMarking, ObstacleType, Quantity, RoadUser, SignalColor, Steps,
    TrafficDirection,
};
use prost::Message;

use super::messages::{self, FloatExactOrInterval, IntegerExactOrInterval};
use super::report::FieldPath;
use super::wire::Field;
use crate::commonroad::ReadError;
use crate::commonroad::builder::{self, ScenarioBuilder, SourceLocation, TimeScale};
use crate::commonroad::writer::allowed;

impl FieldPath<'_> {
    /// A text as XML gives it: trimmed, and with U+FFFD, and a diagnostic, for every character that no XML file can
    /// hold.
    pub fn text(&self, text: &str) -> String {
        let allowed = allowed(text.trim());
        if let Cow::Owned(_) = allowed {
            self.warn("control characters, not allowed in XML, were replaced by U+FFFD");
        }
        allowed.into_owned()
    }

    /// The texts of a repeated field; see [`FieldPath::text`].
    pub fn texts(&self, name: &str, texts: &[String]) -> Vec<String> {
        let numbered = texts.iter().enumerate();
        numbered
            .map(|(i, text)| self.nth(name, i).text(text))
            .collect()
    }

    /// A text that the schema requires.
    pub fn needed_text(&self, name: &str, text: Option<&String>) -> Result<String, ReadError> {
        Ok(self.field(name).text(self.need(name, text)?))
    }

    /// A number.
    pub fn finite(&self, value: f64) -> Result<f64, ReadError> {
        builder::finite(self, value, || value.to_string())
    }

    /// A length, width or radius that the schema requires, metres.
    pub fn size(&self, name: &str, value: Option<f64>) -> Result<f64, ReadError> {
        let (at, value) = (self.field(name), self.need(name, value)?);
        builder::size(&at, at.finite(value)?)
    }

    fn coordinate(&self, name: &str, value: Option<f64>) -> Result<f64, ReadError> {
        let (at, value) = (self.field(name), self.need(name, value)?);
        builder::coordinate(&at, at.finite(value)?)
    }

    /// A number that may be left out; one that is not finite is, with a diagnostic.
    pub fn optional(&self, name: &str, value: Option<f64>) -> Option<f64> {
        let value = value?;
        if !value.is_finite() {
            let message = format!("`{value}` is not a number and was left out");
            self.field(name).warn(message);
        }
        Some(value).filter(|v| v.is_finite())
    }

    /// A point in the plane: bodies have no height, and a z counts as not used.
    pub fn point(&self, point: &messages::Point) -> Result<Point, ReadError> {
        if point.z.is_some() {
            self.no_place_for("z");
        }
        self.in_plane(point)
    }

    fn in_plane(&self, point: &messages::Point) -> Result<Point, ReadError> {
        Ok(Point::new(
            self.coordinate("x", point.x)?,
            self.coordinate("y", point.y)?,
        ))
    }

    /// A point that the schema requires.
    pub fn needed_point(
        &self,
        name: &str,
        point: Option<&messages::Point>,
    ) -> Result<Point, ReadError> {
        self.field(name).point(self.need(name, point)?)
    }

    /// A point that may be left out.
    pub fn optional_point(
        &self,
        name: &str,
        point: Option<&messages::Point>,
    ) -> Result<Option<Point>, ReadError> {
        point.map(|p| self.field(name).point(p)).transpose()
    }

    /// Points, and the heights that some of them have.
    pub fn points(&self, all: &[messages::Point]) -> Result<(Vec<Point>, Vec<f64>), ReadError> {
        if all.len() > MOST_PARTS {
            return Err(self.fail(format!("more than {MOST_PARTS} points in one place")));
        }
        let mut points = Vec::with_capacity(all.len());
        let mut heights = Vec::new();
        for (i, message) in all.iter().enumerate() {
            let at = self.nth("points", i);
            points.push(at.in_plane(message)?);
            if let Some(z) = message.z {
                heights.push(at.field("z").finite(z)?);
            }
        }
        Ok((points, heights))
    }

    /// A number, exact or an interval; nothing, with a diagnostic, where it is neither.
    pub fn quantity(&self, value: &FloatExactOrInterval) -> Result<Option<Quantity>, ReadError> {
        let [exact, start, end] = numbers(value);
        let exact = exact.map(|exact| self.finite(exact)).transpose()?;
        let end_of = |name, end: Option<f64>| end.map(|v| self.field(name).finite(v)).transpose();
        let (start, end) = (end_of("start", start)?, end_of("end", end)?);
        builder::quantity(self, exact, start, end)
    }

    /// The same of a number that is left out, with a diagnostic, where it is not sound.
    pub fn optional_quantity(
        &self,
        value: &FloatExactOrInterval,
    ) -> Result<Option<Quantity>, ReadError> {
        let [exact, start, end] = numbers(value);
        builder::optional_quantity(self, exact, start, end)
    }

    /// A time step or an interval of them that the schema requires.
    pub fn steps(
        &self,
        name: &str,
        value: Option<&IntegerExactOrInterval>,
    ) -> Result<Steps, ReadError> {
        let (at, value) = (self.field(name), self.need(name, value)?);
        let interval = value.interval.unwrap_or_default();
        let [exact, start, end] =
            [value.exact, interval.start, interval.end].map(|step| step.map(f64::from));
        // The messages have whole numbers, so that the length of a step does not matter.
        TimeScale::default().steps(&at, exact, start, end)
    }

    /// The word of a number; a number without one is left out, and noted.
    pub fn word<T: Copy>(&self, words: &[T], number: i32) -> Option<T> {
        let found = word(words, number);
        if found.is_none() {
            self.warn(format!("unknown value {number} was left out"));
        }
        found
    }

    /// The word of a number; a number without one is taken as `fallback`, and noted.
    pub fn word_or<T: Copy + std::fmt::Display>(&self, words: &[T], number: i32, fallback: T) -> T {
        word(words, number).unwrap_or_else(|| {
            self.warn(format!("unknown value {number}; taken as {fallback}"));
            fallback
        })
    }

    /// The words of numbers; those without one are taken as `fallback`, and noted.
    pub fn names<T: Copy + std::fmt::Display>(
        &self,
        name: &str,
        words: &[T],
        numbers: &[i32],
        fallback: T,
    ) -> Vec<T> {
        let numbered = numbers.iter().enumerate();
        numbered
            .map(|(i, number)| self.nth(name, i).word_or(words, *number, fallback))
            .collect()
    }

    /// The word of a number that the schema requires.
    pub fn needed_word<T: Copy + std::fmt::Display>(
        &self,
        name: &str,
        words: &[T],
        number: Option<i32>,
        fallback: T,
    ) -> Result<T, ReadError> {
        let number = self.need(name, number)?;
        Ok(self.field(name).word_or(words, number, fallback))
    }
}

/// The exact number, or the ends of the interval.
fn numbers(value: &FloatExactOrInterval) -> [Option<f64>; 3] {
    match &value.interval {
        Some(interval) if value.exact.is_none() => [None, interval.start, interval.end],
        _ => [value.exact, None, None],
    }
}

fn word<T: Copy>(words: &[T], number: i32) -> Option<T> {
    let place = usize::try_from(number).ok()?;
    words.get(place).copied()
}

pub(super) fn ids(values: &[u32]) -> Vec<i64> {
    values.iter().map(|id| i64::from(*id)).collect()
}

/// The repeated elements of a file's own message, which are added to a scenario.
pub(super) struct Elements<'a> {
    pub root: &'a FieldPath<'a>,
    pub builder: &'a mut ScenarioBuilder,
    /// The numbers of fields, and how many of each there were.
    counts: Vec<(u32, usize)>,
}

impl<'a> Elements<'a> {
    pub fn new(root: &'a FieldPath<'a>, builder: &'a mut ScenarioBuilder) -> Self {
        Self {
            root,
            builder,
            counts: Vec::new(),
        }
    }

    /// Adds the element in a field with this name.
    pub fn add<M: Message + Default>(
        &mut self,
        name: &str,
        field: &Field<'_>,
        read: impl FnOnce(&mut ScenarioBuilder, &FieldPath<'_>, &M) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let at = self.root.nth(name, self.count(field.number));
        read(self.builder, &at, &at.element(field)?)
    }

    /// How many fields with a number there were before.
    fn count(&mut self, number: u32) -> usize {
        let known = self.counts.iter().position(|(n, _)| *n == number);
        let place = known.unwrap_or_else(|| {
            self.counts.push((number, 0));
            self.counts.len() - 1
        });
        self.counts[place].1 += 1;
        self.counts[place].1 - 1
    }
}

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

    use super::super::report::Report;
    use super::*;

    #[test]
    fn a_number_without_a_word_is_named() {
        let report = Report::about("x.pb");
        let root = FieldPath::root(&report, "");
        let types = root.names("types", LANELET_TYPES, &[0, 99, -1], LaneletType::Unknown);
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
        assert!(
            said[0].message.starts_with("unknown value 99;"),
            "{}",
            said[0].message
        );
    }

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
