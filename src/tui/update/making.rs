//! Generates a dangerous variant of the open scenario, and shows it beside the original.

mod described;
mod noted;
mod saved;
mod waiting;
mod writing;

pub use noted::{job, note};
use waiting::still_searching;
pub use waiting::{asks_again, opened};

use std::sync::Arc;

use super::super::action::Action;
use super::super::loaded::{
    GeneratedVariant, GenerationOutcome, GenerationProgress, Opened, VariantRequest, VariantShown,
    Writer,
};
use super::super::message::Effect;
use super::super::model::{
    Drives, JobId, JobKind, Model, OpenId, Search, Update, consequence_words, forecast_words,
    listed,
};
use super::super::tasks::making::{Generate, GenerationUpdate, SaveVariant};
use nearmiss_drive::generation::{AttackStyle, Consequence};
use nearmiss_scene::scenario::{ContentHash, ObstacleRole, Transform};

/// Shown while waiting for cancelled work to end.
const STOPPING: &str = "cancelling…";

/// Does what an action about variants says.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    match action {
        Action::Generate => return generate(model, None),
        Action::GenerateWith => return generate_with(model, false),
        Action::GenerateWish => described::ask(model),
        Action::ModelAttacks => return writing::begin(model, None),
        Action::ModelAttacksWith => return generate_with(model, true),
        Action::SwitchVariant => return switch(model),
        Action::SaveVariant => return save(model),
        _ => {}
    }
    Vec::new()
}

/// Lets the picked obstacle attack; a model writes its motion, or it is searched for.
fn generate_with(model: &mut Model, written: bool) -> Vec<Effect> {
    let Some(id) = model.picked else {
        let key = model.look.key(Action::NextObstacle);
        model.say(format!("pick the attacker first, with {key} or the mouse"));
        return Vec::new();
    };
    let opened = model.opened.as_deref();
    let picked = opened.and_then(|opened| opened.scenario.obstacle(id));
    if picked.is_some_and(|o| o.role != ObstacleRole::Dynamic) {
        model.say(format!(
            "{id} does not move, so it cannot attack; pick another obstacle"
        ));
        return Vec::new();
    }
    if written {
        writing::begin(model, Some(id))
    } else {
        generate(model, Some(id))
    }
}

/// Searches for a variant, once the scenario is open; or says how far that is; or shows the one that was made.
fn generate(model: &mut Model, only: Option<i64>) -> Vec<Effect> {
    if still_searching(model) {
        return Vec::new();
    }
    if let (None, Some(_), Some(place)) = (only, model.opening, model.list.opened) {
        model.maker.wanted = Some(place);
        model.tell("the scenario is still being read; the search for an attack starts then");
        return Vec::new();
    }
    let Some((hash, change)) = ready(model) else {
        return Vec::new();
    };
    // A variant against another planner is replaced.
    let attacked = model.driver.planner;
    let kept = model
        .maker
        .find(hash, change)
        .filter(|kept| kept.planner() == attacked);
    if model.variant().is_none() && only.is_none() && kept.is_some() {
        return show(model, true);
    }
    let seed = model.maker.next_seed(hash, only);
    let who = match (only, model.config.attackers) {
        (Some(id), _) => id.to_string(),
        (None, Some(2..)) => "one obstacle or several".into(),
        (None, _) => "any obstacle".into(),
    };
    let words = forecast_words(model.driver.forecast);
    let key = model.look.key(Action::Cancel);
    model.say(format!(
        "searching for an attack by {who}… ego planned {}with {words}, seed {seed}; {key} {key} cancels",
        planned_by(model)
    ));
    begin(model, change, only, seed)
}

/// The planner that is attacked, where it is a process.
fn planned_by(model: &Model) -> String {
    match model.driver.planner {
        0 => String::new(),
        _ => format!("by {} ", model.driver.planner_name()),
    }
}

/// What variants of the open scenario are kept under, where it can be made dangerous; else it is said why not.
fn ready(model: &mut Model) -> Option<(ContentHash, Option<Transform>)> {
    let of = model.made_of().filter(|_| model.list.opened.is_some());
    let why = if of.is_none() {
        Some("no scenario is open".into())
    } else if model.opening.is_some() {
        // Replies go when the scenario is open.
        model.tell("the scenario was still being read; press the key again");
        return None;
    } else {
        model.nothing_to_plan()
    };
    match why {
        Some(why) => {
            model.say(why);
            None
        }
        None => of,
    }
}

