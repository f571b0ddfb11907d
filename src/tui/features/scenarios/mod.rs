//! The list of scenarios: arriving rows, order, groups and filter.

pub mod columns;
pub mod draw;
pub mod request;
pub mod saved_views;
pub mod state;
pub mod tags;

use nearmiss_formats::{Entry, PassedOver, SearchResults};
use nearmiss_scene::description::visible;
use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::Action;
use crate::features::Step;
use crate::features::picker::Choice;
use crate::keymap::{Code, Key, edit_line, first_line};
use crate::message::Effect;
use crate::model::{Filtering, JobId, JobKind, Line, Model, Order, Pane, Picker, orders_shown};
use crate::session::restore;
use crate::update::{open, open_current, opening};
use crate::widgets::picker;
use crate::widgets::words::pad;
use request::{Rank, Survey, ranking};
use saved_views::{ListViews, SavedViewsScreen};

/// How many of the list have no ego, and whether the planner drives them, or the key that plans one where what is open
/// is one of them and has something to plan for.
pub fn without_ego(model: &Model) -> Option<String> {
    let why = model.list.without_ego()?;
    let mut jobs = model.jobs.all.iter();
    if jobs.any(|job| job.is_running() && matches!(job.kind, JobKind::Ranking(_))) {
        return Some(format!("{why}: the planner drives"));
    }
    let can_plan = model.opened.as_ref().is_some_and(|opened| {
        opened.scene.is_none() && !opened.scenario.planning_problems.is_empty()
    });
    if !can_plan || model.driver.under_way.is_some() {
        return Some(why);
    }
    let key = model.look.key(Action::DrivePlanner);
    Some(format!("{why}: {key} plans one"))
}

/// All scenarios were found at once.
pub fn found(model: &mut Model, found: Result<SearchResults, String>) -> Vec<Effect> {
    match found {
        Ok(found) => {
            let survey = found.entries.iter().cloned().enumerate().collect();
            model.list.fill(found);
            let mut effects = restore::open_found(model);
            effects.push(Survey::All(survey).into());
            effects.extend(ranking(model));
            effects
        }
        Err(message) => nothing_found(model, message),
    }
}

/// More scenarios were found; the search continues.
pub fn listed(model: &mut Model, entries: Vec<Entry>) -> Vec<Effect> {
    let before = model.list.rows.len();
    let new: Vec<(usize, Entry)> = (before..).zip(entries.iter().cloned()).collect();
    model.list.add(entries);
    if before > 0 {
        // Sorted by a measure already, the values of all are asked for when all are there.
        let mut effects = restore::open_found(model);
        effects.push(Survey::More(new).into());
        return effects;
    }
    model.list.settle();
    let mut effects = restore::open_found(model);
    effects.push(Survey::All(new).into());
    effects
}

/// The search has ended.
pub fn searched(model: &mut Model, ended: Result<Vec<PassedOver>, String>) -> Vec<Effect> {
    match ended {
        Ok(passed_over) => {
            model.list.found = true;
            model.list.passed_over = passed_over;
            let mut effects = restore::open_found(model);
            effects.extend(ranking(model));
            effects
        }
        Err(message) => nothing_found(model, message),
    }
}

fn nothing_found(model: &mut Model, message: String) -> Vec<Effect> {
    model.list.found = true;
    model.complain(message.clone());
    if model.list.rows.is_empty() {
        model.open_error = Some(message);
    }
    Vec::new()
}

/// A frame is about to be drawn: what arrived takes its place, and what is on the screen is asked for first.
pub fn drawing(model: &mut Model) -> Vec<Effect> {
    model.list.settle();
    let lacking = model.list.lacking_egos();
    if !lacking.is_empty() {
        return vec![Rank::All(model.list.order.id(), lacking).into()];
    }
    if model.list.lead() {
        return open_current(model);
    }
    let list = &model.list;
    if list.facts_read >= list.rows.len() {
        return Vec::new();
    }
    let extent = model.drawn.extent(Pane::Scenarios);
    let shown = list.lines.iter().skip(extent.top).take(extent.rows);
    let unknown = shown.filter_map(|line| match line {
        Line::Scenario(place, _) if list.rows[*place].facts.is_none() => Some(*place),
        _ => None,
    });
    let unknown: Vec<usize> = unknown.collect();
    if unknown.is_empty() || unknown == model.list.urgent {
        return Vec::new();
    }
    model.list.urgent.clone_from(&unknown);
    vec![Survey::First(unknown).into()]
}

