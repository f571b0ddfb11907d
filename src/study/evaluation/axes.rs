//! Axes of a batch: settings that it asks in several values, each a way of asking of its own.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::hash::{Hash, Hasher};

use serde_json::{Value, json};

use super::Settings;
use nearmiss_ask::llm::{Effort, Parameters};
use nearmiss_scene::description::Form;

/// The settings with several values; a list is empty where all questions have the same value, or the usual one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Axes {
    /// Forms of the description.
    pub forms: Vec<Form>,
    /// Steps between described ones.
    pub strides: Vec<usize>,
    /// How much the models are to reason.
    pub efforts: Vec<Effort>,
    /// Sampling temperatures.
    pub temperatures: Vec<f64>,
    /// Seeds of the sampling.
    pub seeds: Vec<u64>,
    /// Whether the models may call tools.
    pub tools: Vec<bool>,
}

/// One value of each axis; `None` where the setting is no axis.
#[derive(Debug, Clone, Copy, Default)]
pub struct AxisValues {
    /// Form of the description.
    pub form: Option<Form>,
    /// Steps between described ones.
    pub stride: Option<usize>,
    /// How much the model is to reason.
    pub effort: Option<Effort>,
    /// Sampling temperature, from 0.
    pub temperature: Option<f64>,
    /// Seed of the sampling.
    pub seed: Option<u64>,
    /// Whether the model may call tools.
    pub tools: Option<bool>,
}

/// The names of the axes in stored questions, reports and experiment files.
const NAMES: [&str; 6] = ["form", "stride", "effort", "temperature", "seed", "tools"];

/// The words for the values of the axis of tools.
#[must_use]
pub fn tools_word(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}

impl Axes {
    /// Every combination of values, in the order of the lists; without axes one that says nothing.
    #[must_use]
    pub fn values(&self) -> Vec<AxisValues> {
        let mut all = vec![AxisValues::default()];
        all = crossed(&all, &self.forms, |one, form| one.form = Some(form));
        all = crossed(&all, &self.strides, |one, stride| one.stride = Some(stride));
        all = crossed(&all, &self.efforts, |one, effort| one.effort = Some(effort));
        all = crossed(&all, &self.temperatures, |one, temperature| {
            one.temperature = Some(temperature);
        });
        all = crossed(&all, &self.seeds, |one, seed| one.seed = Some(seed));
        crossed(&all, &self.tools, |one, tools| one.tools = Some(tools))
    }

    /// Each axis with the number of its values.
    pub fn sizes(&self) -> impl Iterator<Item = (&'static str, usize)> {
        NAMES.into_iter().zip([
            self.forms.len(),
            self.strides.len(),
            self.efforts.len(),
            self.temperatures.len(),
            self.seeds.len(),
            self.tools.len(),
        ])
    }

    /// Each axis with its values: `effort low,high`.
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        let lists: [Vec<String>; 6] = [
            self.forms.iter().map(|form| form.name().into()).collect(),
            self.strides.iter().map(usize::to_string).collect(),
            self.efforts.iter().map(|one| one.name().into()).collect(),
            self.temperatures.iter().map(f64::to_string).collect(),
            self.seeds.iter().map(u64::to_string).collect(),
            self.tools.iter().map(|on| tools_word(*on).into()).collect(),
        ];
        let lists = NAMES.into_iter().zip(lists);
        let named = lists.filter(|(_, values)| !values.is_empty());
        named
            .map(|(name, values)| format!("{name} {}", values.join(",")))
            .collect()
    }

    /// Each axis with its values, for programs.
    #[must_use]
    pub fn json(&self) -> BTreeMap<&'static str, Vec<Value>> {
        let lists = [
            self.forms.iter().map(|form| json!(form.name())).collect(),
            self.strides.iter().map(|stride| json!(stride)).collect(),
            self.efforts.iter().map(|one| json!(one.name())).collect(),
            self.temperatures.iter().map(|one| json!(one)).collect(),
            self.seeds.iter().map(|seed| json!(seed)).collect(),
            self.tools.iter().map(|on| json!(on)).collect(),
        ];
        let lists = NAMES.into_iter().zip::<[Vec<Value>; 6]>(lists);
        lists.filter(|(_, values)| !values.is_empty()).collect()
    }

    /// Sorts the values of a setting: one is that of all questions, several are an axis.
    #[must_use]
    pub fn one_or_several<T: PartialEq>(values: Vec<T>) -> (Option<T>, Vec<T>) {
        let mut once = Vec::with_capacity(values.len());
        for value in values {
            if !once.contains(&value) {
                once.push(value);
            }
        }
        match once.len() {
            0 | 1 => (once.pop(), Vec::new()),
            _ => (None, once),
        }
    }
}

