//! `[planner]` of `config.toml`: its keys, what each may be, and the setting of the planner that it stands for.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use toml::{Table, Value};

use super::validation::{near, shown};
use super::{Config, external_planner};
use nearmiss_drive::planner::{Forecast, RuleMode};
use nearmiss_drive::simulation::{Settings, TrafficMode};
use nearmiss_scene::scenario::VehicleType;

/// A key of the section.
#[derive(Debug)]
pub struct PlannerKey {
    /// Its name, with that of its table: `horizon`, `weights.speed`.
    pub id: &'static str,
    /// Its unit; nothing for counts, shares, words and weights.
    unit: &'static str,
    allowed: Allowed,
    get: fn(&Settings) -> Value,
    /// Takes a value that is allowed; another one changes nothing.
    set: fn(&mut Settings, &Value),
}

/// What a value may be.
#[derive(Debug)]
enum Allowed {
    /// A number in these bounds.
    Number(RangeInclusive<f64>),
    /// A whole number in these bounds.
    Whole(RangeInclusive<i64>),
    /// An odd number in these bounds.
    Odd(RangeInclusive<i64>),
    /// One of these words.
    Words(&'static [&'static str]),
}

use Allowed::{Number, Odd, Whole, Words};

/// The names of the built-in planner's tables in the section; other tables are planners of their own.
pub(super) const TABLES: [&str; 2] = ["sampling", "weights"];

macro_rules! keys {
    ($($id:literal $unit:literal $kind:ident $bounds:expr => $($field:ident).+;)+) => {
        &[$(keys!(@$kind $id, $unit, $bounds, $($field).+)),+]
    };
    (@number $id:literal, $unit:literal, $bounds:expr, $($field:ident).+) => {
        PlannerKey {
            id: $id,
            unit: $unit,
            allowed: Number($bounds),
            get: |settings| Value::Float(settings.$($field).+),
            set: |settings, value| {
                let whole = value.as_integer().map(|n| n as f64);
                if let Some(number) = whole.or(value.as_float()) {
                    settings.$($field).+ = number;
                }
            },
        }
    };
    (@whole $id:literal, $unit:literal, $bounds:expr, $($field:ident).+) => {
        keys!(@count $id, $unit, Whole($bounds), $($field).+)
    };
    (@odd $id:literal, $unit:literal, $bounds:expr, $($field:ident).+) => {
        keys!(@count $id, $unit, Odd($bounds), $($field).+)
    };
    (@count $id:literal, $unit:literal, $allowed:expr, $($field:ident).+) => {
        PlannerKey {
            id: $id,
            unit: $unit,
            allowed: $allowed,
            get: |settings| Value::Integer(i64::try_from(settings.$($field).+).unwrap_or(i64::MAX)),
            set: |settings, value| {
                let count = value.as_integer().and_then(|n| usize::try_from(n).ok());
                if let Some(count) = count {
                    settings.$($field).+ = count;
                }
            },
        }
    };
    (@word $id:literal, $unit:literal, $words:expr, forecast) => {
        keys!(@named $id, $unit, $words, forecast, Forecast)
    };
    (@word $id:literal, $unit:literal, $words:expr, traffic) => {
        keys!(@named $id, $unit, $words, traffic, TrafficMode)
    };
    (@word $id:literal, $unit:literal, $words:expr, planner.rules) => {
        PlannerKey {
            id: $id,
            unit: $unit,
            allowed: Words($words),
            get: |settings| settings.planner.rules.name().into(),
            set: |settings, value| {
                if let Some(rules) = value.as_str().and_then(RuleMode::parse) {
                    settings.planner.rules = rules;
                }
            },
        }
    };
    (@named $id:literal, $unit:literal, $words:expr, $field:ident, $type:ident) => {
        PlannerKey {
            id: $id,
            unit: $unit,
            allowed: Words($words),
            get: |settings| settings.$field.name().into(),
            set: |settings, value| {
                if let Some(named) = value.as_str().and_then($type::parse) {
                    settings.$field = named;
                }
            },
        }
    };
    (@vehicle $id:literal, $unit:literal, $bounds:expr, planner.vehicle) => {
        PlannerKey {
            id: $id,
            unit: $unit,
            allowed: Whole($bounds),
            get: |settings| Value::Integer(settings.planner.vehicle.number().into()),
            set: |settings, value| {
                if let Some(vehicle) = VehicleType::parse(&value.to_string()) {
                    settings.planner.vehicle = vehicle;
                }
            },
        }
    };
}

/// Weights may be anything that cannot hurt.
const WEIGHT: RangeInclusive<f64> = 0.0..=1e6;

