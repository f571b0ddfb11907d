//! SUMO nets: lanes with a middle and a width, their connections, limits and lights, and all of it as lanelets.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use nearmiss_base::geometry::Point;
use nearmiss_base::system::{self, FileCache};
use nearmiss_scene::scenario::plausibility::{MOST_PARTS, refused_coordinate};
use nearmiss_scene::scenario::{
    Adjacent, ContentHash, Lanelet, LaneletType, LightPhase, LineMarking, RoadUser, Sign,
    SignalColor, TrafficDirection, TrafficLight,
};

use super::geo::Location;
use crate::commonroad::ReadError;
use crate::commonroad::xml::{Element, Xml, decoded};
use crate::recordings::assembly::{Ids, Map};
use crate::recordings::lane_shape::{borders, without_repeats};
use crate::recordings::{Leftovers, Report};

/// No net is larger, bytes.
const LARGEST: u64 = 512 << 20;

/// The width of a lane without one, metres.
const WIDTH: f64 = 3.2;

/// A lane of an edge.
pub struct NetLane {
    pub edge: String,
    pub index: i64,
    pub shape: Vec<Point>,
    /// Metres.
    pub width: f64,
    /// m/s.
    pub speed: Option<f64>,
    /// Whether it is on a junction.
    pub internal: bool,
    pub crossing: bool,
    pub users: Vec<RoadUser>,
}

/// A connection of two lanes.
pub struct Connection {
    pub from: (String, i64),
    pub to: (String, i64),
    /// The lane on the junction between them.
    pub via: Option<String>,
    /// The traffic light and the place of the connection in its states.
    pub light: Option<(String, usize)>,
}

/// A net as it is in its file.
pub struct Net {
    pub location: Location,
    pub lanes: Vec<NetLane>,
    /// The ids of all edges, also of those that are no lanes here.
    pub edges: HashSet<String>,
    pub connections: Vec<Connection>,
    pub programs: HashMap<String, Program>,
    pub hash: ContentHash,
    /// What stands in it and is not used.
    pub leftovers: Leftovers,
}

/// Nets that are kept for other windows of a recording, bytes of their files.
const MAX_CACHED: usize = 256 << 20;

static NETS: FileCache<Net> = FileCache::new(MAX_CACHED);

/// A net, read anew if it changed.
pub fn read(path: &Path) -> Result<Arc<Net>, ReadError> {
    NETS.get(&[path], || Net::read(path))
}

impl Net {
    fn read(path: &Path) -> Result<(Self, usize), ReadError> {
        let file = path.display().to_string();
        let bytes = system::read_file(path, LARGEST).map_err(|e| ReadError::io(&file, &e))?;
        let text = decoded(&bytes, &file)?;
        let mut xml = Xml::new(&text, &file);
        if xml.next()?.is_none_or(|root| root.name != "net") {
            return Err(xml.fail(0, "not a SUMO net: its root is not <net>".into()));
        }
        let (mut lanes, mut connections) = (Vec::new(), Vec::new());
        let (mut location, mut edges) = (Location::default(), HashSet::new());
        let mut leftovers = Leftovers::default();
        let mut programs: HashMap<String, Program> = HashMap::new();
        while let Some(element) = xml.next()? {
            match element.name {
                "location" => location = self::location(&mut xml, element)?,
                "edge" => {
                    let id = xml.attribute(element, "id");
                    edges.extend(id.map(|id| id.into_owned()));
                    edge(&mut xml, element, &mut lanes, &mut leftovers)?;
                }
                "connection" => {
                    leftovers.attributes(&xml, element, &CONNECTION);
                    connections.extend(connection(&mut xml, element)?);
                }
                "tlLogic" => {
                    let (id, program) = program(&mut xml, element, &mut leftovers)?;
                    // Of several programs the first one runs.
                    programs.entry(id).or_insert(program);
                }
                _ => leftovers.element(&mut xml, "net", element)?,
            }
            let most = lanes.len().max(connections.len());
            xml.check_count(element, most, "lanes or connections")?;
        }
        let net = Self {
            location,
            lanes,
            edges,
            leftovers,
            connections,
            programs,
            hash: ContentHash::digest(&bytes),
        };
        Ok((net, bytes.len()))
    }
}