fn crossed<T: Copy>(
    all: &[AxisValues],
    values: &[T],
    set: impl Fn(&mut AxisValues, T),
) -> Vec<AxisValues> {
    if values.is_empty() {
        return all.to_vec();
    }
    let mut more = Vec::with_capacity(all.len() * values.len());
    for one in all {
        for value in values {
            let mut one = *one;
            set(&mut one, *value);
            more.push(one);
        }
    }
    more
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

    /// The names of the axes in which two differ.
    #[must_use]
    pub fn differences(&self, other: &Self) -> Vec<&'static str> {
        let pairs = NAMES
            .into_iter()
            .zip(self.cells().into_iter().zip(other.cells()));
        pairs
            .filter(|(_, (a, b))| a != b)
            .map(|(name, _)| name)
            .collect()
    }

    /// Each value in words.
    fn cells(&self) -> [Option<String>; 6] {
        [
            self.form.map(|form| form.name().into()),
            self.stride.map(|stride| stride.to_string()),
            self.effort.map(|effort| effort.name().into()),
            self.temperature.map(|temperature| temperature.to_string()),
            self.seed.map(|seed| seed.to_string()),
            self.tools.map(|on| tools_word(on).into()),
        ]
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
        let cells = NAMES.into_iter().zip(self.cells());
        let words = cells.filter_map(|(name, value)| Some(format!("{name} {}", value?)));
        f.write_str(&words.collect::<Vec<_>>().join(", "))
    }
}

impl std::str::FromStr for AxisValues {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut values = Self::default();
        let unknown = || format!("the settings `{text}` are not known to this version");
        for part in text.split(", ") {
            let (name, value) = part.split_once(' ').ok_or_else(unknown)?;
            let read = match name {
                "form" => Form::parse(value).map(|form| values.form = Some(form)),
                "stride" => value
                    .parse()
                    .ok()
                    .map(|stride| values.stride = Some(stride)),
                "effort" => Effort::parse(value).map(|effort| values.effort = Some(effort)),
                "temperature" => {
                    let number = value.parse().ok().filter(|number: &f64| *number >= 0.0);
                    number.map(|temperature| values.temperature = Some(temperature))
                }
                "seed" => value.parse().ok().map(|seed| values.seed = Some(seed)),
                "tools" => [false, true]
                    .into_iter()
                    .find(|on| tools_word(*on) == value)
                    .map(|on| values.tools = Some(on)),
                _ => None,
            };
            read.ok_or_else(unknown)?;
        }
        Ok(values)
    }
}

impl PartialEq for AxisValues {
    fn eq(&self, other: &Self) -> bool {
        self.order() == other.order()
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

    #[test]
    fn every_combination_is_a_way_with_a_name_that_is_read_back() {
        let axes = Axes {
            efforts: vec![Effort::Low, Effort::High],
            temperatures: vec![0.0, 0.7],
            forms: vec![Form::Compact, Form::Prose],
            ..Axes::default()
        };
        let all = axes.values();
        let words: Vec<String> = all.iter().map(ToString::to_string).collect();
        assert_eq!(all.len(), 8);
        assert_eq!(words[0], "form compact, effort low, temperature 0");
        assert_eq!(words[7], "form prose, effort high, temperature 0.7");
        for (one, words) in all.iter().zip(&words) {
            assert_eq!(words.parse::<AxisValues>().unwrap(), *one);
        }
        assert_eq!(
            axes.words(),
            ["form compact,prose", "effort low,high", "temperature 0,0.7"]
        );
        assert_eq!(all[0].differences(&all[1]), ["temperature"]);
        assert_eq!(all[0].differences(&all[7]).len(), 3);
        let tools = Axes {
            tools: vec![false, true],
            ..Axes::default()
        };
        assert_eq!(tools.words(), ["tools off,on"]);
        let both = tools.values();
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
        assert_eq!(Axes::one_or_several(vec![3, 3]), (Some(3), Vec::new()));
        assert_eq!(Axes::one_or_several(vec![3, 4, 3]), (None, vec![3, 4]));
        assert_eq!(Axes::one_or_several(Vec::<u8>::new()), (None, Vec::new()));
        assert_eq!(Axes::default().values(), [AxisValues::default()]);
        assert_eq!(AxisValues::default().words(), None);
    }
}
