//! One cell of a report: a prompt configuration on half of the data or all of it, with probabilities, claims, consumption.

use std::collections::BTreeMap;

use nearmiss_record::Record;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Verdict;
use nearmiss_store::Consumed;
use schemars::JsonSchema;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

use super::super::statistics::{
    Bin, Calibration, Interval, Kappa, if_enough, quantile, ratio_interval,
};
use super::super::{
    AnswerStatus, Cluster, Confusion, Naming, NamingIntervals, ProbabilitySource, PromptConfig,
    Scored, Spending, probability,
};
use super::comparison::{Ballot, Samples};

/// The half of the data that a cell counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema, IntoStaticStr, VariantArray)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
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

nearmiss_record::named!(DataHalf);

impl DataHalf {
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
    pub configuration: PromptConfig,
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
    pub(super) fn count(configuration: &PromptConfig, half: DataHalf, scored: &[&Scored]) -> Self {
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
            configuration: configuration.clone(),
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
        if one.configuration.model != judge::MODEL {
            self.flagged.count(verdict);
        }
        if let Some(reference) = reference.filter(|_| one.configuration.model != judge::MODEL) {
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

/// Probabilities beside the truth.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct CalibrationRow {
    /// Verdicts with a truth and such a probability.
    #[schemars(title = "Verdicts")]
    pub n: u32,
    /// The mean square of what the probabilities miss.
    #[schemars(title = "Brier", extend("decimals" = 3))]
    pub brier: Option<f64>,
    /// The probability that a yes in truth has a higher one than a no.
    #[schemars(title = "AUROC", extend("decimals" = 3))]
    pub auroc: Option<f64>,
    /// The expected calibration error, of ten bins.
    #[schemars(title = "ECE", extend("decimals" = 3))]
    pub expected_error: Option<f64>,
    /// By tenths of the probability: verdicts, those of a yes in truth, and the mean probability.
    pub bins: Vec<Bin>,
}

/// Where the probabilities are from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct ProbabilitySources {
    /// Those that the answer states.
    #[schemars(title = "Stated")]
    pub from_stated: u32,
    /// Those of the largest of its critical obstacles.
    #[schemars(title = "Of obstacles")]
    pub from_critical: u32,
    /// Those of log probabilities.
    #[schemars(title = "Of tokens")]
    pub from_token: u32,
    /// Those of the gravest risk score.
    #[schemars(title = "Of scores")]
    pub from_score: u32,
    /// Those of yes or no, 1 or 0.
    #[schemars(title = "Of yes or no")]
    pub from_decision: u32,
}

/// The probabilities of all verdicts beside the truth.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct SourcedCalibration {
    /// How well they fit.
    #[serde(flatten)]
    pub fit: CalibrationRow,
    /// Where they are from.
    #[serde(flatten)]
    pub sources: ProbabilitySources,
}

impl From<&Calibration> for CalibrationRow {
    fn from(all: &Calibration) -> Self {
        Self {
            n: all.n(),
            brier: all.brier(),
            auroc: all.auroc(),
            expected_error: all.error(),
            bins: all.bins().to_vec(),
        }
    }
}

/// Probabilities, counted one by one.
#[derive(Default)]
pub(super) struct Counted {
    all: Calibration,
    tokens: Calibration,
    sources: ProbabilitySources,
}

impl Counted {
    /// Counts the probability of a verdict and its source, and that of its log probabilities.
    pub fn count(
        &mut self,
        (probability, source): (f64, ProbabilitySource),
        token: Option<f64>,
        truth: bool,
    ) {
        self.all.count(probability, truth);
        let of = &mut self.sources;
        *match source {
            ProbabilitySource::Stated => &mut of.from_stated,
            ProbabilitySource::Critical => &mut of.from_critical,
            ProbabilitySource::Token => &mut of.from_token,
            ProbabilitySource::Score => &mut of.from_score,
            ProbabilitySource::Decision => &mut of.from_decision,
        } += 1;
        if let Some(probability) = token {
            self.tokens.count(probability, truth);
        }
    }

    /// Of all verdicts, and of log probabilities alone.
    pub fn rows(&self) -> (SourcedCalibration, CalibrationRow) {
        let all = SourcedCalibration {
            fit: (&self.all).into(),
            sources: self.sources,
        };
        (all, (&self.tokens).into())
    }
}

