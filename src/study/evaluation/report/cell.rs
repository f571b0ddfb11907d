//! One cell of a report: a prompt configuration on half of the data or all of it.

use schemars::JsonSchema;
use serde::Serialize;

use super::super::statistics::{Interval, Kappa};
use super::super::{
    AnswerStatus, Cluster, Confusion, Naming, NamingIntervals, PromptConfig, Scored, probability,
};
use super::calibration_row::{CalibrationRow, Counted, SourcedCalibration};
use super::claims::ClaimTally;
use super::consumption::{Consumption, count};
use super::votes::{Ballot, Samples};
use nearmiss_record::Record;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Verdict;

/// The half of the data that a cell counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
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
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Cell {
    /// Which answers are counted.
    #[serde(rename = "label")]
    pub half: DataHalf,
    /// The way.
    #[serde(flatten)]
    pub way: PromptConfig,
    /// The unit of its intervals.
    #[serde(skip)]
    pub cluster: Cluster,
    /// Questions: each sample of each scenario, answered or not.
    #[schemars(title = "n", extend("table" = "accuracy"))]
    pub n: u32,
    /// Verdicts beside the truth.
    #[serde(flatten)]
    pub confusion: Confusion,
    /// Answers without a verdict.
    #[schemars(title = "Unparsed", extend("table" = "accuracy"))]
    pub unparsed: u32,
    /// Questions that were asked and have no whole answer.
    #[schemars(title = "Failed", extend("table" = "accuracy"))]
    pub failed: u32,
    /// Questions that were not asked, or not yet.
    #[schemars(title = "Not asked", extend("table" = "accuracy", "rare" = true))]
    pub unasked: u32,
    /// Verdicts on scenarios without a truth: neither right nor wrong.
    #[schemars(title = "No truth", extend("table" = "accuracy", "rare" = true))]
    pub unlabelled: u32,
    /// Scenarios asked about.
    pub scenarios: u32,
    /// Questions with a truth that were asked.
    pub asked: u32,
    /// Of them those that are dangerous in truth.
    #[serde(rename = "asked_dangerous")]
    pub dangerous: u32,
    /// Of those asked those whose verdict is right.
    pub right: u32,
    /// The share of the questions asked that it is right about: the main figure. Who has no verdict is not right.
    #[schemars(title = "Right of all", extend("table" = "accuracy", "decimals" = 2))]
    pub right_of_all: Option<f64>,
    /// Its interval of 95 %.
    pub right_of_all_ci: Option<Interval>,
    /// tp / (tp + fp), of whole ways: where one half of the data is missing, it says nothing.
    #[schemars(title = "Precision", extend("table" = "accuracy", "decimals" = 2))]
    pub precision: Option<f64>,
    /// Its interval of 95 %.
    pub precision_ci: Option<Interval>,
    /// tp / (tp + fn).
    #[schemars(title = "Recall", extend("table" = "accuracy", "decimals" = 2))]
    pub recall: Option<f64>,
    /// Its interval of 95 %.
    pub recall_ci: Option<Interval>,
    /// tn / (tn + fp).
    #[schemars(title = "Specificity", extend("table" = "accuracy", "decimals" = 2))]
    pub specificity: Option<f64>,
    /// Its interval of 95 %.
    pub specificity_ci: Option<Interval>,
    /// The share of verdicts that are right.
    #[schemars(title = "Accuracy", extend("table" = "accuracy", "decimals" = 2))]
    pub accuracy: Option<f64>,
    /// Its interval of 95 %.
    pub accuracy_ci: Option<Interval>,
    /// Harmonic mean of precision and recall, of whole ways.
    #[schemars(title = "F1", extend("table" = "accuracy", "decimals" = 2))]
    pub f1: Option<f64>,
    /// Its interval of 95 %.
    pub f1_ci: Option<Interval>,
    /// Verdicts on dangerous windows whose critical obstacles are known.
    #[schemars(title = "Windows", extend("table" = "agreement"))]
    pub named_of: u32,
    /// Of them those that name one of these obstacles.
    pub named: u32,
    /// Their share.
    #[schemars(title = "Obstacle named", extend("table" = "agreement", "decimals" = 2))]
    pub naming_recall: Option<f64>,
    /// Its interval of 95 %.
    pub naming_recall_ci: Option<Interval>,
    /// Of them those that give one of these obstacles the gravest risk score.
    #[schemars(title = "Named worst", extend("table" = "agreement"))]
    pub named_first: u32,
    /// Obstacles named by verdicts, over these windows and the safe ones.
    #[schemars(title = "Names", extend("table" = "agreement"))]
    pub obstacles_named: u32,
    /// Of them those that are truly critical; on a safe window none is.
    pub obstacles_named_right: u32,
    /// Their share.
    #[schemars(title = "Names right", extend("table" = "agreement", "decimals" = 2))]
    pub naming_precision: Option<f64>,
    /// Its interval of 95 %.
    pub naming_precision_ci: Option<Interval>,
    /// Cohen's kappa of yes and no beside the built-in judge; null if its verdict is not known, and of itself.
    #[schemars(title = "κ with judge", extend("table" = "agreement", "decimals" = 2))]
    pub kappa: Option<f64>,
    /// Its interval of 95 %.
    pub kappa_ci: Option<Interval>,
    /// Questions that both answered.
    pub kappa_n: Option<u32>,
    /// The share of them on which both say the same.
    #[schemars(title = "Same verdict", extend("table" = "agreement", "decimals" = 2))]
    pub agreement_with_reference: Option<f64>,
    /// The probabilities of all verdicts beside the truth.
    #[schemars(extend("table" = "calibration"))]
    pub calibration: SourcedCalibration,
    /// The probabilities by log probabilities, of the verdicts that have one, beside the truth.
    #[schemars(extend("table" = "log-probabilities"))]
    pub token_calibration: CalibrationRow,
    /// What several samples of the same questions come to.
    #[schemars(extend("table" = "samples"))]
    pub samples: Samples,
    /// Time, tokens and cost.
    #[serde(flatten)]
    pub consumption: Consumption,
    /// Claims about obstacles.
    #[serde(flatten)]
    pub claims: ClaimTally,
    /// Verdicts that are doubtful by themselves.
    #[serde(flatten)]
    pub flagged: Flagged,
}

