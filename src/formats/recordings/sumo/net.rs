//! SUMO nets as they are in their files: lanes with a middle and a width, and how they are connected.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use super::geo::Location;
use super::lanes::{Program, program};
use crate::commonroad::ReadError;
use crate::commonroad::xml::{Element, Xml, decoded};
use crate::recordings::report::Leftovers;
use nearmiss_base::geometry::Point;
use nearmiss_base::system::{self, FileCache};
use nearmiss_scene::scenario::plausibility::limits::{MOST_PARTS, refused_coordinate};
use nearmiss_scene::scenario::{ContentHash, RoadUser};

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
