//! Generates a dangerous variant of the open scenario, and shows it beside the original.

pub mod panel;
pub mod request;
pub mod state;
pub mod writing;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use nearmiss_drive::generation::{Consequence, Wish};
use nearmiss_formats::{Entry, EntryLocation};
use nearmiss_scene::description::visible;
use nearmiss_scene::scenario::{ContentHash, ObstacleRole, Transform};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Line;
use ratatui::widgets::{Paragraph, Wrap};

use crate::action::Action;
use crate::features::{Screen, Step};
use crate::keymap::{Code, Key, edit_line, first_line};
use crate::loaded::{
    GeneratedVariant, GenerationOutcome, GenerationProgress, GenerationStage, Opened,
    VariantRequest, VariantShown, Writer,
};
use crate::message::Effect;
use crate::model::{
    Drives, Job, JobId, JobKind, JobState, Model, OpenId, Search, Update, consequence_words,
    listed, working_words,
};
use crate::update::opening;
use crate::widgets::hints::{self, Hint};
use crate::widgets::window;
use crate::widgets::words::fit_end;
use request::{Generate, GenerationUpdate, SaveVariant};

/// Shown while waiting for cancelled work to end.
const STOPPING: &str = "cancelling…";

/// Does what an action about variants says.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    match action {
        Action::Generate => return generate(model, None),
        Action::GenerateWith => return generate_with(model, false),
        Action::GenerateWish => ask(model),
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
        model.generation.wanted = Some(place);
        model.tell("the scenario is still being read; the search for an attack starts then");
        return Vec::new();
    }
    let Some((hash, change)) = ready(model) else {
        return Vec::new();
    };
    // A variant against another planner is replaced.
    let attacked = model.driver.planner;
    let kept = model
        .generation
        .find(hash, change)
        .filter(|kept| kept.planner() == attacked);
    if model.variant().is_none() && only.is_none() && kept.is_some() {
        return show(model, true);
    }
    let seed = model.generation.next_seed(hash, only);
    let who = match (only, model.config.attackers) {
        (Some(id), _) => id.to_string(),
        (None, Some(2..)) => "one obstacle or several".into(),
        (None, _) => "any obstacle".into(),
    };
    let against = against(model);
    model.say(format!(
        "searching for an attack by {who}{against}, seed {seed}"
    ));
    begin(model, change, only, seed)
}

