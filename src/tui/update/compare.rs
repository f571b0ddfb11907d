//! Answers side by side on the whole screen: which, how far scrolled, and what a person makes of them.

use super::super::action::{Action, Scope};
use super::super::keymap::{self, Code, Key};
use super::super::message::Effect;
use super::super::model::{Blind, MOST_COMPARED, Marking, Model, Overlay, REASONS, Shown, shuffle};
use super::{actions, answers, claims, clock, open_current};
use crate::store::{Choice, NewRating, RatedAnswer, Rating};

/// How the built-in judge is asked: it is not.
const BUILT_IN: &str = "built in";

/// Opens the screen on the answers that are shown in the verdict pane, the built-in judge's last.
pub fn open(model: &mut Model) {
    let fit = model.fit_side_by_side().max(2);
    let count = model.answers.columns.len();
    let mut shown: Vec<Shown> = (count.saturating_sub(fit - 1)..count)
        .map(Shown::Column)
        .collect();
    if let now @ Shown::Column(_) = model.answers.shown
        && !shown.contains(&now)
        && let Some(first) = shown.first_mut()
    {
        *first = now;
    }
    if model.answers.reference.is_some() {
        shown.push(Shown::Reference);
    }
    if shown.is_empty() {
        let why = model.without_ego();
        return model.say(format!("nothing to compare: {why}"));
    }
    model.compare.open = true;
    model.compare.blind = None;
    model.compare.focus = 0;
    model.compare.show(shown);
    follow_ends(model);
}

/// Opens it with the models hidden, or shows them again.
pub fn toggle_blind(model: &mut Model) {
    if model.compare.open && model.compare.blind.take().is_some() {
        return open(model);
    }
    model.compare.open = true;
    model.compare.blind = Some(Blind::default());
    begin(model);
}

/// Makes the groups of answers to be rated on this scenario, and shows the first.
fn begin(model: &mut Model) {
    let size = model.compare.blind.as_ref().map_or(2, |b| b.size);
    let whole = |place: &usize| {
        let column = &model.answers.columns[*place];
        column.answer().is_some() && !column.failed()
    };
    let all: Vec<usize> = (0..model.answers.columns.len()).filter(whole).collect();
    let mut groups = groups(&all, size);
    let seed = model.compare.next_seed();
    shuffle(&mut groups, seed);
    if let Some(blind) = &mut model.compare.blind {
        blind.left = groups;
        blind.waiting = false;
    }
    next_group(model);
}

/// All choices of so many of the places.
fn groups(all: &[usize], size: usize) -> Vec<Vec<Shown>> {
    if size == 0 {
        return vec![Vec::new()];
    }
    let mut found = Vec::new();
    for (at, place) in all.iter().enumerate() {
        for rest in groups(&all[at + 1..], size - 1) {
            let mut group = vec![Shown::Column(*place)];
            group.extend(rest);
            found.push(group);
        }
    }
    found
}

/// Shows the next group in a shuffled order; nothing where all were rated.
fn next_group(model: &mut Model) {
    let seed = model.compare.next_seed();
    let Some(blind) = &mut model.compare.blind else {
        return;
    };
    let mut group = blind.left.pop().unwrap_or_default();
    blind.seed = seed;
    shuffle(&mut group, seed);
    model.compare.focus = 0;
    model.compare.show(group);
}

/// A key while the screen is open.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    if model.compare.marking.is_some() {
        marking_key(model, key);
        return Vec::new();
    }
    if model.compare.ratings.take().is_some() {
        return Vec::new();
    }
    match keymap::action(key, Scope::Compare) {
        Some(action) => perform(model, action),
        None => Vec::new(),
    }
}

