//! One cell of a report: a prompt configuration on half of the data or all of it.

use super::super::statistics::{Calibration, Kappa, ShareIntervals};
use super::super::{
    AnswerStatus, Cluster, Confusion, Naming, NamingIntervals, ProbabilitySource, PromptConfig,
    Scored, probability,
};
use super::claims::ClaimTally;
use super::consumption::{Consumption, count};
use super::votes::{Ballot, Samples};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Verdict;

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

/// Results of one prompt configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The way.
    pub way: PromptConfig,
    /// Which answers are counted.
    pub half: DataHalf,
    /// The unit of its intervals.
    pub cluster: Cluster,
    /// Scenarios asked about.
    pub scenarios: u32,
    /// Questions: each sample of each scenario, answered or not.
    pub n: u32,
    /// Verdicts beside the truth.
    pub confusion: Confusion,
    /// Questions with a truth that were asked.
    pub asked: u32,
    /// Of them those that are dangerous in truth.
    pub dangerous: u32,
    /// Of those asked those whose verdict is right.
    pub right: u32,
    /// Answers without a verdict.
    pub unparsed: u32,
    /// Questions that were asked and have no whole answer.
    pub failed: u32,
    /// Questions that were not asked, or not yet.
    pub unasked: u32,
    /// Verdicts on scenarios without a truth: neither right nor wrong.
    pub unlabelled: u32,
    /// Intervals of 95 %; those of precision and F1 of whole ways alone.
    pub intervals: ShareIntervals,
    /// Agreement with the built-in judge in yes and no; `None` if its verdict is not known, and of itself.
    pub kappa: Option<Kappa>,
    /// Named obstacles beside those that are truly critical.
    pub naming: Naming,
    /// Intervals of its shares.
    pub naming_intervals: NamingIntervals,
    /// The probabilities of all verdicts beside the truth.
    pub calibration: Calibration,
    /// How many of these probabilities are from each source, in the order of [`ProbabilitySource::ALL`].
    pub sources: [u32; ProbabilitySource::ALL.len()],
    /// The probabilities by log probabilities, of the verdicts that have one, beside the truth.
    pub token_calibration: Calibration,
    /// What several samples of the same questions come to.
    pub samples: Samples,
    /// Time, tokens and cost.
    pub consumption: Consumption,
    /// Claims about obstacles.
    pub claims: ClaimTally,
    /// Verdicts that are doubtful by themselves.
    pub flagged: Flagged,
}

/// Verdicts that are doubtful by themselves: see [`Verdict::flags`](nearmiss_scene::verdict::Verdict::flags).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Flagged {
    /// Those that contradict themselves.
    pub contradictory: u32,
    /// Those that name an obstacle twice.
    pub twice: u32,
    /// Those that name an obstacle that the scene does not have.
    pub unknown: u32,
}

impl Flagged {
    fn count(&mut self, verdict: &Verdict) {
        self.contradictory += u32::from(!verdict.contradictions().is_empty());
        self.twice += u32::from(!verdict.named_twice().is_empty());
        self.unknown += u32::from(!verdict.unknown.is_empty());
    }
}

impl Cell {
    /// Counts the answers of one way.
    pub(super) fn count(way: &PromptConfig, half: DataHalf, scored: &[&Scored]) -> Self {
        let mut cell = Self {
            way: way.clone(),
            half,
            cluster: scored
                .first()
                .map_or_else(Cluster::default, |one| one.cluster),
            scenarios: 0,
            n: count(scored.len()),
            confusion: Confusion::default(),
            asked: 0,
            dangerous: 0,
            right: 0,
            unparsed: 0,
            failed: 0,
            unasked: 0,
            unlabelled: 0,
            intervals: ShareIntervals::default(),
            kappa: None,
            naming: Naming::default(),
            naming_intervals: NamingIntervals::from_scored(scored.iter().copied()),
            calibration: Calibration::default(),
            sources: [0; ProbabilitySource::ALL.len()],
            token_calibration: Calibration::default(),
            samples: Samples::default(),
            consumption: Consumption::from_scored(scored),
            claims: ClaimTally::count(scored),
            flagged: Flagged::default(),
        };
        let mut ballot = Ballot::default();
        let mut both = [0; 4];
        for one in scored {
            ballot.take(one, one.positive());
            cell.take(one, &mut both);
        }
        cell.kappa = Kappa::from_counts(both);
        cell.scenarios = ballot.scenarios();
        cell.samples = ballot.samples();
        cell.intervals = ballot.intervals();
        if half != DataHalf::All {
            (cell.intervals.precision, cell.intervals.f1) = (None, None);
        }
        cell
    }

    fn take(&mut self, one: &Scored, both: &mut [u32; 4]) {
        if let Some(right) = one.is_right() {
            self.asked += 1;
            self.dangerous += u32::from(one.is_collision() == Some(true));
            self.right += u32::from(right);
        }
        let verdict = match &one.status {
            AnswerStatus::Verdict(verdict) => verdict,
            AnswerStatus::Unparsed(_) => return self.unparsed += 1,
            AnswerStatus::Failed(_) => return self.failed += 1,
            AnswerStatus::Unasked(_) => return self.unasked += 1,
        };
        let said = verdict.dangerous;
        // A judge agrees with itself.
        let reference = one.reference.as_ref();
        if one.way.model != judge::MODEL {
            self.flagged.count(verdict);
        }
        if let Some(reference) = reference.filter(|_| one.way.model != judge::MODEL) {
            let place = 2 * usize::from(!said) + usize::from(!reference.dangerous);
            both[place] += 1;
        }
        let Some(truth) = one.is_collision() else {
            self.unlabelled += 1;
            return;
        };
        self.confusion.count(said, truth);
        self.naming.count(one);
        let (probability, source) = probability(verdict);
        self.calibration.count(probability, truth);
        self.sources[source as usize] += 1;
        if let Some(probability) = verdict.token_probability {
            self.token_calibration.count(probability, truth);
        }
    }

    /// The share of the questions asked that it is right about: the main figure. Who has no verdict is not right.
    #[must_use]
    pub fn right_of_all(&self) -> Option<f64> {
        (self.asked > 0).then(|| f64::from(self.right) / f64::from(self.asked))
    }

    /// The share of the questions asked that have no verdict.
    #[must_use]
    pub fn without_verdict(&self) -> Option<f64> {
        let without = self.asked - self.confusion.answered();
        (self.asked > 0).then(|| f64::from(without) / f64::from(self.asked))
    }

    /// How many probabilities are from a source.
    #[must_use]
    pub fn source(&self, source: ProbabilitySource) -> u32 {
        self.sources[source as usize]
    }

    /// Precision, of whole ways: where one half of the data is missing, it says nothing.
    #[must_use]
    pub fn precision(&self) -> Option<f64> {
        self.whole().and_then(|c| c.precision())
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
