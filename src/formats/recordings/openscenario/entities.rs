//! Entities of OpenSCENARIO: what they are, how big, where their middle is, and the catalogs they come from.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use nearmiss_base::geometry::{Point, Pose, Shape};
use nearmiss_base::system;
use nearmiss_scene::scenario::ObstacleType;

use super::expression;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::openscenario::entities;
use crate::recordings::opendrive::tree::{self, Node};
use crate::recordings::{Report, assembly, named_file};

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
pub fn entities(root: &Node, file: &Path, report: &Report) -> Result<Vec<Entity>, ReadError> {
    let mut all = Vec::new();
    let Some(list) = root.child("Entities") else {
        return Ok(all);
    };
    let mut catalogs = Catalogs::new(root, file);
    for object in list.all("ScenarioObject") {
        let name = object.needed("name")?.to_string();
        let inline = object.first(|c| INLINE.contains(&c.name.as_str()));
        let entity = match (inline, object.child("CatalogReference")) {
            (Some(described), _) => entity(name, described)?,
            (None, Some(reference)) => match catalogs.entry(reference, report)? {
                Some(described) => {
                    let entity = entity(name, &described)?;
                    catalogs.account(reference, &described);
                    entity
                }
                None => {
                    let words = Catalogs::reference_text(reference)?;
                    let at = report.at(format!("entity `{name}`"));
                    at.warn(format!(
                        "{words} is in no catalog of the scenario; taken for a car"
                    ));
                    unknown(name)
                }
            },
            (None, None) => {
                let at = report.at(format!("entity `{name}`"));
                at.warn("nothing says what it is; taken for a car");
                unknown(name)
            }
        };
        all.push(entity);
    }
    catalogs.report(report);
    Ok(all)
}

/// Entities that are described where they are named.
const INLINE: [&str; 3] = ["Vehicle", "Pedestrian", "MiscObject"];

/// An entity of which only the name is known.
fn unknown(name: String) -> Entity {
    let kind = ObstacleType::Car;
    let (length, width) = assembly::default_size(kind);
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
    let kind = written
        .and_then(|word| ObstacleType::parse(word))
        .unwrap_or_else(|| kind_of(node));
    let mut entity = Entity {
        kind,
        is_vehicle: node.name == "Vehicle",
        properties,
        ..unknown(name)
    };
    (entity.length, entity.width) = assembly::default_size(kind);
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
    entity.shape = entity.property("commonroad_body").and_then(entities::read);
    Ok(entity)
}

/// The properties that exports write; of others, which only their players know, the values are not read.
fn properties(node: &Node) -> HashMap<String, String> {
    let all = node
        .child("Properties")
        .into_iter()
        .flat_map(|p| p.all("Property"));
    let own = all.filter(|p| p.text("name").is_some_and(is_own_property));
    let pair = |p: &Node| Some((p.text("name")?.to_string(), p.text("value")?.to_string()));
    own.filter_map(pair).collect()
}

/// Whether this is the name of a property that exports write.
pub fn is_own_property(name: &str) -> bool {
    const OWN: [&str; 3] = ["commonroad_", "attacker", "plineInterpolation"];
    OWN.iter().any(|begin| name.starts_with(begin))
}

/// A kind by the category of the standard.
fn kind_of(node: &Node) -> ObstacleType {
    let category = [
        "vehicleCategory",
        "pedestrianCategory",
        "miscObjectCategory",
    ]
    .iter()
    .find_map(|name| node.text(name));
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

impl Entity {
    /// A value that was written beside it.
    pub fn property(&self, name: &str) -> Option<&str> {
        self.properties.get(name).map(String::as_str)
    }

    /// The numbers in a property; nothing where one is none.
    pub fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let numbers = self
            .property(name)?
            .split_whitespace()
            .map(|word| word.parse::<f64>().ok().filter(|v| v.abs() < 1e6));
        numbers.collect()
    }

    /// Where its track is: the middle of its body, or the position that its shape is told from.
    pub fn position(&self, pose: &Pose) -> Point {
        if self.center == Point::origin() || self.shape.is_some() {
            pose.position
        } else {
            pose.to_world(&self.center)
        }
    }
}

/// Files of a folder of catalogs that are looked into.
const MOST_CATALOGS: usize = 100;

/// The element that holds parameters.
const PARAMETERS: &str = "ParameterDeclarations";

/// The name of a catalog and of an entry of it.
type Key = (String, String);