/// What an action does on this screen.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    use Action::*;
    let count = model.compare.shown.len().max(1);
    match action {
        Cancel if model.compare.ratings.take().is_some() => {}
        Cancel | CompareScreen => {
            model.compare.open = false;
            model.compare.blind = None;
        }
        BlindMode => toggle_blind(model),
        Quit => return actions::perform(model, Quit),
        Help => model.overlays.push(Overlay::Help { scroll: 0 }),
        CompareLeft => model.compare.focus = (model.compare.focus + count - 1) % count,
        CompareRight => model.compare.focus = (model.compare.focus + 1) % count,
        Up | Down | PageUp | PageDown | Top | Bottom => scroll(model, action),
        LinkScrolling => {
            model.compare.free = !model.compare.free;
            model.say(if model.compare.free {
                "every column scrolls on its own"
            } else {
                "the columns scroll together"
            });
        }
        NextAnswer => other(model, true),
        PreviousAnswer => other(model, false),
        MoreColumns | FewerColumns => resize(model, action == MoreColumns),
        NextClaim | PreviousClaim => go_to_claim(model, action == NextClaim),
        StepForward | StepBack => clock::clock(model, action),
        BestFirst => return rate(model, Choice::Best(0)),
        BestSecond => return rate(model, Choice::Best(1)),
        BestThird => return rate(model, Choice::Best(2)),
        BestFourth => return rate(model, Choice::Best(3)),
        RateTie => return rate(model, Choice::Tie),
        RateAllWrong => return rate(model, Choice::AllWrong),
        MarkWrong => mark(model),
        NextRound => return next_round(model),
        Ratings => return vec![Effect::ReadRatings],
        _ => {}
    }
    Vec::new()
}

/// Scrolls the column that has the keys, and with it the others where they are linked.
fn scroll(model: &mut Model, action: Action) {
    let focus = model.compare.focus;
    let extent = model.drawn.column(focus);
    let page = extent.rows.saturating_sub(1).max(1);
    for place in 0..model.compare.shown.len() {
        if model.compare.free && place != focus {
            continue;
        }
        let extent = model.drawn.column(place);
        let last = extent.lines.saturating_sub(extent.rows);
        let top = match action {
            Action::Up => extent.top.saturating_sub(1),
            Action::Down => extent.top + 1,
            Action::PageUp => extent.top.saturating_sub(page),
            Action::PageDown => extent.top + page,
            Action::Top => 0,
            _ => last,
        };
        set_top(model, place, top.min(last), last);
    }
}

/// At the end of a text that still arrives, the end is followed.
fn set_top(model: &mut Model, place: usize, top: usize, last: usize) {
    let running = is_running(model, model.compare.shown[place]);
    if let Some(slot) = model.compare.tops.get_mut(place) {
        *slot = Some(top).filter(|_| !(running && top == last));
    }
}

fn is_running(model: &Model, shown: Shown) -> bool {
    match shown {
        Shown::Reference => false,
        Shown::Column(place) => model
            .answers
            .columns
            .get(place)
            .is_some_and(super::Column::is_running),
    }
}

/// What arrives is followed from the beginning.
fn follow_ends(model: &mut Model) {
    for place in 0..model.compare.shown.len() {
        if is_running(model, model.compare.shown[place]) {
            model.compare.tops[place] = None;
        }
    }
}

/// Everything that can be shown.
fn everything(model: &Model) -> Vec<Shown> {
    let mut all: Vec<Shown> = (0..model.answers.columns.len())
        .map(Shown::Column)
        .collect();
    if model.answers.reference.is_some() {
        all.push(Shown::Reference);
    }
    all
}