/// Turns the order around.
pub fn turn(model: &mut Model) {
    let order = model.list.order;
    model.list.sort_by(order);
}

/// Groups by the next thing.
pub fn group(model: &mut Model) {
    let next = model.list.grouping.next();
    model.list.group_by(next);
    let key = model.look.key(Action::Choose);
    model.say(match next.name() {
        "nothing" => "not grouped".to_string(),
        name => format!("grouped by {name}; {key} on a group collapses it"),
    });
}

/// Enter: opens the selected scenario, or shuts the selected group.
pub fn choose(model: &mut Model) -> Vec<Effect> {
    if model.list.toggle_group() {
        return Vec::new();
    }
    restore::released(model);
    let changed = model.opened.as_ref().is_some_and(|o| o.change.is_some());
    match model.list.opened.filter(|_| changed) {
        // The file as it is, and not as an answer was about it.
        Some(place) if model.list.current() == Some(place) => open(model, place, None),
        _ => open_current(model),
    }
}

/// The scenarios of this name, to be counted anew after an answer arrived.
pub fn recount(model: &Model, name: &str) -> Vec<Effect> {
    let rows = model.list.rows.iter().enumerate();
    let of_name = rows.filter(|(_, row)| row.entry.name == name);
    let entries: Vec<_> = of_name
        .map(|(place, row)| (place, row.entry.clone()))
        .collect();
    if entries.is_empty() {
        Vec::new()
    } else {
        vec![Survey::Again(entries).into()]
    }
}

/// The scenario that a question is about, by its name.
pub fn name_of(model: &Model, ask: JobId) -> Option<String> {
    let mut elsewhere = model.answers.elsewhere.iter();
    let left = elsewhere.find(|(id, _)| *id == ask);
    if let Some((_, name)) = left {
        return Some(name.clone());
    }
    let here = model.answers.columns.iter().any(|c| c.ask == Some(ask));
    here.then(|| model.opened.as_ref().map(|o| o.name.clone()))?
}

/// Begins to type; the old text is selected, so that the first character replaces it.
pub fn begin(model: &mut Model) {
    model.focus = Pane::Scenarios;
    if model.list.filtering.is_some() {
        return;
    }
    let before = model.list.filter.clone();
    if let Some(dropped) = model.list.dropped.take().filter(|_| before.is_empty()) {
        model.list.set_filter(dropped);
    }
    model.list.filtering = Some(Filtering {
        selected: !model.list.filter.is_empty(),
        before,
        line: model.list.selected,
        place: opening::here(model),
        rest: None,
    });
}

/// The kept filter goes; the key that types a filter brings it back.
pub fn drop_kept(model: &mut Model) {
    let filter = std::mem::take(&mut model.list.filter);
    model.list.set_filter(String::new());
    let (key, shown) = (
        model.look.key(Action::Filter),
        visible(&filter).into_owned(),
    );
    let all = model.list.rows.len();
    model.say(format!(
        "filter /{shown} removed: all {all} scenarios are listed; {key} Enter brings it back"
    ));
    model.list.dropped = Some(filter);
}

/// A key while the filter is typed.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    match key.code {
        Code::Esc => return cancel(model),
        Code::Enter | Code::Tab => {
            let effects = open_match(model);
            keep(model);
            return effects;
        }
        Code::Up | Code::Down => {
            let mut effects = open_match(model);
            let action = if key.code == Code::Up {
                Action::Up
            } else {
                Action::Down
            };
            effects.push(Effect::Step(Step::Perform(action)));
            return effects;
        }
        Code::Left | Code::Right | Code::Home | Code::End => {
            unselected(model);
            return Vec::new();
        }
        _ => {}
    }
    let mut filter = model.list.filter.clone();
    if model.list.filtering.as_ref().is_some_and(|f| f.selected) && replaces(key) {
        filter.clear();
    }
    if !edit_line(&mut filter, key) {
        return Vec::new();
    }
    typed(model, filter)
}

/// Text that is pasted while the filter is typed.
pub(super) fn paste(model: &mut Model, text: &str) -> Vec<Effect> {
    let selected = model.list.filtering.as_ref().is_some_and(|f| f.selected);
    let kept = if selected { "" } else { &model.list.filter };
    let filter = format!("{kept}{}", first_line(text));
    typed(model, filter)
}

/// Whether a key takes the place of the selected text.
fn replaces(key: Key) -> bool {
    key.writes().is_some() || key.code == Code::Backspace
}

