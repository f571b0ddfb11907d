//! What tells answers apart, the axes of tables and their values, and what the cells measure.

use nearmiss_ask::llm::Parameters;
use nearmiss_record::NONE;
use strum::{IntoStaticStr, VariantArray};

use super::super::Cell;
use crate::evaluation::statistics::Interval;
use crate::evaluation::{AnswerCase, Lead, tools_word};

/// An axis of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Axis {
    /// The model, `provider/model`.
    Model,
    /// The combination of prompting techniques.
    Techniques,
    /// The frame of the description.
    Frame,
    /// The task.
    Task,
    /// The version of the template.
    Template,
    /// Where windows of the safety task end.
    Lead,
    /// What was changed about the scene.
    Transform,
    /// How much the model was to reason.
    Effort,
    /// The sampling temperature.
    Temperature,
    /// The form of the description.
    Form,
    /// Steps between described ones.
    Stride,
    /// The seed of the sampling.
    Seed,
    /// Whether the model could call tools.
    Tools,
    /// Which of several answers to the same question, from 1.
    Sample,
    /// The country that the scenario's name begins with.
    Country,
}

/// A value of an axis; they are ordered as tables have them.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AxisValue {
    rank: i64,
    /// The value in words.
    pub text: String,
}

impl Axis {
    /// Those in which two ways of asking can differ.
    pub(super) const OF_QUESTIONS: [Self; 12] = [
        Self::Model,
        Self::Techniques,
        Self::Frame,
        Self::Template,
        Self::Lead,
        Self::Transform,
        Self::Effort,
        Self::Temperature,
        Self::Form,
        Self::Stride,
        Self::Seed,
        Self::Tools,
    ];

    /// The value of an answer; `parameters` are those that were sent, where they are known.
    #[must_use]
    pub fn value(self, case: &AnswerCase<'_>, parameters: Option<&Parameters>) -> AxisValue {
        let configuration = &case.scored.configuration;
        // What a judge without a prompt has no value of stands last.
        let last = || AxisValue {
            rank: i64::MAX,
            text: NONE.into(),
        };
        let word = |rank, text: String| AxisValue { rank, text };
        match self {
            Self::Model => word(0, configuration.model.clone()),
            Self::Task => word(0, configuration.task.name().into()),
            Self::Frame => configuration
                .frame
                .map_or_else(last, |frame| word(0, frame.name().into())),
            Self::Techniques => configuration.techniques.map_or_else(last, |used| {
                let names = used.to_string();
                let count = names.split('+').filter(|name| *name != "base").count();
                word(i64::try_from(count).unwrap_or(0), used.to_string())
            }),
            Self::Template => {
                (configuration.template.as_ref()).map_or_else(last, |t| word(0, t.to_string()))
            }
            Self::Lead => match (case.lead, case.lead_label()) {
                (Some(Lead::Seconds(seconds)), Some(words)) => {
                    word((seconds * 1000.0) as i64, words)
                }
                (_, Some(words)) => word(-1, words),
                _ => last(),
            },
            Self::Transform => match case.transform() {
                Some(transform) => word(1, transform.to_string()),
                None => word(0, "none".into()),
            },
            Self::Effort => {
                // A question that was not sent has the value of its way.
                let sent = configuration
                    .settings
                    .effort
                    .or(parameters.and_then(|sent| sent.effort));
                match sent {
                    Some(effort) => word(effort as i64, effort.name().into()),
                    None if parameters.is_some() => word(-1, "default".into()),
                    None => last(),
                }
            }
            Self::Temperature => {
                let sent = parameters.and_then(|sent| sent.temperature);
                match configuration.settings.temperature.or(sent) {
                    Some(t) => word((t * 1e6) as i64, t.to_string()),
                    None if parameters.is_some() => word(-1, "default".into()),
                    None => last(),
                }
            }
            Self::Form => {
                (configuration.settings.form).map_or_else(last, |form| word(0, form.name().into()))
            }
            Self::Stride => (configuration.settings.stride).map_or_else(last, |stride| {
                word(
                    i64::try_from(stride).unwrap_or(i64::MAX),
                    stride.to_string(),
                )
            }),
            Self::Seed => (configuration.settings.seed).map_or_else(last, |seed| {
                word(i64::try_from(seed).unwrap_or(i64::MAX), seed.to_string())
            }),
            Self::Tools => {
                let sent = parameters.map(|sent| sent.tools.is_some());
                match configuration.settings.tools.or(sent) {
                    Some(on) => word(i64::from(on), tools_word(on).into()),
                    None => last(),
                }
            }
            Self::Sample => {
                let number = i64::from(case.scored.sample) + 1;
                word(number, number.to_string())
            }
            Self::Country => {
                let code = case.scenario().split('_').next().unwrap_or_default();
                let is_code = code.len() == 3 && code.bytes().all(|b| b.is_ascii_uppercase());
                if is_code {
                    word(0, code.into())
                } else {
                    last()
                }
            }
        }
    }
}

nearmiss_record::named!(Axis, "axis");

/// A measure of answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
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
    #[strum(to_string = "seconds_median")]
    Seconds,
    /// What all answers cost, US dollars.
    #[strum(to_string = "cost_usd")]
    Cost,
}

nearmiss_record::named!(Measure, "measure");

impl Measure {
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

    /// Its value of counted answers.
    #[must_use]
    pub fn value(self, cell: &Cell) -> Option<f64> {
        self.figure(cell).0
    }

    /// The interval of 95 % of its value; times and costs have none.
    #[must_use]
    pub fn interval(self, cell: &Cell) -> Option<Interval> {
        self.figure(cell).1
    }

    fn figure(self, cell: &Cell) -> (Option<f64>, Option<Interval>) {
        match self {
            Self::RightOfAll => (cell.right_of_all, cell.right_of_all_ci),
            Self::F1 => (cell.f1, cell.f1_ci),
            Self::Precision => (cell.precision, cell.precision_ci),
            Self::Recall => (cell.recall, cell.recall_ci),
            Self::Specificity => (cell.specificity, cell.specificity_ci),
            Self::Accuracy => (cell.accuracy, cell.accuracy_ci),
            Self::NamingRecall => (cell.naming_recall, cell.naming_recall_ci),
            Self::NamingPrecision => (cell.naming_precision, cell.naming_precision_ci),
            Self::Seconds => (cell.consumption.seconds_median, None),
            Self::Cost => (cell.consumption.cost_usd, None),
        }
    }
}
