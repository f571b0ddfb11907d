//! The road: lanelets with their borders and neighbours, intersections, signs with what they mean, and what lights show.

use std::collections::HashMap;

use nearmiss_base::geometry::{Bounds, Point};
use serde::{Serialize, Serializer};

use super::road::Index;
use super::{LaneletType, LineMarking, RoadUser, SignalColor, TrafficDirection};

/// The lanelets of a scenario, with signs, lights and intersections.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LaneletNetwork {
    /// In the file's order.
    pub lanelets: Vec<Lanelet>,
    /// Traffic signs.
    pub signs: Vec<Sign>,
    /// Traffic lights.
    pub lights: Vec<TrafficLight>,
    /// Intersections.
    pub intersections: Vec<Intersection>,
    /// Outlines of what can be driven on beside the lanelets, each a ring (not closed): seen on maps, and no more.
    pub areas: Vec<Vec<Point>>,
    pub(super) index: Index,
    places: HashMap<i64, usize>,
    bounds: Vec<Bounds>,
}

/// A piece of lane between two borders, driven from the first to the last points.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Lanelet {
    /// Unique in the scenario.
    pub id: i64,
    /// Border on the left of the driving direction.
    #[serde(flatten, serialize_with = "left_bound")]
    pub left: Bound,
    /// Border on the right.
    #[serde(flatten, serialize_with = "right_bound")]
    pub right: Bound,
    /// Lanelets that end where this one begins.
    pub predecessors: Vec<i64>,
    /// Lanelets that begin where this one ends.
    pub successors: Vec<i64>,
    /// Neighbour on the left.
    pub adjacent_left: Option<Adjacent>,
    /// Neighbour on the right.
    pub adjacent_right: Option<Adjacent>,
    /// Where to stop.
    pub stop_line: Option<StopLine>,
    /// The kinds of road it is part of.
    pub types: Vec<LaneletType>,
    /// Road users that may use it in its direction.
    pub users_one_way: Vec<RoadUser>,
    /// Road users that may use it in both directions.
    pub users_bidirectional: Vec<RoadUser>,
    /// Signs that hold on it.
    #[serde(rename = "traffic_signs")]
    pub signs: Vec<i64>,
    /// Lights that hold on it.
    #[serde(rename = "traffic_lights")]
    pub lights: Vec<i64>,
}

/// Writes a border under keys of its side.
macro_rules! border {
    ($bound:ident, $marking:ident, $heights:ident) => {
        fn $bound<S: Serializer>(bound: &Bound, to: S) -> Result<S::Ok, S::Error> {
            #[derive(Serialize)]
            struct Side<'a> {
                $bound: &'a [Point],
                $marking: LineMarking,
                #[serde(skip_serializing_if = "<[f64]>::is_empty")]
                $heights: &'a [f64],
            }
            let side = Side {
                $bound: &bound.points,
                $marking: bound.marking,
                $heights: &bound.heights,
            };
            side.serialize(to)
        }
    };
}

border!(left_bound, left_line_marking, left_heights);
border!(right_bound, right_line_marking, right_heights);

/// One border of a lanelet.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// At least two points, in driving direction, metres.
    pub points: Vec<Point>,
    /// Heights of the points, metres; empty where the file has none.
    pub heights: Vec<f64>,
    /// The line marking.
    pub marking: LineMarking,
}

impl Default for Bound {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            heights: Vec::new(),
            marking: LineMarking::Unknown,
        }
    }
}

/// A neighbouring lanelet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Adjacent {
    /// Its id.
    pub id: i64,
    /// Whether it is driven in the same direction.
    pub same_direction: bool,
}

/// A line to stop at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StopLine {
    /// Its ends; without them it lies at the end of the lanelet.
    pub points: Option<(Point, Point)>,
    /// What is painted there.
    #[serde(rename = "line_marking")]
    pub marking: LineMarking,
    /// Signs it belongs to.
    #[serde(rename = "traffic_signs")]
    pub signs: Vec<i64>,
    /// Lights it belongs to.
    #[serde(rename = "traffic_lights")]
    pub lights: Vec<i64>,
}

/// A traffic sign.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sign {
    /// Unique in the scenario.
    pub id: i64,
    /// Where it stands.
    pub position: Option<Point>,
    /// Whether it stands only in the map, not on the road.
    #[serde(rename = "virtual")]
    pub is_virtual: bool,
    /// What it says; a post may carry several.
    pub elements: Vec<SignElement>,
}