/// Where a net is.
fn location<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Location, ReadError> {
    let numbers = |name: &str| -> Option<Vec<f64>> {
        let text = xml.attribute(element, name)?;
        text.split(',').map(|n| n.trim().parse().ok()).collect()
    };
    let boundary = |name: &str| <[f64; 4]>::try_from(numbers(name)?).ok();
    let offset = numbers("netOffset").and_then(|both| <[f64; 2]>::try_from(both).ok());
    let projection = xml.attribute(element, "projParameter").unwrap_or_default();
    let found = Location {
        offset: offset.map_or((0.0, 0.0), |[x, y]| (x, y)),
        projection: projection.trim().to_string(),
        original: boundary("origBoundary"),
    };
    xml.skip()?;
    Ok(found)
}

/// The attributes that are used; of some the ids are made.
const EDGE: [&str; 2] = ["id", "function"];

const LANE: [&str; 6] = ["id", "index", "shape", "width", "speed", "allow"];

const CONNECTION: [&str; 7] = ["from", "to", "fromLane", "toLane", "via", "tl", "linkIndex"];

fn edge<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    lanes: &mut Vec<NetLane>,
    leftovers: &mut Leftovers,
) -> Result<(), ReadError> {
    let text = |name: &str| {
        xml.attribute(element, name)
            .map(|v| v.into_owned())
            .unwrap_or_default()
    };
    let (id, function) = (text("id"), text("function"));
    // Areas where people walk in any direction are no lanes.
    if function == "walkingarea" {
        leftovers.add("edge of function walkingarea", || xml.line(element));
        return xml.skip();
    }
    leftovers.attributes(xml, element, &EDGE);
    while let Some(child) = xml.next()? {
        if child.name != "lane" {
            leftovers.element(xml, "edge", child)?;
            continue;
        }
        leftovers.attributes(xml, child, &LANE);
        let shape = shape(xml, child)?;
        let number = |name: &str| -> Result<Option<f64>, ReadError> {
            let Some(text) = xml.attribute(child, name) else {
                return Ok(None);
            };
            let value = text.parse::<f64>().ok().filter(|v| *v >= 0.0 && *v < 1e4);
            value.map(Some).ok_or_else(|| {
                let shown: String = text.chars().take(40).collect();
                xml.fail(
                    child.at,
                    format!("{name}=\"{shown}\" is not a number from 0 to 10000"),
                )
            })
        };
        let (width, speed) = (number("width")?, number("speed")?);
        let allowed = xml.attribute(child, "allow");
        let users = match allowed.as_deref() {
            Some("pedestrian") => vec![RoadUser::Pedestrian],
            Some("bicycle") => vec![RoadUser::Bicycle],
            Some("bus") => vec![RoadUser::Bus],
            Some(all) if all.starts_with("rail") || all.starts_with("tram") => {
                vec![RoadUser::Train]
            }
            _ => vec![RoadUser::Vehicle],
        };
        let index = xml.id_attribute(child, "index")?;
        lanes.push(NetLane {
            edge: id.clone(),
            index,
            shape,
            width: width.filter(|w| *w > 0.0).unwrap_or(WIDTH),
            speed,
            internal: function == "internal",
            crossing: function == "crossing",
            users,
        });
        leftovers.rest(xml, "lane")?;
        xml.check_count(element, lanes.len(), "lanes")?;
    }
    Ok(())
}

fn shape(xml: &Xml<'_>, element: Element<'_>) -> Result<Vec<Point>, ReadError> {
    let text = xml.attribute(element, "shape").unwrap_or_default();
    let mut points = Vec::new();
    for pair in text.split_whitespace() {
        let mut numbers = pair.split(',').map(str::parse::<f64>);
        let (Some(Ok(x)), Some(Ok(y))) = (numbers.next(), numbers.next()) else {
            let shown: String = pair.chars().take(40).collect();
            return Err(xml.fail(element.at, format!("`{shown}` in a shape is not `x,y`")));
        };
        if !x.is_finite() || !y.is_finite() {
            return Err(xml.fail(element.at, "a shape with infinite coordinates".into()));
        }
        if let Some(why) = refused_coordinate(x).or_else(|| refused_coordinate(y)) {
            return Err(xml.fail(element.at, why));
        }
        points.push(Point::new(x, y));
        if points.len() > MOST_PARTS {
            return Err(xml.fail(element.at, format!("more than {MOST_PARTS} points")));
        }
    }
    Ok(points)
}

fn connection<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<Option<Connection>, ReadError> {
    let text = |name: &str| xml.attribute(element, name).map(|v| v.into_owned());
    let number = |name: &str| text(name).and_then(|t| t.parse::<i64>().ok());
    let found = match (
        text("from"),
        text("to"),
        number("fromLane"),
        number("toLane"),
    ) {
        (Some(from), Some(to), Some(from_lane), Some(to_lane)) => Some(Connection {
            from: (from, from_lane),
            to: (to, to_lane),
            via: text("via"),
            light: text("tl").zip(number("linkIndex").and_then(|i| usize::try_from(i).ok())),
        }),
        _ => None,
    };
    xml.skip()?;
    Ok(found)
}

