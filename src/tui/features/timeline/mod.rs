//! The timeline: steps, playback, seeking, and what changes with the step.

pub mod draw;
pub mod state;

use crate::action::Action;
use crate::clock::PlayRange;
use crate::message::Effect;
use crate::model::{Column, Disagreement, Heat, Line, Model, OpenId, Seek, ShownAnswer};
use crate::update::{open, opening};
use nearmiss_scene::metrics::Series;
use nearmiss_scene::verdict::Task;

/// Goes to the most dangerous value of the plotted measure: of the picked obstacle, where it has one, else of all.
pub(super) fn go_to_minimum(model: &mut Model) {
    let measure = model.plot.measure;
    let Some(series) = &model.plot.series else {
        return model.say(match model.scene() {
            Some(_) => format!("{} is still being computed", measure.id),
            None => model.without_ego(),
        });
    };
    let of_picked = model.picked.and_then(|id| worst_of(series, measure.id, id));
    let (words, step, obstacle) = match of_picked.zip(model.picked) {
        Some(((step, value), id)) => (value, step, id),
        None => {
            let found = series.most_dangerous(measure.id).and_then(|(step, _)| {
                let (id, value) = series.most_dangerous_at(measure.id, step)?;
                Some((value, step, id))
            });
            match found {
                Some(found) => found,
                None => return model.say(format!("{} has no value at any step", measure.id)),
            }
        }
    };
    model.clock.go(step);
    model.picked = Some(obstacle);
    let extreme = measure.extreme();
    let unit = match measure.unit {
        "" => String::new(),
        unit => format!(" {unit}"),
    };
    let time = model.clock.time();
    model.say(format!(
        "{extreme} {} {words:.2}{unit} of {obstacle} at {time:.1} s",
        measure.id
    ));
}

/// The most dangerous value of one obstacle and the first step at which it occurs.
fn worst_of(series: &Series, measure: &str, obstacle: i64) -> Option<(i64, f64)> {
    let danger = series.measures().iter().find(|m| m.id == measure)?.danger;
    let row = series.steps().zip(series.row(measure, obstacle));
    let values = row.filter_map(|(step, reading)| Some((step, reading.value()?)));
    values.min_by(|a, b| danger.compare(a.1, b.1))
}

/// Plays everything over and over, then the window as it is now, then no longer.
pub(super) fn turn_round(model: &mut Model) {
    let window = model.shown_window().filter(|(first, last)| first < last);
    let (lap, words) = match (model.clock.lap(), window) {
        (PlayRange::Once, _) => (PlayRange::Whole, "loop: everything".to_string()),
        (PlayRange::Whole, Some((first, last))) => (
            PlayRange::Part(first, last),
            format!("loop: the window, steps {first} to {last}"),
        ),
        (PlayRange::Whole, None) | (PlayRange::Part(..), _) => {
            (PlayRange::Once, "loop off".to_string())
        }
    };
    model.clock.go_round(lap);
    model.say(words);
}

/// Shows another measure in the strips.
pub fn next_heat(model: &mut Model) {
    model.heat = model.next_heat();
    let words = match (model.heat, model.heat_series()) {
        (Heat::Off, _) => "strips off".to_string(),
        (_, Some((measure, _))) => format!("the strips show {}", measure.name),
        (_, None) => model.without_ego(),
    };
    model.say(words);
}

/// Goes to the next thing in this scenario that an answer says otherwise than it is: its yes or no, or what it says of an
/// obstacle; after the last to the first.
pub fn next_difference(model: &mut Model) {
    let all = model.differences();
    match model.next_of(all.clone()).or(all.first().copied()) {
        Some(next) => show(model, next, &all),
        None => {
            let key = model.look.key(Action::NextDisagreement);
            model.say(format!(
                "no answer shown differs from the built-in judge; {key} looks in the whole list"
            ));
        }
    }
}