impl Sign {
    /// The maximum speed that it shows, m/s.
    #[must_use]
    pub fn limit(&self) -> Option<f64> {
        self.elements
            .iter()
            .find_map(|element| match element.meaning() {
                Some(SignMeaning::SpeedLimit(limit)) => Some(limit),
                _ => None,
            })
    }

    /// A maximum speed, m/s, that files have of lanes and no sign: one with this number of the country, in the map alone.
    #[must_use]
    pub fn speed_limit(id: i64, number: &str, limit: f64, position: Option<Point>) -> Self {
        Self {
            id,
            position,
            is_virtual: true,
            elements: vec![SignElement {
                id: number.into(),
                values: vec![limit.to_string()],
            }],
        }
    }
}

/// One sign on a post.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SignElement {
    /// The country's number of the sign, e.g. `274`.
    pub id: String,
    /// Values on it, e.g. a speed in m/s.
    #[serde(rename = "additional_values")]
    pub values: Vec<String>,
}

/// A traffic light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrafficLight {
    /// Unique in the scenario.
    pub id: i64,
    /// Where it stands.
    pub position: Option<Point>,
    /// Whether it is switched on.
    pub active: bool,
    /// Whom it is for.
    pub direction: Option<TrafficDirection>,
    /// Time steps before the first phase begins.
    #[serde(rename = "time_offset")]
    pub offset: i64,
    /// Its phases, repeated for ever.
    pub cycle: Vec<LightPhase>,
}

/// One phase of a traffic light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct LightPhase {
    /// Time steps.
    pub duration: i64,
    /// Colour shown.
    pub color: SignalColor,
}

/// Where roads meet.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Intersection {
    /// Unique in the scenario.
    pub id: i64,
    /// Roads that lead in.
    pub incomings: Vec<Incoming>,
    /// Lanelets of crossings.
    pub crossings: Vec<i64>,
}

/// A road that leads into an intersection.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Incoming {
    /// Unique in the scenario.
    pub id: i64,
    /// Its last lanelets.
    pub lanelets: Vec<i64>,
    /// Lanelets that turn right.
    #[serde(rename = "successors_right")]
    pub right: Vec<i64>,
    /// Lanelets that go straight on.
    #[serde(rename = "successors_straight")]
    pub straight: Vec<i64>,
    /// Lanelets that turn left.
    #[serde(rename = "successors_left")]
    pub left: Vec<i64>,
    /// The incoming to the left of which this one is.
    pub is_left_of: Option<i64>,
}

impl Lanelet {
    /// The region between the borders, as a ring (not closed), whichever way they are drawn.
    #[must_use]
    pub fn ring(&self) -> Vec<Point> {
        let (left, right) = (&self.left.points, &self.right.points);
        let mut ring = Vec::with_capacity(left.len() + right.len());
        ring.extend_from_slice(left);
        if self.borders_disagree() {
            ring.extend(right);
        } else {
            ring.extend(right.iter().rev());
        }
        ring
    }
}

impl LaneletNetwork {
    /// A network of these parts, with its index built.
    #[must_use]
    pub fn new(
        lanelets: Vec<Lanelet>,
        signs: Vec<Sign>,
        lights: Vec<TrafficLight>,
        intersections: Vec<Intersection>,
    ) -> Self {
        // Of several with one id, the first is meant.
        let places = lanelets
            .iter()
            .enumerate()
            .rev()
            .map(|(i, l)| (l.id, i))
            .collect();
        let bounds = lanelets
            .iter()
            .map(|l| {
                let points = l.left.points.iter().chain(&l.right.points);
                Bounds::from_points(points).unwrap_or(Bounds {
                    min: Point::origin(),
                    max: Point::origin(),
                })
            })
            .collect();
        Self {
            lanelets,
            signs,
            lights,
            intersections,
            areas: Vec::new(),
            index: Index::default(),
            places,
            bounds,
        }
    }

    /// The lanelet with this id.
    #[must_use]
    pub fn lanelet(&self, id: i64) -> Option<&Lanelet> {
        self.place(id).map(|place| &self.lanelets[place])
    }

    /// The place in `lanelets` of the one with this id; of several the first.
    #[must_use]
    pub fn place(&self, id: i64) -> Option<usize> {
        self.places.get(&id).copied()
    }