/// Puts another answer, which is not shown yet, into the column that has the keys.
fn other(model: &mut Model, forward: bool) {
    if model.compare.blind.is_some() {
        return model.say("the answers are drawn by lot in blind mode");
    }
    let all = everything(model);
    let (focus, count) = (model.compare.focus, all.len());
    let Some(now) = model
        .compare
        .shown
        .get(focus)
        .and_then(|s| all.iter().position(|a| a == s))
    else {
        return;
    };
    let step = |n: usize| {
        if forward {
            (now + n) % count
        } else {
            (now + count - n) % count
        }
    };
    let free = (1..count)
        .map(|n| all[step(n)])
        .find(|s| !model.compare.shown.contains(s));
    match free {
        Some(next) => {
            model.compare.shown[focus] = next;
            model.compare.tops[focus] = Some(0);
            model.compare.marks[focus] = None;
            model.compare.choice = None;
            follow_ends(model);
        }
        None => {
            model.say("there is no other answer; r in the main screen asks, c asks another model")
        }
    }
}

/// One answer more, or one fewer.
fn resize(model: &mut Model, more: bool) {
    if let Some(blind) = &mut model.compare.blind {
        let size = if more { blind.size + 1 } else { blind.size - 1 };
        blind.size = size.clamp(2, MOST_COMPARED);
        return begin(model);
    }
    if !more {
        if model.compare.shown.len() > 1 {
            let focus = model.compare.focus;
            model.compare.shown.remove(focus);
            let shown = model.compare.shown.clone();
            model.compare.show(shown);
        }
        return;
    }
    let all = everything(model);
    let next = all
        .into_iter()
        .rev()
        .find(|s| !model.compare.shown.contains(s));
    match next {
        Some(next) if model.compare.shown.len() < MOST_COMPARED => {
            let mut shown = model.compare.shown.clone();
            shown.insert(0, next);
            model.compare.show(shown);
            follow_ends(model);
        }
        Some(_) => model.say(format!(
            "{MOST_COMPARED} answers at most stand side by side"
        )),
        None => model.say("there is no other answer"),
    }
}

fn go_to_claim(model: &mut Model, forward: bool) {
    let focus = model.compare.focus;
    let Some(&shown) = model.compare.shown.get(focus) else {
        return;
    };
    if let Some(place) = claims::go(model, shown, forward)
        && let Some(row) = model.drawn.claim_row(focus, place)
    {
        let extent = model.drawn.column(focus);
        let last = extent.lines.saturating_sub(extent.rows);
        let top = row.saturating_sub(extent.rows / 3).min(last);
        if row < extent.top || row >= extent.top + extent.rows {
            set_top(model, focus, top, last);
        }
    }
}

fn mark(model: &mut Model) {
    let focus = model.compare.focus;
    let Some(mark) = model.compare.marks.get_mut(focus) else {
        return;
    };
    if model.compare.choice.is_some() {
        return model.say("these answers were rated; enter goes on");
    }
    if mark.take().is_none() {
        model.compare.marking = Some(Marking::default());
    }
}

fn marking_key(model: &mut Model, key: Key) {
    let Some(marking) = &mut model.compare.marking else {
        return;
    };
    match (key.code, key.writes()) {
        (Code::Esc, _) => model.compare.marking = None,
        (Code::Up, _) => marking.selected = marking.selected.saturating_sub(1),
        (Code::Down | Code::Tab, _) => {
            marking.selected = (marking.selected + 1).min(REASONS.len() - 1)
        }
        (Code::Backspace, _) => drop(marking.text.pop()),
        (Code::Enter, _) => {
            let reason = REASONS[marking.selected];
            let text = marking.text.trim();
            let reason = if text.is_empty() {
                reason.to_string()
            } else {
                format!("{reason}: {text}")
            };
            if let Some(mark) = model.compare.marks.get_mut(model.compare.focus) {
                *mark = Some(reason);
            }
            model.compare.marking = None;
        }
        (_, Some(c)) => marking.text.push(c),
        _ => {}
    }
}

