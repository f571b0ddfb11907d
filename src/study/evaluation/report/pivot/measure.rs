//! What the cells of a table over axes measure.

use super::super::Cell;
use crate::evaluation::statistics::Interval;
use nearmiss_base::system::unknown;

/// A measure of answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Measure {
    /// The share of the questions asked that it is right about: no verdict is not right.
    #[default]
    RightOfAll,
    /// The harmonic mean of precision and recall.
    F1,
    /// Of those called dangerous, the share that is.
    Precision,
    /// Of those that are dangerous, the share that is called so.
    Recall,
    /// Of those that are safe, the share that is called so.
    Specificity,
    /// The share of right verdicts.
    Accuracy,
    /// Of the dangerous windows, the share of which a critical obstacle is named.
    NamingRecall,
    /// Of the obstacles named, the share that is critical.
    NamingPrecision,
    /// Median time of an answer, seconds.
    Seconds,
    /// What all answers cost, US dollars.
    Cost,
}

impl Measure {
    /// Every one.
    pub const ALL: [Self; 10] = [
        Self::RightOfAll,
        Self::F1,
        Self::Precision,
        Self::Recall,
        Self::Specificity,
        Self::Accuracy,
        Self::NamingRecall,
        Self::NamingPrecision,
        Self::Seconds,
        Self::Cost,
    ];

    /// The word for it, as JSON and CSV of reports name it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::RightOfAll => "right_of_all",
            Self::F1 => "f1",
            Self::Precision => "precision",
            Self::Recall => "recall",
            Self::Specificity => "specificity",
            Self::Accuracy => "accuracy",
            Self::NamingRecall => "naming_recall",
            Self::NamingPrecision => "naming_precision",
            Self::Seconds => "seconds_median",
            Self::Cost => "cost_usd",
        }
    }

    /// How captions name it.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::RightOfAll => "Right of all asked",
            Self::F1 => "F1",
            Self::Precision => "Precision",
            Self::Recall => "Recall",
            Self::Specificity => "Specificity",
            Self::Accuracy => "Accuracy",
            Self::NamingRecall => "Recall of named obstacles",
            Self::NamingPrecision => "Precision of named obstacles",
            Self::Seconds => "Median seconds of an answer",
            Self::Cost => "US dollars",
        }
    }

    /// Whether questions without a verdict count, too.
    #[must_use]
    pub fn is_of_all(self) -> bool {
        matches!(self, Self::RightOfAll | Self::Seconds | Self::Cost)
    }

    /// The one that this word is for.
    ///
    /// # Errors
    /// There is none: with those that it may mean.
    pub fn parse(word: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|measure| measure.name() == word);
        found.ok_or_else(|| unknown("measure", word, Self::ALL.map(Self::name)))
    }

    /// Its value of counted answers.
    #[must_use]
    pub fn value(self, cell: &Cell) -> Option<f64> {
        match self {
            Self::RightOfAll => cell.right_of_all,
            Self::F1 => cell.f1,
            Self::Precision => cell.precision,
            Self::Recall => cell.recall,
            Self::Specificity => cell.specificity,
            Self::Accuracy => cell.accuracy,
            Self::NamingRecall => cell.naming_recall,
            Self::NamingPrecision => cell.naming_precision,
            Self::Seconds => cell.consumption.seconds_median,
            Self::Cost => cell.consumption.cost_usd,
        }
    }

    /// The interval of 95 % of its value; times and costs have none.
    #[must_use]
    pub fn interval(self, cell: &Cell) -> Option<Interval> {
        match self {
            Self::RightOfAll => cell.right_of_all_ci,
            Self::F1 => cell.f1_ci,
            Self::Precision => cell.precision_ci,
            Self::Recall => cell.recall_ci,
            Self::Specificity => cell.specificity_ci,
            Self::Accuracy => cell.accuracy_ci,
            Self::NamingRecall => cell.naming_recall_ci,
            Self::NamingPrecision => cell.naming_precision_ci,
            Self::Seconds | Self::Cost => None,
        }
    }
}

impl nearmiss_record::fields::Word for Measure {
    fn known() -> Vec<&'static str> {
        Self::ALL.map(Self::name).to_vec()
    }

    fn of_word(word: &str) -> Result<Self, String> {
        Self::parse(word)
    }

    fn word(&self) -> String {
        self.name().into()
    }
}
