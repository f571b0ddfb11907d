//! Files that belong to floating car data: the net that is meant, and the types that give vehicles their sizes.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::system::{self, FileCache};
use nearmiss_scene::scenario::ObstacleType;

use super::fcd::Recorded;
use super::net::{self, Net};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::xml::{Element, Xml, decoded};
use crate::recordings::{Leftovers, Report};

/// Files of a folder that are looked at.
const MAX_FILES: usize = 1000;

/// The values of an option in the comment.
fn values<'c>(comment: &'c str, option: &str) -> impl Iterator<Item = &'c str> + use<'c> {
    let begin = format!("<{option} value=\"");
    let value = comment
        .split(&*begin)
        .nth(1)
        .map(|rest| rest.split('"'))
        .and_then(|mut rest| rest.next())
        .unwrap_or_default();
    let names = value.split(',').map(str::trim);
    names.filter(|name| !name.is_empty())
}

/// The name of a file without its folders, also of a path of Windows.
fn plain(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

/// The files that an option names and that are there: as they are named from the folder of the file, or beside the file,
/// where files may have been moved together.
fn named_by_option(file: &Path, comment: &str, option: &str) -> Vec<PathBuf> {
    let folder = file.parent().unwrap_or_else(|| Path::new(""));
    let paths = values(comment, option).filter_map(|name| {
        let places = [name, plain(name)].map(|name| folder.join(name));
        places.into_iter().find(|path| path.is_file())
    });
    paths.collect()
}

/// Files beside one whose names end so, by name.
fn siblings_ending_in(file: &Path, end: &str) -> Vec<PathBuf> {
    let folder = file
        .parent()
        .filter(|f| !f.as_os_str().is_empty())
        .unwrap_or_else(|| Path::new("."));
    let all = folder
        .read_dir()
        .into_iter()
        .flatten()
        .flatten()
        .take(MAX_FILES);
    let paths = all.map(|entry| entry.path());
    let mut found: Vec<PathBuf> = paths
        .filter(|path| path.to_string_lossy().ends_with(end))
        .collect();
    found.sort();
    found
}

/// The nets that may be those of a file.
enum Nets {
    /// The one that SUMO was started with, or that has the name of the file.
    Told(PathBuf),
    /// Those beside it, none of which is told; and the name of the one that SUMO was started with, if it is known.
    Beside(Vec<PathBuf>, Option<String>),
}

/// The nets of a file.
fn nets(file: &Path, comment: &str) -> Nets {
    if let Some(named) = named_by_option(file, comment, "net-file")
        .into_iter()
        .next()
    {
        return Nets::Told(named);
    }
    let nets = siblings_ending_in(file, ".net.xml");
    let name = |path: &Path| path.file_name().map(|n| n.to_string_lossy().into_owned());
    let own = name(file).unwrap_or_default();
    let own = format!("{}.net.xml", own.split('.').next().unwrap_or_default());
    match nets.iter().find(|net| name(net).as_ref() == Some(&own)) {
        Some(net) => Nets::Told(net.clone()),
        None => {
            let started_with = values(comment, "net-file").next();
            Nets::Beside(nets, started_with.map(|name| plain(name).to_string()))
        }
    }
}

/// The files that may define types of vehicles.
fn with_types(file: &Path, comment: &str) -> Vec<PathBuf> {
    let mut found = named_by_option(file, comment, "route-files");
    found.extend(named_by_option(file, comment, "additional-files"));
    if found.is_empty() {
        found = siblings_ending_in(file, ".rou.xml");
        found.extend(siblings_ending_in(file, ".add.xml"));
    }
    found
}

/// Names of files, for messages.
fn in_words(paths: &[PathBuf]) -> String {
    let names = paths
        .iter()
        .take(MAX_LISTED)
        .filter_map(|path| path.file_name());
    let names: Vec<_> = names.map(|name| name.to_string_lossy()).collect();
    let more = match paths.len() - names.len().min(paths.len()) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("{}{more}", names.join(", "))
}

/// So many files are named in a message.
const MAX_LISTED: usize = 5;

/// The net of a recording: the one that it names, or the one beside it in which its edges are. What is wrong is said.
pub fn net(
    file: &Path,
    recorded: &Recorded,
    report: &Report,
) -> Result<Option<(PathBuf, Arc<Net>)>, ReadError> {
    let (nets, started_with) = match nets(file, &recorded.comment) {
        Nets::Told(net) => {
            let read = net::read(&net)?;
            return Ok(Some((net, read)));
        }
        Nets::Beside(nets, started_with) => (nets, started_with),
    };
    let none = |why: String| {
        report
            .at("")
            .warn(format!("no net: {why}; the scenario has no lanes"));
        Ok(None)
    };
    let used = &recorded.edges;
    match &nets[..] {
        [] => none(match started_with {
            Some(name) => format!("{name}, which it was made with, is not beside it"),
            None => "no .net.xml beside it".into(),
        }),
        [only] => {
            let net = net::read(only)?;
            if used.is_empty() || used.iter().any(|edge| net.edges.contains(edge)) {
                Ok(Some((only.clone(), net)))
            } else {
                none(format!(
                    "{}, the only one beside it, has none of its edges, such as `{}`",
                    in_words(&nets),
                    used.first().map_or("", String::as_str)
                ))
            }
        }
        several => {
            // One that is damaged is none of these.
            let all = several
                .iter()
                .filter_map(|path| Some((path, net::read(path).ok()?)));
            let has_all = |net: &Net| used.iter().all(|edge| net.edges.contains(edge));
            let mut fit: Vec<_> = all
                .filter(|(_, net)| !used.is_empty() && has_all(net))
                .collect();
            if fit.len() == 1
                && let Some((path, net)) = fit.pop()
            {
                report.note(format!(
                    "net {}: the only one of {} beside it that has its edges",
                    path.display(),
                    several.len()
                ));
                return Ok(Some((path.clone(), net)));
            }
            let which = match fit.len() {
                0 => "none of them has",
                _ => "several of them have",
            };
            none(format!(
                "{} .net.xml files are beside it ({}), and {which} all its edges; leave only its own",
                several.len(),
                in_words(several)
            ))
        }
    }
}

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
        let files = with_types(path, &recorded.comment);
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
