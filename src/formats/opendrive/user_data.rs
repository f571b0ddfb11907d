//! What OpenDRIVE has no place for, or says less exactly: the lanelet of a lane, as user data beside it.

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::plausibility::refused_coordinate;
use nearmiss_scene::scenario::{
    Adjacent, Bound, Lanelet, LaneletType, LineMarking, RoadUser, StopLine,
};

/// The id of the lanelet.
pub const LANELET: &str = "commonroad_lanelet";

/// On a piece that was cut off the road of a lanelet for a junction: the id of that lanelet.
pub const PART_OF: &str = "commonroad_part_of";

const PLACE: &str = "commonroad_place";
const DEVIATION: &str = "commonroad_deviation";
const LEFT: &str = "commonroad_left";
const RIGHT: &str = "commonroad_right";
const MARKINGS: &str = "commonroad_markings";
const PREDECESSORS: &str = "commonroad_predecessors";
const SUCCESSORS: &str = "commonroad_successors";
const ADJACENT_LEFT: &str = "commonroad_adjacent_left";
const ADJACENT_RIGHT: &str = "commonroad_adjacent_right";
const STOP_LINE: &str = "commonroad_stop_line";
const SIGNS: &str = "commonroad_signs";
const LIGHTS: &str = "commonroad_lights";
const STOP_LINE_SIGNS: &str = "commonroad_stop_line_signs";
const STOP_LINE_LIGHTS: &str = "commonroad_stop_line_lights";
const TYPES: &str = "commonroad_types";
const USERS: &str = "commonroad_users";
const USERS_BOTH_WAYS: &str = "commonroad_users_bidirectional";

/// A lanelet as it was before it became a lane.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptLanelet {
    /// With the ids of its signs and lights, and of those of its stop line.
    pub lanelet: Lanelet,
    /// Its place in the network.
    pub place: usize,
    /// How far the borders of its lane are at most from its own, metres.
    pub deviation: f64,
}

impl KeptLanelet {
    /// Names and values. Lists that are empty are not among them.
    pub fn written(&self) -> Vec<(&'static str, String)> {
        let l = &self.lanelet;
        let ids = |ids: &[i64]| joined(ids.iter().map(i64::to_string));
        let users = |users: &[RoadUser]| joined(users.iter().map(|u| u.name().to_string()));
        let of_line = |all: fn(&StopLine) -> &Vec<i64>| {
            l.stop_line
                .as_ref()
                .map(|s| ids(all(s)))
                .unwrap_or_default()
        };
        let all = [
            (LANELET, l.id.to_string()),
            (PLACE, self.place.to_string()),
            (DEVIATION, format!("{:.4}", self.deviation)),
            (LEFT, points(&l.left.points)),
            (RIGHT, points(&l.right.points)),
            (
                MARKINGS,
                format!("{} {}", l.left.marking.name(), l.right.marking.name()),
            ),
            (PREDECESSORS, ids(&l.predecessors)),
            (SUCCESSORS, ids(&l.successors)),
            (ADJACENT_LEFT, adjacent(l.adjacent_left)),
            (ADJACENT_RIGHT, adjacent(l.adjacent_right)),
            (
                STOP_LINE,
                l.stop_line.as_ref().map(stop_line).unwrap_or_default(),
            ),
            (SIGNS, ids(&l.signs)),
            (LIGHTS, ids(&l.lights)),
            (STOP_LINE_SIGNS, of_line(|s| &s.signs)),
            (STOP_LINE_LIGHTS, of_line(|s| &s.lights)),
            (TYPES, joined(l.types.iter().map(|t| t.name().to_string()))),
            (USERS, users(&l.users_one_way)),
            (USERS_BOTH_WAYS, users(&l.users_bidirectional)),
        ];
        all.into_iter()
            .filter(|(_, value)| !value.is_empty())
            .collect()
    }

    /// The lanelet that values by name tell; `None` where one is missing that is always written, or cannot be read.
    pub fn read<'a>(value: impl Fn(&str) -> Option<&'a str>) -> Option<Self> {
        let needed = |name: &str| value(name);
        let list = |name: &str| value(name).unwrap_or_default().split_whitespace();
        let ids = |name: &str| -> Option<Vec<i64>> { list(name).map(|w| w.parse().ok()).collect() };
        let users =
            |name: &str| -> Option<Vec<RoadUser>> { list(name).map(RoadUser::parse).collect() };
        let (left, right) = needed(MARKINGS)?.split_once(' ')?;
        let bound = |name: &str, marking: &str| -> Option<Bound> {
            Some(Bound {
                points: read_points(needed(name)?.split_whitespace())?,
                heights: Vec::new(),
                marking: LineMarking::parse(marking)?,
            })
        };
        let types: Option<Vec<LaneletType>> = list(TYPES).map(LaneletType::parse).collect();
        let lanelet = Lanelet {
            id: needed(LANELET)?.parse().ok()?,
            left: bound(LEFT, left)?,
            right: bound(RIGHT, right)?,
            predecessors: ids(PREDECESSORS)?,
            successors: ids(SUCCESSORS)?,
            adjacent_left: read_adjacent(value(ADJACENT_LEFT))?,
            adjacent_right: read_adjacent(value(ADJACENT_RIGHT))?,
            stop_line: match value(STOP_LINE) {
                Some(text) => Some(StopLine {
                    signs: ids(STOP_LINE_SIGNS)?,
                    lights: ids(STOP_LINE_LIGHTS)?,
                    ..read_stop_line(text)?
                }),
                None => None,
            },
            types: types?,
            users_one_way: users(USERS)?,
            users_bidirectional: users(USERS_BOTH_WAYS)?,
            signs: ids(SIGNS)?,
            lights: ids(LIGHTS)?,
        };
        let paired = |bound: &Bound| bound.points.len() > 1;
        if !paired(&lanelet.left) || !paired(&lanelet.right) {
            return None;
        }
        let deviation: f64 = needed(DEVIATION)?.parse().ok()?;
        Some(Self {
            lanelet,
            place: needed(PLACE)?.parse().ok()?,
            deviation: deviation.clamp(0.0, MOST_OFF),
        })
    }
}

