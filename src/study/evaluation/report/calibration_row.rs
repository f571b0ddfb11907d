//! Probabilities of verdicts beside the truth, as cells have them.

use schemars::JsonSchema;
use serde::Serialize;

use super::super::ProbabilitySource;
use super::super::statistics::{Bin, Calibration};

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
