//! CommonRoad files in protobuf: the single message of 2020a, and the map, dynamic and scenario files of 2024.

mod format_2024;
mod header;
mod map;
#[rustfmt::skip]
mod messages;
mod obstacles;
mod report;
mod road;
mod shapes;
mod values;
pub(crate) mod wire;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use nearmiss_scene::scenario::plausibility::{self, ElementRef};
use nearmiss_scene::scenario::{Lanelet, ObstacleRole, Scenario};

use super::ReadError;
use super::builder::SourceLocation;
use super::encoding::{foreign, without_marks};
use super::xml_reader::{Unrecognised, beginning_of_file};
use crate::commonroad::builder::{Target, Targets};
use format_2024::Folder;
use report::{FieldPath, Report};
use wire::{FileHeader, MessageKind};

pub(super) use format_2024::{is_protobuf_name, scenario_name};

/// Larger files are not read, bytes.
const LARGEST_FILE: u64 = 128 << 20;

/// Whether a file is protobuf: its beginning is a message's, or it has the name of one and is no XML.
pub(super) fn is_meant(bytes: &[u8], file: &str) -> bool {
    FileHeader::detect(bytes).is_some() || !is_markup(bytes) && is_protobuf_name(Path::new(file))
}

/// Reads a scenario; `path` is where the other files of a scenario of 2024 are looked for.
pub(super) fn read(bytes: &[u8], file: &str, path: Option<&Path>) -> Result<Scenario, ReadError> {
    check_size(file, bytes.len() as u64)?;
    match FileHeader::detect(bytes) {
        Some(FileHeader {
            kind: MessageKind::Single,
            ..
        }) => road::read(bytes, file),
        Some(head) => format_2024::read(bytes, file, &head, path),
        None => Err(fail(file, &no_message(bytes))),
    }
}

/// The nature of bytes that do not begin as a message does.
fn no_message(bytes: &[u8]) -> String {
    let said = match foreign(bytes) {
        Some(what) => return format!("this is {what}"),
        None if bytes.is_empty() => "it is empty",
        None => {
            "not a CommonRoad protobuf message, or damaged at its beginning: field 1 must be the information of a scenario or map"
        }
    };
    said.to_string()
}

fn fail(file: &str, message: &str) -> ReadError {
    FieldPath::root(&Report::about(file), "").fail(message)
}

fn check_size(file: &str, size: u64) -> Result<(), ReadError> {
    if size <= LARGEST_FILE {
        return Ok(());
    }
    let (size, largest) = (size.div_ceil(1 << 20), LARGEST_FILE >> 20);
    let message = format!("{size} MiB; at most {largest} MiB are read");
    Err(fail(file, &message))
}

/// Those of the protobuf files in one folder that are scenarios, in the order given: not those that are part of another
/// one. And those that are nothing known, with why.
pub(super) fn scenarios(files: Vec<PathBuf>) -> (Vec<PathBuf>, Vec<(PathBuf, Unrecognised)>) {
    let Some(mut folder) = files.first().map(|file| Folder::around(file)) else {
        return Default::default();
    };
    let parts = files.iter().flat_map(|file| folder.parts_of(file));
    let parts: HashSet<PathBuf> = parts.flatten().collect();
    let whole = files.into_iter().filter(|file| !parts.contains(file));
    let (known, unknown): (Vec<_>, Vec<_>) = whole.partition(|file| folder.head(file).is_some());
    let unknown = unknown.into_iter().map(|file| {
        let why = why_unknown(&file);
        (file, why)
    });
    (known, unknown.collect())
}

/// Why a file is no message that is known.
fn why_unknown(file: &Path) -> Unrecognised {
    match beginning_of_file(file, 64) {
        Err(why) => why,
        Ok(bytes) => match foreign(&bytes) {
            Some(what) => Unrecognised::Foreign(what),
            None if is_markup(&bytes) => Unrecognised::Foreign("XML; its name should end in .xml"),
            None => Unrecognised::NoMessage,
        },
    }
}

/// Whether bytes begin as XML does.
fn is_markup(bytes: &[u8]) -> bool {
    without_marks(bytes).trim_ascii_start().starts_with(b"<")
}

/// The messages that hold road, traffic and planning problems; empty names where one message holds all.
struct Roots {
    pub road: &'static str,
    pub traffic: &'static str,
    pub planning: &'static str,
}

/// The single message of 2020a.
const ONE: Roots = Roots {
    road: "",
    traffic: "",
    planning: "",
};

/// The three messages of 2024.
const THREE: Roots = Roots {
    road: "map",
    traffic: "dynamic",
    planning: "scenario",
};

/// Notes references to nothing and what cannot be true of a scenario; the scenario with all that was noted of it.
fn finish(report: Report, roots: &Roots, mut scenario: Scenario) -> Scenario {
    check_references(&report, roots, &scenario);
    for finding in plausibility::check(&scenario) {
        let field = field(roots, finding.about, &scenario);
        let diagnostics = &report.diagnostics;
        diagnostics.push(finding.severity, || (0, field), finding.message);
    }
    scenario.diagnostics = report.into_diagnostics();
    scenario
}

