//! Sizes of vehicles: from the types in route and additional files, or SUMO's defaults of their class.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use super::fcd::Recorded;
use super::files;
use crate::commonroad::ReadError;
use crate::commonroad::xml::{Element, Xml, decoded};
use crate::recordings::report::{Leftovers, Report};
use nearmiss_base::system::{self, FileCache};
use nearmiss_scene::scenario::ObstacleType;

/// A type of vehicles.
#[derive(Debug, Clone, PartialEq)]
pub struct VehicleType {
    pub kind: ObstacleType,
    /// Metres.
    pub length: f64,
    /// Metres.
    pub width: f64,
}

/// The types of a recording.
pub struct Types {
    known: HashMap<String, VehicleType>,
    default: VehicleType,
}

/// Types that are kept for other windows of a recording, bytes.
const MAX_CACHED: usize = 16 << 20;

static DEFINED: FileCache<Defined> = FileCache::new(MAX_CACHED);

/// The types that files define, and what else stands in these.
#[derive(Default)]
struct Defined {
    types: HashMap<String, VehicleType>,
    leftovers: Leftovers,
}

/// No file of types is larger, bytes.
const LARGEST: u64 = 512 << 20;

/// SUMO's defaults, as version 1.28 has them: class, kind, length and width in metres.
#[rustfmt::skip]
const CLASSES: [(&str, ObstacleType, f64, f64); 34] = [
    ("passenger", ObstacleType::Car, 5.0, 1.8), ("private", ObstacleType::Car, 5.0, 1.8),
    ("vip", ObstacleType::Car, 5.0, 1.8), ("hov", ObstacleType::Car, 5.0, 1.8),
    ("evehicle", ObstacleType::Car, 5.0, 1.8), ("army", ObstacleType::Car, 5.0, 1.8),
    ("custom1", ObstacleType::Car, 5.0, 1.8), ("custom2", ObstacleType::Car, 5.0, 1.8),
    ("ignoring", ObstacleType::Car, 5.0, 1.8), ("taxi", ObstacleType::Taxi, 5.0, 1.8),
    ("authority", ObstacleType::PriorityVehicle, 5.0, 1.8), ("emergency", ObstacleType::PriorityVehicle, 6.5, 2.16),
    ("delivery", ObstacleType::Truck, 6.5, 2.16), ("truck", ObstacleType::Truck, 7.1, 2.4),
    ("trailer", ObstacleType::Truck, 16.5, 2.55),
    ("bus", ObstacleType::Bus, 12.0, 2.5), ("coach", ObstacleType::Bus, 14.0, 2.6),
    ("tram", ObstacleType::Train, 22.0, 2.4), ("rail_urban", ObstacleType::Train, 109.5, 3.0),
    ("subway", ObstacleType::Train, 109.5, 3.0), ("rail", ObstacleType::Train, 135.0, 2.84),
    ("rail_electric", ObstacleType::Train, 200.0, 2.95), ("rail_fast", ObstacleType::Train, 200.0, 2.95),
    ("cable_car", ObstacleType::Unknown, 5.0, 1.8),
    ("motorcycle", ObstacleType::Motorcycle, 2.2, 0.9), ("moped", ObstacleType::Motorcycle, 2.1, 0.78),
    ("bicycle", ObstacleType::Bicycle, 1.6, 0.65), ("scooter", ObstacleType::Bicycle, 1.2, 0.5),
    ("pedestrian", ObstacleType::Pedestrian, 0.215, 0.478), ("wheelchair", ObstacleType::Pedestrian, 1.2, 0.72),
    ("ship", ObstacleType::Unknown, 17.0, 4.0), ("container", ObstacleType::Unknown, 6.096, 2.438),
    ("aircraft", ObstacleType::Unknown, 72.7, 79.8), ("drone", ObstacleType::Unknown, 0.5, 0.5),
];

fn class(name: &str) -> VehicleType {
    let found = CLASSES.iter().find(|(class, ..)| *class == name);
    let (_, kind, length, width) = *found.unwrap_or(&CLASSES[0]);
    VehicleType {
        kind,
        length,
        width,
    }
}

