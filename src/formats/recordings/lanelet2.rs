//! Lanelet2 maps: OpenStreetMap XML with lanelets as relations between two ways.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use nearmiss_base::geometry::Point;
use nearmiss_base::system::{self, FileCache};
use nearmiss_scene::scenario::plausibility::{MOST_PARTS, refused_coordinate};
use nearmiss_scene::scenario::{
    Adjacent, Bound, Lanelet, LaneletType, LineMarking, RoadUser, Severity, Sign,
};

use super::assembly::{Ids, Map};
use super::lane_shape::{matched, same_way};
use super::utm::{self, TransverseMercator};
use super::{Leftovers, Report};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::xml::{Element, Xml, decoded};

/// A lanelet with the nodes along its borders, in driving direction.
struct Course {
    left: Vec<i64>,
    right: Vec<i64>,
}

/// How degrees of a map become the metres of a recording.
#[derive(Debug, Clone, Copy)]
pub enum Placement {
    /// UTM from this place, east and north, metres.
    FromUtm((f64, f64)),
    /// On a plane.
    On(TransverseMercator),
}

/// Reads a map.
pub fn read(
    report: &Report,
    path: &Path,
    placement: Placement,
    ids: &mut Ids,
) -> Result<Map, ReadError> {
    let osm = cached_map(path)?;
    osm.leftovers.report_to(report);
    if matches!(placement, Placement::FromUtm(_)) {
        tell_of_places(report, &osm.nodes);
    }
    let points = in_metres(&osm.nodes, placement);
    Ok(map(report, &points, &osm.ways, &osm.relations, ids))
}

/// Whether no place of a map is in degrees alone.
pub fn is_in_metres(path: &Path) -> Result<bool, ReadError> {
    let osm = cached_map(path)?;
    let mut nodes = osm.nodes.values();
    Ok(nodes.all(|place| place.metres.is_some()))
}

/// The origin in UTM of a map beside tracks that do not say one: 0 where they are in UTM, that of 0° north and 0° east
/// for maps around there (INTERACTION's), else the map's south-west, so that its coordinates are small.
pub fn origin(path: &Path, tracks: &[Point]) -> Result<(f64, f64), ReadError> {
    let osm = cached_map(path)?;
    let degrees = osm.nodes.values().filter_map(Place::degrees_alone);
    let Some((lat, lon)) = degrees.reduce(|a, b| (a.0.min(b.0), a.1.min(b.1))) else {
        return Ok((0.0, 0.0));
    };
    if lat.abs() < 1.0 && lon.abs() < 1.0 {
        return Ok(utm::forward(0.0, 0.0, utm::zone(lon)));
    }
    let is_utm = |place: &Point| place.x.abs() > 1e5 && place.y.abs() > 1e5;
    if tracks.iter().any(is_utm) {
        return Ok((0.0, 0.0));
    }
    let (east, north) = utm::forward(lat, lon, utm::zone(lon));
    Ok((
        (east / 100.0).floor() * 100.0,
        (north / 100.0).floor() * 100.0,
    ))
}

/// Warns where the places of nodes do not go together.
fn tell_of_places(report: &Report, nodes: &HashMap<i64, Place>) {
    let degrees = nodes.values().filter_map(Place::degrees_alone).count();
    let metres = nodes.len() - degrees;
    if degrees > 0 && metres > 0 {
        report.at("").warn(format!(
            "{metres} nodes of the map have `local_x` and `local_y`, and {degrees} only degrees, which are taken relative to the recording's origin"
        ));
    }
}

