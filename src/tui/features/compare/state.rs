//! Full-screen comparison of answers, and a person's ratings of them.

use std::ops::Range;

use crate::model::{Column, Model, ShownAnswer};
use nearmiss_store::{Choice, NewRating, Rating, Unrated};

/// The screen of answers side by side.
#[derive(Debug, Default)]
pub struct Compare {
    /// Whether it is open.
    pub open: bool,
    /// The answers, from the left.
    pub shown: Vec<ShownAnswer>,
    /// The column that has the keys.
    pub focus: usize,
    /// Whether every column scrolls on its own.
    pub free: bool,
    /// The first line of every column; `None` while the end is followed.
    pub tops: Vec<Option<usize>>,
    /// Why columns are marked as wrong, by column.
    pub marks: Vec<Option<String>>,
    /// A reason is being given.
    pub marking: Option<Marking>,
    /// The choice among these answers.
    pub choice: Option<Choice>,
    /// Counts the answers that stood here together.
    pub round: u64,
    /// The rating of these answers in the store: its number, and what it says is chosen.
    pub kept: Option<(i64, Choice)>,
    /// Ratings that are on their way to the store.
    pub keeping: Vec<PendingRating>,
    /// Models are hidden until something was chosen.
    pub blind: Option<BlindMode>,
    /// The ratings, while their totals are displayed.
    pub ratings: Option<Vec<Rating>>,
    /// What the rater has rated and could rate; `None` until it is read.
    pub unrated: Option<Unrated>,
    /// Whether the next scenario is opened once that is read.
    pub going_on: bool,
    /// The rater.
    pub person: String,
    /// From where the seeds of shuffled orders come.
    pub seed: u64,
}

/// A rating on its way to the store.
#[derive(Debug, Clone, PartialEq)]
pub struct PendingRating {
    /// Of which answers, see [`Compare::round`].
    pub round: u64,
    /// The choice.
    pub choice: Choice,
    /// The rating in the store whose place it takes.
    pub replaced: Option<i64>,
    /// A newer rating of the same answers, which replaces this one.
    pub then: Option<Box<NewRating>>,
}

/// Blind mode.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BlindMode {
    /// Groups of answers that are still to be rated on this scenario, the next one last.
    pub left: Vec<Vec<ShownAnswer>>,
    /// Answers side by side, where the person chose how many; else as many as there are and fit.
    pub size: Option<usize>,
    /// Seed of the order of the present ones.
    pub seed: i64,
    /// The answers on the next scenario are waited for.
    pub waiting: bool,
}

/// A reason why an answer is wrong, while it is given.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct Marking {
    /// Which of [`REASONS`] is selected.
    pub selected: usize,
    /// The note typed beside it.
    pub text: String,
}

/// Why an answer may be wrong.
pub const REASONS: [&str; 6] = [
    "wrong verdict",
    "wrong obstacle",
    "wrong numbers",
    "wrong reasoning",
    "contradicts itself",
    "no answer to the question",
];

/// Answers side by side at most.
pub const MAX_COMPARED: usize = 4;

/// Columns of the terminal that an answer needs.
pub const NARROWEST: u16 = 38;

impl Compare {
    /// Whether the models must not be seen.
    #[must_use]
    pub fn hides(&self) -> bool {
        self.open && self.blind.is_some() && self.choice.is_none()
    }

    /// Begins with other answers, from their beginnings.
    pub fn show(&mut self, shown: Vec<ShownAnswer>) {
        self.tops = vec![Some(0); shown.len()];
        self.marks = vec![None; shown.len()];
        self.marking = None;
        self.begin_round();
        self.focus = self.focus.min(shown.len().saturating_sub(1));
        self.shown = shown;
    }

    /// Other answers stand here now, of which nothing was chosen.
    pub fn begin_round(&mut self) {
        self.choice = None;
        self.kept = None;
        self.round += 1;
    }

    /// A seed that was not used before.
    pub fn next_seed(&mut self) -> i64 {
        self.seed = self.seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed(self.seed).cast_signed()
    }
}

/// SplitMix64 (Steele, Lea and Flood 2014): what follows from a state.
fn mixed(state: u64) -> u64 {
    let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Puts items into the order of a seed (Fisher and Yates).
pub fn shuffle<T>(items: &mut [T], seed: i64) {
    let mut state = seed.cast_unsigned();
    for last in (1..items.len()).rev() {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let choices = u64::try_from(last).unwrap_or(0) + 1;
        let place = usize::try_from(mixed(state) % choices).unwrap_or(0);
        items.swap(last, place);
    }
}

impl Model {
    /// Complete answers of models that the person has not rated, by their places.
    #[must_use]
    pub fn to_rate(&self) -> Vec<usize> {
        let rated = self.compare.unrated.as_ref().map(|unrated| &unrated.rated);
        let wanted = |column: &Column| {
            let is_rated = |run| rated.is_some_and(|rated| rated.contains(&run));
            let answer = column.answer().filter(|_| !column.failed());
            answer.is_some_and(|answer| !answer.run.is_some_and(is_rated))
        };
        let columns = self.answers.columns.iter().enumerate();
        columns
            .filter(|(_, column)| wanted(column))
            .map(|(place, _)| place)
            .collect()
    }

    /// How many answers fit side by side.
    #[must_use]
    pub fn fit_side_by_side(&self) -> usize {
        usize::from(self.size.0 / NARROWEST).clamp(1, MAX_COMPARED)
    }

    /// Everything that can be shown side by side: the answers of models, the built-in judge's last.
    #[must_use]
    pub fn comparable(&self) -> Vec<ShownAnswer> {
        let columns = 0..self.answers.columns.len();
        let judge = self.has_reference().then_some(ShownAnswer::Reference);
        columns.map(ShownAnswer::Column).chain(judge).collect()
    }

    /// The places of the answers that are in sight: as many as fit, the one that has the keys among them.
    #[must_use]
    pub fn seen_side_by_side(&self) -> Range<usize> {
        let (fit, count) = (self.fit_side_by_side(), self.compare.shown.len());
        let last_first = count.saturating_sub(fit);
        let first = last_first.min(self.compare.focus.saturating_sub(fit - 1));
        first..(first + fit).min(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_is_an_order_and_orders_differ() {
        let order = |seed| {
            let mut all = [0, 1, 2, 3];
            shuffle(&mut all, seed);
            all
        };
        assert_eq!(order(5), order(5));
        let all: std::collections::BTreeSet<_> = (0..500).map(order).collect();
        assert_eq!(all.len(), 24, "every order comes up");
        let mut compare = Compare::default();
        assert_ne!(compare.next_seed(), compare.next_seed());
    }
}
