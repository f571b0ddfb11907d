//! What this process answers: the scenarios by severity, what is in one, and the windows that fit terms.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Serialize;
use serde_json::Value;

use super::catalogue::{CURSOR, EGO, FILTER, NUMBER, SCENARIO};
use super::jobs::Progress;
use super::resources::page;
use super::scenes::{Ranked, Worst};
use super::{Server, TAKEN_BACK};
use crate::find::{FindDocument, search};
use crate::index::{measured, request};
use crate::many_files::ManyFiles;
use crate::parts::{Measured, write};
use crate::{Failure, output};
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::{Scene, in_short};
use nearmiss_workflow::tables::default_index_options;

/// Scenarios of one page.
const PAGE: usize = 25;

/// Moments of one scenario that are told.
const MOMENTS: usize = 20;

/// Windows that are found where nothing is said.
const FOUND: u64 = 10;

/// A page of the list.
#[derive(Serialize)]
struct Page {
    scenarios: Vec<Ranked>,
    /// How many there are on all pages.
    all: usize,
    /// For the next page.
    #[serde(skip_serializing_if = "Option::is_none")]
    cursor: Option<String>,
}

/// The scenarios, the most severe first.
pub fn list(server: &Server, arguments: &Value, progress: &Progress) -> Result<Value, String> {
    let entries = server.places.entries();
    let all = entries.len();
    let (range, cursor) = page(arguments[CURSOR.name].as_str(), PAGE, all)?;
    let mut ranked = Vec::with_capacity(all);
    for (place, entry) in entries.iter().enumerate() {
        if progress.is_cancelled() {
            return Err(TAKEN_BACK.into());
        }
        let worst = server.places.worst(entry, &server.thresholds);
        ranked.push(Ranked::new(server.places.name(entry), worst));
        progress.tell(place + 1, Some(all), "scenarios are measured");
    }
    Ranked::sort(&mut ranked);
    to_json(&Page {
        scenarios: ranked.drain(range).collect(),
        all,
        cursor,
    })
}

/// What is in a scenario.
#[derive(Serialize)]
struct Inspected {
    scenario: String,
    #[serde(flatten)]
    about: BTreeMap<&'static str, String>,
    /// Seconds.
    time_step: f64,
    /// The first and the last at which the ego is there, or without one anything.
    steps: [i64; 2],
    /// Who it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    ego: Option<String>,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    no_ego: Option<String>,
    /// The most severe ones, the most severe first.
    moments: Vec<Worst>,
    /// How many more there are.
    more_moments: usize,
    warnings: Vec<String>,
}

/// What is in a scenario, and its most severe moments.
pub fn inspect(server: &Server, arguments: &Value, _: &Progress) -> Result<Value, String> {
    let name = arguments[SCENARIO.name].as_str().unwrap_or_default();
    let entry = server.places.entry(name)?;
    let (scenario, scene) = server.places.scene(&entry, arguments[EGO.name].as_i64())?;
    let (scene, no_ego) = match &scene {
        Ok(scene) => (Some(&**scene), None),
        Err(why) => (None, Some(why.clone())),
    };
    let steps = scene.map_or_else(|| scenario.steps(), Scene::steps);
    let mut moments = Worst::all(&scenario, scene, &server.thresholds);
    let more_moments = moments.len().saturating_sub(MOMENTS);
    moments.truncate(MOMENTS);
    let doubts = scene
        .iter()
        .flat_map(|scene| in_short(&scene.ego.diagnostics));
    let warnings = in_short(&scenario.diagnostics).into_iter().chain(doubts);
    to_json(&Inspected {
        scenario: server.places.name(&entry),
        about: scenario.summary().into_iter().collect(),
        time_step: scenario.dt(),
        steps: [steps.start, steps.end - 1],
        ego: scene.map(|scene| format!("{}, {}", scene.ego.id, scene.ego.source)),
        no_ego,
        moments,
        more_moments,
        warnings: warnings.map(|(_, words)| words).collect(),
    })
}

/// What was found.
#[derive(Serialize)]
struct Found {
    #[serde(flatten)]
    document: FindDocument,
    /// Scenarios that are not searched: they cannot be opened.
    left_out: usize,
}

/// The windows that fit terms.
pub fn find(server: &Server, arguments: &Value, progress: &Progress) -> Result<Value, String> {
    let filter = arguments[FILTER.name].as_str().unwrap_or_default();
    let mut document = FindDocument::of(filter).map_err(message)?;
    let entries = server.places.entries();
    let mut index = server.index.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = match &mut *index {
        Some(folder) => folder,
        none => none.insert(tempfile::tempdir().map_err(|why| why.to_string())?),
    };
    let left_out = make(server, folder.path(), &entries, progress)?;
    let number = arguments[NUMBER.name].as_u64().unwrap_or(FOUND);
    let number = usize::try_from(number).unwrap_or(usize::MAX);
    let found = search(
        folder.path(),
        filter,
        number,
        &server.thresholds,
        &progress.cancel,
    );
    document.take(&found.map_err(message)?);
    let names = entries
        .iter()
        .map(|entry| (output::visible(&entry.display()), entry));
    let names: HashMap<String, &Entry> = names.collect();
    document.rename(|file| names.get(file).map(|entry| server.places.name(entry)));
    to_json(&Found { document, left_out })
}

/// Makes the index of what is served, anew where files have changed; how many scenarios it cannot have.
fn make(
    server: &Server,
    folder: &Path,
    entries: &[Entry],
    progress: &Progress,
) -> Result<usize, String> {
    let (options, thresholds) = (default_index_options(), &server.thresholds);
    let many = ManyFiles {
        resume: true,
        ..ManyFiles::default()
    };
    let done = AtomicUsize::new(0);
    let measure = |entry: &Entry| {
        let measured = server
            .places
            .within(|| measured(entry, &options, thresholds));
        let of = Some(entries.len());
        progress.tell(
            done.fetch_add(1, Ordering::Relaxed) + 1,
            of,
            "scenarios are measured",
        );
        measured.unwrap_or_else(|why| Measured {
            said: Vec::new(),
            rows: Err(Failure::input(why)),
            note: None,
        })
    };
    let request = request(folder, many, false, &options, thresholds).map_err(message)?;
    let made = write(request, entries, &progress.cancel, measure).map_err(message)?;
    if made.done.interrupted {
        Err(TAKEN_BACK.into())
    } else {
        Ok(made.failed.count)
    }
}

fn message(failure: Failure) -> String {
    failure.message
}

fn to_json(document: &impl Serialize) -> Result<Value, String> {
    serde_json::to_value(document).map_err(|why| why.to_string())
}
