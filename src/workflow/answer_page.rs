//! Reads the texts, claims and pictures of answers, opening each scene once; counts claims that no program checked yet.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use nearmiss_ask::llm::Message;
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_render::{Figure, FigureOptions, MapExtent, PIXEL, Subject, svg};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Transform};
use nearmiss_scene::verdict::Task;
use nearmiss_store::{ClaimCounts, Origin, Outcome, Run, RunId, RunState, Store, StoreError};
use nearmiss_study::evaluation::claims::{self, TimeOrigin, shown_text};
use nearmiss_study::evaluation::{Answer, AnswerCase, AnswerPage, ShownClaim, tool_rounds};
use rayon::prelude::*;

use super::StoredQuestion;

/// Width and height of a picture, points.
const PICTURE: (f64, f64) = (600.0 * PIXEL, 360.0 * PIXEL);

/// Metres around the ego that a picture shows.
const SEEN: MapExtent = MapExtent::Ego { width: 100.0 };

/// A scene that answers are about: name, content, ego, and whether they are imported.
type SceneKey = (String, Option<String>, String, bool);

/// An answer about a scene, as far as its claims and its picture need it.
struct Told {
    place: usize,
    text: String,
    times: TimeOrigin,
    window: Option<(i64, i64)>,
    task: Task,
}

/// What a scene says of its answers: their claims by place, and pictures by row.
#[derive(Default)]
struct Seen {
    claims: Vec<(usize, Vec<ShownClaim>)>,
    pictures: BTreeMap<usize, String>,
}