/// Claims of the answers of a cell.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct ClaimTally {
    /// Answers whose claims were checked.
    #[serde(rename = "claims_of")]
    #[schemars(title = "Checked", extend("table" = "claims"))]
    pub answers: u32,
    /// Answers that were not checked, as their scenario was not at hand.
    #[serde(rename = "claims_unchecked")]
    #[schemars(title = "Not checked", extend("table" = "claims"))]
    pub unchecked: u32,
    /// Claims about obstacles that hold; null if none was checked.
    #[serde(rename = "claims_right")]
    #[schemars(title = "Right", extend("table" = "claims"))]
    pub right: Option<u32>,
    /// Claims that do not hold; null if none was checked.
    #[serde(rename = "claims_wrong")]
    #[schemars(title = "Wrong", extend("table" = "claims"))]
    pub wrong: Option<u32>,
    /// Claims that cannot be decided; null if none was checked.
    #[serde(rename = "claims_open")]
    #[schemars(title = "Open", extend("table" = "claims"))]
    pub open: Option<u32>,
    /// Wrong numbers that the question does not have; null where no answer has a question of text alone.
    #[serde(rename = "claims_invented")]
    #[schemars(title = "Invented", extend("table" = "claims"))]
    pub invented: Option<u32>,
    /// Sentences that say something of the scene; null if none was checked.
    #[schemars(title = "Sentences", extend("table" = "claims"))]
    pub sentences: Option<u32>,
    /// Of them those that contradict another one.
    #[serde(rename = "sentences_contradictory")]
    #[schemars(title = "Contradictory", extend("table" = "claims"))]
    pub contradictory: Option<u32>,
    /// The share of sentences that were not understood.
    #[serde(rename = "sentences_not_understood_share")]
    #[schemars(title = "Not understood", extend("table" = "claims", "decimals" = 2))]
    pub not_understood_share: Option<f64>,
    /// Right, wrong and open claims of an answer, on average.
    #[serde(rename = "claims_per_answer")]
    #[schemars(title = "Claims an answer", extend("table" = "claims", "decimals" = 1))]
    pub per_answer: Option<f64>,
    /// The share of wrong claims of those that are right or wrong.
    #[serde(rename = "claims_wrong_share")]
    #[schemars(title = "Wrong share", extend("table" = "claims", "decimals" = 2))]
    pub wrong_share: Option<f64>,
    /// Its interval of 95 %: the bootstrap over units; null of few.
    #[serde(rename = "claims_wrong_share_ci")]
    pub interval: Option<Interval>,
}

impl ClaimTally {
    /// Counts the claims of whole answers, with a verdict or without.
    pub(super) fn count(scored: &[&Scored]) -> Self {
        let mut units: BTreeMap<&str, (u32, u32)> = BTreeMap::new();
        let (mut answers, mut unchecked) = (0, 0);
        let mut sums = [0_u32; 3];
        let mut invented = None;
        let mut sentences = [0_u32; 3];
        for one in scored {
            if !matches!(
                one.status,
                AnswerStatus::Verdict(_) | AnswerStatus::Unparsed(_)
            ) {
                continue;
            }
            let Some(counts) = one.claims.known() else {
                unchecked += 1;
                continue;
            };
            answers += 1;
            sums.iter_mut().zip(counts).for_each(|(sum, n)| *sum += n);
            if let Some(more) = one.claims.claims_invented {
                *invented.get_or_insert(0) += more;
            }
            let said = one.claims.known_sentences().unwrap_or_default();
            { sentences.iter_mut().zip(said) }.for_each(|(sum, n)| *sum += n);
            let [right, wrong, _] = counts;
            let (of_wrong, decided) = units.entry(one.unit()).or_default();
            *of_wrong += wrong;
            *decided += right + wrong;
        }
        let decided = units.into_values().filter(|(_, decided)| *decided > 0);
        let counts: Vec<(u32, u32)> = decided.collect();
        let many = u32::try_from(counts.len()).unwrap_or(u32::MAX);
        let share = |part: u32, of: u32| (of > 0).then(|| f64::from(part) / f64::from(of));
        let [right, wrong, open] = sums.map(|sum| (answers > 0).then_some(sum));
        let [said, not_understood, contradictory] = sentences;
        let known = |sum: u32| (said > 0).then_some(sum);
        Self {
            answers,
            unchecked,
            right,
            wrong,
            open,
            invented,
            sentences: known(said),
            contradictory: known(contradictory),
            not_understood_share: share(not_understood, said),
            per_answer: share(sums.iter().sum(), answers),
            wrong_share: share(sums[1], sums[0] + sums[1]),
            interval: if_enough(ratio_interval(&counts), many),
        }
    }
}

/// Consumption of questions.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct Consumption {
    /// Answers whose time is known.
    #[schemars(title = "Timed", extend("table" = "cost"))]
    pub timed: u32,
    /// The median of their times, seconds.
    #[schemars(title = "Median", extend("unit" = "s", "table" = "cost", "decimals" = 2))]
    pub seconds_median: Option<f64>,
    /// The quantile 0.95 of their times, seconds.
    #[schemars(title = "95 %", extend("unit" = "s", "table" = "cost", "decimals" = 2))]
    pub seconds_p95: Option<f64>,
    /// Attempts whose tokens are known.
    #[schemars(title = "Tokens known", extend("table" = "cost"))]
    pub tokens_of: u32,
    /// Tokens of their questions.
    #[schemars(title = "Input", extend("table" = "cost"))]
    pub input_tokens: Option<u64>,
    /// Tokens of their answers.
    #[schemars(title = "Output", extend("table" = "cost"))]
    pub output_tokens: Option<u64>,
    /// What the attempts of known cost cost, US dollars.
    #[schemars(title = "US dollars", extend("table" = "cost", "decimals" = 4))]
    pub cost_usd: Option<f64>,
    /// Attempts of known cost.
    pub cost_of: u32,
    /// Attempts of unknown cost.
    #[schemars(title = "Cost unknown", extend("table" = "cost"))]
    pub cost_unknown: u32,
    /// What those of them cost at most that a price and a limit bound, US dollars.
    #[schemars(title = "at most", extend("table" = "cost", "decimals" = 4))]
    pub cost_unknown_most_usd: Option<f64>,
    /// Attempts in whose place another one counts; they are among the others.
    #[schemars(title = "Superseded", extend("table" = "cost"))]
    pub superseded: u32,
}