fn field(roots: &Roots, about: ElementRef, scenario: &Scenario) -> String {
    let below = |root: &str, path: String| match (root, path.as_str()) {
        ("", _) => path,
        (_, "") => root.to_string(),
        _ => format!("{root}/{path}"),
    };
    let road = |path: String| below(roots.road, path);
    let planning = |path: String| below(roots.planning, path);
    match about {
        ElementRef::Scenario if roots.road.is_empty() => "information/time_step_size".into(),
        ElementRef::Scenario => String::new(),
        ElementRef::Location => road("location".into()),
        ElementRef::Lanelet(i) => road(format!("lanelets[{i}]")),
        ElementRef::Sign(i) => road(format!("traffic_signs[{i}]")),
        ElementRef::Light(i) => road(format!("traffic_lights[{i}]")),
        ElementRef::Intersection(i) => road(format!("intersections[{i}]")),
        ElementRef::Obstacle(i) => obstacle(roots, i, scenario),
        ElementRef::State { obstacle: i, state } => {
            let whole = obstacle(roots, i, scenario);
            match state.checked_sub(1) {
                None => format!("{whole}/initial_state"),
                Some(state) => format!("{whole}/trajectory_prediction/trajectory/states[{state}]"),
            }
        }
        ElementRef::Start(i) => planning(format!("planning_problems[{i}]/initial_state")),
        ElementRef::Goal { problem, goal } => {
            planning(format!("planning_problems[{problem}]/goal_states[{goal}]"))
        }
    }
}

/// The field of an obstacle: the lists of the message have one role each.
fn obstacle(roots: &Roots, place: usize, scenario: &Scenario) -> String {
    let Some(obstacle) = scenario.obstacles.get(place) else {
        return String::new();
    };
    let before = &scenario.obstacles[..place];
    let index = before.iter().filter(|o| o.role == obstacle.role).count();
    let (root, list) = match obstacle.role {
        ObstacleRole::Static => (roots.traffic, "static_obstacles"),
        ObstacleRole::Dynamic => (roots.traffic, "dynamic_obstacles"),
        ObstacleRole::Phantom => (roots.traffic, "phantom_obstacles"),
        ObstacleRole::Environment => (roots.road, "environment_obstacles"),
    };
    let separator = if root.is_empty() { "" } else { "/" };
    format!("{root}{separator}{list}[{index}]")
}

/// Warns of every reference to an element that is not there.
fn check_references(report: &Report, roots: &Roots, scenario: &Scenario) {
    let network = &scenario.network;
    let known = Targets::new(network);
    let road = FieldPath::root(report, roots.road);
    for (i, lanelet) in network.lanelets.iter().enumerate() {
        check_lanelet(&road.nth("lanelets", i), lanelet, &known);
    }
    for (i, intersection) in network.intersections.iter().enumerate() {
        let at = road.nth("intersections", i);
        for (j, road) in intersection.incomings.iter().enumerate() {
            let at = at.nth("incomings", j);
            for ids in [&road.lanelets, &road.right, &road.straight, &road.left] {
                warn_of_missing(&at, Target::Lanelet, ids, &known);
            }
            let left = road.is_left_of.as_slice();
            warn_of_missing(&at, Target::Incoming, left, &known);
        }
        warn_of_missing(&at, Target::Lanelet, &intersection.crossings, &known);
    }
    let planning = FieldPath::root(report, roots.planning);
    for (i, problem) in scenario.planning_problems.iter().enumerate() {
        let at = planning.nth("planning_problems", i);
        for (j, goal) in problem.goals.iter().enumerate() {
            let at = at.nth("goal_states", j);
            warn_of_missing(&at, Target::Lanelet, &goal.lanelets(), &known);
        }
    }
}

fn check_lanelet(at: &FieldPath<'_>, lanelet: &Lanelet, known: &Targets) {
    let beside = [&lanelet.adjacent_left, &lanelet.adjacent_right];
    let beside: Vec<i64> = beside.into_iter().flatten().map(|a| a.id).collect();
    for ids in [&lanelet.predecessors, &lanelet.successors, &beside] {
        warn_of_missing(at, Target::Lanelet, ids, known);
    }
    warn_of_missing(at, Target::Sign, &lanelet.signs, known);
    warn_of_missing(at, Target::Light, &lanelet.lights, known);
    if let Some(line) = &lanelet.stop_line {
        let at = at.field("stop_line");
        warn_of_missing(&at, Target::Sign, &line.signs, known);
        warn_of_missing(&at, Target::Light, &line.lights, known);
    }
}

fn warn_of_missing(at: &FieldPath<'_>, target: Target, ids: &[i64], known: &Targets) {
    let name = match target {
        Target::Lanelet => "lanelet",
        Target::Sign => "sign",
        Target::Light => "light",
        Target::Incoming => "incoming road",
    };
    for id in ids.iter().filter(|id| !known.has(target, **id)) {
        at.warn(format!("refers to missing {name} {id}"));
    }
}
