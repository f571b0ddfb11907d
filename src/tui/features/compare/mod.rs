//! Full-screen comparison: which answers, and their scroll positions.

pub mod band;
pub mod draw;
pub mod fields;
pub mod rating;
pub mod state;

use crate::action::{Action, Scope};
use crate::features::answers::{self, claims};
use crate::features::compare::rating::ReadRatings;
use crate::features::{Step, map, timeline, tour};
use crate::keymap::Key;
use crate::message::Effect;
use crate::model::{Column, Extent, MAX_COMPARED, Model, ShownAnswer, parts};
use crate::update::keys::{KeyEffect, pressed};
use nearmiss_store::Choice;
use nearmiss_study::evaluation::claims::{CheckedClaim, Judgement, Quantity};

/// Opens the screen on as many answers as fit: the shown one and those that tell most beside it; the built-in judge's
/// stands last, unless it would take the place of one of two answers.
pub fn open(model: &mut Model) {
    let count = model.answers.columns.len();
    let fit = model.fit_side_by_side().max(2);
    let judge = model.has_reference() && (fit > 2 || count < 2);
    let answers = fit - usize::from(judge);
    let first = match model.answers.shown {
        ShownAnswer::Column(place) => place,
        ShownAnswer::Reference => 0,
    };
    let mut places = telling(&model.answers.columns, first);
    places.truncate(answers);
    places.sort_unstable();
    let mut shown: Vec<ShownAnswer> = places.into_iter().map(ShownAnswer::Column).collect();
    shown.extend(judge.then_some(ShownAnswer::Reference));
    if shown.is_empty() {
        let why = model.without_ego();
        return model.say(format!("nothing to compare: {why}"));
    }
    model.compare.open = true;
    model.compare.blind = None;
    // It begins at the answer that was spoken of.
    let spoken = shown.iter().position(|s| *s == model.answers.shown);
    model.compare.focus = spoken.unwrap_or(0);
    model.compare.show(shown);
    follow_ends(model);
}

/// The places of answers: that of `first`, then of those that say otherwise about the same steps, of the same frame and
/// techniques before others, and near ones before far ones.
fn telling(columns: &[Column], first: usize) -> Vec<usize> {
    let Some(with) = columns.get(first) else {
        return Vec::new();
    };
    let verdict = |column: &Column| Some(column.answer()?.verdict()?.dangerous);
    let mut places: Vec<usize> = (0..columns.len()).collect();
    places.sort_by_key(|&place| {
        let other = &columns[place];
        let both = verdict(other).zip(verdict(with));
        let differs = other.steps == with.steps && both.is_some_and(|(a, b)| a != b);
        let (way, frame) = (other.how == with.how, frame(other) == frame(with));
        let rank = (other.failed(), !differs, !frame, !way);
        (place != first, rank, place.abs_diff(first))
    });
    places
}

fn frame(column: &Column) -> &str {
    parts(&column.how).0
}

/// Answers have come from the store: where the built-in judge stood alone because there were none, they join it.
pub fn arrived(model: &mut Model) {
    let alone = model.compare.shown == [ShownAnswer::Reference];
    if model.compare.open && model.compare.blind.is_none() && alone {
        open(model);
    }
}

/// A key while the screen is open.
pub fn on_key(model: &mut Model, key: Key) -> Vec<Effect> {
    if model.compare.marking.is_some() {
        return rating::marking_key(model, key);
    }
    match pressed(model, key, Scope::Compare) {
        KeyEffect::Action(Action::Cancel | Action::Quit | Action::Ratings)
            if model.compare.ratings.take().is_some() =>
        {
            Vec::new()
        }
        KeyEffect::Action(_) if model.compare.ratings.is_some() => Vec::new(),
        KeyEffect::Action(action) => {
            tour::follow(model, action);
            perform(model, action)
        }
        KeyEffect::Chord | KeyEffect::Nothing => Vec::new(),
    }
}