impl Consumption {
    /// Of some questions. Medians and quantiles as in [`quantile`].
    pub fn from_scored(all: &[&Scored]) -> Self {
        let mut times = Vec::new();
        let mut sum = Self::default();
        let mut spending = Spending::default();
        for one in all {
            times.extend(one.consumed.duration_ms.map(|ms| ms as f64 / 1000.0));
            sum.tokens(&one.consumed);
            one.superseded.iter().for_each(|a| sum.tokens(&a.consumed));
            sum.superseded += count(one.superseded.len());
            spending.join(&one.spending());
        }
        Self {
            timed: count(times.len()),
            seconds_median: quantile(&times, 0.5),
            seconds_p95: quantile(&times, 0.95),
            cost_usd: spending.cost(),
            cost_of: spending.known,
            cost_unknown: spending.unpriced(),
            cost_unknown_most_usd: spending.most(),
            ..sum
        }
    }

    /// Whether anything is known of it.
    pub fn is_known(&self) -> bool {
        let bounded = self.cost_unknown_most_usd.is_some();
        self.timed + self.tokens_of + self.cost_of > 0 || bounded
    }

    fn tokens(&mut self, of: &Consumed) {
        if let (Some(input), Some(output)) = (of.input_tokens, of.output_tokens) {
            self.tokens_of += 1;
            let sum = |known: Option<u64>, more| known.unwrap_or(0).saturating_add(more);
            self.input_tokens = Some(sum(self.input_tokens, input));
            self.output_tokens = Some(sum(self.output_tokens, output));
        }
    }
}

pub(super) fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::tests_scored::{answer, failed};
    use nearmiss_store::ClaimCounts;

    fn with(scenario: &str, claims: Option<[u32; 3]>) -> Scored {
        let mut scored = answer(scenario, "m/x", true, &[]);
        if let Some([right, wrong, open]) = claims {
            scored.claims = ClaimCounts {
                claims_right: Some(right),
                claims_wrong: Some(wrong),
                claims_open: Some(open),
                claims_check: Some(1),
                claims_invented: Some(1),
                sentences: Some(4),
                sentences_not_understood: Some(1),
                sentences_contradictory: Some(2),
            };
        }
        scored
    }

    #[test]
    fn unchecked_answers_are_told_from_those_without_claims() {
        let all = [
            with("a", Some([6, 2, 1])),
            with("b", Some([0, 0, 0])),
            with("c", None),
            failed("d", "m/x"),
        ];
        let tally = ClaimTally::count(&all.iter().collect::<Vec<_>>());
        assert_eq!((tally.answers, tally.unchecked), (2, 1));
        assert_eq!(
            (tally.right, tally.wrong, tally.open),
            (Some(6), Some(2), Some(1))
        );
        assert_eq!(tally.wrong_share, Some(0.25));
        assert_eq!((tally.invented, tally.sentences), (Some(2), Some(8)));
        assert_eq!(tally.contradictory, Some(4));
        assert_eq!(tally.not_understood_share, Some(0.25));
        assert_eq!(tally.per_answer, Some(4.5));
        assert_eq!(tally.interval, None, "one scenario has no interval");
        let none = ClaimTally::count(&[&all[2]]);
        assert_eq!((none.wrong_share, none.per_answer), (None, None));
        assert_eq!(none.right, None);
    }

    #[test]
    fn scenarios_are_drawn_with_all_their_claims() {
        let of = |samples: usize| -> Vec<Scored> {
            (0..40 * samples)
                .map(|i| with(&format!("s{}", i % 40), Some([4, u32::from(i % 4 == 0), 0])))
                .collect()
        };
        let interval = |all: &[Scored]| {
            let tally = ClaimTally::count(&all.iter().collect::<Vec<_>>());
            tally.interval.unwrap()
        };
        let (once, thrice) = (interval(&of(1)), interval(&of(3)));
        assert!((once.low - thrice.low).abs() < 1e-12 && (once.high - thrice.high).abs() < 1e-12);
        let share = 10.0 / 170.0;
        assert!(once.low < share && share < once.high, "{once:?}");
    }
}