/// Keeps what the person chose.
fn rate(model: &mut Model, choice: Choice) -> Vec<Effect> {
    let shown = model.compare.shown.clone();
    let wrong_place = matches!(choice, Choice::Best(place) if place >= shown.len());
    if wrong_place || shown.len() < 2 {
        model.say(match shown.len() {
            0 | 1 => "two answers are needed to choose one".to_string(),
            n => format!("there are {n} answers"),
        });
        return Vec::new();
    }
    if model.compare.choice.is_some() {
        model.say("these answers were rated; enter goes on");
        return Vec::new();
    }
    if shown.iter().any(|s| is_running(model, *s)) {
        model.say("an answer is still arriving");
        return Vec::new();
    }
    let Some(scenario) = model.opened.as_ref().map(|o| o.name.clone()) else {
        return Vec::new();
    };
    let marks = model.compare.marks.clone();
    let rated = shown
        .iter()
        .zip(marks)
        .map(|(shown, mark)| rated(model, *shown, mark));
    let answers: Vec<RatedAnswer> = rated.collect();
    let blind = model.compare.blind.as_ref();
    let rating = NewRating {
        person: model.compare.person.clone(),
        scenario,
        task: model.task,
        blind: blind.is_some(),
        seed: blind.map_or(0, |b| b.seed),
        choice,
        notes: String::new(),
        answers,
    };
    model.compare.choice = Some(choice);
    vec![Effect::Rate(Box::new(rating))]
}

fn rated(model: &Model, shown: Shown, mark: Option<String>) -> RatedAnswer {
    let (run, id, prompt) = match shown {
        Shown::Column(place) => {
            let column = &model.answers.columns[place];
            (
                column.answer().and_then(|a| a.run),
                column.model.clone(),
                column.how.clone(),
            )
        }
        Shown::Reference => (None, crate::judge::MODEL.to_string(), BUILT_IN.to_string()),
    };
    RatedAnswer {
        run,
        model: id,
        prompt,
        wrong: mark.is_some(),
        reason: mark,
    }
}

/// Goes on to the next answers, or to the next scenario.
fn next_round(model: &mut Model) -> Vec<Effect> {
    let Some(blind) = &mut model.compare.blind else {
        model.say("B hides the models and draws answers by lot");
        return Vec::new();
    };
    if !blind.left.is_empty() {
        next_group(model);
        return Vec::new();
    }
    let before = model.list.opened;
    model.list.move_by(1);
    let effects = open_current(model);
    if model.list.opened == before {
        model.say("this was the last scenario of the list");
        return Vec::new();
    }
    if let Some(blind) = &mut model.compare.blind {
        blind.waiting = true;
    }
    model.compare.show(Vec::new());
    effects
}

/// Keeps the screen true after anything happened: answers that are gone are not shown, those waited for are.
pub fn follow(model: &mut Model) {
    if !model.compare.open {
        return;
    }
    if model.compare.blind.as_ref().is_some_and(|b| b.waiting)
        && model.opening.is_none()
        && !model.answers.columns.is_empty()
    {
        begin(model);
    }
    let there = everything(model);
    if model.compare.shown.iter().any(|s| !there.contains(s)) {
        let shown = model
            .compare
            .shown
            .iter()
            .copied()
            .filter(|s| there.contains(s));
        let shown = shown.collect();
        model.compare.show(shown);
    }
}

/// A rating was kept, or not.
pub fn kept(model: &mut Model, result: Result<i64, String>) {
    match result {
        Ok(number) => model.tell(format!("kept as rating {number}")),
        Err(error) => {
            model.compare.choice = None;
            model.complain(format!("the rating is not kept: {error}"));
        }
    }
}

/// The ratings were read.
pub fn read(model: &mut Model, result: Result<Vec<Rating>, String>) {
    match result {
        Ok(ratings) => model.compare.ratings = Some(ratings),
        Err(error) => model.complain(error),
    }
}

/// Ctrl-C: what runs is cancelled, else the screen is closed.
pub fn interrupt(model: &mut Model) -> Vec<Effect> {
    let aborted = answers::abort_all(model);
    if aborted.is_empty() {
        return perform(model, Action::Cancel);
    }
    aborted
}
