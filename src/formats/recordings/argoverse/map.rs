//! Maps of Argoverse 2: `log_map_archive_ID.json`.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;

use super::LARGEST;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::{Ids, Map};
use crate::recordings::lane_shape::{self, matched, same_way};
use crate::recordings::{At, Leftovers, Report};
use nearmiss_base::geometry::Point;
use nearmiss_base::system;
use nearmiss_scene::scenario::{
    Adjacent, Bound, ContentHash, Lanelet, LaneletType, LineMarking, RoadUser,
};

/// A map as it is in the file, with its elements still to be read.
pub struct Archive {
    file: String,
    lanes: Elements,
    crossings: Elements,
    areas: Elements,
    leftovers: Leftovers,
    pub hash: ContentHash,
}

#[derive(Deserialize)]
struct MapFile {
    lane_segments: Elements,
    #[serde(default)]
    pedestrian_crossings: Elements,
    #[serde(default)]
    drivable_areas: Elements,
}

/// The keys that are used, of the map and of its elements.
const KEYS: [&str; 3] = ["lane_segments", "pedestrian_crossings", "drivable_areas"];
const SEGMENT: [&str; 11] = [
    "id",
    "is_intersection",
    "lane_type",
    "left_lane_boundary",
    "right_lane_boundary",
    "left_lane_mark_type",
    "right_lane_mark_type",
    "successors",
    "predecessors",
    "left_neighbor_id",
    "right_neighbor_id",
];
const CROSSING: [&str; 3] = ["id", "edge1", "edge2"];
const AREA: [&str; 2] = ["id", "area_boundary"];

/// Counts the keys of an object that are not used.
fn count_unused(json: &[u8], name: &str, used: &[&str], leftovers: &mut Leftovers) {
    // What is no object is told by those who read it.
    let keys = serde_json::from_slice::<HashMap<String, IgnoredAny>>(json).unwrap_or_default();
    for key in keys.keys().filter(|key| !used.contains(&key.as_str())) {
        leftovers.field(name, key);
    }
}

/// The elements of an object in the order of the file, still to be read: errors then name the element.
#[derive(Default)]
struct Elements(Vec<(String, Box<RawValue>)>);

impl<'de> Deserialize<'de> for Elements {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Elements;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Elements, A::Error> {
                let mut all = Vec::new();
                while let Some(element) = map.next_entry()? {
                    all.push(element);
                }
                Ok(Elements(all))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}

#[derive(Deserialize)]
struct Segment {
    id: i64,
    #[serde(default)]
    is_intersection: bool,
    #[serde(default)]
    lane_type: String,
    left_lane_boundary: Vec<Corner>,
    right_lane_boundary: Vec<Corner>,
    #[serde(default)]
    left_lane_mark_type: String,
    #[serde(default)]
    right_lane_mark_type: String,
    #[serde(default)]
    successors: Vec<i64>,
    #[serde(default)]
    predecessors: Vec<i64>,
    left_neighbor_id: Option<i64>,
    right_neighbor_id: Option<i64>,
}

#[derive(Deserialize)]
struct Crossing {
    id: i64,
    edge1: Vec<Corner>,
    edge2: Vec<Corner>,
}

#[derive(Deserialize)]
struct Area {
    area_boundary: Vec<Corner>,
}

#[derive(Deserialize)]
struct Corner {
    x: f64,
    y: f64,
    z: Option<f64>,
}

/// The map of a scenario, in the same folder: by the scenario's id, or the only one there.
pub fn find_map(path: &Path, scenario: &str) -> Option<PathBuf> {
    let folder = path.parent()?;
    let plain = scenario
        .chars()
        .all(|c| c.is_ascii_alphanumeric() || c == '-');
    let named = folder.join(format!("{PREFIX}{scenario}.json"));
    if plain && named.is_file() {
        return Some(named);
    }
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let files = folder
        .read_dir()
        .into_iter()
        .flatten()
        .flatten()
        .map(|file| file.path());
    let mut maps = files.filter(|file| {
        let name = file
            .file_name()
            .map(|n| n.to_string_lossy())
            .unwrap_or_default();
        name.starts_with(PREFIX) && name.ends_with(".json")
    });
    let first = maps.next()?;
    maps.next().is_none().then_some(first)
}

/// Names of maps begin so.
const PREFIX: &str = "log_map_archive_";

impl Archive {
    /// Reads the file.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let file = path.display().to_string();
        let bytes = system::read_file(path, LARGEST).map_err(|e| ReadError::io(&file, &e))?;
        let whole: MapFile = serde_json::from_slice(&bytes).map_err(|error| ReadError {
            file: file.clone(),
            line: error.line(),
            column: error.column(),
            element: String::new(),
            message: format!("not a map of Argoverse 2: {error}"),
        })?;
        let mut leftovers = Leftovers::default();
        count_unused(&bytes, "", &KEYS, &mut leftovers);
        let parts = [
            ("lane_segments", &SEGMENT[..], &whole.lane_segments),
            (
                "pedestrian_crossings",
                &CROSSING,
                &whole.pedestrian_crossings,
            ),
            ("drivable_areas", &AREA, &whole.drivable_areas),
        ];
        for (name, used, elements) in parts {
            for (_, element) in &elements.0 {
                count_unused(element.get().as_bytes(), name, used, &mut leftovers);
            }
        }
        Ok(Self {
            file,
            leftovers,
            lanes: whole.lane_segments,
            crossings: whole.pedestrian_crossings,
            areas: whole.drivable_areas,
            hash: ContentHash::digest(&bytes),
        })
    }

