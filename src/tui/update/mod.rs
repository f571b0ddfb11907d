//! `update`: what a message changes, and what has to be done because of it. No input, no output, no clock.

mod actions;
mod answers;
mod batch;
mod claims;
mod clock;
mod compare;
mod editing;
mod history;
mod jobs;
mod keys;
mod list;
mod look;
mod map;
mod overlays;
mod picture;
mod plot;
mod pointer;
mod rating;
mod reopen;
mod source;
mod task;
mod timeline;
mod values;

pub use actions::perform;

use super::action::Action;
use super::keymap::{Code, Key};
use super::loaded::Opened;
use super::message::{Effect, Msg, OpenId};
use super::model::{Model, Notice, Shown};
use crate::evaluation::Answer;
use crate::geometry::Bounds;
use crate::tui::model::Column;

/// What has to be done when the program starts.
#[must_use]
pub fn start(model: &Model) -> Vec<Effect> {
    vec![
        Effect::Find(model.paths.clone()),
        Effect::ReadTags,
        Effect::Probe,
    ]
}

/// Takes one message.
pub fn update(model: &mut Model, msg: Msg) -> Vec<Effect> {
    jobs::hear(model, &msg);
    let mut effects = take(model, msg);
    compare::follow(model);
    claims::follow(model);
    effects.extend(values::follow(model));
    map::follow(model);
    jobs::follow(model, &effects);
    effects
}

fn take(model: &mut Model, msg: Msg) -> Vec<Effect> {
    match msg {
        Msg::Key(key) => on_key(model, key),
        Msg::Paste(text) => editing::paste(model, &text),
        Msg::Mouse(mouse) => pointer::on_mouse(model, mouse),
        Msg::Resize(columns, rows) => {
            model.size = (columns, rows);
            Vec::new()
        }
        Msg::Passed(elapsed) => passed(model, elapsed),
        Msg::Found(found) => list::found(model, found),
        Msg::Listed(entries) => list::listed(model, entries),
        Msg::Searched(ended) => list::searched(model, ended),
        Msg::Tags(tags) => {
            list::tags(model, tags);
            Vec::new()
        }
        Msg::Drawing => list::drawing(model),
        Msg::Discovered(found) => {
            answers::offer(model, found);
            Vec::new()
        }
        Msg::Surveyed(place, facts) => {
            model.list.survey(place, facts);
            Vec::new()
        }
        Msg::Ranked(measure, place, value) => {
            plot::ranked(model, measure, place, value);
            Vec::new()
        }
        Msg::Opened(id, result) => opened(model, id, result),
        Msg::Measured(id, found) => {
            values::measured(model, id, found);
            Vec::new()
        }
        Msg::Thresholds(read) => values::thresholds(model, read),
        Msg::Asked(ask, event) => answers::arrived(model, ask, event),
        Msg::Answered(ask, result) => {
            let name = list::name_of(model, ask);
            let mut effects = answers::answered(model, ask, result);
            effects.extend(name.map_or_else(Vec::new, |name| list::recount(model, &name)));
            effects
        }
        Msg::Stored(of, stored) => {
            if actions::stored_of(model).as_ref() == Some(&of) {
                let reopened = reopen::before_stored(model);
                show_stored(model, stored);
                if let Some(column) = reopened {
                    reopen::after_stored(model, column);
                }
                timeline::arrived(model);
            }
            Vec::new()
        }
        Msg::History(news) => history::heard(model, news),
        Msg::Batch(news) => batch::heard(model, news),
        Msg::Rated(result) => {
            rating::kept(model, result);
            Vec::new()
        }
        Msg::Ratings(result) => {
            rating::read(model, result);
            Vec::new()
        }
        Msg::Saved(file, result) => editing::saved(model, &file, result),
        Msg::Reread(library) => {
            editing::reread(model, library);
            Vec::new()
        }
        Msg::Reloaded(what) => {
            look::reloaded(model, what);
            Vec::new()
        }
        Msg::EditedOutside(sent, result) => {
            editing::edited_outside(model, sent, result);
            Vec::new()
        }
        Msg::Source(place, read) => {
            source::read(model, place, read);
            Vec::new()
        }
        Msg::Pictured(saved) => {
            picture::saved(model, saved);
            Vec::new()
        }
        Msg::Complaint(text) => {
            model.complain(text);
            Vec::new()
        }
        Msg::Terminate => actions::quit(model),
    }
}

fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    // Errors stay until somebody was there to read them, replies until the next question.
    model.toasts.retain(|t| t.kind == Notice::News);
    if key
        == (Key {
            ctrl: true,
            ..Key::plain(Code::Char('c'))
        })
    {
        if keys::give_up(model) {
            return Vec::new();
        }
        return actions::interrupt(model);
    }
    if !model.overlays.is_empty() {
        return overlays::on_key(model, key);
    }
    if model.compare.open {
        return compare::on_key(model, key);
    }
    if model.prompt.editing {
        return editing::on_key(model, key);
    }
    if model.list.filtering {
        return filter_key(model, key);
    }
    keys::on_key(model, key)
}

fn filter_key(model: &mut Model, key: Key) -> Vec<Effect> {
    let mut filter = model.list.filter.clone();
    match (key.code, key.writes()) {
        (Code::Esc, _) => {
            model.list.filtering = false;
            filter.clear();
        }
        (Code::Enter | Code::Tab, _) => model.list.filtering = false,
        (Code::Backspace, _) => {
            filter.pop();
        }
        (Code::Up, _) => return actions::perform(model, Action::Up),
        (Code::Down, _) => return actions::perform(model, Action::Down),
        (_, Some(c)) => filter.push(c),
        _ => return Vec::new(),
    }
    if filter == model.list.filter {
        return Vec::new();
    }
    model.list.set_filter(filter);
    open_current(model)
}

fn passed(model: &mut Model, elapsed: std::time::Duration) -> Vec<Effect> {
    let seconds = elapsed.as_secs_f64();
    for toast in &mut model.toasts {
        toast.left -= seconds;
    }
    model.toasts.retain(|t| t.left > 0.0);
    answers::pass(model, seconds);
    if model.clock.pass(elapsed) {
        clock::stepped(model);
    }
    editing::pass(model, seconds)
}

/// Opens the selected scenario, if another one is open.
pub(super) fn open_current(model: &mut Model) -> Vec<Effect> {
    match model.list.current() {
        Some(place) if model.list.opened != Some(place) => open(model, place, None),
        _ => Vec::new(),
    }
}

/// Opens a scenario of the list.
pub(super) fn open(model: &mut Model, place: usize, ego: Option<i64>) -> Vec<Effect> {
    let id = OpenId(model.new_id());
    model.opening = Some((id, ego));
    model.list.opened = Some(place);
    let entry = model.list.rows[place].entry.clone();
    vec![Effect::Open(id, entry, ego)]
}

fn opened(model: &mut Model, id: OpenId, result: Result<Box<Opened>, String>) -> Vec<Effect> {
    let Some((_, ego)) = model.opening.filter(|(opening, _)| *opening == id) else {
        return Vec::new();
    };
    model.opening = None;
    timeline::opened(model, id);
    let opened = match result {
        Ok(opened) => opened,
        Err(message) if ego.is_some() && model.opened.is_some() => {
            // What is open stays.
            model.complain(message);
            return Vec::new();
        }
        Err(message) => {
            leave(model);
            model.opened = None;
            model.open_error = Some(message);
            model.refresh();
            return Vec::new();
        }
    };
    let again = model
        .opened
        .as_ref()
        .filter(|o| o.scenario.hash == opened.scenario.hash);
    let step = again.map(|_| model.clock.step());
    let kept = again.map(|before| Kept::of(model, before, &opened));
    leave(model);
    model.open_error = None;
    if kept.is_none() {
        model.toasts.retain(|t| t.kind != Notice::Reply);
    }
    let clock = super::clock::Clock::new(opened.steps(), opened.scenario.dt());
    model.clock = clock.like(&model.clock);
    if let Some(step) = step {
        model.clock.go(step);
    }
    let same_ego = kept.as_ref().is_some_and(|kept| kept.same_ego);
    if !same_ego {
        frame_map(model, &opened);
    }
    let riskiest = opened.headline.as_ref().and_then(|h| h.risk);
    model.picked = riskiest.map(|n| n.obstacle);
    if let Some(kept) = kept {
        if kept.same_ego {
            model.picked = kept.picked;
        }
        let ego = opened.scene.as_ref().map(|s| s.ego.id);
        model.plot.marked = kept.marked;
        model.plot.marked.retain(|&id| Some(id) != ego);
    }
    model.taken = ego;
    if let (Some(id), false) = (ego, same_ego) {
        let back = model.look.key(Action::RecordedEgo);
        model.say(format!("{id} is the ego now; {back} goes back"));
    }
    model.opened = Some(opened);
    if step.is_none() {
        clock::to_window(model);
    }
    plot::refresh(model);
    model.refresh();
    reopen::opened(model, id);
    actions::load_stored(model).into_iter().collect()
}