fn unselected(model: &mut Model) {
    if let Some(filtering) = &mut model.list.filtering {
        filtering.selected = false;
    }
}

fn typed(model: &mut Model, filter: String) -> Vec<Effect> {
    unselected(model);
    if filter == model.list.filter {
        return Vec::new();
    }
    model.list.set_filter(filter);
    if let Some(filtering) = &mut model.list.filtering {
        filtering.rest = Some(REST);
    }
    Vec::new()
}

/// The best match is opened after so many seconds without typing.
const REST: f64 = 0.25;

/// Time passes: the best match is opened once typing rests.
pub fn pass(model: &mut Model, seconds: f64) -> Vec<Effect> {
    let filtering = model.list.filtering.as_mut();
    let Some(left) = filtering.and_then(|filtering| filtering.rest.as_mut()) else {
        return Vec::new();
    };
    *left -= seconds;
    if *left <= 0.0 {
        open_match(model)
    } else {
        Vec::new()
    }
}

/// Opens the selected match, unless it is open.
fn open_match(model: &mut Model) -> Vec<Effect> {
    let filtering = model.list.filtering.as_mut();
    match filtering.and_then(|filtering| filtering.rest.take()) {
        Some(_) => open_current(model),
        None => Vec::new(),
    }
}

/// The filter stays; what was open before is a place to go back to.
fn keep(model: &mut Model) {
    let Some(filtering) = model.list.filtering.take() else {
        return;
    };
    if let Some(place) = filtering.place
        && model.list.opened != Some(place.scenario)
    {
        model.jumps.leave(place);
    }
}

/// The filter is what it was, and so are the selected line and the open scenario.
pub fn cancel(model: &mut Model) -> Vec<Effect> {
    let Some(filtering) = model.list.filtering.take() else {
        return Vec::new();
    };
    if model.list.filter != filtering.before {
        model.list.set_filter(filtering.before);
    }
    let last = model.list.lines.len().saturating_sub(1);
    model.list.selected = filtering.line.min(last);
    match filtering.place {
        Some(place) if model.list.opened != Some(place.scenario) => opening::reach(model, place),
        _ => Vec::new(),
    }
}

/// Shows the view that was chosen, else opens the list of them.
pub fn perform(model: &mut Model) -> Vec<Effect> {
    let Some(name) = model.list.chosen_view.take() else {
        model.screens.open(SavedViewsScreen::default());
        return vec![ListViews::Read.into()];
    };
    let Some(view) = model.list.views.get(&name).cloned() else {
        model.say(format!("view `{name}` no longer exists"));
        return Vec::new();
    };
    let unknown = model.list.show_view(&view);
    match unknown.as_slice() {
        [] => model.say(format!("view `{name}`")),
        unknown => model.complain(format!(
            "view `{name}` uses {}, unknown to this version of nearmiss; the rest is shown",
            unknown.join(" and ")
        )),
    }
    let mut effects: Vec<Effect> = ranking(model).into_iter().collect();
    effects.extend(open_current(model));
    effects
}

/// Orders by id.
#[derive(Debug)]
pub struct Orders;

impl Choice for Orders {
    fn count(&self, _model: &Model, picker: &Picker) -> usize {
        orders_shown(picker).len()
    }

    fn choose(&mut self, model: &mut Model, picker: &Picker) -> Step {
        let shown = orders_shown(picker);
        let Some(order) = shown.get(picker.selected) else {
            return Step::close();
        };
        // By the same again, the other way around.
        model.list.sort_by(*order);
        model.list.leads = order.needs_facts();
        let measured = matches!(order, Order::Severity | Order::Measure(_));
        if measured && model.list.without_ego().is_some() {
            model.say(
                "scenarios without an ego come last; the first opens once the planner has tried to drive them",
            );
        }
        Step::Close(ranking(model).into_iter().collect())
    }

    /// From the order as they were found to the one that is wanted most, and from any other back.
    fn first(&self, model: &Model) -> usize {
        let wanted = |order: &Order| *order == Order::Severity && model.list.order == Order::Found;
        Order::PLAIN.iter().position(wanted).unwrap_or(0)
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
        let row = |order: Order| match order {
            Order::Measure(measure) => picker::measure_row(measure),
            _ => {
                let left = format!("{} {}", pad(order.id(), 16), order.doc());
                (left, String::new())
            }
        };
        let rows: Vec<_> = orders_shown(picker).into_iter().map(row).collect();
        picker::draw_measures(frame, screen, model, "sort scenarios by", picker, &rows);
    }
}