    /// The ids that it uses.
    pub fn ids(&self) -> impl Iterator<Item = i64> {
        let all = self.lanes.0.iter().chain(&self.crossings.0);
        all.filter_map(|(key, _)| key.parse().ok())
    }

    /// The map, with what is assumed noted in `report`.
    pub fn map(&self, report: &Report, ids: &mut Ids) -> Result<Map, ReadError> {
        let own = Report::about(&self.file);
        self.leftovers.report_to(report);
        let mut segments = Vec::with_capacity(self.lanes.0.len());
        for (key, value) in &self.lanes.0 {
            let at = own.at(format!("lane_segments/{key}"));
            segments.push((element::<Segment>(&at, value)?, key));
        }
        let mut lane_ids = HashMap::new();
        for (segment, _) in &segments {
            lane_ids
                .entry(segment.id)
                .or_insert_with(|| ids.keep(segment.id));
        }
        let mut map = Map::default();
        let mut seen = HashSet::new();
        for (segment, key) in &segments {
            let at = own.at(format!("lane_segments/{key}"));
            if !seen.insert(segment.id) {
                let message = format!("lane {} is there twice; the first is used", segment.id);
                report.at(format!("lane_segments/{key}")).warn(message);
                continue;
            }
            map.lanelets.push(lanelet(&at, segment, &lane_ids)?);
        }
        let beyond = beside_each_other(&mut map.lanelets, &lane_ids, &segments);
        report.note_count(beyond, |n| {
            format!("links to lanes beyond the map left out: {n}")
        });
        for (key, value) in &self.crossings.0 {
            let at = own.at(format!("pedestrian_crossings/{key}"));
            let said: Crossing = element(&at, value)?;
            let left = points(&at, &said.edge1)?.0;
            let mut right = points(&at, &said.edge2)?.0;
            if left.len() < 2 || right.len() < 2 {
                report
                    .at(format!("pedestrian_crossings/{key}"))
                    .warn("an edge without two points; left out");
                continue;
            }
            if !same_way(&left, &right) {
                right.reverse();
            }
            // The one on the right is the right one.
            let along = left[left.len() - 1] - left[0];
            let (left, right) = if along.perp(&(right[0] - left[0])) > 0.0 {
                (right, left)
            } else {
                (left, right)
            };
            let (left, right) = matched(left, right);
            map.lanelets
                .push(lane_shape::between(ids.keep(said.id), left, right));
        }
        for (key, value) in &self.areas.0 {
            let place = format!("drivable_areas/{key}");
            let at = own.at(place.clone());
            let ring = element::<Area>(&at, value)
                .and_then(|area| Ok(points(&at, &area.area_boundary)?.0));
            match ring {
                Ok(ring) if ring.len() > 2 => map.areas.push(ring),
                // They are only drawn.
                _ => report
                    .at(place)
                    .warn("no boundary of three points; left out"),
            }
        }
        Ok(map)
    }
}

fn element<'d, T: Deserialize<'d>>(at: &At<'_>, value: &'d RawValue) -> Result<T, ReadError> {
    serde_json::from_str(value.get()).map_err(|error| at.fail(error.to_string()))
}

