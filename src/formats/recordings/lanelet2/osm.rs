//! Lanelet2 maps as they are in their files: nodes, ways, and the relations that are lanelets.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use crate::commonroad::ReadError;
use crate::commonroad::xml::{Element, Xml, decoded};
use crate::recordings::report::Leftovers;
use nearmiss_base::system::{self, FileCache};
use nearmiss_scene::scenario::LineMarking;

/// No map is larger, bytes.
const LARGEST: u64 = 256 << 20;

/// A node: its place, until the map's own coordinates are known.
pub enum Place {
    Metres(f64, f64),
    Degrees(f64, f64),
}

/// A line through nodes.
pub struct Way {
    pub nodes: Vec<i64>,
    pub marking: LineMarking,
    /// As the map calls it.
    kind: String,
    line: usize,
}

/// A lanelet, by the ids of the ways along it.
#[derive(Default)]
pub struct Relation {
    pub id: i64,
    pub left: Option<i64>,
    pub right: Option<i64>,
    pub tags: HashMap<String, String>,
}

/// A map as it is in its file.
pub struct Osm {
    pub nodes: HashMap<i64, Place>,
    pub ways: HashMap<i64, Way>,
    pub relations: Vec<Relation>,
    /// What stands in it and is not used.
    pub leftovers: Leftovers,
}

/// Maps that are kept for other windows of a recording, bytes of their files.
const MAX_CACHED: usize = 64 << 20;

static MAPS: FileCache<Osm> = FileCache::new(MAX_CACHED);

/// A map, read anew if it changed.
pub fn cached_map(path: &Path) -> Result<Arc<Osm>, ReadError> {
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
    let place = match (local, lat, lon) {
        ((Some(x), Some(y)), ..) if x.abs() < 1e7 && y.abs() < 1e7 => Place::Metres(x, y),
        (_, Some(lat), Some(lon)) if lat.abs() <= 90.0 && lon.abs() <= 360.0 => {
            Place::Degrees(lat, lon)
        }
        _ => {
            return Err(xml.fail_in(
                element,
                "a node without `lat` and `lon` on the Earth".into(),
            ));
        }
    };
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