/// No lane is farther from its lanelet, metres.
const MOST_OFF: f64 = 1.0;

fn joined(words: impl Iterator<Item = String>) -> String {
    words.collect::<Vec<_>>().join(" ")
}

/// Coordinates in full: what is read is what was there.
fn points(all: &[Point]) -> String {
    joined(all.iter().map(|p| format!("{} {}", p.x, p.y)))
}

fn read_points<'a>(words: impl Iterator<Item = &'a str>) -> Option<Vec<Point>> {
    let number = |word: &str| -> Option<f64> {
        let value = word.parse::<f64>().ok().filter(|v| v.is_finite())?;
        refused_coordinate(value).is_none().then_some(value)
    };
    let numbers: Vec<f64> = words.map(number).collect::<Option<_>>()?;
    if numbers.len() % 2 == 1 {
        return None;
    }
    Some(numbers.chunks(2).map(|p| Point::new(p[0], p[1])).collect())
}

fn adjacent(of: Option<Adjacent>) -> String {
    of.map_or_else(String::new, |a| {
        let direction = if a.same_direction { "same" } else { "opposite" };
        format!("{} {direction}", a.id)
    })
}

/// Nothing where nothing is written; `None` where it cannot be read.
#[allow(clippy::option_option)]
fn read_adjacent(text: Option<&str>) -> Option<Option<Adjacent>> {
    let Some(text) = text else {
        return Some(None);
    };
    let (id, direction) = text.split_once(' ')?;
    Some(Some(Adjacent {
        id: id.parse().ok()?,
        same_direction: match direction {
            "same" => true,
            "opposite" => false,
            _ => return None,
        },
    }))
}

fn stop_line(of: &StopLine) -> String {
    let ends = of
        .points
        .map(|(a, b)| [a, b])
        .map_or_else(String::new, |ends| format!(" {}", points(&ends)));
    format!("{}{ends}", of.marking.name())
}

fn read_stop_line(text: &str) -> Option<StopLine> {
    let mut words = text.split_whitespace();
    let marking = LineMarking::parse(words.next()?)?;
    let points = match &read_points(words)?[..] {
        [] => None,
        [a, b] => Some((*a, *b)),
        _ => return None,
    };
    Some(StopLine {
        points,
        marking,
        signs: Vec::new(),
        lights: Vec::new(),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    fn kept() -> KeptLanelet {
        let bound = |y: f64, marking| Bound {
            points: vec![
                Point::new(0.1, y),
                Point::new(1.0 / 3.0, y),
                Point::new(1e5, y),
            ],
            heights: Vec::new(),
            marking,
        };
        let lanelet = Lanelet {
            id: 7,
            left: bound(3.5, LineMarking::Dashed),
            right: bound(0.0, LineMarking::Curb),
            predecessors: vec![5, 6],
            adjacent_left: Some(Adjacent {
                id: 8,
                same_direction: false,
            }),
            stop_line: Some(StopLine {
                points: Some((Point::new(1.0, 0.0), Point::new(1.0, 3.5))),
                marking: LineMarking::Solid,
                signs: vec![31],
                lights: vec![41, 42],
            }),
            signs: vec![31, 32],
            lights: vec![41],
            types: vec![LaneletType::Urban],
            users_one_way: vec![RoadUser::Vehicle, RoadUser::Bicycle],
            ..Lanelet::default()
        };
        KeptLanelet {
            lanelet,
            place: 3,
            deviation: 0.0125,
        }
    }

    #[test]
    fn a_lanelet_is_read_as_it_was_written() {
        let written: HashMap<&str, String> = kept().written().into_iter().collect();
        assert!(!written.contains_key(SUCCESSORS));
        let read = KeptLanelet::read(|name| written.get(name).map(String::as_str));
        assert_eq!(read.unwrap(), kept());
    }

    #[test]
    fn what_is_missing_or_damaged_is_not_read() {
        for damaged in [LEFT, MARKINGS, PLACE, DEVIATION, LANELET] {
            let mut written: HashMap<&str, String> = kept().written().into_iter().collect();
            written.remove(damaged);
            assert!(KeptLanelet::read(|name| written.get(name).map(String::as_str)).is_none());
        }
        for (name, value) in [
            (LEFT, "1 2 3"),
            (RIGHT, "1 2 nan 4"),
            (RIGHT, "1 2"),
            (LEFT, "1e300 2 3 4"),
            (SUCCESSORS, "x"),
            (SIGNS, "1 x"),
            (STOP_LINE_LIGHTS, "x"),
            (ADJACENT_LEFT, "8 up"),
            (STOP_LINE, "solid 1 2"),
            (TYPES, "road"),
        ] {
            let mut written: HashMap<&str, String> = kept().written().into_iter().collect();
            written.insert(name, value.into());
            let read = KeptLanelet::read(|name| written.get(name).map(String::as_str));
            assert!(read.is_none(), "{name}: {value}");
        }
    }
}
