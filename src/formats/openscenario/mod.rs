//! OpenSCENARIO XML: a scenario for simulators, with its road network as OpenDRIVE.

mod actor;
pub(super) mod entities;
mod environment;
mod storyboard;

use std::collections::BTreeMap;
use std::sync::Arc;

use super::commonroad::xml_writer::XmlWriter;
use super::commonroad::{WriteError, write};
use super::opendrive::{date, write_opendrive};
pub use actor::ExportedEgo;
pub(super) use actor::SINGLE_STATES;
use actor::{Actor, Notes, actors};
use nearmiss_scene::scenario::{Ego, LaneletNetwork, Scenario, Scene, driven_way};
use storyboard::Clock;

/// A scenario as it is exported.
#[derive(Debug, Clone, Copy)]
pub struct Export<'a> {
    /// The scenario.
    pub scenario: &'a Scenario,
    /// Its ego.
    pub ego: ExportedEgo<'a>,
    /// The name of the file with the roads, beside the scenario's.
    pub road_file: &'a str,
    /// More that is known of obstacles, by id: names and values.
    pub properties: &'a BTreeMap<i64, Vec<(String, String)>>,
    /// More that is known of the scenario: names and values.
    pub about: &'a [(String, String)],
}

/// The two files of an export.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// OpenSCENARIO XML 1.2, in UTF-8.
    pub scenario: Vec<u8>,
    /// OpenDRIVE 1.7, in UTF-8.
    pub roads: Vec<u8>,
    /// What the formats cannot say, or say differently, one sentence each.
    pub notes: Vec<String>,
    /// How far borders of lanes are at most from those of the lanelets, metres.
    pub deviation: f64,
}

/// Writes a scenario as OpenSCENARIO XML 1.2 with OpenDRIVE 1.7. The same scenario gives the same bytes.
///
/// Entities are called as their obstacles, the ego `ego`. The position of an entity is that of CommonRoad: the middle of
/// its body. Time 0 is time step 0, or the first one if that is earlier.
///
/// # Errors
/// None in practice: writing goes to memory.
pub fn write_openscenario(export: &Export<'_>) -> Result<Exported, WriteError> {
    let scenario = export.scenario;
    let mut notes = Notes::default();
    let mut all = actors(scenario, export.ego, &mut notes);
    for actor in &mut all {
        let id: Option<i64> = match actor.name.as_str() {
            "ego" => None,
            name => name.parse().ok(),
        };
        let more = id.and_then(|id| export.properties.get(&id));
        actor.properties.extend(more.into_iter().flatten().cloned());
    }
    let mut clock = clock(scenario, &all);
    if let ExportedEgo::Follows(ego) = export.ego
        && let Some(last) = contact_at_end(scenario, ego).filter(|last| *last < clock.last)
    {
        // Players report an error where an entity vanishes that touches another one.
        clock.last = last.max(clock.origin + 1);
        notes.ended = true;
    }
    let roads = write_opendrive(scenario)?;
    let mut sentences = roads.notes.clone();
    sentences.extend(notes.sentences());
    if clock.origin < 0 {
        sentences.push(format!("time 0 is step {}", clock.origin));
    }
    if matches!(export.ego, ExportedEgo::Missing) {
        sentences.push("no ego: none is recorded beside it".into());
    }
    if !scenario.planning_problems.is_empty() {
        sentences.push("goals of planning problems are properties".into());
    }
    Ok(Exported {
        scenario: bytes(export, &all, clock)?,
        roads: roads.bytes,
        notes: sentences,
        deviation: roads.deviation,
    })
}

/// The last step of an ego that touches an obstacle then, or on the way there.
fn contact_at_end(scenario: &Scenario, ego: &Ego) -> Option<i64> {
    let last = ego.track.steps().end - 1;
    let scene = Scene::new(Arc::new(scenario.clone()), ego.clone());
    let own = scene.ego_at(last)?;
    let touches = |p: nearmiss_scene::scenario::Participant<'_>| {
        let at_last = |other| own.distance(&other) <= CONTACT;
        let on_the_way = || {
            let (before, dt) = (last - 1, scenario.dt());
            let own = driven_way(scene.ego_at(before)?, own, dt)?;
            let other = driven_way(p.placed_at(before)?, p.placed_at(last)?, dt)?;
            own.first_touch(&other)
        };
        p.placed_at(last).is_some_and(at_last) || on_the_way().is_some()
    };
    scene.participants().any(touches).then_some(last)
}

/// Bodies as near as this may touch in a player, metres.
const CONTACT: f64 = 0.01;