/// The lanes of a net, with the lights as they are from `start` on in steps of `dt` seconds.
pub fn to_map(
    report: &Report,
    net: &Net,
    ids: &mut Ids,
    (start, dt): (f64, f64),
) -> (Map, ContentHash) {
    let Net {
        lanes,
        connections,
        programs,
        hash,
        leftovers,
        ..
    } = net;
    leftovers.report_to(report);
    let mut map = lanelets(lanes, connections, ids);
    let actuated = programs.values().filter(|p| !p.is_static).count();
    report.note_count(actuated, |n| {
        format!("traffic lights that are not static: {n}; the phases of their program are taken as they stand")
    });
    let places = names(&map.names);
    for connection in connections {
        let Some((light, link)) = &connection.light else {
            continue;
        };
        let on = connection
            .via
            .clone()
            .unwrap_or_else(|| lane_name(&connection.from));
        let (Some(place), Some(program)) = (places.get(&on), programs.get(light)) else {
            continue;
        };
        let lanelet = &mut map.lanelets[*place];
        if let Some(light) = program.light(*link, start, dt) {
            let id = ids.fresh();
            let position = lanelet.right.points.first().copied();
            lanelet.lights.push(id);
            map.lights.push(nearmiss_scene::scenario::TrafficLight {
                id,
                position,
                ..light
            });
        }
    }
    let map = Map {
        lanelets: map.lanelets,
        signs: map.signs,
        lights: map.lights,
        ..Map::default()
    };
    (map, *hash)
}

fn names(names: &[String]) -> HashMap<String, usize> {
    names.iter().cloned().zip(0..).collect()
}

fn lane_name((edge, index): &(String, i64)) -> String {
    format!("{edge}_{index}")
}

/// Lanelets with the names of their lanes.
struct NamedMap {
    names: Vec<String>,
    lanelets: Vec<Lanelet>,
    signs: Vec<Sign>,
    lights: Vec<nearmiss_scene::scenario::TrafficLight>,
}

fn lanelets(lanes: &[NetLane], connections: &[Connection], ids: &mut Ids) -> NamedMap {
    let mut map = NamedMap {
        names: Vec::new(),
        lanelets: Vec::new(),
        signs: Vec::new(),
        lights: Vec::new(),
    };
    let mut limits: HashMap<u64, i64> = HashMap::new();
    let mut kept = Vec::new();
    for lane in lanes {
        let (centre, ..) = without_repeats(lane.shape.clone(), Vec::new());
        if centre.len() < 2 {
            continue;
        }
        let half = lane.width / 2.0;
        let (mut left, mut right) = borders(&centre, &[], &vec![(half, half); centre.len()]);
        if !lane.internal && !lane.crossing {
            (left.marking, right.marking) = (LineMarking::Unknown, LineMarking::Unknown);
        } else {
            (left.marking, right.marking) = (LineMarking::NoMarking, LineMarking::NoMarking);
        }
        let kind = match lane.users[..] {
            _ if lane.crossing => LaneletType::Crosswalk,
            [RoadUser::Pedestrian] => LaneletType::Sidewalk,
            [RoadUser::Bicycle] => LaneletType::BicycleLane,
            [RoadUser::Bus] => LaneletType::BusLane,
            [RoadUser::Train] => LaneletType::Tram,
            _ => LaneletType::Urban,
        };
        let mut lanelet = Lanelet {
            id: ids.fresh(),
            left,
            right,
            types: vec![kind],
            ..Lanelet::default()
        };
        if lane.internal {
            lanelet.types.push(LaneletType::Intersection);
        }
        if lane.crossing || lane.users == [RoadUser::Pedestrian] {
            lanelet.users_bidirectional = vec![RoadUser::Pedestrian]
        } else {
            lanelet.users_one_way = lane.users.clone()
        }
        let limit = lane
            .speed
            .filter(|v| *v > 0.0 && kind == LaneletType::Urban && !lane.internal);
        if let Some(limit) = limit {
            let id = *limits.entry(limit.to_bits()).or_insert_with(|| {
                let id = ids.fresh();
                let position = lanelet.right.points.first().copied();
                map.signs
                    .push(Sign::speed_limit(id, "274", limit, position));
                id
            });
            lanelet.signs.push(id);
        }
        map.names.push(lane_name(&(lane.edge.clone(), lane.index)));
        map.lanelets.push(lanelet);
        kept.push(lane);
    }
    link(&mut map, &kept, connections);
    map
}