/// What stays when the scenario that is open is opened again.
struct Kept {
    /// Whether its ego is the same too, as when thresholds are read again.
    same_ego: bool,
    picked: Option<i64>,
    marked: Vec<i64>,
}

impl Kept {
    fn of(model: &Model, before: &Opened, now: &Opened) -> Self {
        let ego = |opened: &Opened| opened.scene.as_ref().map(|s| s.ego.to_string());
        Self {
            same_ego: ego(before) == ego(now),
            picked: model.picked,
            marked: model.plot.marked.clone(),
        }
    }
}

/// Puts away what belongs to the scenario that was open.
fn leave(model: &mut Model) {
    let name = model
        .opened
        .as_ref()
        .map_or(String::new(), |o| o.name.clone());
    answers::leave(model, &name);
    model.answers.reference_ms = None;
    model.answers.show(Shown::Reference);
    model.taken = None;
    model.picked = None;
    model.plot.marked.clear();
    model.plot.series = None;
    model.map.tape = None;
    model.values = super::model::Values::default();
    model.prompt.scroll = 0;
}

/// Metres that the map shows at first, so that a vehicle is seen before it is near.
const NEIGHBOURHOOD: f64 = 45.0;

/// Points the map at the ego, or at everything where there is none.
fn frame_map(model: &mut Model, opened: &Opened) {
    if opened.scene.is_some() {
        model.camera.follow = true;
        model.camera.shift = crate::geometry::Vector::zeros();
        let (columns, _) = model.drawn.map_size();
        model.camera.show_at_least(NEIGHBOURHOOD, columns);
        return;
    }
    let positions: Vec<_> = opened
        .scenario
        .obstacles
        .iter()
        .flat_map(|o| o.track().iter().map(|(_, m)| m.pose.position))
        .collect();
    let bounds = Bounds::of(&positions).or_else(|| opened.scenario.network.bounds());
    if let Some(bounds) = bounds {
        let size = model.drawn.map_size();
        model.camera.fit(&bounds, size);
    }
}

/// Shows earlier answers that say something, the newest of each model and way of asking, unless something newer is
/// there. Those that were asked as it would be asked now come last, beside the built-in judge.
fn show_stored(model: &mut Model, stored: Vec<Answer>) {
    if !model.answers.columns.is_empty() {
        return;
    }
    let how = model.way();
    let mut seen = std::collections::HashSet::new();
    let mut newest: Vec<Answer> = stored
        .into_iter()
        // A run that reached no model says nothing about the scenario, nor about an older answer of that model.
        .filter(|a| a.model != crate::judge::MODEL && !a.text.trim().is_empty())
        .filter(|a| seen.insert((a.model.clone(), a.how.clone())))
        .collect();
    newest.sort_by_key(|answer| answer.how != how);
    newest.truncate(STORED);
    for answer in newest {
        let mut column = Column::from(answer);
        column.truth = column.steps.and_then(|steps| truth(model, steps));
        model.answers.columns.push(column);
    }
    model.answers.arrange(&how);
    if !model.answers.columns.is_empty() {
        let last = model.answers.columns.len() - 1;
        model.answers.show(Shown::Column(last));
    }
}

/// Earlier answers kept at hand.
const STORED: usize = 32;

/// What the built-in judge says about the window of an answer.
fn truth(model: &Model, (first, last): (i64, i64)) -> Option<crate::verdict::Verdict> {
    let scene = model.scene()?;
    let history = usize::try_from(last.saturating_sub(first).saturating_add(1)).unwrap_or(1);
    let window = crate::scenario::Window::ending_at(scene, last, history);
    let judgement = crate::judge::judge_under(scene, model.task, &window, &model.thresholds);
    Some(judgement.verdict)
}
