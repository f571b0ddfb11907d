//! OpenSCENARIO XML with its OpenDRIVE: scenarios whose entities follow trajectories, and recordings that a player made.

mod entities;
mod expression;
mod kept;
mod lights;
mod motion;
mod parameters;
mod player_log;
mod position;
mod tracks;

use std::path::{Path, PathBuf};

use super::assembly::{About, Map, assemble};
use super::ids::Ids;
use super::opendrive;
use super::opendrive::tree::{self, Node};
use super::report::Report;
use super::{sizes, whole_file};
use crate::formats::address::Address;
use crate::formats::commonroad::builder::SourceLocation;
use crate::formats::commonroad::{ReadError, beginning};
use crate::formats::dispatch::{Format, Parts};
use crate::formats::openscenario::DOCUMENT;
use crate::scenario::plausibility::limits::refused_time_step;
use crate::scenario::{ContentHash, Scenario};
use crate::system;
use entities::{Entity, entities};
use motion::motions;
use tracks::{Timeline, followed, own_number, recorded};

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
        let bytes = system::read_file(file, system::LARGEST);
        let bytes = bytes.map_err(|e| ReadError::io(&shown, &e))?;
        let report = Report::about(shown.clone());
        if beginning(&bytes[..bytes.len().min(4096)]).contains("<OpenDRIVE") {
            return roads_alone(&bytes, file, report);
        }
        let root = tree::read(&bytes, &shown, "OpenSCENARIO")?;
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

/// The road file of a scenario.
fn road_file(root: &Node, file: &Path) -> Option<PathBuf> {
    let named = root.at(&["RoadNetwork", "LogicFile"])?.text("filepath")?;
    (!named.is_empty()).then(|| file.parent().unwrap_or(Path::new("")).join(named))
}

fn scenario(file: &Path, bytes: &[u8], root: Node, report: Report) -> Result<Scenario, ReadError> {
    let entities = entities(&root, file)?;
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
    let mut missing_roads = None;
    let network = match road_file(&root, file) {
        None => {
            report
                .at("")
                .warn("names no road file; the scenario has no lanes");
            None
        }
        Some(path) => match system::read_file(&path, system::LARGEST) {
            Ok(roads) => {
                let read = opendrive::read(&roads, &path.display().to_string(), &report, &mut ids)?;
                hashed.push(roads);
                Some(read)
            }
            Err(error) => {
                let why = format!("{}: {}", path.display(), system::words(&error));
                report
                    .at("")
                    .warn(format!("{why}; the scenario has no lanes"));
                missing_roads = Some(why);
                None
            }
        },
    };
    let header = root.child("FileHeader");
    let header_property = |name: &str| {
        let all = header?.child("Properties")?.all("Property");
        let mut found = all.filter(|p| p.text("name") == Some(name));
        found.next()?.text("value").map(str::to_string)
    };
    let dt = header_property("commonroad_time_step").and_then(|t| t.parse().ok());
    let dt = dt.filter(|dt| refused_time_step(*dt).is_none());
    let origin = header_property("commonroad_first_step").and_then(|s| s.parse().ok());
    let log = file.with_extension("csv");
    let motions = motions(&root, network.as_ref()).map_err(|mut error| {
        if let Some(why) = &missing_roads {
            error.message = format!("{} ({why})", error.message);
        }
        error
    });
    let document = header_property(DOCUMENT);
    let ego = ego(&entities, document.is_some());
    // What only a player works out, or what nothing tells: a recording beside it has that.
    let is_open = match &motions {
        Err(_) => true,
        Ok(all) => all
            .values()
            .any(|m| m.other.is_some() || m.is_free() || m.is_controlled),
    };
    let played = match is_open {
        true => system::read_file(&log, system::LARGEST).ok(),
        false => None,
    };
    let (dt, tracks) = match played {
        Some(read) => {
            let text = String::from_utf8_lossy(&read).into_owned();
            hashed.push(read);
            let shown = log.display().to_string();
            let seen = player_log::read(&text, &Report::about(shown.clone()))?;
            report.note(format!("motion as a player recorded it in {shown}"));
            recorded(&entities, seen, &mut ids)
        }
        None => {
            let motions = motions?;
            let acting = entities.iter().find_map(|e| {
                let motion = motions.get(&e.name)?;
                let is_ego = ego.is_some_and(|ego| ego.name == e.name);
                let drives_on = motion.is_free() && !is_ego;
                let on = || format!("begins at {} m/s and drives on by itself", motion.speed);
                let does = motion.other.clone();
                Some((e, does.or_else(|| drives_on.then(on))?))
            });
            if let Some((entity, does)) = acting {
                let element = format!("entity `{}`", entity.name);
                return Err(report.at(element).fail(format!(
                    "{does}, which only a player works out; put its recording beside it as {}: esmini --osc {} \
                     --headless --fixed_timestep 0.1 --csv_logger {}",
                    log.display(),
                    file.display(),
                    log.display()
                )));
            }
            let timeline = Timeline {
                dt: dt.unwrap_or(STEP),
                origin: origin.unwrap_or(0),
                end: motion::end(&root),
            };
            let own = followed(&entities, &motions, timeline, &report, &mut ids);
            (timeline.dt, own)
        }
    };
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
    if let Some(network) = network {
        (map, signs) = (network.map, network.kept);
        let clock = lights::Clock {
            dt,
            origin: origin.unwrap_or(0),
        };
        lights::phases(&root, clock, &network.lights, &mut map.lights)?;
    }
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
