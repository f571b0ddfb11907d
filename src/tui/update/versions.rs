//! Compares two versions of a prompt over many scenarios, and asks for the answers that are missing.

use std::sync::Arc;

use super::super::action::Action;
use super::super::message::runs::{ComparedVersions, VersionSide};
use super::super::message::{Effect, JobId, JobRequest, Update};
use super::super::model::{JobKind, JobState, Model, PromptVersion, ShownAnswer, VersionKind};
use super::super::screens::versions::VersionsScreen;
use super::batch::{batch_of, propose_batch};
use super::{compare, editing, reopen};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_store::Run;

/// Opens the screen on the draft and the version that it is to replace.
pub fn open(model: &mut Model) -> Vec<Effect> {
    if let Some(why) = unfit(model) {
        model.say(why);
        return Vec::new();
    }
    if editing::show_error(model) {
        return Vec::new();
    }
    model.screens.open(VersionsScreen);
    let all = model.prompt_versions();
    let keep = model.versions.sides.as_ref().filter(|sides| {
        let has = |all: &[PromptVersion], one: &PromptVersion| all.contains(one);
        // A draft goes on changing: its last version takes the place of an older one.
        let drafted = all.first().filter(|one| one.kind == VersionKind::Draft);
        sides.iter().all(|side| has(&all, side)) && drafted.is_none_or(|d| has(&sides[..], d))
    });
    if keep.is_none() {
        model.versions.sides = usual(&all);
    }
    look(model)
}

/// Why prompts cannot be compared as things stand.
fn unfit(model: &Model) -> Option<String> {
    let key = |action| model.look.key(action);
    if model.model == judge::MODEL {
        let key = key(Action::ChooseModel);
        return Some(format!(
            "the built-in judge reads no prompt: {key} chooses a model first"
        ));
    }
    if !Task::VERDICTS.contains(&model.task) || model.frame.is_of_one_obstacle() {
        let (task, frame) = (key(Action::ToggleTask), key(Action::ToggleFrame));
        return Some(format!(
            "prompts are compared for {} only: {task} switches the task, {frame} the frame",
            Task::names(&Task::VERDICTS)
        ));
    }
    if model.prompt.file().is_empty() {
        return Some("open a scenario with an ego first".into());
    }
    if model.marks.chosen(&model.list).is_empty() {
        return Some("no scenarios listed".into());
    }
    None
}

/// The newest version last, the one it replaces first; nothing where there is one version alone.
fn usual(all: &[PromptVersion]) -> Option<[PromptVersion; 2]> {
    let (new, others) = all.split_first()?;
    let of_file = others.iter().find(|one| one.file == new.file);
    let shipped = || others.iter().find(|one| one.kind == VersionKind::Shipped);
    let old = of_file.or_else(shipped).or_else(|| others.first())?;
    Some([old.clone(), new.clone()])
}

/// Looks up the answers to both versions.
pub fn look(model: &mut Model) -> Vec<Effect> {
    let entries = model.marks.chosen(&model.list);
    let versions = &model.versions;
    let mut effects: Vec<Effect> = versions.job.map(Effect::Cancel).into_iter().collect();
    // With one version alone the store is read all the same: it may know of more.
    let all = model.prompt_versions();
    let sides = versions.sides.clone();
    let Some([a, b]) = sides.or_else(|| all.first().map(|one| [one.clone(), one.clone()])) else {
        return effects;
    };
    let of = format!(
        "{:?}",
        (
            &a,
            &b,
            &model.model,
            model.techniques,
            &entries,
            model.decided()
        )
    );
    let side = |version: &PromptVersion| VersionSide {
        batch: Arc::new(batch_of(model, entries.clone(), model.draft_of(version))),
        hash: matches!(version.kind, VersionKind::Stored(_)).then(|| version.hash.clone()),
    };
    let sides = Arc::new([side(&a), side(&b)]);
    let id = JobId(model.new_id());
    model.versions.job = Some(id);
    model.versions.looked = (0, 2 * entries.len());
    model.versions.error = None;
    if model.versions.of != of {
        // What is shown is of other versions or scenarios.
        model.versions.of = of;
        model.versions.found = None;
        model.versions.selected = 0;
    }
    effects.push(Effect::Start(id, JobRequest::Versions(sides)));
    effects
}

/// Takes what was found.
pub fn found(model: &mut Model, update: Update<usize, Box<ComparedVersions>>) -> Vec<Effect> {
    match update {
        Update::Progress(done) => model.versions.looked.0 = done,
        Update::Ended(Ok(found)) => {
            model.versions.job = None;
            model.versions.asked = found.asked;
            model.versions.found = Some(found.comparison);
            let last = model.versions.answers().len().saturating_sub(1);
            model.versions.selected = model.versions.selected.min(last);
            if model.versions.sides.is_none() {
                // The store knows of another version.
                model.versions.sides = usual(&model.prompt_versions());
                if model.versions.sides.is_some() {
                    return look(model);
                }
            }
        }
        Update::Ended(Err(why)) => {
            model.versions.job = None;
            model.versions.error = Some(why);
        }
        Update::Cancelled => model.versions.job = None,
    }
    Vec::new()
}

