//! OpenSCENARIO XML with its OpenDRIVE: scenarios whose entities follow trajectories, and recordings that a player made.

mod entities;
mod expression;
mod motion;
mod player;
mod storyboard;
mod tracks;
mod trajectory;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use nearmiss_base::system;
use nearmiss_scene::scenario::plausibility::refused_time_step;
use nearmiss_scene::scenario::{
    ContentHash, LaneletNetwork, LightPhase, PlanningProblem, Position, Scenario, SignalColor,
    TrafficLight,
};

use super::assembly::{self, About, Ids, Map, assemble};
use super::opendrive::Network;
use super::opendrive::tree::{self, Node};
use super::{Report, named_file, opendrive, whole_file};
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::{ReadError, beginning, read};
use crate::dispatch::{Address, Format};
use crate::opendrive::signals::{signal_keys, speed_limit};
use crate::openscenario::DOCUMENT;
use crate::recordings::opendrive::KeptSigns;
use entities::{Entity, entities, is_own_property};
pub use player::{LONGEST as LONGEST_PLAY, Player, play_with};
use tracks::{Played, Timeline, own_number};

/// The format.
pub struct OpenScenario;

/// The source of its scenarios.
const SOURCE: &str = "OpenSCENARIO";

/// Seconds between two steps, where nothing tells them.
const STEP: f64 = 0.1;

/// Entities that are the ego by their names.
pub const EGOS: [&str; 4] = ["ego", "hero", "ego_vehicle", "host"];