impl Record for Cell {
    const NAME: &'static str = "cell";
    const TITLE: &'static str = "Results of one prompt configuration";
}

/// Verdicts that are doubtful by themselves: see [`Verdict::flags`](nearmiss_scene::verdict::Verdict::flags).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct Flagged {
    /// Verdicts that contradict themselves.
    pub contradictory: u32,
    /// Verdicts that name an obstacle twice.
    #[serde(rename = "named_twice")]
    pub twice: u32,
    /// Verdicts that name an obstacle that the scene does not have.
    #[serde(rename = "unknown_obstacles")]
    pub unknown: u32,
}

impl Flagged {
    fn count(&mut self, verdict: &Verdict) {
        self.contradictory += u32::from(!verdict.contradictions().is_empty());
        self.twice += u32::from(!verdict.named_twice().is_empty());
        self.unknown += u32::from(!verdict.unknown.is_empty());
    }
}

/// What is counted answer by answer.
#[derive(Default)]
struct Tally {
    confusion: Confusion,
    asked: u32,
    dangerous: u32,
    right: u32,
    unparsed: u32,
    failed: u32,
    unasked: u32,
    unlabelled: u32,
    /// Beside the built-in judge: both yes, yes and no, no and yes, both no.
    both: [u32; 4],
    naming: Naming,
    probabilities: Counted,
    flagged: Flagged,
}

impl Cell {
    /// Counts the answers of one way.
    pub(super) fn count(way: &PromptConfig, half: DataHalf, scored: &[&Scored]) -> Self {
        let mut ballot = Ballot::default();
        let mut tally = Tally::default();
        for one in scored {
            ballot.take(one, one.positive());
            tally.take(one);
        }
        let whole = half == DataHalf::All;
        let (c, naming) = (&tally.confusion, &tally.naming);
        let (calibration, token_calibration) = tally.probabilities.rows();
        let kappa = Kappa::from_counts(tally.both);
        let scenarios = ballot.scenarios();
        let intervals = ballot.intervals();
        let of_naming = NamingIntervals::from_scored(scored.iter().copied());
        Self {
            half,
            way: way.clone(),
            cluster: scored
                .first()
                .map_or_else(Cluster::default, |one| one.cluster),
            n: count(scored.len()),
            confusion: *c,
            unparsed: tally.unparsed,
            failed: tally.failed,
            unasked: tally.unasked,
            unlabelled: tally.unlabelled,
            scenarios,
            asked: tally.asked,
            dangerous: tally.dangerous,
            right: tally.right,
            right_of_all: (tally.asked > 0)
                .then(|| f64::from(tally.right) / f64::from(tally.asked)),
            right_of_all_ci: intervals.right,
            precision: c.precision().filter(|_| whole),
            precision_ci: intervals.precision.filter(|_| whole),
            recall: c.recall(),
            recall_ci: intervals.recall,
            specificity: c.specificity(),
            specificity_ci: intervals.specificity,
            accuracy: c.accuracy(),
            accuracy_ci: intervals.accuracy,
            f1: c.f1().filter(|_| whole),
            f1_ci: intervals.f1.filter(|_| whole),
            named_of: naming.windows,
            named: naming.found,
            naming_recall: naming.recall(),
            naming_recall_ci: of_naming.recall,
            named_first: naming.first,
            obstacles_named: naming.named,
            obstacles_named_right: naming.right,
            naming_precision: naming.precision(),
            naming_precision_ci: of_naming.precision,
            kappa: kappa.and_then(|k| k.kappa),
            kappa_ci: kappa.and_then(|k| k.interval),
            kappa_n: kappa.map(|k| k.n),
            agreement_with_reference: kappa.map(|k| k.agreement),
            calibration,
            token_calibration,
            samples: ballot.samples(c.f1().filter(|_| whole).is_some()),
            consumption: Consumption::from_scored(scored),
            claims: ClaimTally::count(scored),
            flagged: tally.flagged,
        }
    }

    /// The share of the questions asked that have no verdict.
    #[must_use]
    pub fn without_verdict(&self) -> Option<f64> {
        let without = self.asked - self.confusion.answered();
        (self.asked > 0).then(|| f64::from(without) / f64::from(self.asked))
    }
}

impl Tally {
    fn take(&mut self, one: &Scored) {
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
            self.both[place] += 1;
        }
        let Some(truth) = one.is_collision() else {
            self.unlabelled += 1;
            return;
        };
        self.confusion.count(said, truth);
        self.naming.count(one);
        self.probabilities
            .count(probability(verdict), verdict.token_probability, truth);
    }
}
