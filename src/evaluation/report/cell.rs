//! One cell of a report: a prompt configuration on half of the data or all of it.

use std::collections::BTreeMap;

use super::super::answer::NOT_SENT;
use super::super::statistics::{
    AnswerAgreement, Calibration, Interval, Kappa, f1_interval, majority, shown, wilson,
};
use super::super::{AnswerStatus, Confusion, Label, PromptConfig, Scored, names_obstacle};
use super::consumption::{Consumption, count};
use crate::judge;
use crate::store::Consumed;

/// The half of the data that a cell counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataHalf {
    /// Those about scenarios that collide.
    Collision,
    /// Those about scenarios that do not.
    Normal,
    /// Those about scenarios whose truth is unknown.
    Unknown,
    /// All of them.
    All,
}

impl DataHalf {
    /// Every one, in the order of reports.
    pub const ALL: [Self; 4] = [Self::Collision, Self::Normal, Self::Unknown, Self::All];

    /// The word for it in reports: the label.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Collision => "collision",
            Self::Normal => "normal",
            Self::Unknown => "unknown",
            Self::All => "all",
        }
    }

    /// Whether an answer is counted.
    #[must_use]
    pub fn holds(self, scored: &Scored) -> bool {
        match self {
            Self::Collision => scored.is_collision() == Some(true),
            Self::Normal => scored.is_collision() == Some(false),
            Self::Unknown => scored.is_collision().is_none(),
            Self::All => true,
        }
    }
}

/// Counts of how often the colliding obstacle is named.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NamingCounts {
    /// Verdicts on collisions whose obstacle is known.
    pub n: u32,
    /// Of them those that name it as the danger, see [`crate::evaluation::named_obstacles`].
    pub right: u32,
    /// Of them those that give no obstacle a graver score.
    pub first: u32,
}

/// Results of one prompt configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The way.
    pub way: PromptConfig,
    /// Which answers are counted.
    pub half: DataHalf,
    /// Scenarios asked about.
    pub scenarios: u32,
    /// Questions: each sample of each scenario, answered or not.
    pub n: u32,
    /// Verdicts beside the truth.
    pub confusion: Confusion,
    /// Answers without a verdict.
    pub unparsed: u32,
    /// Questions that were asked and have no whole answer.
    pub failed: u32,
    /// Questions that were not asked, or not yet.
    pub unasked: u32,
    /// Verdicts on scenarios without a truth: neither right nor wrong.
    pub unlabelled: u32,
    /// Of the false negatives those that say yes and do not name the obstacle of the truth, see [`Scored::positive`].
    pub wrong_obstacle: u32,
    /// The bootstrap interval of F1, over scenarios; of whole ways alone.
    pub f1_interval: Option<Interval>,
    /// Agreement with the built-in judge in yes and no; `None` if its verdict is not known, and of itself.
    pub kappa: Option<Kappa>,
    /// The obstacle that collides.
    pub named: NamingCounts,
    /// Risk scores beside the truth.
    pub calibration: Calibration,
    /// Agreement of several samples.
    pub spread: AnswerAgreement,
    /// The majority of samples for each scenario, against the ground truth.
    pub majority: Confusion,
    /// Scenarios whose samples say yes and no equally often, or nothing at all: no vote.
    pub undecided: u32,
    /// Time, tokens and cost.
    pub consumption: Consumption,
}

/// The verdicts on one scenario.
#[derive(Default)]
struct Votes {
    truth: Option<bool>,
    yes: u32,
    no: u32,
    counts: Confusion,
}

/// What a question took; `None` if it was not asked. The built-in judge, and what was not sent, cost nothing, which
/// is known.
fn taken(one: &Scored) -> Option<Consumed> {
    let free = match &one.status {
        AnswerStatus::Unasked(_) => return None,
        AnswerStatus::Failed(why) => why.starts_with(NOT_SENT),
        AnswerStatus::Verdict(_) | AnswerStatus::Unparsed(_) => false,
    };
    let free = free || one.way.model == judge::MODEL;
    let cost_usd = one.consumed.cost_usd.or(free.then_some(0.0));
    Some(Consumed {
        cost_usd,
        ..one.consumed
    })
}

/// The Wilson interval of a proportion, where enough answers stand behind it.
fn proportion(hits: u32, all: u32) -> Option<Interval> {
    shown(wilson(hits, all), all)
}