/// Nodes in the recording's metres.
fn in_metres(nodes: &HashMap<i64, Place>, placement: Placement) -> HashMap<i64, Point> {
    // One zone for all, so that a map at a zone's edge stays whole: that of its westernmost node.
    let places = nodes.values().filter_map(Place::degrees_alone);
    let longitudes = places.map(|place| place.1);
    let zone = utm::zone(longitudes.fold(f64::MAX, f64::min).min(180.0));
    let metres = nodes.iter().filter_map(|(id, place)| {
        let (x, y) = match (placement, place.metres, place.degrees) {
            // Tracks in degrees are where the degrees are.
            (Placement::On(plane), _, Some((lat, lon))) => plane.forward(lat, lon),
            (_, Some(metres), _) => metres,
            (Placement::FromUtm(origin), None, Some((lat, lon))) => {
                let (east, north) = utm::forward(lat, lon, zone);
                (east - origin.0, north - origin.1)
            }
            (_, None, None) => return None,
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
                let position = lanelet.right.points.first().copied();
                map.signs
                    .push(Sign::speed_limit(id, "274", limit, position));
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

/// No map is larger, bytes.
const LARGEST: u64 = 256 << 20;

/// A node: its place, of which the map says one or both.
struct Place {
    /// Its own coordinates.
    metres: Option<(f64, f64)>,
    /// Latitude and longitude.
    degrees: Option<(f64, f64)>,
}

impl Place {
    /// Latitude and longitude where it has nothing else.
    fn degrees_alone(&self) -> Option<(f64, f64)> {
        self.degrees.filter(|_| self.metres.is_none())
    }
}

/// A line through nodes.
struct Way {
    nodes: Vec<i64>,
    marking: LineMarking,
    /// As the map calls it.
    kind: String,
    line: usize,
}

/// A lanelet, by the ids of the ways along it.
#[derive(Default)]
struct Relation {
    id: i64,
    left: Option<i64>,
    right: Option<i64>,
    tags: HashMap<String, String>,
}

/// A map as it is in its file.
struct Osm {
    nodes: HashMap<i64, Place>,
    ways: HashMap<i64, Way>,
    relations: Vec<Relation>,
    /// What stands in it and is not used.
    leftovers: Leftovers,
}

/// Maps that are kept for other windows of a recording, bytes of their files.
const MAX_CACHED: usize = 64 << 20;

static MAPS: FileCache<Osm> = FileCache::new(MAX_CACHED);

/// A map, read anew if it changed.
fn cached_map(path: &Path) -> Result<Arc<Osm>, ReadError> {
    MAPS.get(&[path], || elements(path))
}

/// The elements of a map, and the size of its file in bytes.
fn elements(path: &Path) -> Result<(Osm, usize), ReadError> {
    let file = path.display().to_string();
    let bytes = system::read_file(path, LARGEST).map_err(|e| ReadError::io(&file, &e))?;
    let text = decoded(&bytes, &file)?;
    let mut xml = Xml::new(&text, &file);
    let (mut nodes, mut ways, mut relations) = (HashMap::new(), HashMap::new(), Vec::new());
    let mut leftovers = Leftovers::default();
    let root = xml.next()?;
    if root.is_none_or(|root| root.name != "osm") {
        return Err(xml.fail(0, "not a Lanelet2 map: its root is not <osm>".into()));
    }
    while let Some(element) = xml.next()? {
        match element.name {
            "node" => {
                let (id, place) = node(&mut xml, element, &mut leftovers)?;
                nodes.insert(id, place);
            }
            "way" => {
                let (id, way) = way(&mut xml, element, &mut leftovers)?;
                ways.insert(id, way);
            }
            "relation" => relations.extend(relation(&mut xml, element, &mut leftovers)?),
            "bounds" | "MetaInfo" | "meta" => xml.skip()?,
            _ => leftovers.element(&mut xml, "osm", element)?,
        }
        xml.check_count(
            element,
            nodes.len().max(ways.len()).max(relations.len()),
            "elements",
        )?;
    }
    unused_ways(&ways, &relations, &mut leftovers);
    let osm = Osm {
        nodes,
        ways,
        relations,
        leftovers,
    };
    Ok((osm, bytes.len()))
}

/// The attribute as a number.
fn number(xml: &Xml<'_>, element: Element<'_>, name: &str) -> Result<Option<f64>, ReadError> {
    let Some(text) = xml.attribute(element, name) else {
        return Ok(None);
    };
    let value = text
        .parse::<f64>()
        .ok()
        .filter(|v| v.is_finite() && v.abs() < 1e9)
        .ok_or_else(|| {
            let shown: String = text.chars().take(40).collect();
            xml.fail(element.at, format!("{name}=\"{shown}\" is not a number"))
        });
    value.map(Some)
}

fn tag<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Option<(String, String)>, ReadError> {
    let found = match (xml.attribute(element, "k"), xml.attribute(element, "v")) {
        (Some(k), Some(v)) => Some((k.into_owned(), v.into_owned())),
        _ => None,
    };
    xml.skip()?;
    Ok(found)
}

fn node<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    leftovers: &mut Leftovers,
) -> Result<(i64, Place), ReadError> {
    leftovers.attributes(xml, element, &["id", "lat", "lon"]);
    let id = xml.id_attribute(element, "id")?;
    let (lat, lon) = (number(xml, element, "lat")?, number(xml, element, "lon")?);
    let mut local = (None, None);
    while let Some(child) = xml.next()? {
        match (child.name, tag(xml, child)?) {
            ("tag", Some((k, v))) if k == "local_x" => local.0 = v.parse::<f64>().ok(),
            ("tag", Some((k, v))) if k == "local_y" => local.1 = v.parse::<f64>().ok(),
            ("tag", Some((k, _))) => leftovers.attribute("node tag", &k, || xml.line(child)),
            _ => leftovers.attribute("node", child.name, || xml.line(child)),
        }
    }
    let (metres, degrees) = (local.0.zip(local.1), lat.zip(lon));
    let place = Place {
        metres: metres.filter(|(x, y)| x.abs() < 1e7 && y.abs() < 1e7),
        // Editors of local maps write 0.
        degrees: degrees.filter(|(lat, lon)| {
            let is_none = metres.is_some() && (*lat, *lon) == (0.0, 0.0);
            lat.abs() <= 90.0 && lon.abs() <= 360.0 && !is_none
        }),
    };
    if place.metres.is_none() && place.degrees.is_none() {
        let message = "a node without `lat` and `lon` on the Earth";
        return Err(xml.fail_in(element, message.into()));
    }
    Ok((id, place))
}

fn way<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    leftovers: &mut Leftovers,
) -> Result<(i64, Way), ReadError> {
    let id = xml.id_attribute(element, "id")?;
    let line = xml.line(element);
    let mut nodes = Vec::new();
    let (mut kind, mut subtype) = (String::new(), String::new());
    while let Some(child) = xml.next()? {
        if child.name == "nd" {
            nodes.push(xml.id_attribute(child, "ref")?);
            xml.check_count(element, nodes.len(), "nodes")?;
        }
        match tag(xml, child)? {
            Some((k, v)) if k == "type" => kind = v,
            Some((k, v)) if k == "subtype" => subtype = v,
            Some((k, _)) => leftovers.attribute("way tag", &k, || xml.line(child)),
            None => {}
        }
    }
    let marking = match (kind.as_str(), subtype.as_str()) {
        ("line_thin", "dashed") => LineMarking::Dashed,
        ("line_thick", "dashed") => LineMarking::BroadDashed,
        ("line_thin" | "line_thick", "solid_solid") => LineMarking::SolidSolid,
        ("line_thin" | "line_thick", "solid_dashed") => LineMarking::SolidDashed,
        ("line_thin" | "line_thick", "dashed_solid") => LineMarking::DashedSolid,
        ("line_thick", _) => LineMarking::BroadSolid,
        ("line_thin", _) => LineMarking::Solid,
        ("curbstone", "low") => LineMarking::LoweredCurb,
        ("curbstone" | "guard_rail" | "wall" | "fence" | "road_border", _) => LineMarking::Curb,
        ("virtual", _) => LineMarking::NoMarking,
        _ => LineMarking::Unknown,
    };
    let way = Way {
        nodes,
        marking,
        kind,
        line,
    };
    Ok((id, way))
}

/// A lanelet; nothing for other relations.
fn relation<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    leftovers: &mut Leftovers,
) -> Result<Option<Relation>, ReadError> {
    let mut found = Relation {
        id: xml.id_attribute(element, "id")?,
        ..Relation::default()
    };
    let mut members = Vec::new();
    while let Some(child) = xml.next()? {
        if child.name == "member" {
            let reference = xml.id_attribute(child, "ref")?;
            let role = xml.attribute(child, "role").unwrap_or_default();
            let side = match &*role {
                "left" => Some(&mut found.left),
                "right" => Some(&mut found.right),
                _ => None,
            };
            match side {
                Some(side) if side.is_none() => *side = Some(reference),
                // Of a border in several ways the first one is read.
                Some(_) => members.push((format!("further {role}"), xml.line(child))),
                None => members.push((role.into_owned(), xml.line(child))),
            }
        }
        if let Some((k, v)) = tag(xml, child)? {
            found.tags.insert(k, v);
        }
    }
    let is_lanelet = found.tags.get("type").is_some_and(|t| t == "lanelet");
    if is_lanelet && (found.left.is_none() || found.right.is_none()) {
        let message = "a lanelet without a left and a right border";
        return Err(xml.fail_in(element, message.into()));
    }
    let text = |key: &str| found.tags.get(key).map_or("", String::as_str);
    if !is_lanelet {
        let kind = format!("relation {} {}", text("type"), text("subtype"));
        leftovers.add(kind.trim_end(), || xml.line(element));
        return Ok(None);
    }
    for (role, line) in members {
        leftovers.add(&format!("lanelet member {role}"), || line);
    }
    for key in found
        .tags
        .keys()
        .filter(|key| !TAGS.contains(&key.as_str()))
    {
        leftovers.attribute("lanelet tag", key, || xml.line(element));
    }
    Ok(Some(found))
}

/// The tags of lanelets that are used.
const TAGS: [&str; 5] = ["type", "subtype", "location", "one_way", "speed_limit"];

/// Counts ways that are no borders of lanelets.
fn unused_ways(ways: &HashMap<i64, Way>, relations: &[Relation], leftovers: &mut Leftovers) {
    let borders = relations.iter().flat_map(|r| [r.left, r.right]).flatten();
    let borders: HashSet<i64> = borders.collect();
    let mut others: Vec<&Way> = { ways.iter() }
        .filter(|(id, _)| !borders.contains(id))
        .map(|(_, way)| way)
        .collect();
    others.sort_by_key(|way| way.line);
    for way in others {
        let kind = format!("way {} of no lanelet", way.kind);
        leftovers.add(&kind, || way.line);
    }
}
