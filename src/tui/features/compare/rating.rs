//! Ratings of answers side by side: blind mode, marks, kept ratings.

use crate::action::Action;
use crate::features::compare::{is_running, open};
use crate::keymap::{Code, Key, edit_line};
use crate::message::Effect;
use crate::model::{
    BlindMode, Marking, Model, Notice, PendingRating, REASONS, ShownAnswer, shuffle,
};
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::update::open_current;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Choice, NewRating, RatedAnswer, Rating, Unrated};

/// How the built-in judge is asked: it is not.
const BUILT_IN: &str = "built in";

/// Opens it with the models hidden, or shows them again.
pub fn toggle_blind(model: &mut Model) -> Vec<Effect> {
    if model.compare.open && model.compare.blind.take().is_some() {
        open(model);
        return Vec::new();
    }
    model.compare.open = true;
    model.compare.blind = Some(BlindMode::default());
    // What was said before may name a model and its verdict.
    model.toasts.retain(|toast| toast.kind == Notice::Error);
    begin(model);
    vec![find_unrated(model)]
}

/// Asks the store what is left to rate.
fn find_unrated(model: &Model) -> Effect {
    let find = FindUnrated {
        task: model.task,
        person: model.compare.person.clone(),
    };
    find.into()
}

/// Makes the groups of answers to be rated on this scenario, and shows the first.
pub fn begin(model: &mut Model) {
    let all = model.to_rate();
    let chosen = model.compare.blind.as_ref().and_then(|blind| blind.size);
    let fit = model.fit_side_by_side().max(2);
    let size = chosen.unwrap_or(fit.min(all.len())).max(2);
    let mut groups = groups(&all, size);
    let seed = model.compare.next_seed();
    shuffle(&mut groups, seed);
    if let Some(blind) = &mut model.compare.blind {
        blind.left = groups;
        blind.waiting = false;
    }
    next_group(model);
}