impl Cell {
    /// Counts the answers of one way.
    pub(super) fn count(way: &PromptConfig, half: DataHalf, scored: &[&Scored]) -> Self {
        let taken: Vec<Consumed> = scored.iter().copied().filter_map(taken).collect();
        let mut cell = Self {
            way: way.clone(),
            half,
            scenarios: 0,
            n: count(scored.len()),
            confusion: Confusion::default(),
            unparsed: 0,
            failed: 0,
            unasked: 0,
            unlabelled: 0,
            wrong_obstacle: 0,
            f1_interval: None,
            kappa: None,
            named: NamingCounts::default(),
            calibration: Calibration::default(),
            spread: AnswerAgreement::default(),
            majority: Confusion::default(),
            undecided: 0,
            consumption: Consumption::from_answers(taken.iter()),
        };
        let mut votes: BTreeMap<&str, Votes> = BTreeMap::new();
        let mut both = [0; 4];
        for one in scored {
            let votes = votes.entry(&one.scenario).or_default();
            votes.truth = votes.truth.or(one.is_collision());
            cell.take(one, votes, &mut both);
        }
        cell.kappa = Kappa::from_counts(both);
        cell.scenarios = count(votes.len());
        for vote in votes.values() {
            cell.spread.count(vote.yes, vote.no);
            match (majority(vote.yes, vote.no), vote.truth) {
                (Some(said), Some(truth)) => cell.majority.count(said, truth),
                (None, Some(_)) => cell.undecided += 1,
                (_, None) => {}
            }
        }
        if half == DataHalf::All {
            let counts: Vec<Confusion> = votes.values().map(|v| v.counts).collect();
            let counted: Vec<Confusion> = counts.into_iter().filter(|c| c.answered() > 0).collect();
            cell.f1_interval = shown(f1_interval(&counted), count(counted.len()));
        }
        cell
    }

    fn take(&mut self, one: &Scored, votes: &mut Votes, both: &mut [u32; 4]) {
        let verdict = match &one.status {
            AnswerStatus::Verdict(verdict) => verdict,
            AnswerStatus::Unparsed(_) => return self.unparsed += 1,
            AnswerStatus::Failed(_) => return self.failed += 1,
            AnswerStatus::Unasked(_) => return self.unasked += 1,
        };
        let said = one.positive().unwrap_or(verdict.dangerous);
        match said {
            true => votes.yes += 1,
            false => votes.no += 1,
        }
        // Against the judge a yes counts whichever obstacle is named; a judge agrees with itself.
        let reference = one.reference.as_ref();
        if let Some(reference) = reference.filter(|_| one.way.model != judge::MODEL) {
            let place = 2 * usize::from(!verdict.dangerous) + usize::from(!reference.dangerous);
            both[place] += 1;
        }
        let Some(truth) = one.is_collision() else {
            self.unlabelled += 1;
            return;
        };
        self.confusion.count(said, truth);
        self.wrong_obstacle += u32::from(truth && verdict.dangerous && !said);
        votes.counts.count(said, truth);
        if let Some(worst) = verdict.worst() {
            self.calibration.count(worst.risk_score, truth);
            if let Some(Label::Collision(Some(who))) = one.truth {
                let its = verdict.obstacles.iter().find(|o| o.id == who);
                let first = its.is_some_and(|o| o.risk_score <= worst.risk_score);
                self.named.first += u32::from(first);
            }
        }
        if let Some(Label::Collision(Some(who))) = one.truth {
            self.named.n += 1;
            self.named.right += u32::from(names_obstacle(verdict, who));
        }
    }

    /// Precision, of whole ways: where one half of the data is missing, it says nothing.
    #[must_use]
    pub fn precision(&self) -> Option<f64> {
        self.whole().and_then(|c| c.precision())
    }

    /// The Wilson interval of the precision.
    #[must_use]
    pub fn precision_interval(&self) -> Option<Interval> {
        let c = self.whole()?;
        proportion(c.true_positives, c.true_positives + c.false_positives)
    }

    /// The Wilson interval of the recall.
    #[must_use]
    pub fn recall_interval(&self) -> Option<Interval> {
        proportion(self.confusion.true_positives, self.confusion.positives())
    }

    /// The Wilson interval of the specificity.
    #[must_use]
    pub fn specificity_interval(&self) -> Option<Interval> {
        proportion(self.confusion.true_negatives, self.confusion.negatives())
    }

    /// The Wilson interval of the accuracy.
    #[must_use]
    pub fn accuracy_interval(&self) -> Option<Interval> {
        let c = &self.confusion;
        proportion(c.true_positives + c.true_negatives, c.answered())
    }

    /// F1, of whole ways.
    #[must_use]
    pub fn f1(&self) -> Option<f64> {
        self.whole().and_then(|c| c.f1())
    }

    fn whole(&self) -> Option<&Confusion> {
        (self.half == DataHalf::All).then_some(&self.confusion)
    }
}