fn clock(scenario: &Scenario, actors: &[Actor]) -> Clock {
    let moving = actors.iter().filter(|a| !a.stands && !a.is_free);
    let steps = moving.flat_map(|a| a.stretches.iter().flatten().map(|(step, _)| *step));
    let (first, last) = steps.fold((0, 0), |(low, high), s| (low.min(s), high.max(s)));
    // A free ego drives at least until its goal's time is over.
    let free = actors.iter().any(|a| a.is_free);
    let goals = scenario.planning_problems.iter().flat_map(|p| &p.goals);
    let goal = goals.map(|g| g.time.to).max().filter(|_| free && last == 0);
    Clock {
        dt: scenario.dt(),
        origin: first,
        last: goal
            .unwrap_or(last)
            .clamp(last, last + 10_000)
            .max(first + 1),
    }
}

fn bytes(export: &Export<'_>, actors: &[Actor], clock: Clock) -> Result<Vec<u8>, WriteError> {
    let scenario = export.scenario;
    let mut out = XmlWriter::begun()?;
    out.comment(" Written by nearmiss. Positions of entities are the middle of their bodies. ")?;
    let header = &scenario.header;
    let of = |name: &str| header.attributes.get(name).cloned().unwrap_or_default();
    let attributes = [
        ("revMajor", "1".into()),
        ("revMinor", "2".into()),
        ("date", date(scenario)),
        ("description", header.benchmark_id.clone()),
        ("author", of("author")),
    ];
    out.element("OpenSCENARIO", &[], |out| {
        out.element("FileHeader", &attributes, |out| {
            out.element("Properties", &[], |out| {
                let kept = (DOCUMENT.to_string(), document(scenario)?);
                let mut all = about(export, clock).into_iter().chain([kept]);
                all.try_for_each(|(name, value)| {
                    out.empty("Property", &[("name", name), ("value", value)])
                })
            })
        })?;
        out.empty("CatalogLocations", &[])?;
        out.element("RoadNetwork", &[], |out| {
            out.empty("LogicFile", &[("filepath", export.road_file.to_string())])?;
            environment::signals(out, scenario, clock)
        })?;
        out.element("Entities", &[], |out| {
            actors.iter().try_for_each(|a| entities::entity(out, a))
        })?;
        storyboard::storyboard(out, scenario, actors, clock)
    })?;
    Ok(out.finished())
}

/// The property with a CommonRoad document of what has no place elsewhere.
pub(super) const DOCUMENT: &str = "commonroad_document";

/// A CommonRoad document without lanelets and obstacles: planning problems, signs, lights, intersections, place and
/// authors.
fn document(scenario: &Scenario) -> Result<String, WriteError> {
    let roads = &scenario.network;
    let rest = Scenario {
        header: scenario.header.clone(),
        location: scenario.location.clone(),
        tags: scenario.tags.clone(),
        network: LaneletNetwork::new(
            Vec::new(),
            roads.signs.clone(),
            roads.lights.clone(),
            roads.intersections.clone(),
        ),
        obstacles: Vec::new(),
        planning_problems: scenario.planning_problems.clone(),
        recorded_ego: None,
        diagnostics: Vec::new(),
        hash: scenario.hash,
    };
    let text = String::from_utf8_lossy(&write(&rest)?).into_owned();
    // Lines and indents have no meaning in it.
    Ok(text.lines().map(str::trim).collect())
}

/// What is known of the scenario as a whole.
fn about(export: &Export<'_>, clock: Clock) -> Vec<(String, String)> {
    let scenario = export.scenario;
    let mut all = vec![
        (
            "commonroad_benchmark_id".to_string(),
            scenario.header.benchmark_id.clone(),
        ),
        (
            "commonroad_time_step".to_string(),
            scenario.dt().to_string(),
        ),
    ];
    if clock.origin != 0 {
        let first = clock.origin.to_string();
        all.push(("commonroad_first_step".to_string(), first));
    }
    for name in ["affiliation", "source"] {
        let value = scenario
            .header
            .attributes
            .get(name)
            .filter(|v| !v.is_empty());
        all.extend(value.map(|v| (format!("commonroad_{name}"), v.clone())));
    }
    if !scenario.tags.is_empty() {
        all.push(("commonroad_tags".to_string(), scenario.tags.join(" ")));
    }
    for problem in &scenario.planning_problems {
        for (i, goal) in problem.goals.iter().enumerate() {
            let positions = serde_json::to_string(&goal.positions).unwrap_or_default();
            all.push((
                format!("commonroad_goal_{}_{i}", problem.id),
                format!("steps {} to {}, {positions}", goal.time.from, goal.time.to),
            ));
        }
    }
    all.extend(export.about.iter().cloned());
    all
}
