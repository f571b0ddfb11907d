//! SUMO nets: lanes with a middle and a width, and how they are connected.

use std::collections::HashMap;
use std::path::Path;

use super::lights::{Program, program};
use crate::formats::commonroad::ReadError;
use crate::formats::commonroad::xml::{Element, Xml, decoded};
use crate::formats::recordings::assembly::Map;
use crate::formats::recordings::ids::Ids;
use crate::formats::recordings::lane_shape::{borders, without_repeats};
use crate::formats::recordings::report::Report;
use crate::geometry::Point;
use crate::scenario::plausibility::limits::{MOST_PARTS, refused_coordinate};
use crate::scenario::{
    Adjacent, ContentHash, Lanelet, LaneletType, LineMarking, RoadUser, Sign, SignElement,
};
use crate::system::{self, FileCache};

/// No net is larger, bytes.
const LARGEST: u64 = 512 << 20;

/// The width of a lane without one, metres.
const WIDTH: f64 = 3.2;

/// A lane of an edge.
struct NetLane {
    edge: String,
    index: i64,
    shape: Vec<Point>,
    width: f64,
    /// m/s.
    speed: Option<f64>,
    internal: bool,
    crossing: bool,
    users: Vec<RoadUser>,
}

/// A connection of two lanes.
struct Connection {
    from: (String, i64),
    to: (String, i64),
    /// The lane on the junction between them.
    via: Option<String>,
    /// The traffic light and the place of the connection in its states.
    light: Option<(String, usize)>,
}

/// A net as it is in its file.
struct Net {
    lanes: Vec<NetLane>,
    connections: Vec<Connection>,
    programs: HashMap<String, Program>,
    hash: ContentHash,
}

/// Nets that are kept for other windows of a recording, bytes of their files.
const KEPT: usize = 256 << 20;

static NETS: FileCache<Net> = FileCache::new(KEPT);

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
        let mut programs: HashMap<String, Program> = HashMap::new();
        while let Some(element) = xml.next()? {
            match element.name {
                "edge" => edge(&mut xml, element, &mut lanes)?,
                "connection" => connections.extend(connection(&mut xml, element)?),
                "tlLogic" => {
                    let (id, program) = program(&mut xml, element)?;
                    // Of several programs the first one runs.
                    programs.entry(id).or_insert(program);
                }
                _ => xml.skip()?,
            }
            let most = lanes.len().max(connections.len());
            xml.check_count(element, most, "lanes or connections")?;
        }
        let net = Self {
            lanes,
            connections,
            programs,
            hash: ContentHash::digest(&bytes),
        };
        Ok((net, bytes.len()))
    }
}

/// The lanes of a net, with the lights as they are from `start` on in steps of `dt` seconds.
pub fn read(
    report: &Report,
    path: &Path,
    ids: &mut Ids,
    (start, dt): (f64, f64),
) -> Result<(Map, ContentHash), ReadError> {
    let net = NETS.get(&[path], || Net::read(path))?;
    let Net {
        lanes,
        connections,
        programs,
        hash,
    } = &*net;
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
        let on = connection.via.clone();
        let on = on.unwrap_or_else(|| lane_name(&connection.from));
        let (Some(place), Some(program)) = (places.get(&on), programs.get(light)) else {
            continue;
        };
        let lanelet = &mut map.lanelets[*place];
        if let Some(light) = program.light(*link, start, dt) {
            let id = ids.fresh();
            let position = lanelet.right.points.first().copied();
            lanelet.lights.push(id);
            map.lights.push(crate::scenario::TrafficLight {
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
    Ok((map, *hash))
}

fn names(names: &[String]) -> HashMap<String, usize> {
    names.iter().cloned().zip(0..).collect()
}

fn lane_name((edge, index): &(String, i64)) -> String {
    format!("{edge}_{index}")
}

fn edge<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    lanes: &mut Vec<NetLane>,
) -> Result<(), ReadError> {
    let text = |name: &str| {
        xml.attribute(element, name)
            .map(|v| v.into_owned())
            .unwrap_or_default()
    };
    let (id, function) = (text("id"), text("function"));
    // Areas where people walk in any direction are no lanes.
    if function == "walkingarea" {
        return xml.skip();
    }
    while let Some(child) = xml.next()? {
        if child.name != "lane" {
            xml.skip()?;
            continue;
        }
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
        xml.skip()?;
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

/// Lanelets with the names of their lanes.
struct NamedMap {
    names: Vec<String>,
    lanelets: Vec<Lanelet>,
    signs: Vec<Sign>,
    lights: Vec<crate::scenario::TrafficLight>,
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
        match lane.crossing || lane.users == [RoadUser::Pedestrian] {
            true => lanelet.users_bidirectional = vec![RoadUser::Pedestrian],
            false => lanelet.users_one_way = lane.users.clone(),
        }
        let limit = lane
            .speed
            .filter(|v| *v > 0.0 && kind == LaneletType::Urban && !lane.internal);
        if let Some(limit) = limit {
            let id = *limits.entry(limit.to_bits()).or_insert_with(|| {
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
        let to = connection.via.clone();
        let to = to.unwrap_or_else(|| lane_name(&connection.to));
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
        let Some(left) = places.get(&lane_name(&(lane.edge.clone(), lane.index + 1))) else {
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
