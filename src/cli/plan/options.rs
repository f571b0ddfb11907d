//! Planner settings: from `--set`, else the configuration, else the defaults.

use std::collections::BTreeMap;

use serde::Serialize;
use toml::Value;

use super::monitor::MonitorOptions;
use super::planners::BUILT_IN;
use crate::Failure;
use crate::set::{Settable, number};
use nearmiss_drive::simulation::{ExternalPlanner, Settings, TrafficMode};
use nearmiss_settings::{Config, PlannerKey};
use nearmiss_study::evaluation::default_planning;

/// Which planning problem is solved.
#[derive(Debug, clap::Args)]
pub struct ProblemOption {
    /// Planning problem to solve [default: that of the recorded ego, else the first of each scenario].
    #[arg(long, value_name = "ID", allow_negative_numbers = true)]
    pub planning_problem: Option<i64>,
}

/// Settings of the planner that are given, by the keys of `[planner]`.
#[derive(Debug, Clone, Default)]
pub struct PlannerSettings {
    given: Vec<(&'static PlannerKey, Value)>,
    /// Seconds that a process may take for a cycle.
    pub timeout: Option<f64>,
}

/// The key of `[planner.NAME]`.
const TIMEOUT: &str = "timeout";

impl Settable for PlannerSettings {
    fn keys() -> Vec<&'static str> {
        let keys = PlannerKey::ALL.iter().map(|key| key.id);
        keys.chain([TIMEOUT]).collect()
    }

    fn set(&mut self, id: &str, word: &str) -> Result<(), String> {
        if id == TIMEOUT {
            self.timeout = Some(number(word, 0.001, 3600.0)?);
            return Ok(());
        }
        let key = PlannerKey::named(id).ok_or("unknown key")?;
        self.given.push((key, value(key, word)?));
        Ok(())
    }
}

/// A word of the command line as the value of a key of the configuration, in the same bounds.
fn value(key: &PlannerKey, word: &str) -> Result<Value, String> {
    let whole = word.parse().map(Value::Integer);
    let number = whole.or_else(|_| word.parse().map(Value::Float));
    let value = number.unwrap_or_else(|_| Value::String(word.into()));
    if key.allows(&value) {
        Ok(value)
    } else {
        Err(key.needed())
    }
}

/// The settings of a run by the names of the configuration and of options.
#[derive(Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct RunOptions<'a> {
    #[serde(flatten)]
    planning: BTreeMap<&'static str, Value>,
    planner: String,
    #[serde(flatten)]
    process: Option<ProcessOptions>,
    planning_problem: Option<i64>,
    #[serde(flatten)]
    monitor: Option<&'a MonitorOptions>,
}

/// How a planner's process is run, by the keys of `[planner.NAME]`.
#[derive(Serialize)]
struct ProcessOptions {
    start_timeout: f64,
    timeout: f64,
    predictions: bool,
    history: usize,
    clock: &'static str,
}

impl<'a> RunOptions<'a> {
    /// Those of a run.
    pub fn new(
        settings: &Settings,
        planning_problem: Option<i64>,
        planner: Option<&ExternalPlanner>,
        monitor: Option<&'a MonitorOptions>,
    ) -> Self {
        let process = planner.map(ExternalPlanner::options);
        Self {
            planning: PlannerKey::values(settings),
            planner: process.map_or(BUILT_IN.into(), |options| options.command.join(" ")),
            process: process.map(|options| ProcessOptions {
                start_timeout: options.start.as_secs_f64(),
                timeout: options.cycle.as_secs_f64(),
                predictions: options.predictions,
                history: options.history,
                clock: options.clock.name(),
            }),
            planning_problem,
            monitor,
        }
    }
}

impl PlannerSettings {
    /// Whether the command line asks for traffic that reacts.
    pub fn asks_for_reactions(&self) -> bool {
        let traffic = { self.given.iter() }.rfind(|(key, _)| key.id == "traffic");
        traffic.and_then(|(_, mode)| mode.as_str()) == Some(TrafficMode::Reactive.name())
    }

    /// What is planned with.
    pub fn over(&self, config: &Config) -> Result<Settings, Failure> {
        let mut settings = config.planning(default_planning());
        for (key, value) in &self.given {
            key.set(&mut settings, value).map_err(Failure::input)?;
        }
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn words_are_held_to_the_bounds_of_the_configuration() {
        let value = |id, word| value(PlannerKey::named(id).unwrap(), word);
        assert_eq!(value("horizon", "3"), Ok(Value::Integer(3)));
        assert_eq!(value("horizon", "2.5"), Ok(Value::Float(2.5)));
        assert_eq!(value("rules", "off"), Ok("off".into()));
        for (id, word) in [
            ("horizon", "0"),
            ("horizon", "inf"),
            ("horizon", "long"),
            ("replan", "0"),
            ("replan", "1.5"),
            ("vehicle", "5"),
            ("rules", "maybe"),
        ] {
            assert!(value(id, word).is_err(), "{id} {word}");
        }
    }
}
