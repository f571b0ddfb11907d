//! OpenSCENARIO XML with its OpenDRIVE: scenarios whose entities follow trajectories, and recordings that a player made.

mod entities;
mod lights;
mod motion;
mod player_log;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use super::assembly::{About, Map, RecordedTrack, TrackState, assemble};
use super::ids::Ids;
use super::opendrive;
use super::opendrive::tree::{self, Node};
use super::report::Report;
use super::{sizes, whole_file};
use crate::formats::address::Address;
use crate::formats::commonroad::ReadError;
use crate::formats::commonroad::builder::SourceLocation;
use crate::formats::dispatch::{Format, Parts};
use crate::geometry::Pose;
use crate::scenario::plausibility::limits::refused_time_step;
use crate::scenario::{ContentHash, Scenario};
use crate::system;
use entities::{Entity, entities};
use motion::{Motions, motions};
use player_log::Seen;

/// The format.
pub struct OpenScenario;

/// Seconds between two steps, where nothing tells them.
const STEP: f64 = 0.1;

/// Entities that are the ego by their names.
const EGOS: [&str; 4] = ["ego", "hero", "ego_vehicle", "host"];

/// Steps of a scenario at most.
const MOST_STEPS: i64 = 100_000;

impl Format for OpenScenario {
    fn recognises(&self, _: &Path, head: &[u8]) -> bool {
        let text = String::from_utf8_lossy(head);
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
        if String::from_utf8_lossy(&bytes[..bytes.len().min(4096)]).contains("<OpenDRIVE") {
            return roads_alone(&bytes, file, report);
        }
        let root = tree::read(&bytes, &shown, "OpenSCENARIO")?;
        scenario(file, &bytes, with_parameters(root)?, report)
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

/// The document with the values of its parameters in their places.
fn with_parameters(mut root: Node) -> Result<Node, ReadError> {
    let declared = root.within("ParameterDeclaration");
    let mut values: HashMap<String, String> = HashMap::new();
    for parameter in declared {
        let name = parameter
            .needed("name")?
            .trim_start_matches('$')
            .to_string();
        values.insert(
            name,
            parameter.text("value").unwrap_or_default().to_string(),
        );
    }
    if values.is_empty() {
        return Ok(root);
    }
    let mut open = vec![&mut root];
    while let Some(node) = open.pop() {
        for value in node.attributes_mut() {
            let found = value.strip_prefix('$').and_then(|name| values.get(name));
            if let Some(found) = found {
                *value = found.clone();
            }
        }
        open.extend(node.children.iter_mut());
    }
    Ok(root)
}

/// The road file of a scenario.
fn road_file(root: &Node, file: &Path) -> Option<PathBuf> {
    let named = root.at(&["RoadNetwork", "LogicFile"])?.text("filepath")?;
    (!named.is_empty()).then(|| file.parent().unwrap_or(Path::new("")).join(named))
}

fn scenario(file: &Path, bytes: &[u8], root: Node, report: Report) -> Result<Scenario, ReadError> {
    let entities = entities(&root, file)?;
    let numbers = entities.iter().filter_map(|e| e.name.parse::<i64>().ok());
    let ego_id = |e: &Entity| {
        e.property("commonroad_id")
            .and_then(|id| id.parse::<i64>().ok())
    };
    let mut ids = Ids::beyond(numbers.clone().chain(entities.iter().filter_map(ego_id)));
    numbers.filter(|id| *id > 0).for_each(|id| {
        ids.take(id);
    });
    let mut hashed = vec![bytes.to_vec()];
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
                let words = system::words(&error);
                report.at("").warn(format!(
                    "{}: {words}; the scenario has no lanes",
                    path.display()
                ));
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
    let log = file.with_extension("csv");
    let motions = motions(&root, network.as_ref())?;
    let acting = entities.iter().find_map(|e| {
        let motion = motions.get(&e.name)?;
        Some((e, motion.other.clone()?))
    });
    let ego = ego(&entities);
    let (dt, tracks) = match acting {
        None => {
            let dt = dt.unwrap_or(STEP);
            let own = followed(
                &entities,
                &motions,
                motion::end(&root),
                dt,
                &report,
                &mut ids,
            );
            (dt, own)
        }
        Some((entity, action)) => {
            let Ok(read) = system::read_file(&log, system::LARGEST) else {
                return Err(report.at(format!("entity `{}`", entity.name)).fail(format!(
                    "moves by <{action}>, which only a player works out; put its recording beside it as {}: \
                     esmini --osc {} --headless --fixed_timestep 0.1 --csv_logger {}",
                    log.display(),
                    file.display(),
                    log.display()
                )));
            };
            let text = String::from_utf8_lossy(&read).into_owned();
            hashed.push(read);
            let shown = log.display().to_string();
            let seen = player_log::read(&text, &Report::about(shown.clone()))?;
            report.note(format!("motion as a player recorded it in {shown}"));
            recorded(&entities, seen, &mut ids)
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
    if let Some(network) = network {
        map = network.map;
        lights::phases(&root, dt, &network.lights, &mut map.lights)?;
    }
    assemble(report, about, map, all)
}

/// The ego: by its name, else the first vehicle.
fn ego(entities: &[Entity]) -> Option<&Entity> {
    let named = |e: &&Entity| EGOS.contains(&e.name.to_lowercase().as_str());
    let first = || entities.iter().find(|e| e.is_vehicle);
    entities.iter().find(named).or_else(first)
}

fn id_of(entity: &Entity, ids: &mut Ids) -> i64 {
    match entity.name.parse::<i64>() {
        Ok(id) if id > 0 => id,
        _ => match entity.property("commonroad_id").map(str::parse) {
            Some(Ok(id)) => ids.keep(id),
            _ => ids.fresh(),
        },
    }
}

type Named = Vec<(String, RecordedTrack)>;

/// The tracks of entities that follow trajectories or stand.
fn followed(
    entities: &[Entity],
    motions: &HashMap<String, Motions>,
    end: Option<f64>,
    dt: f64,
    report: &Report,
    ids: &mut Ids,
) -> Named {
    let last = |m: &Motions| {
        let ends = m.followed.iter().filter_map(|f| f.vertices.last());
        ends.map(|(t, _)| *t).fold(0.0, f64::max)
    };
    let longest = motions.values().map(last).fold(0.0, f64::max);
    // The moment of the end may be a little before the last step, or none of ours at all.
    let until = end
        .filter(|e| *e > 0.0 && *e < 1e5)
        .map_or(longest, |e| e.max(longest));
    let steps = ((until / dt + 0.01).floor() as i64).clamp(0, MOST_STEPS);
    let mut all = Vec::new();
    for entity in entities {
        let Some(motion) = motions.get(&entity.name) else {
            report.note(format!(
                "entity `{}` has no position; left out",
                entity.name
            ));
            continue;
        };
        let free = motion.followed.is_empty() && motion.speed.abs() > 1e-3;
        if free {
            report.note(format!(
                "entity `{}` begins at {} m/s and follows nothing; left out",
                entity.name, motion.speed
            ));
            continue;
        }
        let mut poses: BTreeMap<i64, Pose> = BTreeMap::new();
        for step in 0..=steps {
            let time = step as f64 * dt;
            let on_way = motion.followed.iter().find_map(|f| f.at(time));
            let pose = match (on_way, motion.followed.is_empty()) {
                (Some(pose), _) => pose,
                (None, true) => match motion.start {
                    Some(start) if is_there(motion, time, dt) => start,
                    _ => continue,
                },
                (None, false) => continue,
            };
            poses.insert(step, pose);
        }
        let speeds = entity.numbers("commonroad_velocity");
        let accelerations = entity.numbers("commonroad_acceleration");
        let stands = motion.followed.is_empty();
        let whole = |all: &Option<Vec<f64>>, i: usize| match all {
            Some(all) if all.len() == poses.len() => all.get(i).copied(),
            // One that stands has one state for all times.
            Some(all) if stands && all.len() == 1 => all.first().copied(),
            _ => None,
        };
        let states = poses
            .iter()
            .enumerate()
            .map(|(i, (step, pose))| TrackState {
                step: *step,
                position: entity.middle(pose),
                heading: pose.heading,
                velocity: whole(&speeds, i).or(stands.then_some(0.0)),
                acceleration: whole(&accelerations, i),
            });
        let states: Vec<TrackState> = states.collect();
        let track = RecordedTrack {
            id: id_of(entity, ids),
            kind: entity.kind,
            length: entity.length,
            width: entity.width,
            states,
        };
        all.push((entity.name.clone(), track));
    }
    all
}

/// Whether an entity that stands is there at a moment.
fn is_there(motion: &Motions, time: f64, dt: f64) -> bool {
    // What is triggered at a moment is done in the step that begins there.
    let done = |moments: &[f64]| moments.iter().filter(|m| **m < time - dt / 2.0).count();
    let (came, went) = (done(&motion.appears), done(&motion.vanishes));
    match motion.is_late {
        true => came > went,
        false => came >= went,
    }
}

/// The tracks of a player's recording, and its time step.
fn recorded(entities: &[Entity], seen: BTreeMap<String, Vec<Seen>>, ids: &mut Ids) -> (f64, Named) {
    let mut times: Vec<f64> = seen.values().flatten().map(|s| s.time).collect();
    times.sort_by(f64::total_cmp);
    times.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    let between = times
        .windows(2)
        .map(|p| p[1] - p[0])
        .fold(f64::INFINITY, f64::min);
    let dt = match refused_time_step(between) {
        None => (between * 1e6).round() / 1e6,
        Some(_) => STEP,
    };
    let mut all = Vec::new();
    for (name, states) in seen {
        let entity = entities.iter().find(|e| e.name == name);
        let Some(first) = states.first() else {
            continue;
        };
        let (center, length, width) = first.body;
        let id = match entity {
            Some(entity) => id_of(entity, ids),
            None => ids.fresh(),
        };
        let kind = entity.map_or(crate::scenario::ObstacleType::Car, |e| e.kind);
        let mut states: Vec<TrackState> = states
            .iter()
            .map(|s| TrackState {
                step: (s.time / dt).round() as i64,
                position: s.pose.to_world(&center),
                heading: s.pose.heading,
                velocity: Some(s.speed),
                acceleration: None,
            })
            .collect();
        states.sort_by_key(|s| s.step);
        states.dedup_by_key(|s| s.step);
        let track = RecordedTrack {
            id,
            kind,
            length,
            width,
            states,
        };
        all.push((name, track));
    }
    (dt, all)
}