/// All combinations of `size` places.
fn groups(all: &[usize], size: usize) -> Vec<Vec<ShownAnswer>> {
    if size == 0 {
        return vec![Vec::new()];
    }
    let mut found = Vec::new();
    for (at, place) in all.iter().enumerate() {
        for rest in groups(&all[at + 1..], size - 1) {
            let mut group = vec![ShownAnswer::Column(*place)];
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

/// Asks why the answer of the column that has the keys is wrong, or takes that back; answers that were rated are rated
/// anew then.
pub fn mark(model: &mut Model) -> Vec<Effect> {
    let focus = model.compare.focus;
    let Some(mark) = model.compare.marks.get_mut(focus) else {
        return Vec::new();
    };
    if mark.take().is_some() {
        return marked(model);
    }
    model.compare.marking = Some(Marking::default());
    Vec::new()
}

/// A mark was set or taken back.
fn marked(model: &mut Model) -> Vec<Effect> {
    match model.compare.choice {
        Some(choice) => keep(model, choice),
        None => Vec::new(),
    }
}

/// A key while a reason is given.
pub fn marking_key(model: &mut Model, key: Key) -> Vec<Effect> {
    let Some(marking) = &mut model.compare.marking else {
        return Vec::new();
    };
    match key.code {
        Code::Esc => model.compare.marking = None,
        Code::Up => marking.selected = marking.selected.saturating_sub(1),
        Code::Down | Code::Tab => marking.selected = (marking.selected + 1).min(REASONS.len() - 1),
        Code::Enter => {
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
            return marked(model);
        }
        _ => drop(edit_line(&mut marking.text, key)),
    }
    Vec::new()
}

/// Keeps what the person chose; a second choice of the same answers takes the place of the first.
pub fn rate(model: &mut Model, choice: Choice) -> Vec<Effect> {
    let shown = model.compare.shown.clone();
    let wrong_place = matches!(choice, Choice::Best(place) if place >= shown.len());
    if wrong_place || shown.len() < 2 {
        model.say(match shown.len() {
            0 | 1 => "a rating needs 2 complete answers".to_string(),
            n => format!("only {n} answers are shown"),
        });
        return Vec::new();
    }
    if matches!(choice, Choice::Best(place) if !model.seen_side_by_side().contains(&place)) {
        model.say("this answer is out of sight; ←→ goes to it");
        return Vec::new();
    }
    if model.compare.choice == Some(choice) {
        model.say("already rated so; another key changes the rating, enter goes on");
        return Vec::new();
    }
    if shown.iter().any(|s| is_running(model, *s)) {
        model.say("an answer is still streaming");
        return Vec::new();
    }
    keep(model, choice)
}

/// Sends the rating of the answers that stand here to the store, or puts it behind one that is on its way there.
fn keep(model: &mut Model, choice: Choice) -> Vec<Effect> {
    let shown = model.compare.shown.clone();
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
    let compare = &mut model.compare;
    compare.choice = Some(choice);
    let (round, replaced) = (compare.round, compare.kept.map(|(id, _)| id));
    let mut keeping = compare.keeping.iter_mut();
    match keeping.find(|keeping| keeping.round == round) {
        Some(before) => {
            before.then = Some(Box::new(rating));
            Vec::new()
        }
        None => send(model, round, Box::new(rating), replaced),
    }
}

fn send(
    model: &mut Model,
    round: u64,
    rating: Box<NewRating>,
    replaced: Option<i64>,
) -> Vec<Effect> {
    model.compare.keeping.push(PendingRating {
        round,
        choice: rating.choice,
        replaced,
        then: None,
    });
    let rate = Rate {
        round,
        rating,
        replaced,
    };
    vec![rate.into()]
}

fn rated(model: &Model, shown: ShownAnswer, mark: Option<String>) -> RatedAnswer {
    let (run, id, prompt) = match shown {
        ShownAnswer::Column(place) => {
            let column = &model.answers.columns[place];
            (
                column.answer().and_then(|a| a.run),
                column.model.clone(),
                column.how.clone(),
            )
        }
        ShownAnswer::Reference => (
            None,
            nearmiss_scene::judge::MODEL.to_string(),
            BUILT_IN.to_string(),
        ),
    };
    RatedAnswer {
        run,
        model: id,
        prompt,
        wrong: mark.is_some(),
        reason: mark,
        template: None,
    }
}

/// Moves on to the next answers, or to the next scenario.
pub fn next_round(model: &mut Model) -> Vec<Effect> {
    let Some(blind) = &mut model.compare.blind else {
        let key = model.look.key(Action::BlindMode);
        model.say(format!("{key} starts blind mode"));
        return Vec::new();
    };
    if !blind.left.is_empty() {
        next_group(model);
        return Vec::new();
    }
    if model.compare.unrated.is_none() {
        model.compare.going_on = true;
        return vec![find_unrated(model)];
    }
    next_scenario(model)
}

/// Opens the next scenario of the list, from the top again behind its end, on which two answers are left to rate.
fn next_scenario(model: &mut Model) -> Vec<Effect> {
    let known = model.compare.unrated.as_ref();
    let now = model.list.opened;
    let order = &model.list.visible;
    let at = now.and_then(|now| order.iter().position(|place| *place == now));
    let after = at.map_or(0, |at| at + 1);
    let around = order[after..].iter().chain(&order[..after]).copied();
    let left = |place: &usize| {
        let name = &model.list.rows[*place].entry.name;
        Some(*place) != now && known.is_some_and(|known| known.scenarios.contains_key(name))
    };
    let next = around.into_iter().find(left);
    let Some(next) = next.filter(|place| model.list.select(*place)) else {
        model.say("no more answers: no other scenario in the list has 2 unrated answers");
        return Vec::new();
    };
    debug_assert!(model.list.current() == Some(next));
    let effects = open_current(model);
    if let Some(blind) = &mut model.compare.blind {
        blind.waiting = true;
    }
    model.compare.show(Vec::new());
    effects
}

/// Keeps a rating of the answers of a round of the comparison.
#[derive(Debug)]
pub struct Rate {
    /// The round.
    pub round: u64,
    /// The rating.
    pub rating: Box<NewRating>,
    /// The number of the one in whose place it is kept.
    pub replaced: Option<i64>,
}

impl Request for Rate {
    /// The round, and the number under which it was kept, or why not.
    type Reply = (u64, Result<i64, String>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        services.with_store(replies, move |store| {
            let kept = store.and_then(|store| {
                let kept = match self.replaced {
                    None => store.rate(&self.rating),
                    Some(id) => store.rate_anew(id, &self.rating).map(|()| id),
                };
                kept.map_err(|error| error.to_string())
            });
            (self.round, kept)
        });
    }

    /// A rating was kept, or not.
    fn reply(model: &mut Model, (round, result): Self::Reply) -> Vec<Effect> {
        let compare = &mut model.compare;
        let mut keeping = compare.keeping.iter();
        let Some(place) = keeping.position(|keeping| keeping.round == round) else {
            return Vec::new();
        };
        let done = compare.keeping.remove(place);
        let here = compare.round == round;
        if let (Ok(number), true) = (&result, here) {
            compare.kept = Some((*number, done.choice));
        }
        if let Some(rating) = done.then {
            let replaced = result.ok().or(done.replaced);
            return send(model, round, rating, replaced);
        }
        match result {
            Ok(number) if done.replaced.is_some() => {
                model.tell(format!("rating {number} changed"));
                return vec![find_unrated(model)];
            }
            Ok(number) => {
                model.tell(format!("saved as rating {number}"));
                return vec![find_unrated(model)];
            }
            Err(error) => {
                if here {
                    compare.choice = compare.kept.map(|(_, choice)| choice);
                }
                model.complain(format!("rating not saved: {error}"));
            }
        }
        Vec::new()
    }
}

/// Reads every rating.
#[derive(Debug)]
pub struct ReadRatings;

impl Request for ReadRatings {
    type Reply = Result<Vec<Rating>, String>;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        services.with_store(replies, |store| {
            store.and_then(|store| store.ratings().map_err(|error| error.to_string()))
        });
    }

    fn reply(model: &mut Model, ratings: Self::Reply) -> Vec<Effect> {
        match ratings {
            Ok(ratings) => model.compare.ratings = Some(ratings),
            Err(error) => model.complain(error),
        }
        Vec::new()
    }
}

/// Finds out which answers to a task a person has not rated.
#[derive(Debug)]
pub struct FindUnrated {
    /// The task.
    pub task: Task,
    /// The person.
    pub person: String,
}

impl Request for FindUnrated {
    type Reply = Result<Unrated, String>;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        services.with_store(replies, move |store| {
            let unrated = store?.unrated(self.task, &self.person, judge::MODEL);
            unrated.map_err(|error| error.to_string())
        });
    }

    /// What is left to rate was read; a scenario that waited for that is opened.
    fn reply(model: &mut Model, result: Self::Reply) -> Vec<Effect> {
        match result {
            Ok(unrated) => model.compare.unrated = Some(unrated),
            Err(error) => {
                model.compare.going_on = false;
                model.complain(error);
            }
        }
        if std::mem::take(&mut model.compare.going_on) {
            return next_scenario(model);
        }
        // What was rated before is not shown again, unless the person is at it.
        let compare = &model.compare;
        let untouched = compare.choice.is_none() && compare.marks.iter().all(Option::is_none);
        if compare.open && compare.blind.is_some() && untouched {
            begin(model);
        }
        Vec::new()
    }
}