/// Performs an action on this screen; if it is closed, only opens it.
pub fn perform(model: &mut Model, action: Action) -> Vec<Effect> {
    use Action::*;
    if !model.compare.open {
        open(model);
        return match action {
            Ratings if model.compare.open => vec![ReadRatings.into()],
            _ => Vec::new(),
        };
    }
    let count = model.compare.shown.len().max(1);
    match action {
        Cancel if model.compare.ratings.take().is_some() => {}
        Cancel | Quit | CompareScreen => close(model),
        BlindMode => return rating::toggle_blind(model),
        SavePicture | Help => return vec![Effect::Step(Step::Perform(action))],
        CompareLeft => model.compare.focus = (model.compare.focus + count - 1) % count,
        CompareRight => model.compare.focus = (model.compare.focus + 1) % count,
        Up | Down | PageUp | PageDown | Top | Bottom => scroll(model, action),
        LinkScrolling => {
            model.compare.free = !model.compare.free;
            model.say(if model.compare.free {
                "scroll unlinked"
            } else {
                "scroll linked"
            });
        }
        NextAnswer => other(model, true),
        PreviousAnswer => other(model, false),
        MoreColumns | FewerColumns => resize(model, action == MoreColumns),
        NextClaim | PreviousClaim | NextObstacle | PreviousObstacle if model.compare.hides() => {
            model.say("checks hidden until rated");
        }
        NextClaim | PreviousClaim => go_to_claim(model, action == NextClaim),
        NextObstacle | PreviousObstacle => go_to_obstacle(model, action == NextObstacle),
        StepForward | StepBack => timeline::clock(model, action),
        BestFirst => return rating::rate(model, Choice::Best(0)),
        BestSecond => return rating::rate(model, Choice::Best(1)),
        BestThird => return rating::rate(model, Choice::Best(2)),
        BestFourth => return rating::rate(model, Choice::Best(3)),
        RateTie => return rating::rate(model, Choice::Tie),
        RateAllWrong => return rating::rate(model, Choice::AllWrong),
        MarkWrong => return rating::mark(model),
        NextRound => return rating::next_round(model),
        Ratings => return vec![ReadRatings.into()],
        _ => {}
    }
    Vec::new()
}

/// Closes the screen, if it is open.
pub fn close(model: &mut Model) {
    model.compare.open = false;
    model.compare.blind = None;
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
        let top = extent.scrolled(action, page);
        set_top(model, place, top, extent.last_top());
    }
}

/// At the end of a text that still arrives, the end is followed.
fn set_top(model: &mut Model, place: usize, top: usize, last: usize) {
    let running = is_running(model, model.compare.shown[place]);
    if let Some(slot) = model.compare.tops.get_mut(place) {
        *slot = Some(top).filter(|_| !(running && top == last));
    }
}

pub(crate) fn is_running(model: &Model, shown: ShownAnswer) -> bool {
    match shown {
        ShownAnswer::Reference => false,
        ShownAnswer::Column(place) => model
            .answers
            .columns
            .get(place)
            .is_some_and(Column::is_running),
    }
}

/// Streaming answers are followed from the beginning.
fn follow_ends(model: &mut Model) {
    for place in 0..model.compare.shown.len() {
        if is_running(model, model.compare.shown[place]) {
            model.compare.tops[place] = None;
        }
    }
}

/// Puts another answer, which is not shown yet, into the column that has the keys.
fn other(model: &mut Model, forward: bool) {
    if model.compare.blind.is_some() {
        return model.say("blind mode draws the answers at random");
    }
    let all = model.comparable();
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
            model.compare.begin_round();
            follow_ends(model);
        }
        None => {
            let (asks, compares) = (model.look.key(Action::Run), model.look.key(Action::Compare));
            model.say(format!(
                "no other answer; on the main screen {asks} asks, {compares} asks another model"
            ));
        }
    }
}

