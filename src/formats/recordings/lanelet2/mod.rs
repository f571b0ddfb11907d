//! Lanelet2 maps: OpenStreetMap XML with lanelets as relations between two ways.

mod osm;

use std::collections::HashMap;
use std::path::Path;

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::plausibility::limits::{MOST_PARTS, refused_coordinate};
use nearmiss_scene::scenario::{
    Adjacent, Bound, Lanelet, LaneletType, RoadUser, Severity, Sign, SignElement,
};

use super::assembly::{Ids, Map};
use super::lane_shape::{matched, same_way};
use super::report::Report;
use super::utm;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use osm::{Place, Relation, Way};

/// A lanelet with the nodes along its borders, in driving direction.
struct Course {
    left: Vec<i64>,
    right: Vec<i64>,
}

/// Reads a map; `origin` is east and north in UTM of what the recording's coordinates are relative to.
pub fn read(
    report: &Report,
    path: &Path,
    origin: (f64, f64),
    ids: &mut Ids,
) -> Result<Map, ReadError> {
    let osm = osm::cached_map(path)?;
    osm.leftovers.report_to(report);
    tell_of_places(report, &osm.nodes, origin);
    let points = in_metres(&osm.nodes, origin);
    Ok(map(report, &points, &osm.ways, &osm.relations, ids))
}

/// Warns where the places of nodes do not go together.
fn tell_of_places(report: &Report, nodes: &HashMap<i64, Place>, origin: (f64, f64)) {
    let degrees = nodes
        .values()
        .filter(|place| matches!(place, Place::Degrees(..)))
        .count();
    let metres = nodes.len() - degrees;
    if degrees > 0 && metres > 0 {
        report.at("").warn(format!(
            "{metres} nodes of the map have `local_x` and `local_y`, and {degrees} only degrees, which are taken relative to the recording's origin"
        ));
    }
    if degrees > 0 && origin == (0.0, 0.0) {
        report.at("").warn(
            "the map is in degrees, and the recording has no origin (`xUtmOrigin`, `yUtmOrigin`): its lanes are not where the tracks are",
        );
    }
}

/// Nodes in the recording's metres.
fn in_metres(nodes: &HashMap<i64, Place>, origin: (f64, f64)) -> HashMap<i64, Point> {
    // One zone for all, so that a map at a zone's edge stays whole: that of its westernmost node.
    let longitudes = nodes.values().filter_map(|place| match place {
        Place::Degrees(_, lon) => Some(*lon),
        Place::Metres(..) => None,
    });
    let zone = utm::zone(longitudes.fold(f64::MAX, f64::min).min(180.0));
    let metres = nodes.iter().filter_map(|(id, place)| {
        let (x, y) = match *place {
            Place::Metres(x, y) => (x, y),
            Place::Degrees(lat, lon) => {
                let (east, north) = utm::forward(lat, lon, zone);
                (east - origin.0, north - origin.1)
            }
        };
        // A place far from all others is a mistake; borders without it are left out, which is said there.
        let fits = |value: f64| value.is_finite() && refused_coordinate(value).is_none();
        (fits(x) && fits(y)).then(|| (*id, Point::new(x, y)))
    });
    metres.collect()
}

fn map(
    report: &Report,
    points: &HashMap<i64, Point>,
    ways: &HashMap<i64, Way>,
    relations: &[Relation],
    ids: &mut Ids,
) -> Map {
    let mut map = Map::default();
    let mut courses = Vec::new();
    let mut borders = Vec::new();
    let mut limits: HashMap<String, i64> = HashMap::new();
    for relation in relations.iter().take(MOST_PARTS) {
        let way = |id: Option<i64>| ways.get(&id?).filter(|way| way.nodes.len() > 1);
        let element = || format!("relation {}", relation.id);
        let (Some(left), Some(right)) = (way(relation.left), way(relation.right)) else {
            report.push(
                Severity::Warning,
                element(),
                "its borders are not in the map; left out".into(),
            );
            continue;
        };
        let Some(course) = course(left, right, points) else {
            report.push(
                Severity::Warning,
                element(),
                "a node of its borders is missing; left out".into(),
            );
            continue;
        };
        let line = |nodes: &[i64]| nodes.iter().map(|id| points[id]).collect::<Vec<_>>();
        let (left_points, right_points) = matched(line(&course.left), line(&course.right));
        let bound = |points, marking| Bound {
            points,
            heights: Vec::new(),
            marking,
        };
        let text = |key: &str| relation.tags.get(key).map_or("", String::as_str);
        let (types, users) = kind(text("subtype"), text("location"));
        let mut lanelet = Lanelet {
            id: ids.keep(relation.id),
            left: bound(left_points, left.marking),
            right: bound(right_points, right.marking),
            types,
            ..Lanelet::default()
        };
        match text("one_way") {
            "no" => lanelet.users_bidirectional = users,
            _ => lanelet.users_one_way = users,
        }
        if let Some(limit) = limit(text("speed_limit")) {
            let id = *limits.entry(limit.to_string()).or_insert_with(|| {
                let id = ids.fresh();
                map.signs.push(Sign {
                    id,
                    position: lanelet.right.points.first().copied(),
                    is_virtual: true,
                    elements: vec![SignElement {
                        id: "274".into(),
                        values: vec![limit.to_string()],
                    }],
                });
                id
            });
            lanelet.signs.push(id);
        }
        map.lanelets.push(lanelet);
        borders.push((relation.left, relation.right));
        courses.push(course);
    }
    link(&mut map.lanelets, &courses, &borders);
    map
}