/// The planner that is attacked, where it is a process.
fn against(model: &Model) -> String {
    match model.driver.planner {
        0 => String::new(),
        _ => format!(" against {}", model.driver.planner_name()),
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
    let Some((place, request)) = variant_request(model, change, only, seed, None) else {
        return Vec::new();
    };
    let id = JobId(model.new_id());
    model.generation.begin(id, place);
    vec![Generate { id, request }.into()]
}

/// The work of making what is open dangerous, and its place in the list.
fn variant_request(
    model: &Model,
    change: Option<Transform>,
    only: Option<i64>,
    seed: u64,
    writer: Option<Box<Writer>>,
) -> Option<(usize, Box<VariantRequest>)> {
    let place = model.list.opened?;
    let request = VariantRequest {
        style: model.config.attack_style.unwrap_or_default(),
        attackers: match only {
            Some(_) => 1,
            None => model.config.attackers.unwrap_or(1),
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
    let Some(search) = model.generation.under_way.take() else {
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
    if model.generation.under_way.as_ref().is_some_and(leaves) {
        stop(model)
    } else {
        Vec::new()
    }
}

/// How far the search is that is under way, or what came of it.
pub fn on_update(model: &mut Model, update: GenerationUpdate) -> Vec<Effect> {
    match update {
        Update::Progress(GenerationProgress::Working(at)) => {
            if let Some(search) = &mut model.generation.under_way {
                search.at = Some(at);
                search.waits = None;
            }
            Vec::new()
        }
        Update::Progress(GenerationProgress::Model(progress)) => {
            writing::on_progress(model, &progress);
            Vec::new()
        }
        Update::Ended(result) => {
            let search = model.generation.under_way.take();
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
                Err(why) => {
                    let is_open = search.is_some_and(|s| model.list.opened == Some(s.place));
                    let words = state::failed_words(&why);
                    if let Some(of) = model.made_of().filter(|_| is_open) {
                        model.generation.keep_fruitless(of, Err(why));
                    }
                    model.complain(words);
                }
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
            writing::note_asked(model, made.original(), wrote);
        }
        model.generation.keep(original, variant, made);
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
        .and_then(|(hash, change)| model.generation.find(hash, change));
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
    let effects = crate::update::opened(model, id, Ok(opened));
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
    let what = match made.effect.consequence {
        Consequence::Collision(c) => {
            let with = match &ids[..] {
                [one] if *one == c.with => String::new(),
                _ => format!(" with {}", c.with),
            };
            format!("collision{with} at {:.1} s", c.step as f64 * dt)
        }
        other => consequence_words(&other).to_string(),
    };
    format!(
        "variant: {}, {what}; {} details, {switch} original",
        listed(&ids),
        model.look.key(Action::VariantPanel)
    )
}

fn switch(model: &mut Model) -> Vec<Effect> {
    if let Some(entry) = original(model) {
        return open_original(model, entry);
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

/// Asks for the terms that describe an attack.
fn ask(model: &mut Model) {
    if still_searching(model) {
        return;
    }
    let Some((hash, change)) = ready(model) else {
        return;
    };
    // The seed is chosen when the search begins: a line that is closed uses none up.
    if let Some((place, request)) = variant_request(model, change, None, 0, None) {
        open_wish(model, place, hash, request);
    }
}

/// Whether something is made already; then it is said.
fn still_searching(model: &mut Model) -> bool {
    let Some(search) = &model.generation.under_way else {
        return false;
    };
    let words = working_words(search.at, true);
    model.say(words);
    true
}

/// Whether Esc is to be pressed again before what is made ends, as minutes of work end with it; the footer says so.
pub fn asks_again(model: &mut Model) -> bool {
    if model.generation.under_way.is_none() || model.stop_within > 0.0 {
        return false;
    }
    model.stop_within = AGAIN;
    true
}

/// Seconds within which Esc has to be pressed again.
const AGAIN: f64 = 4.0;

/// A scenario was opened: the search starts that was asked for meanwhile.
pub fn opened(model: &mut Model) -> Vec<Effect> {
    match model.generation.wanted.take() {
        Some(place) if model.list.opened == Some(place) => generate(model, None),
        _ => Vec::new(),
    }
}

/// A job for the list of tasks.
pub fn job(id: JobId, request: &VariantRequest, now: Duration) -> Job {
    let name = &request.entry.name;
    match &request.writer {
        Some(writer) => writing::job(id, name, &writer.model, writer.method.samples, now),
        None => {
            let title = format!("{name} made dangerous, seed {}", request.seed);
            Job::new(id, JobKind::Generate, title, 1, now)
        }
    }
}

/// Notes in the list of tasks how far it is.
pub fn note(job: &mut Job, update: &GenerationUpdate, now: Duration) {
    let stopping = job.state == JobState::Stopping;
    let result = match update {
        Update::Progress(GenerationProgress::Working(GenerationStage::Searching(progress, of))) => {
            (job.done, job.of) = (progress.tried.min(*of), *of);
            return;
        }
        Update::Progress(GenerationProgress::Working(_)) if stopping => return,
        Update::Progress(GenerationProgress::Working(_)) => return job.state = JobState::Running,
        Update::Progress(GenerationProgress::Model(progress)) => {
            return writing::note(job, progress);
        }
        // Results of a stopped search are dropped.
        Update::Ended(result) if !stopping => result,
        Update::Ended(_) | Update::Cancelled => {
            return job.end(JobState::Cancelled(String::new()), now);
        }
    };
    let state = match result {
        Ok(GenerationOutcome::Unwritten(words, wrote)) if wrote.failed() => {
            JobState::Failed(words.clone())
        }
        Ok(GenerationOutcome::Unwritten(words, _) | GenerationOutcome::Nothing(words)) => {
            JobState::Done(words.clone())
        }
        Ok(GenerationOutcome::Found { variant, .. }) => {
            let shown = variant.variant.as_ref();
            let effect = shown.map(|shown| &shown.made.effect);
            JobState::Done(effect.map_or(String::new(), |effect| {
                let what = consequence_words(&effect.consequence);
                let ids: Vec<i64> = effect.ids().collect();
                match ids.len() {
                    1 => format!("{what}, attacker {}", listed(&ids)),
                    _ => format!("{what}, attackers {}", listed(&ids)),
                }
            }))
        }
        Err(why) => JobState::Failed(why.clone()),
    };
    job.end(state, now);
}

/// The original of the saved variant that is open, unless something was made of this in turn.
fn original(model: &Model) -> Option<Entry> {
    let (hash, change) = model.made_of()?;
    let none = model.variant().is_none() && model.generation.find(hash, change).is_none();
    let saved = model.opened.as_ref()?.saved.as_ref().filter(|_| none)?;
    let (entry, _) = saved.original.as_ref().ok()?;
    Some(entry.clone())
}

/// Opens the original of a saved variant, which joins the list where it is not there yet.
fn open_original(model: &mut Model, entry: Entry) -> Vec<Effect> {
    let name = entry.name.clone();
    let mut rows = model.list.rows.iter();
    let listed = rows.position(|row| same_place(&row.entry.place, &entry.place));
    let place = listed.unwrap_or_else(|| model.list.append(entry));
    let effects = opening::open(model, place, None);
    model.list.show(place);
    let back = model.look.key(Action::PlaceBack);
    model.tell(format!(
        "the original {name}; {back} goes back to the variant"
    ));
    effects
}

/// Whether two scenarios are the same file, whether or not its path begins with `./`.
fn same_place(a: &EntryLocation, b: &EntryLocation) -> bool {
    let parts = |path: &Path| -> Vec<_> {
        let parts = path.components().map(|part| part.as_os_str().to_owned());
        parts.filter(|part| part != ".").collect()
    };
    match (a, b) {
        (EntryLocation::File(a), EntryLocation::File(b)) => parts(a) == parts(b),
        (a, b) => a == b,
    }
}

/// The terms, and the search that waits for them.
#[derive(Debug)]
pub struct WishScreen {
    typed: String,
    /// The search; taken when it begins.
    request: Option<Box<VariantRequest>>,
    /// The scenario's place in the list.
    place: usize,
    /// The scenario's hash.
    hash: ContentHash,
}

/// Opens the line for a search in the scenario at a place of the list.
pub fn open_wish(model: &mut Model, place: usize, hash: ContentHash, request: Box<VariantRequest>) {
    model.screens.open(WishScreen {
        typed: String::new(),
        request: Some(request),
        place,
        hash,
    });
}

impl Screen for WishScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        Some(match key.code {
            Code::Esc => Step::close(),
            Code::Enter => self.begin(model),
            _ => {
                edit_line(&mut self.typed, key);
                Step::stay()
            }
        })
    }

    fn paste(&mut self, _model: &mut Model, text: &str) -> Vec<Effect> {
        self.typed.push_str(&first_line(text));
        Vec::new()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let title = "search for an attack that terms describe";
        let inner = window::window(frame, screen, model, title, (76, 10));
        let width = usize::from(inner.width);
        let (accent, dim) = (
            Style::new().fg(model.theme.accent),
            Style::new().fg(model.theme.dim),
        );
        // The end is where one types.
        let line = format!("> {}▏", fit_end(&self.typed, width.saturating_sub(4)));
        let mut lines = vec![Line::styled(line, accent), Line::default()];
        if let Some(why) = self
            .typed
            .parse::<Wish>()
            .err()
            .filter(|_| !self.typed.is_empty())
        {
            let style = Style::new().fg(model.theme.warning);
            lines.push(Line::styled(visible(&why).into_owned(), style));
            lines.push(Line::default());
        }
        let hint = "who, which manoeuvre, from where: actor:car,truck manoeuvre:cut-in place:left-lane; actor:bicycle place:hidden severe";
        lines.push(Line::styled(hint, dim));
        frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: true }), inner);
    }

    fn hints(&self, _model: &Model) -> Vec<Hint> {
        hints::fixed(&[("type", "terms"), ("Enter", "search"), ("Esc", "cancel")])
    }
}

impl WishScreen {
    fn begin(&mut self, model: &mut Model) -> Step {
        let wish = match self.typed.parse::<Wish>() {
            Ok(wish) => wish,
            Err(why) => {
                model.say(visible(&why).into_owned());
                return Step::stay();
            }
        };
        let Some(mut request) = self.request.take() else {
            return Step::close();
        };
        let id = JobId(model.new_id());
        model.say(format!("searching for an attack: {wish}…"));
        request.wish = Some(wish);
        request.seed = model.generation.next_seed(self.hash, None);
        model.generation.begin(id, self.place);
        Step::Close(vec![Generate { id, request }.into()])
    }
}
