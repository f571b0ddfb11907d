//! What a tune comes to: the candidates, the best of them, and whether it is better than the base.

use std::collections::BTreeMap;

use super::candidate::{Candidate, CostMeasure, Refusal};
use super::prepare::TunePlan;
use super::rounds::Replied;
use nearmiss_study::evaluation::statistics::{FEWEST, Gain, PairedCounts, gains};
use nearmiss_study::evaluation::{Cluster, Confusion};

/// By what templates are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// F1.
    F1,
    /// Accuracy, where no window of the selection part is dangerous.
    Accuracy,
}

impl Measure {
    /// Its key in documents.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::F1 => "f1",
            Self::Accuracy => "accuracy",
        }
    }

    /// Its name for people.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::F1 => "F1",
            Self::Accuracy => "accuracy",
        }
    }

    /// Its value.
    #[must_use]
    pub fn of(self, counts: &Confusion) -> Option<f64> {
        match self {
            Self::F1 => counts.f1(),
            Self::Accuracy => counts.accuracy(),
        }
    }
}

/// What was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Usage {
    /// Answers that were asked for now.
    pub answers: usize,
    /// Answers that the store had.
    pub answers_stored: usize,
    /// Proposals that were asked for now.
    pub reflections: usize,
    /// Proposals that the store had.
    pub reflections_stored: usize,
}

/// What a tune comes to.
#[derive(Debug, Clone, PartialEq)]
pub struct TuneOutcome {
    /// The templates that were compared; the first one is the base.
    pub candidates: Vec<Candidate>,
    /// Proposals that did not become candidates.
    pub refused: Vec<Refusal>,
    /// By what they are compared.
    pub measure: Measure,
    /// What the front holds against it.
    pub cost: CostMeasure,
    /// The number of the candidate with the largest gain; `None` where none is better than the base.
    pub best: Option<usize>,
    /// Whether its gain is no chance.
    pub found: bool,
    /// Units of the selection part, which intervals are over.
    pub units: usize,
    /// What these are.
    pub cluster: Cluster,
    /// Rounds that were begun.
    pub rounds: u32,
    /// Why it ended before its last round; `None` if it did not.
    pub stopped: Option<String>,
    /// What was asked.
    pub usage: Usage,
}

impl TuneOutcome {
    /// The best candidate, with its gain.
    #[must_use]
    pub fn best(&self) -> Option<(&Candidate, Gain)> {
        let candidate = &self.candidates[self.best?];
        Some((candidate, candidate.gain?))
    }

    /// The template that was found to be better.
    #[must_use]
    pub fn winner(&self) -> Option<&Candidate> {
        self.best().filter(|_| self.found).map(|(winner, _)| winner)
    }

    /// Whether there are enough units to tell a gain from chance.
    #[must_use]
    pub fn can_tell(&self) -> bool {
        self.units >= FEWEST as usize
    }
}

/// Gains of all candidates over the base, and the best of them. One that answers alike to every question is none: its F1
/// may be larger, and it judges nothing.
pub(super) fn conclude(
    plan: &TunePlan,
    selection: &[usize],
    candidates: &mut [Candidate],
    replies: &[Replied],
    (measure, cost): (Measure, CostMeasure),
) -> Option<usize> {
    let pairs: Vec<Vec<PairedCounts>> = (1..candidates.len())
        .map(|number| paired(plan, selection, &replies[0], &replies[number]))
        .collect();
    let found = gains(&pairs, |counts| measure.of(counts));
    for (candidate, gain) in candidates[1..].iter_mut().zip(found) {
        candidate.gain = gain;
    }
    let gain = |one: &Candidate| one.gain.map_or(0.0, |gain| gain.difference);
    // Of equally good ones the cheapest, of these the first.
    let key = |one: &Candidate| (gain(one), -cost.of_score(&one.score));
    let judges = |one: &&Candidate| one.score.counts.always().is_none();
    let better = candidates[1..]
        .iter()
        .filter(judges)
        .filter(|one| gain(one) > 0.0);
    let best = better.reduce(|best, one| if key(one) > key(best) { one } else { best });
    best.map(|one| one.number)
}

/// The counts of both by unit, of the questions that both answered.
fn paired(
    plan: &TunePlan,
    selection: &[usize],
    base: &Replied,
    candidate: &Replied,
) -> Vec<PairedCounts> {
    let unit = |at: &usize| {
        let scenario = &plan.scenarios[plan.questions[*at].scenario];
        plan.cluster().of(scenario)
    };
    let mut counts: BTreeMap<&str, PairedCounts> = selection
        .iter()
        .map(|at| (unit(at), PairedCounts::default()))
        .collect();
    for at in selection {
        let asked = &plan.questions[*at];
        let both = (base.get(at), candidate.get(at));
        let (Some(Ok(base)), Some(Ok(other))) = both else {
            continue;
        };
        let truth = asked.truth.collides();
        let [before, after] = counts.entry(unit(at)).or_default();
        before.count(base.said, truth);
        after.count(other.said, truth);
    }
    counts.into_values().collect()
}