/// The borders in driving direction: the left one on the left, both the same way.
fn course(left: &Way, right: &Way, points: &HashMap<i64, Point>) -> Option<Course> {
    let line = |nodes: &[i64]| {
        let each = nodes.iter().map(|id| points.get(id).copied());
        each.collect::<Option<Vec<Point>>>()
    };
    let (mut left, mut right) = (left.nodes.clone(), right.nodes.clone());
    let (a, b) = (line(&left)?, line(&right)?);
    // The way round in which starts are near starts, so that bends of any angle come out right.
    let straight = (a[0] - b[0]).norm() + (a[a.len() - 1] - b[b.len() - 1]).norm();
    let crossed = (a[0] - b[b.len() - 1]).norm() + (a[a.len() - 1] - b[0]).norm();
    if crossed < straight || crossed == straight && !same_way(&a, &b) {
        right.reverse();
    }
    let (a, b) = (line(&left)?, line(&right)?);
    let ring: Vec<Point> = a.iter().rev().chain(&b).copied().collect();
    // Left border backwards and right border forwards is counterclockwise where the left one is on the left.
    let next = ring.iter().cycle().skip(1);
    let area: f64 = ring
        .iter()
        .zip(next)
        .map(|(p, q)| p.coords.perp(&q.coords))
        .sum();
    if area < 0.0 {
        left.reverse();
        right.reverse();
    }
    Some(Course { left, right })
}

/// Lanelets that share nodes at their ends follow each other; those that share a border lie side by side.
fn link(lanelets: &mut [Lanelet], courses: &[Course], borders: &[(Option<i64>, Option<i64>)]) {
    let mut starts: HashMap<(i64, i64), Vec<usize>> = HashMap::new();
    let (mut by_left, mut by_right) = (HashMap::new(), HashMap::new());
    for (i, course) in courses.iter().enumerate() {
        starts
            .entry((course.left[0], course.right[0]))
            .or_default()
            .push(i);
        by_left.entry(borders[i].0).or_insert_with(Vec::new).push(i);
        by_right
            .entry(borders[i].1)
            .or_insert_with(Vec::new)
            .push(i);
    }
    let known: Vec<i64> = lanelets.iter().map(|l| l.id).collect();
    for i in 0..lanelets.len() {
        let course = &courses[i];
        let end = (
            course.left[course.left.len() - 1],
            course.right[course.right.len() - 1],
        );
        for next in starts
            .get(&end)
            .into_iter()
            .flatten()
            .filter(|next| **next != i)
        {
            lanelets[i].successors.push(known[*next]);
            lanelets[*next].predecessors.push(known[i]);
        }
        let other = |found: Option<&Vec<usize>>, same_direction: bool| {
            let id = found?.iter().find(|j| **j != i).map(|j| known[*j])?;
            Some(Adjacent { id, same_direction })
        };
        let (left, right) = borders[i];
        lanelets[i].adjacent_left =
            other(by_right.get(&left), true).or_else(|| other(by_left.get(&left), false));
        lanelets[i].adjacent_right =
            other(by_left.get(&right), true).or_else(|| other(by_right.get(&right), false));
    }
}

/// What a lanelet is, and who uses it.
fn kind(subtype: &str, location: &str) -> (Vec<LaneletType>, Vec<RoadUser>) {
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
fn limit(text: &str) -> Option<f64> {
    let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit());
    let value: f64 = digits.trim().parse().ok()?;
    let metres = match text.trim_start_matches(digits).trim() {
        "mph" => value * 0.447_04,
        "m/s" | "mps" => value,
        _ => value / 3.6,
    };
    (metres > 0.0 && metres < 100.0).then_some((metres * 1e4).round() / 1e4)
}
