//! OpenSCENARIO XML with its OpenDRIVE: scenarios whose entities follow trajectories, and recordings that a player made.

mod actions;
mod catalogs;
mod entities;
mod expression;
mod kept;
mod lights;
mod motion;
mod parameters;
mod played;
mod player_log;
mod position;
mod storyboard;
mod tracks;
mod trajectory;
mod triggers;

use std::path::Path;

use super::assembly::{About, Map, assemble};
use super::ids::Ids;
use super::named_files::named_file;
use super::opendrive::tree::{self, Node};
use super::opendrive::{self, Network};
use super::report::Report;
use super::{sizes, whole_file};
use crate::address::Address;
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::{ReadError, beginning};
use crate::dispatch::{Format, Parts};
use crate::openscenario::DOCUMENT;
use entities::{Entity, entities, is_own_property};
use nearmiss_base::system;
use nearmiss_scene::scenario::plausibility::limits::refused_time_step;
use nearmiss_scene::scenario::{ContentHash, Scenario};
use played::Played;
use tracks::{Timeline, own_number};

/// The format.
pub struct OpenScenario;

/// Seconds between two steps, where nothing tells them.
const STEP: f64 = 0.1;

/// Entities that are the ego by their names.
const EGOS: [&str; 4] = ["ego", "hero", "ego_vehicle", "host"];

impl Format for OpenScenario {
    fn recognises(&self, _: &Path, head: &[u8]) -> bool {
        let text = beginning(head);
        text.contains("<OpenSCENARIO") || text.contains("<OpenDRIVE")
    }

    fn parts(&self, _: &Path) -> Result<Parts, ReadError> {
        Ok(Parts::One)
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let file = whole_file(address)?;
        let shown = file.display().to_string();
        let bytes =
            system::read_file(file, system::LARGEST).map_err(|e| ReadError::io(&shown, &e))?;
        let report = Report::about(shown.clone());
        if beginning(&bytes[..bytes.len().min(4096)]).contains("<OpenDRIVE") {
            return roads_alone(&bytes, file, report);
        }
        let root = tree::read(&bytes, &shown, "OpenSCENARIO")?;
        check_version(&root, &report)?;
        scenario(file, &bytes, parameters::filled(root)?, report)
    }
}

fn roads_alone(bytes: &[u8], file: &Path, report: Report) -> Result<Scenario, ReadError> {
    let mut ids = Ids::beyond([]);
    let network = opendrive::read(bytes, &file.display().to_string(), &report, &mut ids)?;
    let about = About {
        source: "OpenDRIVE",
        benchmark_id: "ZAM_OpenDrive-1".into(),
        time_step_size: STEP,
        tags: Vec::new(),
        ego: None,
        hash: ContentHash::digest(bytes),
    };
    assemble(report, about, network.map, Vec::new())
}

/// The newest version of the standard whose elements are known.
const NEWEST: (i64, i64) = (1, 3);

/// Refuses what is no OpenSCENARIO of the versions that are read.
fn check_version(root: &Node, report: &Report) -> Result<(), ReadError> {
    let Some(header) = root.child("FileHeader") else {
        return Ok(());
    };
    let number = |name: &str| header.text(name).and_then(|v| v.trim().parse::<i64>().ok());
    let (Some(major), Some(minor)) = (number("revMajor"), number("revMinor")) else {
        return Ok(());
    };
    if major < 1 {
        return Err(header.fail(format!(
            "OpenSCENARIO {major}.{minor} is not read, only 1.0 and later; convert it with the migration script (XSLT) \
             that ASAM ships with OpenSCENARIO 1.0"
        )));
    }
    if (major, minor) > NEWEST {
        let (newest, of) = NEWEST;
        let words = format!("OpenSCENARIO {major}.{minor} is read as {newest}.{of}");
        report.at("FileHeader").warn(words);
    }
    Ok(())
}

/// Why a scenario that names no roads has none.
const NO_ROADS: &str = "names no road file";

/// The roads of a scenario; words where their file cannot be read.
fn roads(
    root: &Node,
    file: &Path,
    report: &Report,
    ids: &mut Ids,
    hashed: &mut Vec<Vec<u8>>,
) -> Result<Result<Network, String>, ReadError> {
    let named = root
        .at(&["RoadNetwork", "LogicFile"])
        .and_then(|l| l.text("filepath"))
        .filter(|n| !n.is_empty());
    let Some(named) = named else {
        return Ok(Err(NO_ROADS.into()));
    };
    let path = named_file(file, named);
    let shown = path.display().to_string();
    match system::read_file(&path, system::LARGEST) {
        Ok(roads) => {
            let read = opendrive::read(&roads, &shown, report, ids)?;
            hashed.push(roads);
            Ok(Ok(read))
        }
        Err(error) => Ok(Err(format!("{shown}: {}", system::words(&error)))),
    }
}

/// Elements that only hold others.
const GROUPS: [&str; 5] = [
    "ParameterDeclarations",
    "CatalogLocations",
    "Properties",
    "StartTrigger",
    "StopTrigger",
];