fn link(map: &mut NamedMap, lanes: &[&NetLane], connections: &[Connection]) {
    let places = names(&map.names);
    for connection in connections {
        let to = connection
            .via
            .clone()
            .unwrap_or_else(|| lane_name(&connection.to));
        let from = places.get(&lane_name(&connection.from));
        let (Some(from), Some(to)) = (from, places.get(&to)) else {
            continue;
        };
        let (from_id, to_id) = (map.lanelets[*from].id, map.lanelets[*to].id);
        let successors = &mut map.lanelets[*from].successors;
        if !successors.contains(&to_id) {
            successors.push(to_id);
            map.lanelets[*to].predecessors.push(from_id);
        }
    }
    for (place, lane) in lanes.iter().enumerate() {
        // On junctions, lanes of one edge may part.
        if lane.internal || lane.crossing {
            continue;
        }
        // Lanes are counted from the right.
        let Some(left) = places.get(&lane_name(&(
            lane.edge.clone(),
            lane.index.saturating_add(1),
        ))) else {
            continue;
        };
        let adjacent = |id| {
            Some(Adjacent {
                id,
                same_direction: true,
            })
        };
        let (own, other) = (map.lanelets[place].id, map.lanelets[*left].id);
        map.lanelets[place].adjacent_left = adjacent(other);
        map.lanelets[*left].adjacent_right = adjacent(own);
    }
}

/// A program: its phases one after the other.
pub struct Program {
    pub is_static: bool,
    /// Seconds by which it is delayed.
    offset: f64,
    /// Seconds, and the signal of each connection.
    phases: Vec<(f64, String)>,
}

/// Phases longer than this are none, seconds.
const LONGEST: f64 = 1e6;

/// Reads a program, with the id of its light.
fn program<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    leftovers: &mut Leftovers,
) -> Result<(String, Program), ReadError> {
    leftovers.attributes(xml, element, &["id", "type", "offset", "programID"]);
    let id = xml
        .attribute(element, "id")
        .unwrap_or_default()
        .into_owned();
    let kind = xml.attribute(element, "type");
    let is_static = kind.is_none_or(|kind| kind == "static");
    let offset = xml
        .attribute(element, "offset")
        .and_then(|o| o.parse::<f64>().ok());
    let mut phases = Vec::new();
    while let Some(child) = xml.next()? {
        if child.name != "phase" {
            leftovers.element(xml, "tlLogic", child)?;
            continue;
        }
        leftovers.attributes(xml, child, &["duration", "state"]);
        let text = xml.attribute(child, "duration").unwrap_or_default();
        let seconds = text
            .parse::<f64>()
            .ok()
            .filter(|s| (0.0..=LONGEST).contains(s))
            .ok_or_else(|| {
                let shown: String = text.chars().take(40).collect();
                xml.fail(
                    child.at,
                    format!("duration=\"{shown}\" is not a number of seconds"),
                )
            })?;
        let state = xml
            .attribute(child, "state")
            .unwrap_or_default()
            .into_owned();
        phases.push((seconds, state));
        xml.check_count(element, phases.len(), "phases")?;
        xml.skip()?;
    }
    let offset = offset.filter(|o| o.is_finite() && o.abs() < LONGEST);
    let program = Program {
        is_static,
        offset: offset.unwrap_or(0.0),
        phases,
    };
    Ok((id, program))
}

impl Program {
    /// The light of a connection as it is from `start` on, in steps of `dt` seconds; its id is still to be given.
    pub fn light(&self, link: usize, start: f64, dt: f64) -> Option<TrafficLight> {
        let steps = |seconds: f64| (seconds / dt).round() as i64;
        let mut cycle: Vec<LightPhase> = Vec::new();
        for (seconds, state) in &self.phases {
            let color = match state.as_bytes().get(link)? {
                b'r' => SignalColor::Red,
                b'y' | b'Y' => SignalColor::Yellow,
                b'g' | b'G' | b's' => SignalColor::Green,
                b'u' => SignalColor::RedYellow,
                _ => SignalColor::Inactive,
            };
            let duration = steps(*seconds);
            match cycle.last_mut() {
                Some(phase) if phase.color == color => phase.duration += duration,
                _ => cycle.push(LightPhase { duration, color }),
            }
        }
        let whole: i64 = cycle.iter().map(|p| p.duration).sum();
        if whole <= 0 {
            return None;
        }
        Some(TrafficLight {
            id: 0,
            position: None,
            active: true,
            direction: Some(TrafficDirection::All),
            offset: steps(self.offset - start).rem_euclid(whole),
            cycle,
        })
    }
}
