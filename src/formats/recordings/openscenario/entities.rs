//! Entities of OpenSCENARIO: what they are, how big, and where the middle of their bodies is.

use std::collections::HashMap;
use std::path::Path;

use super::parameters;
use crate::formats::commonroad::ReadError;
use crate::formats::openscenario::body;
use crate::formats::recordings::opendrive::tree::{self, Node};
use crate::formats::recordings::sizes;
use crate::geometry::{Point, Pose, Shape};
use crate::scenario::ObstacleType;
use crate::system;

/// An entity.
#[derive(Debug, Clone)]
pub struct Entity {
    pub name: String,
    pub kind: ObstacleType,
    /// Metres.
    pub length: f64,
    pub width: f64,
    /// The middle of the body, from the entity's position.
    pub center: Point,
    /// Whether its size is assumed.
    pub assumed: bool,
    pub is_vehicle: bool,
    /// Its body, where that is no box, in the frame of its position.
    pub shape: Option<Shape>,
    properties: HashMap<String, String>,
}

/// Reads the entities of a scenario; catalogs lie in folders named from that of the file.
pub fn entities(root: &Node, file: &Path) -> Result<Vec<Entity>, ReadError> {
    let mut all = Vec::new();
    let Some(list) = root.child("Entities") else {
        return Ok(all);
    };
    for object in list.all("ScenarioObject") {
        let name = object.needed("name")?.to_string();
        let inline = object
            .children
            .iter()
            .find(|c| matches!(c.name.as_str(), "Vehicle" | "Pedestrian" | "MiscObject"));
        let entity = match (inline, object.child("CatalogReference")) {
            (Some(described), _) => entity(name, described)?,
            (None, Some(reference)) => match from_catalog(root, reference, file)? {
                Some(described) => entity(name, &described)?,
                None => unknown(name),
            },
            (None, None) => unknown(name),
        };
        all.push(entity);
    }
    Ok(all)
}

/// An entity of which only the name is known.
fn unknown(name: String) -> Entity {
    let kind = ObstacleType::Car;
    let (length, width) = sizes::usual(kind);
    Entity {
        name,
        kind,
        length,
        width,
        center: Point::origin(),
        assumed: true,
        is_vehicle: true,
        shape: None,
        properties: HashMap::new(),
    }
}

fn entity(name: String, node: &Node) -> Result<Entity, ReadError> {
    let properties = properties(node);
    let written = properties.get("commonroad_type");
    let kind = written.and_then(|word| ObstacleType::parse(word));
    let kind = kind.unwrap_or_else(|| kind_of(node));
    let mut entity = Entity {
        kind,
        is_vehicle: node.name == "Vehicle",
        properties,
        ..unknown(name)
    };
    (entity.length, entity.width) = sizes::usual(kind);
    let Some(described) = node.child("BoundingBox") else {
        return Ok(entity);
    };
    if let Some(center) = described.child("Center") {
        entity.center = Point::new(center.or_zero("x")?, center.or_zero("y")?);
    }
    if let Some(size) = described.child("Dimensions") {
        let (length, width) = (size.or_zero("length")?, size.or_zero("width")?);
        if length > 0.0 && width > 0.0 {
            (entity.length, entity.width, entity.assumed) = (length, width, false);
        }
    }
    entity.shape = entity.property("commonroad_body").and_then(body::read);
    Ok(entity)
}

fn properties(node: &Node) -> HashMap<String, String> {
    let all = node
        .child("Properties")
        .into_iter()
        .flat_map(|p| p.all("Property"));
    let pair = |p: &Node| Some((p.text("name")?.to_string(), p.text("value")?.to_string()));
    all.filter_map(pair).collect()
}

/// A kind by the category of the standard.
fn kind_of(node: &Node) -> ObstacleType {
    let category = [
        "vehicleCategory",
        "pedestrianCategory",
        "miscObjectCategory",
    ];
    let category = category.iter().find_map(|name| node.text(name));
    match (node.name.as_str(), category.unwrap_or_default()) {
        ("Vehicle", "truck" | "semitrailer" | "trailer") => ObstacleType::Truck,
        ("Vehicle", "bus") => ObstacleType::Bus,
        ("Vehicle", "motorbike") => ObstacleType::Motorcycle,
        ("Vehicle", "bicycle") => ObstacleType::Bicycle,
        ("Vehicle", "train" | "tram") => ObstacleType::Train,
        ("Vehicle", _) => ObstacleType::Car,
        ("Pedestrian", _) => ObstacleType::Pedestrian,
        (_, "barrier" | "railing" | "soundBarrier") => ObstacleType::RoadBoundary,
        (_, "building") => ObstacleType::Building,
        (_, "pole" | "streetLamp") => ObstacleType::Pillar,
        (_, "obstacle") => ObstacleType::ConstructionZone,
        _ => ObstacleType::Unknown,
    }
}

/// An entry of a catalog; nothing where its folder or entry is not there.
fn from_catalog(root: &Node, reference: &Node, file: &Path) -> Result<Option<Node>, ReadError> {
    let catalog = reference.needed("catalogName")?;
    let entry = reference.needed("entryName")?;
    let Some(locations) = root.child("CatalogLocations") else {
        return Ok(None);
    };
    for location in &locations.children {
        let Some(folder) = location.child("Directory").and_then(|d| d.text("path")) else {
            continue;
        };
        let folder = file.parent().unwrap_or(Path::new("")).join(folder);
        let Ok(files) = folder.read_dir() else {
            continue;
        };
        let mut files: Vec<_> = files.flatten().map(|f| f.path()).collect();
        files.retain(|f| {
            f.extension()
                .is_some_and(|x| x.eq_ignore_ascii_case("xosc"))
        });
        files.sort();
        for path in files.into_iter().take(MOST_CATALOGS) {
            let Ok(bytes) = system::read_file(&path, system::LARGEST) else {
                continue;
            };
            let Ok(read) = tree::read(&bytes, &path.display().to_string(), "OpenSCENARIO") else {
                continue;
            };
            let Some(found) = read
                .child("Catalog")
                .filter(|c| c.text("name") == Some(catalog))
            else {
                continue;
            };
            let found = found
                .children
                .iter()
                .find(|e| e.text("name") == Some(entry));
            if let Some(found) = found {
                return parameters::assigned(found.clone(), reference).map(Some);
            }
        }
    }
    Ok(None)
}

/// Files of a folder of catalogs that are looked into.
const MOST_CATALOGS: usize = 100;

impl Entity {
    /// A value that was written beside it.
    pub fn property(&self, name: &str) -> Option<&str> {
        self.properties.get(name).map(String::as_str)
    }

    /// The numbers in a property; nothing where one is none.
    pub fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let numbers = self.property(name)?.split_whitespace();
        let numbers = numbers.map(|word| word.parse::<f64>().ok().filter(|v| v.abs() < 1e6));
        numbers.collect()
    }

    /// Where its track is: the middle of its body, or the position that its shape is told from.
    pub fn position(&self, pose: &Pose) -> Point {
        match self.center == Point::origin() || self.shape.is_some() {
            true => pose.position,
            false => pose.to_world(&self.center),
        }
    }
}
