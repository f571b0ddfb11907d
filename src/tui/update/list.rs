//! The list of scenarios: arriving rows, order and groups, and the user's tags.

use super::super::action::Action;
use super::super::message::Effect;
use super::super::model::{JobId, Line, Model, Pane};
use super::super::session::restore;
use super::super::tasks::scenarios::{Survey, ranking};
use super::{open, open_current};
use nearmiss_formats::{Entry, PassedOver, SearchResults};

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
    let list = &model.list;
    if list.known >= list.rows.len() {
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