    /// The box around a lanelet, by its place in `lanelets`.
    #[must_use]
    pub fn bounds_of(&self, place: usize) -> Bounds {
        self.bounds[place]
    }

    /// The box around the whole road; `None` if there is no road.
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        self.bounds.iter().copied().reduce(|a, b| a.union(&b))
    }
}

impl TrafficLight {
    /// The colour that it shows at a time step: its phases one after the other, for ever, before the offset too.
    #[must_use]
    pub fn color_at(&self, step: i64) -> SignalColor {
        let lasts = |duration: i64| i128::from(duration.max(0));
        let whole: i128 = self.cycle.iter().map(|p| lasts(p.duration)).sum();
        if !self.active || whole == 0 {
            return SignalColor::Inactive;
        }
        let mut left = (i128::from(step) - i128::from(self.offset)).rem_euclid(whole);
        for phase in &self.cycle {
            left -= lasts(phase.duration);
            if left < 0 {
                return phase.color;
            }
        }
        SignalColor::Inactive
    }
}

impl Lanelet {
    /// The ends of its stop line; one without points lies across the end of the lanelet.
    #[must_use]
    pub fn stop_line_ends(&self) -> Option<(Point, Point)> {
        let line = self.stop_line.as_ref()?;
        line.points
            .or_else(|| Some((*self.left.points.last()?, *self.right.points.last()?)))
    }
}

impl LaneletNetwork {
    /// Where a light stands; one without a position stands at the end of the first lanelet that it holds on.
    #[must_use]
    pub fn position_of(&self, light: &TrafficLight) -> Option<Point> {
        light.position.or_else(|| {
            let refers = |l: &&Lanelet| l.lights.contains(&light.id);
            let lanelet = self.lanelets.iter().find(refers)?;
            lanelet.right.points.last().copied()
        })
    }
}

/// What a sign tells a driver, as far as a map can show it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SignMeaning {
    /// No faster than this, m/s.
    SpeedLimit(f64),
    /// At least this fast, m/s.
    LeastSpeed(f64),
    /// Anything else, in a few words.
    Words(&'static str),
}

/// Words for the signs of Germany (by number) and of some others that files hold.
const WORDS: &[(&str, &str)] = &[
    ("101", "danger"),
    ("102", "right before left"),
    ("131", "lights ahead"),
    ("138", "cyclists"),
    ("201", "railway crossing"),
    ("205", "yield"),
    ("206", "stop"),
    ("208", "yield to oncoming"),
    ("209", "mandatory direction"),
    ("211", "turn here"),
    ("215", "roundabout"),
    ("220", "one way"),
    ("222", "pass here"),
    ("224", "bus stop"),
    ("237", "bicycles"),
    ("239", "pedestrians"),
    ("240", "foot and bicycle path"),
    ("242.1", "pedestrian zone"),
    ("244.1", "bicycle street"),
    ("245", "bus lane"),
    ("250", "no vehicles"),
    ("251", "no cars"),
    ("253", "no trucks"),
    ("254", "no bicycles"),
    ("259", "no pedestrians"),
    ("260", "no motor vehicles"),
    ("267", "no entry"),
    ("276", "no overtaking"),
    ("277", "no overtaking by trucks"),
    ("278", "end of limit"),
    ("280", "end of no overtaking"),
    ("282", "end of all limits"),
    ("283", "no stopping"),
    ("286", "no parking"),
    ("301", "right of way"),
    ("306", "priority road"),
    ("308", "priority over oncoming"),
    ("310", "town"),
    ("311", "end of town"),
    ("314", "parking"),
    ("325.1", "living street"),
    ("325.2", "end of living street"),
    ("330.1", "motorway"),
    ("330.2", "end of motorway"),
    ("331.1", "motor road"),
    ("331.2", "end of motor road"),
    ("350", "crossing"),
    ("357", "dead end"),
    ("R1-1", "stop"),
    ("R1-2", "yield"),
    ("R5-1", "no entry"),
    ("R6-1L", "one way"),
    ("R6-1R", "one way"),
    ("r1", "yield"),
    ("r2", "stop"),
];

/// Signs whose value is the highest speed, of any country.
const LIMITS: &[&str] = &["274", "274.1", "R2-1", "r301", "C43", "B14", "3.24"];