/// The catalogs of a scenario, each file of which is read once, when the first entry is looked for.
pub struct Catalogs {
    folders: Vec<PathBuf>,
    read: Option<HashMap<Key, Node>>,
    /// What of the entries that are used was not, by entry.
    unused: BTreeMap<Key, Vec<(String, usize)>>,
}

impl Catalogs {
    /// Those that a document names; their folders are named from that of its file.
    pub fn new(root: &Node, file: &Path) -> Self {
        Self {
            folders: folders(root, file),
            read: None,
            unused: BTreeMap::new(),
        }
    }

    /// An entry with the values of its parameters; nothing where its folder or entry is not there.
    pub fn entry(&mut self, reference: &Node, report: &Report) -> Result<Option<Node>, ReadError> {
        let key = key(reference)?;
        let read = self.read.get_or_insert_with(|| all(&self.folders, report));
        let found = read.get(&key).cloned();
        found
            .map(|entry| expression::assigned(entry, reference))
            .transpose()
    }

    /// Notes what of an entry was not used, once it was.
    pub fn account(&mut self, reference: &Node, entry: &Node) {
        if let Ok(key) = key(reference) {
            self.unused
                .entry(key)
                .or_insert_with(|| entry.unused(&[PARAMETERS]));
        }
    }

    /// Reports what of the entries was not used.
    pub fn report(self, report: &Report) {
        for (kind, _) in self.unused.into_values().flatten() {
            // Its line is one of another file.
            report.unused(kind, 0);
        }
    }

    /// What a reference names, in words.
    pub fn reference_text(reference: &Node) -> Result<String, ReadError> {
        let (catalog, entry) = key(reference)?;
        Ok(format!("`{entry}` of the catalog `{catalog}`"))
    }
}

fn key(reference: &Node) -> Result<Key, ReadError> {
    let word = |name: &str| Ok::<String, ReadError>(reference.needed(name)?.to_string());
    Ok((word("catalogName")?, word("entryName")?))
}

/// The folders of catalogs that a document names.
fn folders(root: &Node, file: &Path) -> Vec<PathBuf> {
    let locations = root
        .child("CatalogLocations")
        .into_iter()
        .flat_map(Node::children);
    let folders = locations.filter_map(|l| l.child("Directory")?.text("path"));
    folders.map(|folder| named_file(file, folder)).collect()
}

/// The files in a folder that may be catalogs, by name.
fn files_in(folder: &Path) -> Vec<PathBuf> {
    let is_xosc = |f: &PathBuf| {
        f.extension()
            .is_some_and(|x| x.eq_ignore_ascii_case("xosc"))
    };
    let all = folder.read_dir().into_iter().flatten().flatten();
    let mut files: Vec<_> = all.map(|f| f.path()).filter(is_xosc).collect();
    files.sort();
    files
}

/// The files in all folders of catalogs that a document names.
pub fn catalog_files(root: &Node, file: &Path) -> Vec<PathBuf> {
    let folders = folders(root, file);
    let files = folders.iter().map(|folder| files_in(folder));
    files
        .flat_map(|files| files.into_iter().take(MOST_CATALOGS))
        .collect()
}

/// All entries of the files of some folders; the first of those with the same names.
fn all(folders: &[PathBuf], report: &Report) -> HashMap<Key, Node> {
    let mut all = HashMap::new();
    let mut seen = Vec::new();
    for folder in folders {
        let files = files_in(folder);
        if files.len() > MOST_CATALOGS {
            let folder = folder.display();
            report.note(format!(
                "only the first {MOST_CATALOGS} catalogs of {folder} are read"
            ));
        }
        for path in files.into_iter().take(MOST_CATALOGS) {
            if seen.contains(&path) {
                continue;
            }
            let shown = path.display().to_string();
            seen.push(path.clone());
            // A scenario may lie among catalogs; what is broken is told of only where it is one that was asked for.
            let Ok(bytes) = system::read_file(&path, system::LARGEST) else {
                continue;
            };
            let read = match tree::read(&bytes, &shown, "OpenSCENARIO") {
                Ok(read) => read,
                Err(error) => {
                    report.note(format!("catalog not read: {error}"));
                    continue;
                }
            };
            let Some(catalog) = read.into_child("Catalog") else {
                continue;
            };
            let name = catalog.text("name").unwrap_or_default().to_string();
            for entry in catalog.into_children() {
                let key = (
                    name.clone(),
                    entry.text("name").unwrap_or_default().to_string(),
                );
                all.entry(key).or_insert(entry);
            }
        }
    }
    all
}