impl Format for OpenScenario {
    fn recognises(&self, _: &Path, head: &[u8]) -> bool {
        let text = beginning(head);
        text.contains("<OpenSCENARIO") || text.contains("<OpenDRIVE")
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
        scenario(file, &bytes, expression::filled(root)?, report)
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

/// The file of the roads that a document names.
fn road_file(root: &Node, file: &Path) -> Option<PathBuf> {
    let logic = root.at(&["RoadNetwork", "LogicFile"])?;
    let named = logic.text("filepath").filter(|n| !n.is_empty())?;
    Some(named_file(file, named))
}

/// The roads of a scenario; words where their file cannot be read.
fn roads(
    root: &Node,
    file: &Path,
    report: &Report,
    ids: &mut Ids,
    hashed: &mut Vec<Vec<u8>>,
) -> Result<Result<Network, String>, ReadError> {
    let Some(path) = road_file(root, file) else {
        return Ok(Err(NO_ROADS.into()));
    };
    let shown = path.display().to_string();
    match system::read_file(&path, system::LARGEST) {
        Ok(roads) => {
            let read = opendrive::read(&roads, &shown, report, ids)?;
            hashed.push(roads);
            Ok(Ok(read))
        }
        Err(error) => Ok(Err(format!("{shown}: {}", system::error_text(&error)))),
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
        is_export: document.is_some(),
        timeline: Timeline {
            dt: dt.unwrap_or(STEP),
            origin: origin.unwrap_or(0),
            end: storyboard::end(&root),
        },
    };
    let motion = played.motion(&roads, &report, &mut ids, &mut hashed)?;
    let assumed = entities.iter().filter(|e| e.assumed).map(|e| e.kind);
    let assumed: Vec<_> = assumed.collect();
    report.note_count(assumed.len(), |n| {
        let words = assembly::in_words(assumed);
        format!("entities without a size: {n}; assumed by kind: {words}")
    });
    let mut named = Vec::new();
    let mut own = None;
    let mut all = Vec::new();
    for (name, track) in motion.tracks {
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
        source: SOURCE,
        benchmark_id: header_property("commonroad_benchmark_id")
            .unwrap_or_else(|| "ZAM_OpenScenario-1_1_T-1".into()),
        time_step_size: motion.time_step,
        tags: tags.split_whitespace().map(str::to_string).collect(),
        ego: own,
        hash: ContentHash::of_parts(parts),
    };
    let mut map = Map::default();
    let mut signs = None;
    if let Ok(network) = roads {
        (map, signs) = (network.map, network.kept);
        let clock = Clock {
            dt: motion.time_step,
            origin: origin.unwrap_or(0),
        };
        phases(&root, clock, &network.lights, &mut map.lights)?;
    }
    account(&root, &report);
    let mut scenario = assemble(report, about, map, all)?;
    if let Some(player) = motion.player {
        let source = format!("{SOURCE}, played by {player}");
        scenario.header.attributes.insert("source".into(), source);
    }
    if let Some(document) = document {
        restore(&mut scenario, &document, signs);
    }
    Ok(scenario)
}

/// The ego: by its name, else the first vehicle; exports whose ego has no name have none.
fn ego(entities: &[Entity], is_export: bool) -> Option<&Entity> {
    let named = |e: &&Entity| EGOS.contains(&e.name.to_lowercase().as_str());
    let first = || entities.iter().find(|e| e.is_vehicle && !is_export);
    entities.iter().find(named).or_else(first)
}

/// Puts what was kept into a scenario. `signs` are there where its lanelets are those of the export; what names lanelets
/// holds only then.
///
/// A document that cannot be read tells nothing: the scenario stays as it is.
fn restore(scenario: &mut Scenario, document: &str, signs: Option<KeptSigns>) {
    let Ok(kept) = read(document.as_bytes(), "") else {
        return;
    };
    scenario.location = kept.location;
    for (name, value) in kept.header.attributes {
        scenario.header.attributes.insert(name, value);
    }
    let holds = |p: &PlanningProblem| signs.is_some() || !names_lanelets(p);
    if !kept.planning_problems.is_empty() && kept.planning_problems.iter().all(holds) {
        scenario.planning_problems = kept.planning_problems;
    }
    let Some(signs) = signs else {
        return;
    };
    let roads = std::mem::take(&mut scenario.network);
    scenario.network = match with_signs(&roads, &kept.network, signs) {
        Some(network) => network,
        None => LaneletNetwork::new(
            roads.lanelets,
            roads.signs,
            roads.lights,
            kept.network.intersections,
        ),
    };
}

/// The roads with signs and lights as they were before the export; `None` where the files tell others now.
fn with_signs(
    roads: &LaneletNetwork,
    kept: &LaneletNetwork,
    mut signs: KeptSigns,
) -> Option<LaneletNetwork> {
    let mut lanelets = roads.lanelets.clone();
    let mut limits = HashMap::new();
    for lanelet in &mut lanelets {
        let of = signs.lanelets.remove(&lanelet.id)?;
        [lanelet.signs, lanelet.lights] = of.own;
        if let Some(line) = &mut lanelet.stop_line {
            [line.signs, line.lights] = of.stop_line;
        }
        limits.insert(lanelet.id, of.limit);
    }
    let network = LaneletNetwork::new(
        lanelets,
        kept.signs.clone(),
        kept.lights.clone(),
        kept.intersections.clone(),
    );
    let same_limit = |id: i64, own: Option<f64>| match (limits.get(&id).copied().flatten(), own) {
        (Some(a), Some(b)) => (a - b).abs() < SAME_SPEED,
        (a, b) => a.is_none() && b.is_none(),
    };
    let mut all = network.lanelets.iter();
    let is_unchanged = signal_keys(&network) == signs.signals
        && all.all(|l| same_limit(l.id, speed_limit(&network, l)))
        && shows_the_same(&roads.lights, &network.lights);
    is_unchanged.then_some(network)
}

/// Speeds that differ by less are the same, m/s: files are rounded.
const SAME_SPEED: f64 = 1e-3;

/// Whether the lights that were read show at each step what those with the same ids show.
fn shows_the_same(read: &[TrafficLight], kept: &[TrafficLight]) -> bool {
    read.iter().all(|light| {
        let before = kept.iter().find(|k| k.id == light.id);
        before.is_some_and(|before| {
            let whole: i64 = before
                .cycle
                .iter()
                .map(|p| p.duration.clamp(0, LONGEST_CYCLE))
                .sum();
            (0..=whole.min(LONGEST_CYCLE)).all(|step| light.color_at(step) == before.color_at(step))
        })
    })
}

/// No longer cycle is compared to its end, steps.
const LONGEST_CYCLE: i64 = 10_000;

fn names_lanelets(problem: &PlanningProblem) -> bool {
    let mut goals = problem.goals.iter().flat_map(|g| &g.positions);
    goals.any(|p| matches!(p, Position::Lanelets(_)))
}

/// No phase is longer, steps.
const LONGEST_PHASE: f64 = 1e6;

/// When controllers begin.
#[derive(Clone, Copy)]
struct Clock {
    /// Seconds between two steps.
    pub dt: f64,
    /// The step of time 0.
    pub origin: i64,
}

/// Sets the phases of lights whose signals (by their ids) a controller switches.
fn phases(
    root: &Node,
    clock: Clock,
    ids: &HashMap<String, i64>,
    lights: &mut [TrafficLight],
) -> Result<(), ReadError> {
    let Some(signals) = root.at(&["RoadNetwork", "TrafficSignals"]) else {
        return Ok(());
    };
    for controller in signals.all("TrafficSignalController") {
        let mut cycles: HashMap<i64, Vec<LightPhase>> = HashMap::new();
        for phase in controller.all("Phase") {
            let steps = (phase.needed_number("duration")? / clock.dt).round();
            if !(0.0..=LONGEST_PHASE).contains(&steps) {
                return Err(phase.fail(format!("a phase of {steps} steps")));
            }
            for state in phase.all("TrafficSignalState") {
                let Some(id) = ids.get(state.needed("trafficSignalId")?) else {
                    continue;
                };
                cycles.entry(*id).or_default().push(LightPhase {
                    duration: steps as i64,
                    color: color(state.text("state").unwrap_or_default()),
                });
            }
        }
        for light in lights.iter_mut() {
            if let Some(cycle) = cycles.remove(&light.id) {
                light.active = cycle.iter().any(|p| p.color != SignalColor::Inactive);
                light.cycle = cycle;
                light.offset = clock.origin;
            }
        }
    }
    Ok(())
}

/// The colour of a state: lamps from the top, or a word.
fn color(state: &str) -> SignalColor {
    let lamps: Vec<bool> = state.split(';').map(|lamp| lamp.trim() == "on").collect();
    match (&lamps[..], state) {
        ([true, true, false], _) => SignalColor::RedYellow,
        ([true, false, false], _) | (_, "red") => SignalColor::Red,
        ([false, true, false], _) | (_, "yellow") => SignalColor::Yellow,
        ([false, false, true], _) | (_, "green") => SignalColor::Green,
        _ => SignalColor::Inactive,
    }
}
