//! `[planner]` of `config.toml`: how motions are planned, and planners that are processes of their own.

use std::time::Duration;

use nearmiss_base::system::nearest;
use nearmiss_drive::planner::{self, Forecast, RuleMode, Sampling, Weights};
use nearmiss_drive::simulation::{ExternalOptions, Settings, TrafficMode};
use nearmiss_record::fields::{FieldValue, Fields, JsonSchema, Takes, Wrong};
use nearmiss_scene::scenario::VehicleType;
use toml::{Table, Value};

use super::Config;
use super::config::wrong;

fn usual() -> planner::Settings {
    planner::Settings::default()
}

nearmiss_record::fields! {
    /// How motions are planned.
    pub struct Planning {
        "planner" {
            /// Planning horizon in seconds [default: 4].
            horizon: f64 = usual().horizon, Takes::Number(0.5, 20.0), "s";
            /// Steps of a plan that are driven before replanning [default: 1].
            replan: usize = 1, Takes::Whole(1, 1000), "steps";
            /// Prediction of the other road users: recorded, constant-velocity or lane [default: lane].
            prediction: Forecast = Forecast::Lane;
            /// Behaviour of the other road users: recorded or reactive [default: recorded].
            traffic: TrafficMode;
            /// Traffic rules: obey (lights, signs and right of way) or off [default: obey].
            rules: RuleMode;
            /// CommonRoad vehicle number, 1 to 4 [default: 2].
            vehicle: u32 = usual().vehicle.number().into(), Takes::Whole(1, 4);
            /// Share of the vehicle's forces and steering that plans may use [default: 0.95].
            share: f64 = usual().share, Takes::Number(0.1, 1.0);
            /// Speed in m/s below which the lateral offset is planned over arc length instead of time [default: 4].
            low_speed: f64 = usual().low_speed, Takes::Number(0.0, 20.0), "m/s";
            /// Distance kept from predicted bodies in metres [default: 0.1].
            margin: f64 = usual().margin, Takes::Number(0.0, 5.0), "m";
            /// Deceleration assumed for stopping distances in m/s² [default: 6].
            braking: f64 = usual().braking, Takes::Number(0.5, 20.0), "m/s²";
            /// Reaction time assumed for stopping distances in seconds [default: 0.5].
            reaction: f64 = usual().reaction, Takes::Number(0.0, 5.0), "s";
            /// Maximum time per cycle of an external planner in seconds [default: from its table].
            timeout [run]: Option<f64>, Takes::Number(0.001, 3600.0), "s";
            /// Sampling density.
            sampling: Sampling;
            /// Weights of the cost terms.
            weights: Weights;
        }
    }
}

impl Planning {
    /// The values that drives have, by key: those of its tables as `weights.risk`, last.
    #[must_use]
    pub fn values(settings: &Settings) -> Vec<(String, Value)> {
        let own = Self::from(settings);
        let mut all = values("", &own);
        all.retain(|(_, value)| !value.is_table());
        all.extend(values("sampling.", &own.sampling));
        all.extend(values("weights.", &own.weights));
        all
    }

    /// Every key, as [`Planning::values`] has them.
    pub fn keys() -> impl Iterator<Item = String> {
        let settings = Settings::from(&Self::default());
        let keys = Self::values(&settings).into_iter().map(|(key, _)| key);
        keys.chain(["timeout".into()])
    }
}

fn values<F: Fields>(table: &str, fields: &F) -> Vec<(String, Value)> {
    let rows = F::rows().iter();
    let value = |key: &str| Some((format!("{table}{key}"), fields.value(key)?));
    rows.filter_map(|row| value(row.key)).collect()
}