impl Types {
    /// Those of a recording; what is assumed is noted.
    pub fn read(path: &Path, recorded: &Recorded, report: &Report) -> Result<Self, ReadError> {
        let mut known = HashMap::from(
            [
                ("DEFAULT_VEHTYPE", "passenger"),
                ("DEFAULT_TAXITYPE", "taxi"),
                ("DEFAULT_BIKETYPE", "bicycle"),
                ("DEFAULT_PEDTYPE", "pedestrian"),
                ("DEFAULT_RAILTYPE", "rail"),
            ]
            .map(|(name, of)| (name.to_string(), class(of))),
        );
        let files = files::with_types(path, &recorded.comment);
        let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
        let defined = DEFINED.get(&files, || {
            let mut defined = Defined::default();
            for file in &files {
                read(file, &mut defined)?;
            }
            let size = defined.types.len() * (size_of::<VehicleType>() + 128);
            Ok::<_, ReadError>((defined, size))
        })?;
        defined.leftovers.report_to(report);
        known.extend(
            defined
                .types
                .iter()
                .map(|(name, kind)| (name.clone(), kind.clone())),
        );
        let used: BTreeSet<&str> = recorded.vehicles.iter().map(|v| v.kind.as_str()).collect();
        let missing: Vec<&str> = used
            .into_iter()
            .filter(|kind| !known.contains_key(*kind))
            .collect();
        if !missing.is_empty() {
            report.note(format!(
                "types {} are not defined in a route or additional file beside it; taken as passenger cars of 5 m × 1.8 m",
                missing.join(", ")
            ));
        }
        Ok(Self {
            known,
            default: class("passenger"),
        })
    }

    /// The type of this name.
    pub fn get(&self, name: &str) -> &VehicleType {
        self.known.get(name).unwrap_or(&self.default)
    }

    /// All of them, in an order.
    pub fn bytes(&self) -> Vec<u8> {
        let all: BTreeMap<_, _> = self.known.iter().collect();
        format!("{all:?}").into_bytes()
    }
}

/// Adds the types that a file defines.
fn read(path: &Path, known: &mut Defined) -> Result<(), ReadError> {
    let file = path.display().to_string();
    let bytes = system::read_file(path, LARGEST).map_err(|e| ReadError::io(&file, &e))?;
    let text = decoded(&bytes, &file)?;
    let mut xml = Xml::new(&text, &file);
    let Some(root) = xml.next()? else {
        return Ok(());
    };
    while let Some(element) = xml.next()? {
        match element.name {
            "vType" => add(&mut xml, element, known)?,
            "vTypeDistribution" => {
                while let Some(child) = xml.next()? {
                    match child.name {
                        "vType" => add(&mut xml, child, known)?,
                        _ => known
                            .leftovers
                            .element(&mut xml, "vTypeDistribution", child)?,
                    }
                }
            }
            _ => known.leftovers.element(&mut xml, root.name, element)?,
        }
    }
    Ok(())
}

fn add<'a>(xml: &mut Xml<'a>, element: Element<'a>, known: &mut Defined) -> Result<(), ReadError> {
    known
        .leftovers
        .attributes(xml, element, &["id", "vClass", "length", "width"]);
    let name = xml.attribute(element, "id");
    let v_class = xml.attribute(element, "vClass");
    let of_class = v_class.as_deref().unwrap_or("passenger");
    if !CLASSES.iter().any(|(class, ..)| *class == of_class) {
        let shown: String = of_class.chars().take(40).collect();
        let kind = format!("vType@vClass `{shown}`, taken as passenger");
        known.leftovers.add(&kind, || xml.line(element));
    }
    let mut found = class(of_class);
    for (name, into) in [("length", &mut found.length), ("width", &mut found.width)] {
        let Some(text) = xml.attribute(element, name) else {
            continue;
        };
        let metres = text.parse::<f64>().ok().filter(|m| *m > 0.0 && *m < 1000.0);
        *into = metres.ok_or_else(|| {
            let shown: String = text.chars().take(40).collect();
            xml.fail(
                element.at,
                format!("{name}=\"{shown}\" is not a size in metres"),
            )
        })?;
    }
    if let Some(name) = name {
        known.types.insert(name.into_owned(), found);
    }
    known.leftovers.rest(xml, "vType")
}
