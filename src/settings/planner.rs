//! `[planner]` of `config.toml`: its keys, and what each may be. What they mean is the planner's.

use std::ops::RangeInclusive;

use toml::{Table, Value};

use super::mistakes::{near, shown};

/// A key of the section.
#[derive(Debug)]
pub struct PlannerKey {
    /// Its name, with that of its table: `horizon`, `weights.speed`.
    pub id: &'static str,
    /// Its unit; nothing for counts, shares, words and weights.
    pub unit: &'static str,
    /// What it may be.
    pub allowed: Allowed,
}

/// What a value may be.
#[derive(Debug)]
pub enum Allowed {
    /// A number in these bounds.
    Number(RangeInclusive<f64>),
    /// A whole number in these bounds.
    Whole(RangeInclusive<i64>),
    /// An odd number in these bounds.
    DecodeError(RangeInclusive<i64>),
    /// One of these words.
    Words(&'static [&'static str]),
}

use Allowed::{DecodeError, Number, Whole, Words};

/// The names of the tables in the section.
const TABLES: [&str; 2] = ["sampling", "weights"];

const fn key(id: &'static str, unit: &'static str, allowed: Allowed) -> PlannerKey {
    PlannerKey { id, unit, allowed }
}

/// Weights may be anything that cannot hurt.
const fn weight(id: &'static str) -> PlannerKey {
    key(id, "", Number(0.0..=1e6))
}

/// Every key, in the order of the documentation.
const KEYS: [PlannerKey; 23] = [
    key("horizon", "s", Number(0.5..=20.0)),
    key("replan", "steps", Whole(1..=1000)),
    key(
        "prediction",
        "",
        Words(&["recorded", "constant-velocity", "lane"]),
    ),
    key("vehicle", "", Whole(1..=4)),
    key("share", "", Number(0.1..=1.0)),
    key("low_speed", "m/s", Number(0.0..=20.0)),
    key("margin", "m", Number(0.0..=5.0)),
    key("braking", "m/s²", Number(0.5..=20.0)),
    key("reaction", "s", Number(0.0..=5.0)),
    key("sampling.durations", "", Whole(1..=12)),
    key("sampling.speeds", "", Whole(2..=30)),
    key("sampling.offsets", "", DecodeError(3..=31)),
    key("sampling.changes", "", Whole(1..=6)),
    key("sampling.widest", "m", Number(0.1..=20.0)),
    key("sampling.refinements", "", Whole(0..=3)),
    weight("weights.longitudinal_jerk"),
    weight("weights.lateral_jerk"),
    weight("weights.acceleration"),
    weight("weights.speed"),
    weight("weights.offset"),
    weight("weights.clearance"),
    weight("weights.following"),
    weight("weights.risk"),
];

impl PlannerKey {
    /// Every key, in the order of the documentation.
    pub const ALL: &'static [Self] = &KEYS;

    /// The key with this name.
    #[must_use]
    pub fn named(id: &str) -> Option<&'static Self> {
        Self::ALL.iter().find(|key| key.id == id)
    }

    /// The names that lead to it, in the section.
    #[must_use]
    pub fn path(&self) -> Vec<&'static str> {
        self.id.split('.').collect()
    }

    /// Whether it may have this value.
    #[must_use]
    pub fn allows(&self, value: &Value) -> bool {
        match (&self.allowed, value) {
            (Number(range), Value::Float(x)) => range.contains(x),
            (Number(range), Value::Integer(n)) => range.contains(&(*n as f64)),
            (Whole(range), Value::Integer(n)) => range.contains(n),
            (DecodeError(range), Value::Integer(n)) => n % 2 != 0 && range.contains(n),
            (Words(words), Value::String(word)) => words.contains(&word.as_str()),
            _ => false,
        }
    }

    /// What is needed, in words.
    #[must_use]
    pub fn needed(&self) -> String {
        let unit = match self.unit {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        match &self.allowed {
            Number(range) => format!(
                "a number from {} to {}{unit} is needed",
                range.start(),
                range.end()
            ),
            Whole(range) => format!(
                "a whole number from {} to {}{unit} is needed",
                range.start(),
                range.end()
            ),
            DecodeError(range) => format!(
                "an odd number from {} to {}{unit} is needed",
                range.start(),
                range.end()
            ),
            Words(words) => {
                let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                match words.split_last() {
                    Some((last, others)) => format!("{} or {last} is needed", others.join(", ")),
                    None => String::new(),
                }
            }
        }
    }
}