impl From<&Settings> for Planning {
    fn from(settings: &Settings) -> Self {
        let planner = &settings.planner;
        Self {
            horizon: planner.horizon,
            replan: settings.replan,
            prediction: settings.forecast,
            traffic: settings.traffic,
            rules: planner.rules,
            vehicle: planner.vehicle.number().into(),
            share: planner.share,
            low_speed: planner.low_speed,
            margin: planner.margin,
            braking: planner.braking,
            reaction: planner.reaction,
            timeout: None,
            sampling: planner.sampling,
            weights: planner.weights,
        }
    }
}

impl From<&Planning> for Settings {
    fn from(planning: &Planning) -> Self {
        let vehicle = VehicleType::parse(&planning.vehicle.to_string());
        Self {
            planner: planner::Settings {
                vehicle: vehicle.unwrap_or(usual().vehicle),
                horizon: planning.horizon,
                sampling: planning.sampling,
                weights: planning.weights,
                share: planning.share,
                low_speed: planning.low_speed,
                margin: planning.margin,
                braking: planning.braking,
                reaction: planning.reaction,
                rules: planning.rules,
            },
            forecast: planning.prediction,
            replan: planning.replan,
            without: None,
            traffic: planning.traffic,
            policy: None,
        }
    }
}

impl Config {
    /// How motions are planned, as the section `[planner]` of the file says.
    #[must_use]
    pub fn planning(&self) -> Planning {
        let mut own = self.planner.clone();
        own.retain(|name, _| !is_name(name));
        Planning::from_table(&own).unwrap_or_default()
    }
}

/// What is wrong with a section: the names that lead to each mistake from its beginning, and a message.
pub(super) fn mistakes(section: &Table) -> Vec<(Vec<String>, String)> {
    let mut found = Vec::new();
    for (name, value) in section {
        match (name.as_str(), value) {
            ("sampling", Value::Table(table)) => found.extend(in_table::<Sampling>(name, table)),
            ("weights", Value::Table(table)) => found.extend(in_table::<Weights>(name, table)),
            (_, Value::Table(table)) if is_name(name) => {
                let mistakes = process_mistakes(name, table);
                found.extend(mistakes.map(|(key, message)| {
                    (std::iter::once(name.clone()).chain(key).collect(), message)
                }));
            }
            _ => {
                let message = wrong::<Planning>("planner.", name, value);
                found.extend(message.map(|message| (vec![name.clone()], message)));
            }
        }
    }
    found
}

fn in_table<F: Fields>(name: &str, table: &Table) -> impl Iterator<Item = (Vec<String>, String)> {
    table.iter().filter_map(move |(key, value)| {
        let message = wrong::<F>(&format!("planner.{name}."), key, value)?;
        Some((vec![name.to_owned(), key.clone()], message))
    })
}

nearmiss_record::fields! {
    /// A planner that is a process.
    pub struct Process {
        "process" {
            /// Program and arguments.
            command [required]: Command;
            /// Maximum time in seconds until the planner is ready [default: 60].
            start_timeout: Option<f64>, Takes::Number(0.1, 3600.0), "s";
            /// Maximum time per cycle in seconds [default: 10].
            timeout: Option<f64>, Takes::Number(0.001, 3600.0), "s";
            /// Send predictions to the planner [default: false].
            predictions: bool;
            /// Past steps to send to the planner [default: 0].
            history: usize, Takes::Whole(0, 1000), "steps";
        }
    }
}

/// A command: a line for a shell, or its words.
#[derive(Debug, Clone, PartialEq, Default)]
struct Command(Vec<String>);

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
fn is_name(name: &str) -> bool {
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
fn process_mistakes(name: &str, table: &Table) -> impl Iterator<Item = (Option<String>, String)> {
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
    let whose = match name {
        "nearmiss" => Some("the built-in planner"),
        "recorded" => Some("the recorded ego"),
        _ => None,
    };
    let taken = whose.map(|whose| {
        let message = format!("planner.{name}: this is the name of {whose}");
        (None, message)
    });
    let missing = missing.into_iter().chain(taken);
    missing.chain(values.collect::<Vec<_>>())
}

#[cfg(test)]
#[path = "planner_tests.rs"]
mod tests;