/// Does an action of the screen that changes more than the screen.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    if !model.screens.is_top::<VersionsScreen>() {
        return open(model);
    }
    match action {
        Action::ChangeVersion => look(model),
        Action::AskVersions => ask(model),
        Action::OpenVersions => side_by_side(model),
        _ => Vec::new(),
    }
}

/// Proposes to ask for the answers that are missing, one version after the other: the cost is shown before anything is
/// sent.
fn ask(model: &mut Model) -> Vec<Effect> {
    let Some(found) = &model.versions.found else {
        model.say("still looking up the stored answers");
        return Vec::new();
    };
    let askable = |side: &usize| {
        let sides = model.versions.sides.as_ref();
        let stored = sides.is_some_and(|s| matches!(s[*side].kind, VersionKind::Stored(_)));
        !stored && !found.missing(*side).is_empty()
    };
    let queue: Vec<usize> = [0, 1].into_iter().filter(askable).collect();
    if queue.is_empty() {
        model.say("nothing to ask: every answer that can be asked for is stored");
        return Vec::new();
    }
    model.versions.queue = queue;
    propose_next(model)
}

fn propose_next(model: &mut Model) -> Vec<Effect> {
    if model.versions.queue.is_empty() {
        return Vec::new();
    }
    let side = model.versions.queue.remove(0);
    let (Some(sides), Some(found)) = (&model.versions.sides, &model.versions.found) else {
        return Vec::new();
    };
    let version = sides[side].clone();
    let entries = found.missing(side);
    let batch = batch_of(model, entries, model.draft_of(&version));
    let effects = propose_batch(model, batch);
    model.versions.proposed = model.card.as_ref().map(|card| card.id);
    let letter = ['A', 'B'][side];
    model.say(format!("missing answers to {letter}, {}", version.name()));
    effects
}

/// Goes on once a proposed batch was accepted or declined, and looks up the answers again once all was asked.
pub fn follow(model: &mut Model) -> Vec<Effect> {
    if let Some(id) = model.versions.proposed
        && model.card.as_ref().is_none_or(|card| card.id != id)
    {
        model.versions.proposed = None;
        let begun = model.jobs.all.iter().any(|job| job.id == id);
        if begun {
            model.versions.asking.push(id);
            return propose_next(model);
        }
        model.versions.queue.clear();
    }
    let before = model.versions.asking.len();
    let jobs = &model.jobs.all;
    let runs = |id: &JobId| {
        let mut batches = jobs.iter().filter(|job| job.kind == JobKind::Batch);
        batches.any(|job| job.id == *id && (job.is_running() || job.state == JobState::Stopping))
    };
    model.versions.asking.retain(runs);
    if model.versions.asking.len() < before && model.versions.sides.is_some() {
        return look(model);
    }
    Vec::new()
}

/// Reads both answers about the selected scenario.
fn side_by_side(model: &mut Model) -> Vec<Effect> {
    let Some(row) = model.versions.answers().get(model.versions.selected) else {
        return Vec::new();
    };
    let [Some(a), Some(b)] = [row.answers[0].run, row.answers[1].run] else {
        let key = model.look.key(Action::AskVersions);
        model.say(format!("an answer is missing: {key} asks for it"));
        return Vec::new();
    };
    let id = JobId(model.new_id());
    model.versions.pair = Some(id);
    vec![Effect::Start(id, JobRequest::Pair([a, b]))]
}

/// Both answers were read: their scenario is opened.
pub fn read(model: &mut Model, update: Update<(), Vec<Run>>) -> Vec<Effect> {
    model.versions.pair = None;
    match update {
        Update::Ended(Ok(runs)) => match <[Run; 2]>::try_from(runs) {
            Ok(runs) => {
                let second = runs[1].clone();
                if model.files_of(&second.question.scenario).is_empty() {
                    model.say(format!("{} is not in the list", second.question.scenario));
                    return Vec::new();
                }
                model.screens.close::<VersionsScreen>();
                model.versions.beside = Some(runs);
                reopen::begin(model, second)
            }
            Err(_) => {
                model.say("an answer was deleted from the store");
                Vec::new()
            }
        },
        Update::Ended(Err(why)) => {
            model.complain(why);
            Vec::new()
        }
        Update::Progress(()) | Update::Cancelled => Vec::new(),
    }
}

/// The scenario is open and its earlier answers are there: the two stand side by side.
pub fn arrived(model: &mut Model) {
    let open = model.opened.as_ref().map(|o| o.scenario.hash.to_string());
    let same = |runs: &mut [Run; 2]| runs[1].question.scenario_hash == open;
    let Some(runs) = model.versions.beside.take_if(same) else {
        return;
    };
    let ids = runs.each_ref().map(|run| run.id);
    for run in runs {
        reopen::put(model, run.into());
    }
    let columns = &model.answers.columns;
    let shown: Vec<ShownAnswer> = ids
        .iter()
        .filter_map(|id| {
            let is_it =
                |c: &super::super::model::Column| c.answer().and_then(|a| a.run) == Some(*id);
            columns.iter().position(is_it).map(ShownAnswer::Column)
        })
        .collect();
    if shown.len() == 2 {
        compare::open_on(model, shown);
    }
}
