//! `[planner.NAME]` of `config.toml`: planners that are processes of their own.

use std::time::Duration;

use nearmiss_base::system::nearest;
use nearmiss_drive::simulation::ExternalOptions;
use nearmiss_record::fields::{FieldValue, Fields, JsonSchema, Takes, Wrong};
use toml::{Table, Value};

use super::Config;
use super::planner::Planning;
use super::validation::wrong;

nearmiss_record::fields! {
    /// A planner that is a process.
    pub struct Process {
        "process" {
            /// Its program and arguments.
            command [required]: Command;
            /// Seconds until it has to be ready.
            start_timeout: Option<f64>, Takes::Number(0.1, 3600.0), "s";
            /// Seconds that it may take for a cycle.
            timeout: Option<f64>, Takes::Number(0.001, 3600.0), "s";
            /// Whether it is told predictions.
            predictions: bool;
            /// Steps of the past that it is told.
            history: usize, Takes::Whole(0, 1000), "steps";
        }
    }
}

/// A command: a line for a shell, or its words.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Command(Vec<String>);

impl FieldValue for Command {
    fn read(value: &Value, takes: &Takes) -> Result<Self, Wrong> {
        let words = match value {
            Value::String(line) => {
                ExternalOptions::split_command(line).map_err(|_| Wrong::kind())?
            }
            // Words may be the same.
            list => {
                let words = list.as_array().ok_or(Wrong::kind())?.iter();
                words
                    .map(|word| String::read(word, takes))
                    .collect::<Result<_, _>>()?
            }
        };
        match words.first() {
            Some(program) if !program.is_empty() => Ok(Self(words)),
            _ => Err(Wrong::kind()),
        }
    }

    fn write(&self) -> Option<Value> {
        Some(self.0.clone().into())
    }

    fn describe(_: &Takes) -> (String, JsonSchema) {
        let words = "a command as text or as a list of words";
        (words.into(), JsonSchema::default())
    }
}

impl Config {
    /// The planners of the file that are processes, by name, in the order of names.
    #[must_use]
    pub fn external_planners(&self) -> Vec<(String, ExternalOptions)> {
        let tables = self.planner.iter().filter_map(|(name, value)| {
            let table = value.as_table().filter(|_| is_name(name))?;
            Some((name.clone(), options(Process::from_table(table).ok()?)))
        });
        tables.collect()
    }
}

/// Whether a table of this name in the section is a planner's: it is none of the built-in planner's keys.
pub(super) fn is_name(name: &str) -> bool {
    !Planning::row(name).is_ok_and(|row| !row.is("run"))
}

fn options(process: Process) -> ExternalOptions {
    let mut options = ExternalOptions::new(process.command.0);
    let seconds = |seconds: Option<f64>| seconds.map(Duration::from_secs_f64);
    options.start = seconds(process.start_timeout).unwrap_or(options.start);
    options.cycle = seconds(process.timeout).unwrap_or(options.cycle);
    options.predictions = process.predictions;
    options.history = process.history;
    options
}

/// What is wrong with the table of planner `name`: the key, and a message.
pub(super) fn mistakes(
    name: &str,
    table: &Table,
) -> impl Iterator<Item = (Option<String>, String)> {
    let missing = (!table.contains_key("command")).then(|| {
        let keys = Planning::rows().iter().map(|row| row.key);
        let message = match nearest(name, keys) {
            Some(known) => format!("unknown key `planner.{name}`; did you mean `{known}`?"),
            None => format!("planner.{name}: command is missing"),
        };
        (None, message)
    });
    let values = table.iter().filter_map(move |(key, value)| {
        let message = wrong::<Process>(&format!("planner.{name}."), key, value)?;
        Some((Some(key.clone()), message))
    });
    let taken = (name == "nearmiss").then(|| {
        let message = "planner.nearmiss: this is the name of the built-in planner".to_string();
        (None, message)
    });
    let missing = missing.into_iter().chain(taken);
    missing.chain(values.collect::<Vec<_>>())
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