/// Notes what of the document was not used.
fn account(root: &Node, report: &Report) {
    if let Some(header) = root.child("FileHeader") {
        // What says of a file what it is, not what happens.
        header.child("License").into_iter().for_each(Node::skip);
        header.skip_attributes(&["author", "date", "description"]);
        let properties = header
            .child("Properties")
            .into_iter()
            .flat_map(|p| p.all("Property"));
        let is_own = |p: &&Node| p.text("name").is_some_and(is_own_property);
        properties.filter(is_own).for_each(Node::skip);
    }
    for (kind, line) in root.unused(&GROUPS) {
        report.unused(kind, line);
    }
}

fn scenario(file: &Path, bytes: &[u8], root: Node, report: Report) -> Result<Scenario, ReadError> {
    let entities = entities(&root, file, &report)?;
    let numbers = entities.iter().filter_map(own_number);
    let ego_id = |e: &Entity| {
        e.property("commonroad_id")
            .and_then(|id| id.parse::<i64>().ok())
    };
    let mut ids = Ids::beyond(numbers.clone().chain(entities.iter().filter_map(ego_id)));
    numbers.for_each(|id| {
        ids.take(id);
    });
    let mut hashed = vec![bytes.to_vec()];
    let roads = roads(&root, file, &report, &mut ids, &mut hashed)?;
    if let Err(why) = &roads {
        let words = format!("{why}; the scenario has no lanes");
        report.at("").warn(words);
    }
    let header = root.child("FileHeader");
    let header_property = |name: &str| {
        let all = header?.child("Properties")?.all("Property");
        let mut found = all.filter(|p| p.text("name") == Some(name));
        found.next()?.text("value").map(str::to_string)
    };
    let dt = header_property("commonroad_time_step")
        .and_then(|t| t.parse().ok())
        .filter(|dt| refused_time_step(*dt).is_none());
    let origin = header_property("commonroad_first_step").and_then(|s| s.parse().ok());
    let document = header_property(DOCUMENT);
    let mut names: Vec<&str> = entities.iter().map(|entity| entity.name.as_str()).collect();
    names.sort_unstable();
    if let Some(twice) = names.windows(2).find(|two| two[0] == two[1]) {
        let words = format!(
            "two entities are called `{}`; actions mean the first",
            twice[0]
        );
        report.at("Entities").warn(words);
    }
    let ego = ego(&entities, document.is_some());
    let played = Played {
        root: &root,
        file,
        entities: &entities,
        ego,
        timeline: Timeline {
            dt: dt.unwrap_or(STEP),
            origin: origin.unwrap_or(0),
            end: storyboard::end(&root),
        },
    };
    let (dt, tracks) = played.tracks(&roads, &report, &mut ids, &mut hashed)?;
    let assumed = entities.iter().filter(|e| e.assumed).map(|e| e.kind);
    let assumed: Vec<_> = assumed.collect();
    report.note_count(assumed.len(), |n| {
        let words = sizes::in_words(assumed);
        format!("entities without a size: {n}; assumed by kind: {words}")
    });
    let mut named = Vec::new();
    let mut own = None;
    let mut all = Vec::new();
    for (name, track) in tracks {
        if ego.is_some_and(|e| e.name == name) {
            own = Some(track.id);
        }
        if name != track.id.to_string() {
            named.push(format!("`{name}` {}", track.id));
        }
        all.push(track);
    }
    if !named.is_empty() {
        report.note(format!("entities are numbered: {}", named.join(", ")));
    }
    if let (Some(_), None) = (ego, own) {
        report.note("the ego has no motion: a driver under test is to drive it; it is left out");
    }
    let parts: Vec<&[u8]> = hashed.iter().map(Vec::as_slice).collect();
    let tags = header_property("commonroad_tags").unwrap_or_default();
    let about = About {
        source: "OpenSCENARIO",
        benchmark_id: header_property("commonroad_benchmark_id")
            .unwrap_or_else(|| "ZAM_OpenScenario-1_1_T-1".into()),
        time_step_size: dt,
        tags: tags.split_whitespace().map(str::to_string).collect(),
        ego: own,
        hash: ContentHash::of_parts(parts),
    };
    let mut map = Map::default();
    let mut signs = None;
    if let Ok(network) = roads {
        (map, signs) = (network.map, network.kept);
        let clock = lights::Clock {
            dt,
            origin: origin.unwrap_or(0),
        };
        lights::phases(&root, clock, &network.lights, &mut map.lights)?;
    }
    account(&root, &report);
    let mut scenario = assemble(report, about, map, all)?;
    if let Some(document) = document {
        kept::restore(&mut scenario, &document, signs);
    }
    Ok(scenario)
}

/// The ego: by its name, else the first vehicle; exports whose ego has no name have none.
fn ego(entities: &[Entity], is_export: bool) -> Option<&Entity> {
    let named = |e: &&Entity| EGOS.contains(&e.name.to_lowercase().as_str());
    let first = || entities.iter().find(|e| e.is_vehicle && !is_export);
    entities.iter().find(named).or_else(first)
}
