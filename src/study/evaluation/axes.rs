//! Axes of a batch: settings that it asks in several values, each a way of asking of its own.

use std::cmp::Ordering;
use std::hash::{Hash, Hasher};

use super::Settings;
use nearmiss_ask::llm::{Effort, Parameters};
use nearmiss_record::fields::Fields;
use nearmiss_scene::description::Form;

nearmiss_record::fields! {
    /// One value of each axis; `None` where the setting is no axis. The keys are those of experiments, stored questions
    /// and reports.
    #[derive(Copy)]
    pub struct AxisValues {
        "axes" {
            /// Form of the description.
            form: Option<Form>;
            /// Steps between described ones.
            stride: Option<usize>;
            /// How much the model is to reason.
            effort: Option<Effort>;
            /// Sampling temperature, from 0.
            temperature: Option<f64>, Takes::Number(0.0, f64::MAX);
            /// Seed of the sampling.
            seed: Option<u64>;
            /// Whether the model may call tools.
            tools: Option<bool>;
        }
    }
}

/// The words for the values of the axis of tools.
#[must_use]
pub fn tools_word(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}

impl AxisValues {
    /// Whether no setting is an axis.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// What is sent beside the messages, with these values in the place of others.
    #[must_use]
    pub fn parameters(&self, usual: Parameters) -> Parameters {
        Parameters {
            effort: self.effort.or(usual.effort),
            temperature: self.temperature.or(usual.temperature),
            seed: self.seed.or(usual.seed),
            tools: match self.tools {
                Some(true) => Some(usual.tools.unwrap_or_default()),
                Some(false) => None,
                None => usual.tools,
            },
            ..usual
        }
    }

    /// How scenes are described, with these values in the place of others.
    #[must_use]
    pub fn settings(&self, usual: Settings) -> Settings {
        Settings {
            form: self.form.or(usual.form),
            stride: self.stride.or(usual.stride),
            ..usual
        }
    }

    /// The same as the store and tables have it; `None` without a value.
    #[must_use]
    pub fn words(&self) -> Option<String> {
        (!self.is_empty()).then(|| self.to_string())
    }

    /// The values in an order. Temperatures are not negative, so that their bits are in the order of the numbers.
    fn order(&self) -> impl Ord + Hash + use<> {
        (
            self.form.map(Form::name),
            self.stride,
            self.effort,
            self.temperature.map(f64::to_bits),
            self.seed,
            self.tools,
        )
    }
}

/// `effort low, temperature 0.7`.
impl std::fmt::Display for AxisValues {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let words = Self::rows().iter();
        let words = words.filter_map(|row| Some(format!("{} {}", row.key, self.text(row.key)?)));
        f.write_str(&words.collect::<Vec<_>>().join(", "))
    }
}

impl std::str::FromStr for AxisValues {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut values = Self::default();
        let unknown = || format!("the settings `{text}` are not known to this version");
        for part in text.split(", ") {
            let (key, value) = part.split_once(' ').ok_or_else(unknown)?;
            let row = Self::row(key).map_err(|_| unknown())?;
            values.set(key, &row.parse(value)).map_err(|_| unknown())?;
        }
        Ok(values)
    }
}

impl Eq for AxisValues {}

impl PartialOrd for AxisValues {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for AxisValues {
    fn cmp(&self, other: &Self) -> Ordering {
        self.order().cmp(&other.order())
    }
}

impl Hash for AxisValues {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.order().hash(state);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::batch::Experiment;

    #[test]
    fn every_combination_is_a_way_with_a_name_that_is_read_back() {
        let axes = Experiment {
            effort: [Effort::Low, Effort::High].into_iter().collect(),
            temperature: [0.0, 0.7].into_iter().collect(),
            form: [Form::Compact, Form::Prose].into_iter().collect(),
            ..Experiment::default()
        };
        let all = axes.axis_values();
        let words: Vec<String> = all.iter().map(ToString::to_string).collect();
        assert_eq!(all.len(), 8);
        assert_eq!(words[0], "form compact, effort low, temperature 0");
        assert_eq!(words[7], "form prose, effort high, temperature 0.7");
        for (one, words) in all.iter().zip(&words) {
            assert_eq!(words.parse::<AxisValues>().unwrap(), *one);
        }
        let keys: Vec<&str> = axes.several().map(|(key, _)| key).collect();
        assert_eq!(keys, ["form", "effort", "temperature"]);
        assert_eq!(all[0].differences(&all[1]), ["temperature"]);
        assert_eq!(all[0].differences(&all[7]).len(), 3);
        let tools = Experiment {
            tools: [false, true].into_iter().collect(),
            ..Experiment::default()
        };
        let both = tools.axis_values();
        assert_eq!(both[0].differences(&both[1]), ["tools"]);
        let sent = both
            .iter()
            .map(|one| one.parameters(Parameters::default()).tools);
        let sent: Vec<_> = sent.collect();
        for one in &both {
            assert_eq!(one.to_string().parse::<AxisValues>().unwrap(), *one);
        }
        assert_eq!(sent, [None, Some(nearmiss_ask::llm::ToolLimits::default())]);
        assert!("effort lazy".parse::<AxisValues>().is_err() && "".parse::<AxisValues>().is_err());
    }

    #[test]
    fn a_single_value_is_no_axis() {
        let same = Experiment {
            stride: [3, 3].into_iter().collect(),
            ..Experiment::default()
        };
        assert_eq!(same.stride.one(), Some(3));
        assert_eq!(same.axis_values(), [AxisValues::default()]);
        assert_eq!(AxisValues::default().words(), None);
    }
}