/// One answer more, or one fewer.
fn resize(model: &mut Model, more: bool) {
    if let Some(blind) = &mut model.compare.blind {
        let size = model.compare.shown.len();
        let size = if more {
            size + 1
        } else {
            size.saturating_sub(1)
        };
        blind.size = Some(size.clamp(2, MAX_COMPARED));
        return rating::begin(model);
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
    let all = model.comparable();
    let next = all
        .into_iter()
        .rev()
        .find(|s| !model.compare.shown.contains(s));
    match next {
        Some(next) if model.compare.shown.len() < MAX_COMPARED => {
            let mut shown = model.compare.shown.clone();
            // The others stay where they are.
            shown.push(next);
            model.compare.show(shown);
            follow_ends(model);
        }
        Some(_) => model.say(format!("at most {MAX_COMPARED} answers side by side")),
        None => model.say("no other answer"),
    }
}

/// Goes to the next claim of the column that has the keys, or the one before. Where none here was picked yet, it begins
/// in a column with a wrong one.
fn go_to_claim(model: &mut Model, forward: bool) {
    if let Some(place) = with_wrong_claim(model).filter(|_| forward) {
        model.compare.focus = place;
    }
    let focus = model.compare.focus;
    let Some(&shown) = model.compare.shown.get(focus) else {
        return;
    };
    let Some(picked) = claims::go(model, shown, forward) else {
        return;
    };
    let claims::PickedClaim {
        claim,
        row: Some(row),
    } = picked
    else {
        return;
    };
    let extent = model.drawn.column(focus);
    // The words on the row above it are in sight, too.
    let is_seen = row > extent.top && row < extent.top + extent.rows;
    let last = last_top(extent, row);
    let top = if is_seen {
        extent.top
    } else {
        row.saturating_sub(extent.rows / 3).min(last)
    };
    set_top(model, focus, top, last);
    if !model.compare.free {
        let others = (0..model.compare.shown.len()).filter(|other| *other != focus);
        let rows = others.filter_map(|other| {
            let row = spoken_of(model, other, claim.obstacle, Some(claim.quantity))?;
            Some((other, row))
        });
        let rows: Vec<(usize, usize)> = rows.collect();
        scroll_to(model, &rows, row - top);
    }
}

/// The column in sight with a wrong claim, that of the keys first; `None` where a claim of one is picked.
fn with_wrong_claim(model: &Model) -> Option<usize> {
    let key = |place: usize| Some(model.document(*model.compare.shown.get(place)?)?.key);
    let picked = |place| key(place).is_some_and(|key| model.claims.picked_of(key).is_some());
    let is_wrong = |claim: &CheckedClaim| claim.judgement == Judgement::Wrong;
    let wrong = |place: &usize| {
        let claims = key(*place).map_or(&[][..], |key| model.claims.get(key));
        claims.iter().any(is_wrong)
    };
    let seen = model.seen_side_by_side();
    if seen.clone().any(picked) {
        return None;
    }
    std::iter::once(model.compare.focus).chain(seen).find(wrong)
}

/// Picks the next obstacle that one of the answers speaks of, the most dangerous first, or the one before, and scrolls to
/// where they do.
fn go_to_obstacle(model: &mut Model, forward: bool) {
    let count = model
        .opened
        .as_ref()
        .map_or(0, |o| o.scenario.obstacles.len());
    for _ in 0..count {
        map::pick(model, if forward { 1 } else { -1 });
        let Some(id) = model.picked else { return };
        let linked = !model.compare.free;
        let places = (0..model.compare.shown.len()).filter(|p| linked || *p == model.compare.focus);
        let rows = places.filter_map(|place| Some((place, spoken_of(model, place, id, None)?)));
        let rows: Vec<(usize, usize)> = rows.collect();
        let of_model = |place: usize| model.compare.shown[place] != ShownAnswer::Reference;
        if rows.iter().any(|(place, _)| of_model(*place)) {
            return scroll_to(model, &rows, ABOVE);
        }
    }
    model.say("no answer here speaks of an obstacle");
}

/// Rows above the first words on an obstacle that stay in sight: its heading.
const ABOVE: usize = 2;

/// The last line that a text can begin with: JSON that was folded made it longer, down to that row at least.
fn last_top(extent: Extent, row: usize) -> usize {
    extent.last_top().max((row + 1).saturating_sub(extent.rows))
}

/// Scrolls columns so that a row of each stands in that row of the screen.
fn scroll_to(model: &mut Model, rows: &[(usize, usize)], at: usize) {
    for &(place, row) in rows {
        let last = last_top(model.drawn.column(place), row);
        set_top(model, place, row.saturating_sub(at).min(last), last);
    }
}

/// The row in which the answer at a place speaks of an obstacle: in a claim of that quantity, else in its first claim,
/// else where its id is first.
fn spoken_of(model: &Model, place: usize, id: i64, quantity: Option<Quantity>) -> Option<usize> {
    let shown = *model.compare.shown.get(place)?;
    let document = model.document(shown)?;
    let claims = model.claims.get(document.key);
    let about = |claim: &CheckedClaim| claim.claim.obstacle == id;
    let same = |claim: &CheckedClaim| about(claim) && Some(claim.claim.quantity) == quantity;
    let claim = claims
        .iter()
        .position(same)
        .or_else(|| claims.iter().position(about));
    let end = match claim {
        Some(place) => claims[place].claim.span.end,
        None => mention(&document.text, id)? + id.to_string().len(),
    };
    claims::row(model, shown, &document, end)
}

/// Where the id of an obstacle first stands in a text.
fn mention(text: &str, id: i64) -> Option<usize> {
    let id = id.to_string();
    let is_part = |c: char| c.is_alphanumeric() || c == '.';
    let mut found = text.match_indices(&id).map(|(at, _)| at);
    found.find(|&at| {
        let behind = &text[at + id.len()..];
        !text[..at].ends_with(is_part) && !behind.starts_with(|c: char| c.is_alphanumeric())
    })
}

/// Keeps the screen true after anything happened: answers that are gone are not shown, those waited for are.
pub fn settle(model: &mut Model) {
    if !model.compare.open {
        return;
    }
    if model.compare.blind.as_ref().is_some_and(|b| b.waiting)
        && model.opening.is_none()
        && !model.answers.columns.is_empty()
    {
        rating::begin(model);
    }
    let there = model.comparable();
    if model.compare.shown.iter().any(|s| !there.contains(s)) {
        let shown = model
            .compare
            .shown
            .iter()
            .copied()
            .filter(|s| there.contains(s))
            .collect();
        model.compare.show(shown);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_is_a_number_of_its_own() {
        assert_eq!(mention("at 1.301 m, 3012 and car 301's", 301), Some(25));
        assert_eq!(mention("obstacle 301.0 is", 301), Some(9));
        assert_eq!(mention("301st", 301), None);
    }
}