/// The answers of a report with their questions, claims and pictures, as far as the store has them and one of `files` is
/// their scenario. `on_progress` hears how many of how many scenes are done.
///
/// # Errors
/// The store cannot be read.
pub fn answer_page(
    store: &Store,
    cases: &[AnswerCase<'_>],
    files: &[Entry],
    on_progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<AnswerPage, StoreError> {
    let mut page = AnswerPage::new(cases);
    let mut scenes: BTreeMap<SceneKey, Vec<Told>> = BTreeMap::new();
    for (place, case) in cases.iter().enumerate() {
        let Some(run) = load_run(store, case.scored.run)? else {
            continue;
        };
        let key = (
            run.question.scenario.clone(),
            run.question.scenario_hash.clone(),
            run.question.ego.clone(),
            run.origin == Origin::Recorded,
        );
        for hash in run.question.image_hashes() {
            let found = if page.knows_sent(&hash) {
                None
            } else {
                store.image(&hash)?
            };
            page.add_sent(place, &hash, found.as_ref());
        }
        let told = add(&mut page, place, run);
        scenes.entry(key).or_default().push(told);
    }
    let mut entries: HashMap<&str, Vec<&Entry>> = HashMap::new();
    for entry in files {
        entries.entry(entry.name.as_str()).or_default().push(entry);
    }
    let (done, of) = (AtomicUsize::new(0), scenes.len());
    let scenes: Vec<_> = scenes.into_iter().collect();
    let seen: Vec<Seen> = scenes
        .par_iter()
        .map(|(key, told)| {
            let seen = look(&page, key, told, &entries);
            on_progress(done.fetch_add(1, Ordering::Relaxed) + 1, of);
            seen
        })
        .collect();
    for seen in seen {
        for (place, claims) in seen.claims {
            if let Some(detail) = page.detail_mut(place) {
                detail.claims = Some(claims);
            }
        }
        for (row, picture) in &seen.pictures {
            page.set_picture(*row, picture);
        }
    }
    Ok(page)
}

fn load_run(store: &Store, run: Option<RunId>) -> Result<Option<Run>, StoreError> {
    run.map_or(Ok(None), |run| store.run_shown(run))
}

/// Adds the texts of a run to the page.
fn add(page: &mut AnswerPage, place: usize, run: Run) -> Told {
    let messages: Vec<Message> = serde_json::from_str(&run.question.messages).unwrap_or_default();
    for message in &messages {
        page.add_message(place, message.role.name(), &message.to_text());
    }
    let rounds = tool_rounds::stored(run.tool_rounds.as_deref());
    for (round, number) in rounds.iter().zip(1..) {
        let lines = tool_rounds::lines(round).join("\n");
        page.add_message(place, &format!("tools, round {number}"), &lines);
    }
    let text = shown_text(&run.reasoning, &run.answer, false);
    if !text.is_empty() {
        page.set_text(place, &text);
    }
    let (window, task) = (run.question.window, run.question.task);
    let answer = Answer::from(run);
    if let Some(detail) = page.detail_mut(place) {
        detail.model_returned = answer.model_returned;
        detail.finish = answer.finish;
    }
    Told {
        place,
        text,
        times: answer.times,
        window,
        task,
    }
}

/// What a scene says of its answers; nothing if no file holds it.
fn look(
    page: &AnswerPage,
    (scenario, hash, ego, imported): &SceneKey,
    told: &[Told],
    entries: &HashMap<&str, Vec<&Entry>>,
) -> Seen {
    let mut seen = Seen::default();
    let (name, transform) = Transform::of_name(scenario);
    let Some(first) = told.first() else {
        return seen;
    };
    let question = StoredQuestion {
        task: first.task,
        scenario,
        scenario_hash: hash.as_deref(),
        ego: (!imported).then_some(ego.as_str()),
        window: first.window,
    };
    let files = entries.get(name).into_iter().flatten();
    let scene = files
        .into_iter()
        .find_map(|entry| question.scene(entry, &EgoSelection::Beside));
    let Some(scene) = scene else {
        return seen;
    };
    let renumbered = matches!(transform, Some(Transform::Renumber(_)));
    for one in told {
        let subject = claims::Subject::new(&scene, one.times, one.window);
        let found = claims::sentences(&one.text, &subject);
        seen.claims
            .push((one.place, ShownClaim::all(&one.text, &found)));
        let Some((row, critical)) = page.question(one.place) else {
            continue;
        };
        // The ids of the truth are those before a renumbering.
        let critical = if renumbered { &[] } else { critical };
        let step = subject.present();
        (seen.pictures.entry(row)).or_insert_with(|| picture(&scene, scenario, critical, step));
    }
    seen
}

/// The map at the last step of a window, with the critical obstacles pointed out.
fn picture(scene: &Scene, name: &str, critical: &[i64], step: i64) -> String {
    let there = |id: &&i64| **id != scene.ego.id && scene.scenario.obstacle(**id).is_some();
    let look = FigureOptions {
        seen: SEEN,
        obstacles: critical.iter().filter(there).copied().collect(),
        size: (PICTURE.0, Some(PICTURE.1)),
        ..FigureOptions::default()
    };
    let figure = Figure::new(Subject::with_ego(scene), name, look, Thresholds::shipped());
    let steps = scene.steps();
    let step = step.clamp(steps.start, (steps.end - 1).max(steps.start));
    figure.map_or_else(|_| String::new(), |figure| svg(&figure.at(step)))
}

/// Whether the claims of an answer are still to be counted: it is whole, and this version's check did not see it.
#[must_use]
pub fn is_unchecked(outcome: &Outcome) -> bool {
    outcome.state == RunState::Answered
        && Task::VERDICTS.contains(&outcome.task)
        && outcome.claims.claims_check != Some(claims::CHECK)
}

/// Counts the claims of those of the answers that [`is_unchecked`], as far as one of the files is their scenario; each
/// scene is opened once, for all answers about it. `on_progress` hears how many of how many scenes are done.
///
/// # Errors
/// The store cannot be read.
pub fn count_claims(
    store: &Store,
    outcomes: &[Outcome],
    files: &[Entry],
    on_progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Vec<(RunId, ClaimCounts)>, StoreError> {
    let mut entries: HashMap<&str, Vec<&Entry>> = HashMap::new();
    for entry in files {
        entries.entry(entry.name.as_str()).or_default().push(entry);
    }
    let mut scenes: BTreeMap<_, Vec<&Outcome>> = BTreeMap::new();
    for one in outcomes.iter().filter(|one| is_unchecked(one)) {
        let name = Transform::of_name(&one.scenario).0;
        if entries.contains_key(name) {
            let scene = (
                &one.scenario,
                &one.scenario_hash,
                &one.ego,
                one.origin.name(),
            );
            scenes.entry(scene).or_default().push(one);
        }
    }
    let (done, of) = (AtomicUsize::new(0), scenes.len());
    let counted: Vec<_> = scenes
        .into_values()
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|asked| {
            let found = of_scene(store, &asked, &entries);
            on_progress(done.fetch_add(1, Ordering::Relaxed) + 1, of);
            found
        })
        .collect::<Result<_, _>>()?;
    Ok(counted.into_iter().flatten().collect())
}

/// The scenarios of all batches.
///
/// # Errors
/// The store cannot be read.
pub fn files_of_batches(store: &Store) -> Result<Vec<Entry>, StoreError> {
    let mut paths = BTreeSet::new();
    for (batch, _) in store.batches()? {
        for item in store.items(batch.id)? {
            paths.insert(item.asked.path);
        }
    }
    let paths = paths.iter().map(Path::new);
    Ok(paths.map(Entry::of_argument).collect())
}

/// The counts of answers about one scene; none if no file holds it.
fn of_scene(
    store: &Store,
    asked: &[&Outcome],
    entries: &HashMap<&str, Vec<&Entry>>,
) -> Result<Vec<(RunId, ClaimCounts)>, StoreError> {
    let Some(first) = asked.first() else {
        return Ok(Vec::new());
    };
    let question = StoredQuestion::from(*first);
    let files = entries.get(Transform::of_name(&first.scenario).0);
    let scene = files
        .into_iter()
        .flatten()
        .find_map(|entry| question.scene(entry, &EgoSelection::Beside));
    let Some(scene) = scene else {
        return Ok(Vec::new());
    };
    let mut found = Vec::new();
    for one in asked {
        if let Some(run) = store.run(one.run)? {
            let messages: Vec<Message> =
                serde_json::from_str(&run.question.messages).unwrap_or_default();
            found.push((one.run, Answer::from(run).claims(&scene, &messages)));
        }
    }
    Ok(found)
}
