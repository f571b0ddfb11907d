//! `[planner.NAME]` of `config.toml`: planners that are processes of their own.

use std::ops::RangeInclusive;
use std::time::Duration;

use toml::{Table, Value};

use super::Config;
use super::planner::{PlannerKey, TABLES};
use super::validation::{near, shown};
use nearmiss_drive::simulation::ExternalOptions;

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
pub(super) fn is_name(name: &str) -> bool {
    !TABLES.contains(&name) && PlannerKey::named(name).is_none()
}

/// The options that a table says; nothing where it is wrong.
fn options(table: &Table) -> Option<ExternalOptions> {
    if wrong("", table).next().is_some() {
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
pub(super) fn wrong(name: &str, table: &Table) -> impl Iterator<Item = (Option<String>, String)> {
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
        let words = wrong_value(name, key, value)?;
        Some((Some(key.clone()), words))
    });
    let taken = (name == "nearmiss").then(|| {
        let words = "planner.nearmiss: this is the name of the built-in planner".to_string();
        (None, words)
    });
    let missing = missing.into_iter().chain(taken);
    missing.chain(values.collect::<Vec<_>>())
}

fn wrong_value(name: &str, key: &str, value: &Value) -> Option<String> {
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
