//! `[planner]` of `config.toml`: keys of the planner with what each may be, and planners that are processes of their own.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::time::Duration;

use Allowed::{Number, Odd, Whole, Words};
use nearmiss_drive::planner::{Forecast, RuleMode};
use nearmiss_drive::simulation::{ExternalOptions, Settings, TrafficMode};
use nearmiss_scene::scenario::VehicleType;
use toml::{Table, Value};

use super::Config;
use super::config::{near, shown};

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

/// The names of the built-in planner's tables in the section; other tables are planners of their own.
const TABLES: [&str; 2] = ["sampling", "weights"];

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
            Value::Table(table) if is_name(name) => {
                found.extend(wrong_external(name, table).map(|(key, words)| {
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

/// The keys of a table, and what is needed behind each.
const KEYS: [(&str, &str); 5] = [
    (
        "command",
        "expected a command as text or as a list of words",
    ),
    ("start_timeout", "expected a number from 0.1 to 3600 s"),
    ("timeout", "expected a number from 0.001 to 3600 s"),
    ("predictions", "expected true or false"),
    ("history", "expected a whole number from 0 to 1000 steps"),
];

const START: RangeInclusive<f64> = 0.1..=3600.0;

const CYCLE: RangeInclusive<f64> = 0.001..=3600.0;

const HISTORY: RangeInclusive<i64> = 0..=1000;

impl Config {
    /// The planners of the file that are processes, by name, in the order of names.
    #[must_use]
    pub fn external_planners(&self) -> Vec<(String, ExternalOptions)> {
        let tables = self.planner.iter().filter_map(|(name, value)| {
            let table = value.as_table().filter(|_| is_name(name))?;
            Some((name.clone(), options(table)?))
        });
        tables.collect()
    }
}

/// Whether a table of this name in the section is a planner's: it is none of the built-in planner's keys.
fn is_name(name: &str) -> bool {
    !TABLES.contains(&name) && PlannerKey::named(name).is_none()
}

/// The options that a table says; nothing where it is wrong.
fn options(table: &Table) -> Option<ExternalOptions> {
    if wrong_external("", table).next().is_some() {
        return None;
    }
    let mut options = ExternalOptions::new(command(table.get("command")?)?);
    let seconds = |name: &str| {
        table
            .get(name)
            .and_then(number)
            .map(Duration::from_secs_f64)
    };
    options.start = seconds("start_timeout").unwrap_or(options.start);
    options.cycle = seconds("timeout").unwrap_or(options.cycle);
    let predictions = table.get("predictions").and_then(Value::as_bool);
    options.predictions = predictions.unwrap_or_default();
    let history = table.get("history").and_then(Value::as_integer);
    options.history = history.and_then(|n| usize::try_from(n).ok()).unwrap_or(0);
    Some(options)
}

fn number(value: &Value) -> Option<f64> {
    let whole = value.as_integer().map(|n| n as f64);
    whole.or(value.as_float())
}

fn command(value: &Value) -> Option<Vec<String>> {
    let words = match value {
        Value::String(line) => ExternalOptions::split_command(line).ok()?,
        Value::Array(words) => {
            let words = words.iter().map(|word| word.as_str().map(String::from));
            words.collect::<Option<Vec<String>>>()?
        }
        _ => return None,
    };
    let named = words.first().is_some_and(|program| !program.is_empty());
    named.then_some(words)
}

/// What is wrong with the table of planner `name`: the key, and words.
fn wrong_external(name: &str, table: &Table) -> impl Iterator<Item = (Option<String>, String)> {
    let missing = (!table.contains_key("command")).then(|| {
        let keys = PlannerKey::ALL.iter().map(|key| key.id).chain(TABLES);
        let meant = nearmiss_base::system::nearest(name, keys);
        let words = match meant {
            Some(known) => format!("unknown key `planner.{name}`; did you mean `{known}`?"),
            None => format!("planner.{name}: command is missing"),
        };
        (None, words)
    });
    let values = table.iter().filter_map(move |(key, value)| {
        let words = wrong_external_value(name, key, value)?;
        Some((Some(key.clone()), words))
    });
    let taken = (name == "nearmiss").then(|| {
        let words = "planner.nearmiss: this is the name of the built-in planner".to_string();
        (None, words)
    });
    let missing = missing.into_iter().chain(taken);
    missing.chain(values.collect::<Vec<_>>())
}

fn wrong_external_value(name: &str, key: &str, value: &Value) -> Option<String> {
    let Some((_, needed)) = KEYS.iter().find(|(known, _)| *known == key) else {
        let all = KEYS.map(|(known, _)| known);
        return Some(format!(
            "unknown key `planner.{name}.{key}`{}",
            near(key, &all)
        ));
    };
    let within = |range: RangeInclusive<f64>| number(value).is_some_and(|n| range.contains(&n));
    let right = match key {
        "command" => command(value).is_some(),
        "start_timeout" => within(START),
        "timeout" => within(CYCLE),
        "predictions" => value.is_bool(),
        _ => value.as_integer().is_some_and(|n| HISTORY.contains(&n)),
    };
    (!right).then(|| format!("planner.{name}.{key} = {}: {needed}", shown(value)))
}

#[cfg(test)]
#[path = "planner_tests.rs"]
mod planner_tests;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn read(text: &str) -> Result<Config, String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("config.toml");
        std::fs::write(&file, text).unwrap();
        Config::read(&file).map_err(|error| error.to_string())
    }

    #[test]
    fn planners_stand_beside_the_keys_of_the_built_in_one() {
        let config = read(
            "[planner]\nhorizon = 3\n[planner.weights]\nspeed = 2\n\
             [planner.lab]\ncommand = \"python3 'my planner.py' --fast\"\ntimeout = 0.5\nhistory = 10\n\
             [planner.other]\ncommand = [\"./other\", \"a b\"]\nstart_timeout = 120\npredictions = true\n",
        );
        let planners = config.unwrap().external_planners();
        let names: Vec<&str> = planners.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["lab", "other"]);
        let (lab, other) = (&planners[0].1, &planners[1].1);
        assert_eq!(lab.command, ["python3", "my planner.py", "--fast"]);
        assert_eq!((lab.cycle, lab.history), (Duration::from_millis(500), 10));
        assert_eq!(lab.start, ExternalOptions::START);
        assert_eq!(other.command, ["./other", "a b"]);
        assert_eq!(
            (other.start, other.predictions),
            (Duration::from_secs(120), true)
        );
    }

    #[test]
    fn what_a_planner_may_not_be_is_named_with_its_line() {
        for (text, said) in [
            ("timeout = 1", ":1: planner.lab: command is missing"),
            (
                "command = \"\"",
                ":2: planner.lab.command = \"\": expected a command",
            ),
            ("command = \"a 'b\"", ":2: planner.lab.command"),
            (
                "command = \"a\"\ntimeout = 0",
                ":3: planner.lab.timeout = 0: expected a number from 0.001",
            ),
            (
                "command = \"a\"\ntimout = 1",
                ":3: unknown key `planner.lab.timout`; did you mean `timeout`?",
            ),
            (
                "command = \"a\"\nhistory = 1.5",
                ":3: planner.lab.history = 1.5: expected a whole number",
            ),
            (
                "command = \"a\"\npredictions = 1",
                ":3: planner.lab.predictions = 1: expected true",
            ),
        ] {
            let error = read(&format!("[planner.lab]\n{text}\n")).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
        let error = read("[planner.wieghts]\nspeed = 1\n").unwrap_err();
        assert!(error.contains("did you mean `weights`?"), "{error}");
        let error = read("[planner.horizon]\ncommand = \"a\"\n").unwrap_err();
        assert!(
            error.contains("planner.horizon = a table: expected a number"),
            "{error}"
        );
    }
}