/// The value that a section has for a key, if it says one.
pub(super) fn said<'a>(section: &'a Table, key: &PlannerKey) -> Option<&'a Value> {
    match key.id.split_once('.') {
        Some((table, name)) => section.get(table)?.as_table()?.get(name),
        None => section.get(key.id),
    }
}

/// What is wrong with a section: the names that lead to each mistake from its beginning, and words.
pub(super) fn wrong(section: &Table) -> Vec<(Vec<String>, String)> {
    let mut found = Vec::new();
    for (name, value) in section {
        match value {
            Value::Table(table) if TABLES.contains(&name.as_str()) => {
                for (inner, value) in table {
                    let words = wrong_value(&format!("{name}.{inner}"), value);
                    found.extend(words.map(|words| (vec![name.clone(), inner.clone()], words)));
                }
            }
            value => {
                let words = match TABLES.contains(&name.as_str()) {
                    true => Some(format!(
                        "planner.{name} = {}: a table is needed: [planner.{name}]",
                        shown(value)
                    )),
                    false => wrong_value(name, value),
                };
                found.extend(words.map(|words| (vec![name.clone()], words)));
            }
        }
    }
    found
}

fn wrong_value(id: &str, value: &Value) -> Option<String> {
    let Some(key) = PlannerKey::named(id) else {
        let all: Vec<&str> = PlannerKey::ALL.iter().map(|key| key.id).collect();
        return Some(format!("planner.{id} is not known{}", near(id, &all)));
    };
    (!key.allows(value)).then(|| format!("planner.{id} = {}: {}", shown(value), key.needed()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn words(text: &str) -> Vec<String> {
        let section: Table = toml::from_str(text).unwrap();
        wrong(&section)
            .into_iter()
            .map(|(_, words)| words)
            .collect()
    }

    #[test]
    fn what_may_be_is_taken() {
        let text = "horizon = 3\nprediction = \"lane\"\nvehicle = 4\nshare = 1\n[sampling]\noffsets = 11\n\
            [weights]\nspeed = 0\nrisk = 2.5\n";
        assert_eq!(words(text), [""; 0]);
        let section: Table = toml::from_str(text).unwrap();
        let risk = PlannerKey::named("weights.risk").unwrap();
        assert_eq!(said(&section, risk), Some(&Value::Float(2.5)));
        let jerk = PlannerKey::named("weights.lateral_jerk").unwrap();
        assert_eq!(said(&section, jerk), None);
    }

    #[test]
    fn what_may_not_be_is_named_with_what_is_needed() {
        for (text, said) in [
            (
                "horizon = 0",
                "planner.horizon = 0: a number from 0.5 to 20 s",
            ),
            ("horizon = nan", "planner.horizon = nan: a number"),
            ("horizon = \"4\"", "planner.horizon = \"4\": a number"),
            (
                "replan = 1.5",
                "planner.replan = 1.5: a whole number from 1 to 1000 steps",
            ),
            ("vehicle = 5", "planner.vehicle = 5: a whole number"),
            (
                "prediction = \"oracle\"",
                "planner.prediction = \"oracle\": \"recorded\", \"constant-velocity\" or \"lane\" is",
            ),
            (
                "horizn = 3",
                "planner.horizn is not known; did you mean horizon?",
            ),
            (
                "sampling = 3",
                "planner.sampling = 3: a table is needed: [planner.sampling]",
            ),
            (
                "[sampling]\noffsets = 4",
                "planner.sampling.offsets = 4: an odd number from 3 to 31",
            ),
            (
                "[weights]\nrisk = -1",
                "planner.weights.risk = -1: a number from 0 to 1000000",
            ),
            (
                "[weights]\nrisks = 1",
                "planner.weights.risks is not known; did you mean weights.risk?",
            ),
        ] {
            let found = words(text);
            assert!(found.len() == 1 && found[0].starts_with(said), "{found:?}");
        }
    }
}