impl SignElement {
    /// What it means; `None` if its number is not known here.
    #[must_use]
    pub fn meaning(&self) -> Option<SignMeaning> {
        let speed = || self.values.iter().find_map(|v| v.trim().parse().ok());
        let speed = || speed().filter(|v: &f64| v.is_finite() && *v >= 0.0);
        // `274-56` is a variant of 274.
        let (base, _) = self.id.split_once('-').unwrap_or((&self.id, ""));
        if LIMITS.contains(&self.id.as_str()) || LIMITS.contains(&base) {
            return Some(match speed() {
                Some(limit) => SignMeaning::SpeedLimit(limit),
                None => SignMeaning::Words("speed limit"),
            });
        }
        if self.id == "275" {
            return Some(match speed() {
                Some(least) => SignMeaning::LeastSpeed(least),
                None => SignMeaning::Words("minimum speed"),
            });
        }
        let words = |id: &str| WORDS.iter().find(|(known, _)| *known == id);
        // `283-10` is a variant of 283.
        let variant = self.id.split('-').next().unwrap_or_default();
        let found = words(&self.id).or_else(|| words(variant))?;
        Some(SignMeaning::Words(found.1))
    }
}

impl Sign {
    /// Whether its speeds are told in miles an hour where it stands.
    fn in_miles(&self) -> bool {
        let american = |e: &SignElement| e.id.starts_with('R') && e.id.contains('-');
        self.elements.iter().any(american)
    }

    /// A speed (m/s) as the sign tells it, with its unit.
    #[must_use]
    pub fn speed_shown(&self, speed: f64) -> (f64, &'static str) {
        if self.in_miles() {
            (speed * 2.236_936, "mph")
        } else {
            (speed * 3.6, "km/h")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::LightPhase;
    use super::*;

    fn light(offset: i64, phases: &[(i64, SignalColor)]) -> TrafficLight {
        TrafficLight {
            id: 1,
            cycle: phases
                .iter()
                .map(|&(duration, color)| LightPhase { duration, color })
                .collect(),
            offset,
            position: None,
            direction: None,
            active: true,
        }
    }

    #[test]
    fn phases_follow_each_other_for_ever_and_began_before_the_offset() {
        use SignalColor::*;
        // 10 red and yellow, 150 green, 30 yellow, 170 red: 360 steps, and the first phase begins at step 320.
        let phases = [(10, RedYellow), (150, Green), (30, Yellow), (170, Red)];
        let light = light(320, &phases);
        // Step 0 is 40 steps into the cycle before.
        let expected = [
            (-40, RedYellow),
            (-31, RedYellow),
            (-30, Green),
            (0, Green),
            (119, Green),
            (120, Yellow),
            (149, Yellow),
            (150, Red),
            (319, Red),
            (320, RedYellow),
            (330, Green),
            (680, RedYellow),
        ];
        for (step, color) in expected {
            assert_eq!(light.color_at(step), color, "step {step}");
        }
    }

    #[test]
    fn what_is_off_or_has_no_phases_shows_nothing() {
        let mut off = light(0, &[(5, SignalColor::Red)]);
        assert_eq!(off.color_at(3), SignalColor::Red);
        off.active = false;
        assert_eq!(off.color_at(3), SignalColor::Inactive);
        assert_eq!(light(0, &[]).color_at(3), SignalColor::Inactive);
        let odd = [(0, SignalColor::Red), (-4, SignalColor::Yellow)];
        assert_eq!(light(0, &odd).color_at(3), SignalColor::Inactive);
        let long = [(i64::MAX, SignalColor::Red), (i64::MAX, SignalColor::Green)];
        // 2⁶⁴ − 1 steps into a cycle of 2⁶⁴ − 2.
        let late = light(i64::MIN, &long).color_at(i64::MAX);
        assert_eq!(late, SignalColor::Red);
    }

    #[test]
    fn signs_are_read_by_their_numbers() {
        let element = |id: &str, value: &str| SignElement {
            id: id.into(),
            values: vec![value.into()],
        };
        assert_eq!(
            element("274", " 13.888888").meaning(),
            Some(SignMeaning::SpeedLimit(13.888_888))
        );
        assert_eq!(
            element("274", "NaN").meaning(),
            Some(SignMeaning::Words("speed limit"))
        );
        assert_eq!(
            element("283-10", "").meaning(),
            Some(SignMeaning::Words("no stopping"))
        );
        assert_eq!(element("no such", "").meaning(), None);
    }
}