/// Goes to the next answer whose yes or no differs from the built-in judge's: in this scenario, else in the next one of
/// the list of which the store has such an answer.
pub fn next_disagreement(model: &mut Model) -> Vec<Effect> {
    let here_all = model.disagreements();
    if let Some(next) = model.next_of(here_all.clone()) {
        show(model, next, &here_all);
        return Vec::new();
    }
    let here = model.list.opened;
    let task = model.task;
    let differs = |place: usize| {
        let facts = model.list.rows[place].facts();
        facts.is_some_and(|facts| facts.task_tally(task).differ > 0)
    };
    let places: Vec<usize> = places(model);
    let after = places
        .iter()
        .position(|&p| Some(p) == here)
        .map_or(0, |at| at + 1);
    let round = places[after..].iter().chain(&places[..after]);
    let next = round.copied().find(|&p| differs(p) && Some(p) != here);
    match next {
        Some(place) => {
            model.list.select(place);
            let effects = open(model, place, None);
            model.seek = model.opening.map(|(opening, _)| Seek { opening });
            effects
        }
        None => match here_all.first() {
            Some(&first) => {
                show(model, first, &here_all);
                model.say("back at the first disagreement");
                Vec::new()
            }
            None => {
                let unread = model.list.rows.len().saturating_sub(model.list.facts_read);
                let words = "no answer to this task differs from the built-in judge";
                model.say(match unread {
                    0 => words.to_string(),
                    n => format!("{words}; {n} scenarios are not read yet"),
                });
                Vec::new()
            }
        },
    }
}

/// Scenarios in the order in which they are shown, each once, those in shut groups too.
fn places(model: &Model) -> Vec<usize> {
    let mut seen = std::collections::HashSet::new();
    let lines = model.list.lines.iter().filter_map(|line| match line {
        Line::Scenario(place, _) => Some(*place),
        Line::Head(_) => None,
    });
    let all = lines.chain(model.list.visible.iter().copied());
    all.filter(|place| seen.insert(*place)).collect()
}

/// Stored answers have arrived: a disagreement that was looked for in this scenario is shown.
pub(super) fn arrived(model: &mut Model) {
    let Some(seek) = model.seek.take() else {
        return;
    };
    let all = model.disagreements();
    // Some may still be held against the geometry.
    let is_unsure = |c: &Column| c.truth.is_none() && c.steps.is_some() && c.answer().is_some();
    if all.is_empty() && model.answers.columns.iter().any(is_unsure) {
        model.seek = Some(seek);
        return;
    }
    match all.first() {
        Some(&first) => show(model, first, &all),
        None => model.say("no answer shown differs from the built-in judge now"),
    }
}

/// A scenario was opened; what is looked for elsewhere is forgotten.
pub fn opened(model: &mut Model, id: OpenId) {
    model.seek = model.seek.filter(|seek| seek.opening == id);
}

/// Goes to one of these.
fn show(model: &mut Model, at: Disagreement, all: &[Disagreement]) {
    opening::leave_place(model);
    model.clock.playing = false;
    model.clock.go(at.step);
    model.answers.show(ShownAnswer::Column(at.column));
    model.answers.walked = Some(at);
    stepped(model);
    if let Some(words) = model.difference_words(at) {
        model.picked = at.obstacle;
        model.answers.cursor = at.obstacle;
        let place = all.iter().position(|d| *d == at).map_or(0, |p| p + 1);
        return model.say(format!("difference {place} of {}: {words}", all.len()));
    }
    let column = &model.answers.columns[at.column];
    let name = column.model.clone();
    let said = column.answer().and_then(|a| a.verdict()).map(|v| v.word());
    let place = all.iter().position(|d| *d == at).map_or(0, |p| p + 1);
    let said = said.unwrap_or_default();
    let reference = model.answers.reference.as_ref().map(|r| &r.verdict);
    let truth = column.truth_or(reference).map_or("otherwise", |v| v.word());
    model.say(format!(
        "difference {place} of {}: {name} says {said}, the built-in judge says {truth}",
        all.len()
    ));
}