/// Begins a search for an attack.
fn begin(
    model: &mut Model,
    change: Option<Transform>,
    only: Option<i64>,
    seed: u64,
) -> Vec<Effect> {
    let Some((place, request)) = request(model, change, only, seed, None) else {
        return Vec::new();
    };
    let id = JobId(model.new_id());
    model.maker.begin(id, place);
    vec![Generate { id, request }.into()]
}

/// The work of making what is open dangerous, and its place in the list.
fn request(
    model: &Model,
    change: Option<Transform>,
    only: Option<i64>,
    seed: u64,
    writer: Option<Box<Writer>>,
) -> Option<(usize, Box<VariantRequest>)> {
    let place = model.list.opened?;
    let style = model.config.attack_style.as_deref();
    let request = VariantRequest {
        style: style.and_then(AttackStyle::parse).unwrap_or_default(),
        attackers: match only {
            Some(_) => 1,
            None => model.config.attackers.map_or(1, usize::from),
        },
        entry: model.list.rows[place].entry.clone(),
        change,
        forecast: model.driver.forecast,
        planner: model.driver.planner,
        only,
        wish: None,
        seed,
        writer,
        folder: model.config.pictures.clone(),
    };
    Some((place, Box::new(request)))
}

/// Stops what is under way.
pub fn cancel(model: &mut Model) -> Vec<Effect> {
    let effects = stop(model);
    if !effects.is_empty() {
        model.say(STOPPING);
    }
    effects
}

fn stop(model: &mut Model) -> Vec<Effect> {
    let Some(search) = model.maker.under_way.take() else {
        return Vec::new();
    };
    vec![Effect::Cancel(search.id)]
}

/// A search that was to stop has ended.
pub fn stopped(model: &mut Model) {
    let said = model.toasts.iter().any(|toast| toast.text == STOPPING);
    if said && !model.jobs.is_stopping(JobKind::Generate) {
        model.toasts.retain(|toast| toast.text != STOPPING);
        model.say("cancelled");
    }
}

/// Stops the search if another scenario is opened.
pub fn stop_left(model: &mut Model) -> Vec<Effect> {
    if model.variant().is_none() && model.plot.drives == Some(Drives::Risk) {
        model.plot.drives = None;
    }
    let leaves =
        |search: &Search| model.opened.is_none() || model.list.opened != Some(search.place);
    if model.maker.under_way.as_ref().is_some_and(leaves) {
        stop(model)
    } else {
        Vec::new()
    }
}

/// How far the search is that is under way, or what came of it.
pub fn on_update(model: &mut Model, update: GenerationUpdate) -> Vec<Effect> {
    match update {
        Update::Progress(GenerationProgress::Working(at)) => {
            if let Some(search) = &mut model.maker.under_way {
                search.at = Some(at);
                search.waits = None;
            }
            Vec::new()
        }
        Update::Progress(GenerationProgress::Model(progress)) => {
            writing::heard(model, &progress);
            Vec::new()
        }
        Update::Ended(result) => {
            model.maker.under_way = None;
            let mut effects = writing::recount(model);
            match result {
                Ok(GenerationOutcome::Found { original, variant }) => {
                    effects.extend(found(model, original, variant));
                }
                Ok(GenerationOutcome::Unwritten(words, wrote)) => {
                    writing::unwritten(model, words, wrote)
                }
                Ok(GenerationOutcome::Nothing(words)) => {
                    let key = model.look.key(Action::Generate);
                    model.announce(format!("{words}; {key} tries another seed"));
                }
                Err(why) => model.complain(format!("no variant was made: {why}")),
            }
            effects
        }
        Update::Cancelled => Vec::new(),
    }
}

fn found(model: &mut Model, original: Box<Opened>, variant: Box<Opened>) -> Vec<Effect> {
    if let Some(shown) = &variant.variant {
        let made = shown.made.clone();
        if let Some(wrote) = &made.authorship {
            writing::heard_out(model, made.original(), wrote);
        }
        model.maker.keep(original, variant, made);
    }
    let effects = show(model, true);
    let at = model.variant().map(|shown| moment(&shown.made));
    if let Some(step) = at {
        model.clock.go(step);
    }
    effects
}