fn points(at: &At<'_>, line: &[Corner]) -> Result<(Vec<Point>, Vec<f64>), ReadError> {
    let points = line
        .iter()
        .map(|c| at.point(c.x, c.y))
        .collect::<Result<_, _>>()?;
    let heights = line.iter().filter_map(|c| c.z.filter(|z| z.is_finite()));
    Ok((points, heights.collect()))
}

fn lanelet(at: &At<'_>, segment: &Segment, ids: &HashMap<i64, i64>) -> Result<Lanelet, ReadError> {
    let (left, _) = points(at, &segment.left_lane_boundary)?;
    let (right, _) = points(at, &segment.right_lane_boundary)?;
    if left.len() < 2 || right.len() < 2 {
        return Err(at.fail("a boundary with less than 2 points"));
    }
    let (left, right) = matched(left, right);
    let bound = |points, mark: &str| Bound {
        points,
        heights: Vec::new(),
        marking: marking(mark),
    };
    let linked = |wanted: &[i64]| {
        wanted
            .iter()
            .filter_map(|id| ids.get(id).copied())
            .collect()
    };
    let (mut types, users) = match segment.lane_type.as_str() {
        "BIKE" => (vec![LaneletType::BicycleLane], vec![RoadUser::Bicycle]),
        "BUS" => (vec![LaneletType::BusLane], vec![RoadUser::Bus]),
        _ => (vec![LaneletType::Urban], vec![RoadUser::Vehicle]),
    };
    if segment.is_intersection {
        types.push(LaneletType::Intersection);
    }
    Ok(Lanelet {
        id: ids[&segment.id],
        left: bound(left, &segment.left_lane_mark_type),
        right: bound(right, &segment.right_lane_mark_type),
        predecessors: linked(&segment.predecessors),
        successors: linked(&segment.successors),
        types,
        users_one_way: users,
        ..Lanelet::default()
    })
}

/// Gives lanes their neighbours, with the way that these are driven; and how many links lead out of the map.
fn beside_each_other(
    lanelets: &mut [Lanelet],
    ids: &HashMap<i64, i64>,
    segments: &[(Segment, &String)],
) -> usize {
    let by_id: HashMap<i64, &Segment> = segments.iter().map(|(s, _)| (s.id, s)).collect();
    let middles: HashMap<i64, Vec<Point>> = lanelets
        .iter()
        .map(|l| (l.id, l.left.points.clone()))
        .collect();
    let real: HashMap<i64, i64> = ids.iter().map(|(said, id)| (*id, *said)).collect();
    let mut beyond = 0;
    for lanelet in lanelets {
        let Some(segment) = real.get(&lanelet.id).and_then(|said| by_id.get(said)) else {
            continue;
        };
        let links = segment.successors.iter().chain(&segment.predecessors);
        beyond += links.filter(|id| !ids.contains_key(id)).count();
        let own = lanelet.left.points.clone();
        let neighbor = |said: Option<i64>, left: bool| {
            let said = said?;
            let (other, id) = (by_id.get(&said)?, *ids.get(&said)?);
            let same_direction = same_way(&own, middles.get(&id)?);
            // Both name each other, on the side that the way of driving tells.
            let back = if left == same_direction {
                other.right_neighbor_id
            } else {
                other.left_neighbor_id
            };
            (back == Some(segment.id)).then_some(Adjacent { id, same_direction })
        };
        lanelet.adjacent_left = neighbor(segment.left_neighbor_id, true);
        lanelet.adjacent_right = neighbor(segment.right_neighbor_id, false);
    }
    beyond
}

fn marking(said: &str) -> LineMarking {
    match said {
        "NONE" => LineMarking::NoMarking,
        "DASHED_WHITE" | "DASHED_YELLOW" => LineMarking::Dashed,
        "SOLID_WHITE" | "SOLID_YELLOW" | "SOLID_BLUE" => LineMarking::Solid,
        "DOUBLE_SOLID_WHITE" | "DOUBLE_SOLID_YELLOW" => LineMarking::SolidSolid,
        "DOUBLE_DASH_WHITE" | "DOUBLE_DASH_YELLOW" => LineMarking::DashedDashed,
        "SOLID_DASH_WHITE" | "SOLID_DASH_YELLOW" => LineMarking::SolidDashed,
        "DASH_SOLID_WHITE" | "DASH_SOLID_YELLOW" => LineMarking::DashedSolid,
        _ => LineMarking::Unknown,
    }
}
