//! Exports a scenario: selects its ego, gathers what is known of it, writes OpenSCENARIO and OpenDRIVE for simulators.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde_json::Value;

use super::{OpenRequest, PlanRequest, StandIn, open, prepare};
use nearmiss_base::system;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::{
    EgoSelection, Entry, Export, Exported, ExportedEgo, VariedMotion, write_openscenario,
};
use nearmiss_scene::scenario::{
    Ego, EgoSource, PlanningProblem, Sample, Scenario, Track, VehicleType,
};

/// What the ego does in the simulator.
#[derive(Debug, Clone, PartialEq)]
pub enum SimulatedEgo {
    /// It follows a motion that exists.
    Follows(EgoSelection),
    /// It follows the plan of the built-in planner.
    Planned,
    /// It stands at its start with its speed, for a driver under test.
    Free,
}

/// What is exported.
#[derive(Debug, Clone, Copy)]
pub struct ExportRequest<'a> {
    /// Where the scenario is from.
    pub entry: &'a Entry,
    /// It, or the part of it that is exported.
    pub scenario: &'a Scenario,
    /// The ego in it.
    pub ego: Option<&'a Ego>,
    /// Whether the ego only begins there, for a driver under test.
    pub is_free: bool,
    /// The name of the file with the roads.
    pub road_file: &'a str,
    /// An obstacle whose motion follows from parameters.
    pub varied: Option<&'a VariedMotion>,
}

/// A scenario, and its ego where it has one.
type WithEgo = (Arc<Scenario>, Option<Ego>);

/// A scenario with its ego, where it has one, as it is written for other programs; nothing where `cancel` asked for an end.
///
/// # Errors
/// The scenario cannot be read, or has no such ego, or nothing can be planned: in words that begin with the file.
pub fn scene_to_export(
    entry: &Entry,
    ego: &SimulatedEgo,
    settings: &Settings,
    cancel: &Cancel,
) -> Result<Option<WithEgo>, String> {
    let named = |error: String| named(entry, error);
    let selection = match ego {
        SimulatedEgo::Follows(selection) => selection,
        _ => &EgoSelection::Beside,
    };
    let opening = OpenRequest {
        entry,
        ego: selection,
        transform: None,
        strict: matches!(ego, SimulatedEgo::Follows(_)),
        stand_in: StandIn::None,
    };
    let opened = open(&opening).map_err(|e| named(e.to_string()))?;
    let (scenario, recorded) = match opened.scene {
        Ok(scene) => (Arc::clone(&scene.scenario), Some(scene.ego.clone())),
        Err(_) => (opened.scenario, None),
    };
    match ego {
        SimulatedEgo::Planned => {
            let plan = PlanRequest {
                open: opening,
                problem: None,
                settings,
            };
            let prepared = prepare(&plan).map_err(|e| named(e.to_string()))?;
            let outcome = prepared.only_best().run(cancel, &mut |_| {});
            let Some(outcome) = outcome.map_err(|e| named(e.to_string()))? else {
                return Ok(None);
            };
            let prepared = &outcome.prepared;
            let ego = outcome.drive.ego(prepared.problem(), &prepared.settings);
            Ok(Some((prepared.driven(&outcome.drive), Some(ego))))
        }
        SimulatedEgo::Free if recorded.is_none() => {
            let problem = scenario.planning_problems.first();
            let start = problem.and_then(|p| at_start(p, &scenario, entry));
            let start = start.ok_or_else(|| {
                named("no ego recorded beside it and no planning problem, so the free ego has no start".into())
            })?;
            Ok(Some((scenario, Some(start))))
        }
        SimulatedEgo::Free | SimulatedEgo::Follows(_) => Ok(Some((scenario, recorded))),
    }
}

/// An error that begins with the file.
fn named(entry: &Entry, error: String) -> String {
    if error.starts_with(&entry.display()) {
        error
    } else {
        format!("{}: {error}", entry.display())
    }
}

/// The files of a scenario for simulators.
///
/// # Errors
/// It cannot be written: in words that begin with the file.
pub fn export_to_simulator(request: &ExportRequest<'_>) -> Result<Exported, String> {
    let entry = request.entry;
    let exported = match request.ego {
        None => ExportedEgo::Missing,
        Some(ego) if request.is_free => ExportedEgo::Free(ego),
        Some(ego) => ExportedEgo::Follows(ego),
    };
    let (properties, about) = variant(entry);
    let export = Export {
        scenario: request.scenario,
        ego: exported,
        road_file: request.road_file,
        properties: &properties,
        about: &about,
        varied: request.varied,
    };
    write_openscenario(&export).map_err(|e| named(entry, e.to_string()))
}

/// An ego at the start of a planning problem, of usual size.
fn at_start(problem: &PlanningProblem, scenario: &Scenario, entry: &Entry) -> Option<Ego> {
    let initial = &problem.initial;
    let sample = Sample {
        step: initial.time.from,
        position: initial.middle()?,
        heading: initial.orientation.map(|q| q.middle()),
        velocity: initial.velocity.map(|q| q.middle()),
        acceleration: initial.acceleration.map(|q| q.middle()),
    };
    Some(Ego {
        id: problem.id,
        source: EgoSource::Recording(entry.display()),
        footprint: VehicleType::Bmw320i.footprint(),
        track: Track::new(vec![sample], scenario.dt(), None),
        recorded: Vec::new(),
        diagnostics: Vec::new(),
    })
}

type Named = Vec<(String, String)>;

/// What the document beside a variant tells of its attackers, by id, and of itself.
fn variant(entry: &Entry) -> (BTreeMap<i64, Named>, Named) {
    let document = || -> Option<Value> {
        let path = entry.file()?.with_extension("json");
        let bytes = system::read_file(&path, system::LARGEST).ok()?;
        let document: Value = serde_json::from_slice(&bytes).ok()?;
        let same = document["variant"].as_str() == entry.file()?.file_name()?.to_str();
        same.then_some(document)
    };
    let Some(document) = document() else {
        return Default::default();
    };
    let text = |value: &Value| match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let mut properties: BTreeMap<i64, Named> = BTreeMap::new();
    for attacker in document["attackers"].as_array().into_iter().flatten() {
        let Some(id) = attacker["id"].as_i64() else {
            continue;
        };
        let known = [
            "manoeuvre",
            "from_step",
            "until_step",
            "min_distance",
            "outcome_without",
        ];
        let mut all = vec![("attacker".to_string(), "true".to_string())];
        let told = known.iter().filter(|name| !attacker[**name].is_null());
        all.extend(told.map(|name| (format!("attacker_{name}"), text(&attacker[*name]))));
        properties.insert(id, all);
    }
    let known = [
        "by",
        "outcome",
        "hit_from_behind",
        "min_distance",
        "program",
    ];
    let told = known.iter().filter(|name| !document[**name].is_null());
    let mut about: Named = told
        .map(|name| (format!("variant_{name}"), text(&document[*name])))
        .collect();
    let original = &document["original"]["benchmark_id"];
    if !original.is_null() {
        about.push(("variant_of".to_string(), text(original)));
    }
    (properties, about)
}
