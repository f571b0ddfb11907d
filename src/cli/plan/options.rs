//! Planner settings: from the arguments, else the configuration, else the defaults.

use std::collections::BTreeMap;

use toml::Value;

use crate::Failure;
use nearmiss_drive::simulation::{ExternalPlanner, Settings, TrafficMode};
use nearmiss_settings::{Config, PlannerKey};
use nearmiss_study::evaluation::default_planning;

/// How to plan.
#[derive(Debug, clap::Args)]
pub struct PlanOptions {
    /// Prediction of the other road users: recorded (an oracle), constant-velocity or lane [default: `prediction` in
    /// config.toml, else lane].
    #[arg(long, value_name = "KIND", value_parser = ["recorded", "constant-velocity", "lane"])]
    prediction: Option<String>,
    /// Planning problem to solve [default: that of the recorded ego, else the first of each scenario].
    #[arg(long, value_name = "ID", allow_negative_numbers = true)]
    pub planning_problem: Option<i64>,
    /// Other road users: recorded (they follow their recording, whatever the ego does) or reactive (they react once the
    /// ego's deviation concerns them) [default: `traffic` in config.toml, else recorded].
    #[arg(long, value_name = "MODE", value_parser = ["recorded", "reactive"])]
    traffic: Option<String>,
    /// Traffic rules: obey (lights, stop signs, right of way, speed limits, as far as the map has them) or off [default:
    /// `rules` in config.toml, else obey].
    #[arg(long, value_name = "MODE", value_parser = ["obey", "off"])]
    rules: Option<String>,
    /// Steps driven before the next plan, at most the horizon [default: `replan` in config.toml, else 1].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = |word: &str| value("replan", word))]
    replan: Option<Value>,
    /// Planning horizon in seconds [default: `horizon` in config.toml, else 4].
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = |word: &str| value("horizon", word))]
    horizon: Option<Value>,
    /// Vehicle: 1 Ford Escort, 2 BMW 320i, 3 VW Vanagon, 4 truck [default: `vehicle` in config.toml, else 2].
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, value_parser = |word: &str| value("vehicle", word))]
    vehicle: Option<Value>,
}

/// A word of the command line as the value of a key of the configuration, in the same bounds.
fn value(id: &str, word: &str) -> Result<Value, String> {
    let key = PlannerKey::named(id).ok_or("unknown key")?;
    let whole = word.parse().map(Value::Integer);
    let number = whole.or_else(|_| word.parse().map(Value::Float)).ok();
    number.filter(|n| key.allows(n)).ok_or_else(|| key.needed())
}

/// The settings of a run by the names of the configuration, for messages about another run.
pub fn named(
    settings: &Settings,
    problem: Option<i64>,
    planner: Option<&ExternalPlanner>,
) -> BTreeMap<String, String> {
    let keys = PlannerKey::ALL.iter();
    let word = |value: Value| match value {
        Value::String(word) => word,
        other => other.to_string(),
    };
    let mut named: BTreeMap<String, String> = keys
        .map(|key| (key.id.to_string(), word(key.value(settings))))
        .collect();
    let planner = planner.map(|planner| planner.options());
    let command = planner.map_or("nearmiss".into(), |options| options.command.join(" "));
    named.insert("planner".into(), command);
    named.extend(problem.map(|id| ("planning-problem".into(), id.to_string())));
    if let Some(options) = planner {
        for (name, value) in [
            ("start_timeout", options.start.as_secs_f64().to_string()),
            ("timeout", options.cycle.as_secs_f64().to_string()),
            ("predictions", options.predictions.to_string()),
            ("history", options.history.to_string()),
            ("clock", options.clock.name().to_string()),
        ] {
            named.insert(name.into(), value);
        }
    }
    named
}

impl PlanOptions {
    /// Whether the command line asks for traffic that reacts.
    pub fn asks_for_reactions(&self) -> bool {
        self.traffic.as_deref() == Some(TrafficMode::Reactive.name())
    }

    /// What is planned with.
    pub fn settings(&self, config: &Config) -> Result<Settings, Failure> {
        let mut settings = config.planning(default_planning());
        let prediction = self.prediction.clone().map(Value::String);
        let traffic = self.traffic.clone().map(Value::String);
        let rules = self.rules.clone().map(Value::String);
        for (id, said) in [
            ("prediction", &prediction),
            ("traffic", &traffic),
            ("rules", &rules),
            ("replan", &self.replan),
            ("horizon", &self.horizon),
            ("vehicle", &self.vehicle),
        ] {
            if let (Some(value), Some(key)) = (said, PlannerKey::named(id)) {
                key.set(&mut settings, value).map_err(Failure::input)?;
            }
        }
        Ok(settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_held_to_the_bounds_of_the_configuration() {
        assert_eq!(value("horizon", "3"), Ok(Value::Integer(3)));
        assert_eq!(value("horizon", "2.5"), Ok(Value::Float(2.5)));
        for (id, word) in [
            ("horizon", "0"),
            ("horizon", "inf"),
            ("horizon", "long"),
            ("replan", "0"),
            ("replan", "1.5"),
            ("vehicle", "5"),
        ] {
            assert!(value(id, word).is_err(), "{id} {word}");
        }
    }
}