/// Plays, or goes to another step.
pub fn clock(model: &mut Model, action: Action) {
    let before = model.clock.step();
    let times = model.look.times();
    if leaves(action) {
        opening::leave_place(model);
    }
    match action {
        Action::StepForward => model.clock.advance(times),
        Action::StepBack => model.clock.advance(-times),
        Action::JumpForward => model.clock.advance(10 * times),
        Action::JumpBack => model.clock.advance(-10 * times),
        Action::FirstStep => model.clock.go(i64::MIN),
        Action::LastStep => model.clock.go(i64::MAX),
        Action::Play => play(model),
        Action::Faster => model.clock.change_speed(true),
        Action::Slower => model.clock.change_speed(false),
        Action::MinimumStep => go_to_minimum(model),
        Action::Loop => turn_round(model),
        Action::ContactStep => go_to_contact(model),
        _ => go_to_worst(model),
    }
    if !matches!(
        action,
        Action::Play | Action::Faster | Action::Slower | Action::Loop
    ) {
        model.clock.playing = false;
    }
    if model.clock.step() != before {
        stepped(model);
    }
    let headline = model.opened.as_ref().and_then(|o| o.headline.as_ref());
    let worst = headline.and_then(|headline| headline.worst());
    if matches!(action, Action::CollisionStep | Action::ContactStep)
        && worst.is_some_and(|moment| moment.step == model.clock.step())
    {
        model.placed = Some(model.clock.step());
    }
}

/// Whether an action jumps away from a place that the list of jumps should have.
fn leaves(action: Action) -> bool {
    use Action::{CollisionStep, ContactStep, FirstStep, LastStep, MinimumStep};
    matches!(
        action,
        CollisionStep | ContactStep | FirstStep | LastStep | MinimumStep
    )
}

fn go_to_contact(model: &mut Model) {
    let headline = model.opened.as_ref().and_then(|o| o.headline.as_ref());
    match headline.map(nearmiss_scene::metrics::Headline::collides) {
        Some(false) => model.say("no contact in this scenario"),
        _ => go_to_worst(model),
    }
}

/// Goes to the moment that matters, picks its obstacle and says why it matters.
fn go_to_worst(model: &mut Model) {
    let headline = model.opened.as_ref().and_then(|o| o.headline.as_ref());
    match headline.and_then(|headline| headline.worst().copied()) {
        Some(moment) => {
            model.clock.go(moment.step);
            model.picked = Some(moment.obstacle);
            model.say(format!("{}: {}", moment.obstacle, moment.hazard));
        }
        None if model.scene().is_none() => {
            let why = model.without_ego();
            model.say(why);
        }
        None => model.say("no obstacle is there with the ego at any step"),
    }
}

/// Goes to the moment that matters, or for a question about a window to the end of its default window, unless the user
/// went to another step.
pub fn to_moment(model: &mut Model) {
    let (first, _) = model.clock.range();
    let now = model.clock.step();
    let moved = now != first && model.placed != Some(now);
    if moved || model.clock.playing {
        return;
    }
    let headline = model.opened.as_ref().and_then(|o| o.headline.as_ref());
    let worst = headline.and_then(|headline| headline.worst());
    let step = match model.task {
        task if task.is_about_all_steps() => worst.map(|moment| moment.step),
        // Stored answers are about this window.
        Task::Safety => model
            .scene()
            .map(|scene| scene.last_step() - nearmiss_scene::scenario::Window::AFTER_SAFETY),
        _ => model.scene().map(|scene| scene.last_step()),
    };
    model.clock.go(step.unwrap_or(first));
    model.placed = step.map(|_| model.clock.step());
}

/// Seconds before the moment that matters from which playing starts there.
const RUN_UP: f64 = 3.0;

/// Plays, or pauses; from the moment that matters it first goes back, so that one sees how it comes about.
fn play(model: &mut Model) {
    let headline = model.opened.as_ref().and_then(|o| o.headline.as_ref());
    let worst = headline.and_then(|headline| headline.worst());
    let was_placed = model.placed == Some(model.clock.step());
    if let (Some(step), true, false) = (
        worst.map(|moment| moment.step),
        was_placed,
        model.clock.playing,
    ) {
        model.clock.go(step);
        model.clock.rewind(RUN_UP);
    }
    model.clock.toggle();
}

/// The clock moved: recomputes what depends on the step.
pub fn stepped(model: &mut Model) {
    model.placed = None;
    // Some tasks are about the whole recording, the others about a window that ends here.
    if !model.task.is_about_all_steps() {
        model.refresh();
    }
}