impl PlannerKey {
    /// Every key, in the order of the documentation.
    pub const ALL: &'static [Self] = keys! {
        "horizon" "s" number 0.5..=20.0 => planner.horizon;
        "replan" "steps" whole 1..=1000 => replan;
        "prediction" "" word &["recorded", "constant-velocity", "lane"] => forecast;
        "traffic" "" word &["recorded", "reactive"] => traffic;
        "rules" "" word &["obey", "off"] => planner.rules;
        "vehicle" "" vehicle 1..=4 => planner.vehicle;
        "share" "" number 0.1..=1.0 => planner.share;
        "low_speed" "m/s" number 0.0..=20.0 => planner.low_speed;
        "margin" "m" number 0.0..=5.0 => planner.margin;
        "braking" "m/s²" number 0.5..=20.0 => planner.braking;
        "reaction" "s" number 0.0..=5.0 => planner.reaction;
        "sampling.durations" "" whole 1..=12 => planner.sampling.durations;
        "sampling.speeds" "" whole 2..=30 => planner.sampling.speeds;
        "sampling.offsets" "" odd 3..=31 => planner.sampling.offsets;
        "sampling.changes" "" whole 1..=6 => planner.sampling.changes;
        "sampling.widest" "m" number 0.1..=20.0 => planner.sampling.widest;
        "sampling.refinements" "" whole 0..=3 => planner.sampling.refinements;
        "weights.longitudinal_jerk" "" number WEIGHT => planner.weights.longitudinal_jerk;
        "weights.lateral_jerk" "" number WEIGHT => planner.weights.lateral_jerk;
        "weights.acceleration" "" number WEIGHT => planner.weights.acceleration;
        "weights.speed" "" number WEIGHT => planner.weights.speed;
        "weights.offset" "" number WEIGHT => planner.weights.offset;
        "weights.clearance" "" number WEIGHT => planner.weights.clearance;
        "weights.following" "" number WEIGHT => planner.weights.following;
        "weights.risk" "" number WEIGHT => planner.weights.risk;
    };

    /// The values that settings have, by key.
    #[must_use]
    pub fn values(settings: &Settings) -> BTreeMap<&'static str, Value> {
        let all = Self::ALL.iter();
        all.map(|key| (key.id, key.value(settings))).collect()
    }

    /// The value that settings have for it.
    #[must_use]
    pub fn value(&self, settings: &Settings) -> Value {
        (self.get)(settings)
    }

    /// Gives settings a value for it.
    ///
    /// # Errors
    /// It may not have this value: what is needed, in words.
    pub fn set(&self, settings: &mut Settings, value: &Value) -> Result<(), String> {
        if !self.allows(value) {
            return Err(format!("planner.{} = {value}: {}", self.id, self.needed()));
        }
        (self.set)(settings, value);
        Ok(())
    }

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
            (Odd(range), Value::Integer(n)) => n % 2 != 0 && range.contains(n),
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
                "expected a number from {} to {}{unit}",
                range.start(),
                range.end()
            ),
            Whole(range) => format!(
                "expected a whole number from {} to {}{unit}",
                range.start(),
                range.end()
            ),
            Odd(range) => format!(
                "expected an odd number from {} to {}{unit}",
                range.start(),
                range.end()
            ),
            Words(words) => {
                let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                match words.split_last() {
                    Some((last, others)) => format!("expected {} or {last}", others.join(", ")),
                    None => String::new(),
                }
            }
        }
    }
}

impl Config {
    /// These settings, changed as the section `[planner]` of the file says.
    #[must_use]
    pub fn planning(&self, mut settings: Settings) -> Settings {
        for key in PlannerKey::ALL {
            if let Some(value) = stated_value(&self.planner, key).filter(|value| key.allows(value))
            {
                (key.set)(&mut settings, value);
            }
        }
        settings
    }
}

/// The value that a section has for a key, if it says one.
fn stated_value<'a>(section: &'a Table, key: &PlannerKey) -> Option<&'a Value> {
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
            Value::Table(table) if external_planner::is_name(name) => {
                found.extend(external_planner::wrong(name, table).map(|(key, words)| {
                    (std::iter::once(name.clone()).chain(key).collect(), words)
                }));
            }
            value => {
                let words = if TABLES.contains(&name.as_str()) {
                    Some(format!(
                        "planner.{name} = {}: expected a table: [planner.{name}]",
                        shown(value)
                    ))
                } else {
                    wrong_value(name, value)
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
        return Some(format!("unknown key `planner.{id}`{}", near(id, &all)));
    };
    (!key.allows(value)).then(|| format!("planner.{id} = {}: {}", shown(value), key.needed()))
}

#[cfg(test)]
#[path = "planner_tests.rs"]
mod tests;