/// The step that says most of a variant: of the contact, or else of the lowest risk.
fn moment(made: &GeneratedVariant) -> i64 {
    let effect = &made.effect;
    let lowest = effect.main().after.iter().min_by_key(|(_, score)| *score);
    let contact = effect.contact.map(|c| c.step);
    contact
        .or(lowest.map(|(step, _)| *step))
        .unwrap_or(effect.from)
}

/// Shows the kept variant of what is open, or its original.
fn show(model: &mut Model, changed: bool) -> Vec<Effect> {
    let kept = model
        .made_of()
        .and_then(|(hash, change)| model.maker.find(hash, change));
    let Some(kept) = kept else {
        let why = model.without_variant();
        model.say(why);
        return Vec::new();
    };
    let made = kept.made.clone();
    let mut opened = if changed {
        kept.variant.clone()
    } else {
        kept.original.clone()
    };
    opened.variant = Some(VariantShown {
        made: made.clone(),
        changed,
    });
    let again = model.variant().is_some();
    let (step, drives) = (model.clock.step(), model.plot.drives);
    let pinned = model.map.second.pinned.filter(|_| again);
    if let Some(planned) = &opened.planned {
        model.driver.forecast = planned.forecast;
        model.driver.planner = planned.planner;
    }
    let id = OpenId(model.new_id());
    model.opening = Some((id, None));
    let effects = super::opened(model, id, Ok(opened));
    model.picked = Some(made.effect.main().obstacle);
    model.clock.go(step);
    model.map.second.pinned = pinned;
    model.plot.drives = if again { drives } else { Some(Drives::Risk) };
    model.refresh();
    let words = in_words(model, &made, changed);
    model.tell(words);
    effects
}

/// Describes the shown variant, and the possible actions.
fn in_words(model: &Model, made: &GeneratedVariant, changed: bool) -> String {
    let switch = model.look.key(Action::SwitchVariant);
    if !changed {
        return format!("original, with the planned ego; {switch} shows the variant");
    }
    let dt = made.closed.driver().dt();
    let ids: Vec<i64> = made.effect.ids().collect();
    let given = match ids.len() {
        1 => "given a new motion",
        _ => "given new motions",
    };
    let what = match made.effect.consequence {
        Consequence::Collision(c) => {
            format!("collision with {} at {:.1} s", c.with, c.step as f64 * dt)
        }
        other => consequence_words(&other).to_string(),
    };
    format!(
        "variant: {} {given}, {what}; {switch} original, {} details, {} leaves it",
        listed(&ids),
        model.look.key(Action::VariantPanel),
        model.look.key(Action::RecordedEgo)
    )
}

fn switch(model: &mut Model) -> Vec<Effect> {
    if let Some(entry) = saved::original(model) {
        return saved::open(model, entry);
    }
    let changed = model.variant().is_some_and(|shown| shown.changed);
    show(model, !changed)
}

/// The variant, or the original beside it, gives its place back.
pub fn left(model: &mut Model) {
    let key = model.look.key(Action::Generate);
    model.say(format!(
        "back to the scenario; {key} shows the variant again"
    ));
}

/// Why nothing else can be planned in a variant.
pub fn fixed(model: &Model) -> String {
    let key = model.look.key(Action::RecordedEgo);
    format!("the variant belongs to this prediction; {key} leaves it")
}

/// Writes the variant.
fn save(model: &mut Model) -> Vec<Effect> {
    match model.variant() {
        Some(shown) => {
            let made: Arc<GeneratedVariant> = shown.made.clone();
            let folder = model.config.pictures.clone();
            vec![SaveVariant(made, folder).into()]
        }
        None => {
            let why = model.without_variant();
            model.say(format!("nothing to write: {why}"));
            Vec::new()
        }
    }
}

/// A variant was written, or not.
pub fn saved(model: &mut Model, made: &Arc<GeneratedVariant>, result: Result<String, String>) {
    match result {
        Ok(files) => {
            model.maker.saved(made, &files);
            model.say(format!("saved as {files}"));
        }
        Err(error) => model.complain(format!("the variant is not written: {error}")),
    }
}
