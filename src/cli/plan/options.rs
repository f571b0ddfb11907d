//! Which planners drive (`--planner`), and their settings: from `--set`, else the configuration, else the defaults.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use nearmiss_base::system::{did_you_mean, is_program};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{Clock, ExternalOptions, ExternalPlanner, Settings, TrafficMode};
use nearmiss_formats::Entry;
use nearmiss_settings::{Config, PlannerKey};
use nearmiss_study::evaluation::default_planning;
use serde::Serialize;
use toml::Value;

use super::driven::request;
use super::monitor::MonitorOptions;
use crate::set::{Settable, number};
use crate::{Failure, output};

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

/// The built-in planner's name.
pub const BUILT_IN: &str = "nearmiss";

/// The recorded ego in place of a planner, beside one.
pub const RECORDED: &str = "recorded";

/// Planners that are processes.
#[derive(Debug, Clone, clap::Args)]
pub struct PlannerOptions {
    /// Planner that drives: `nearmiss` (the built-in one), a [planner.NAME] of config.toml, or a command that speaks
    /// the planner protocol, split into words without a shell (`nearmiss help planners`). `plan` compares two: paired
    /// differences with intervals; `recorded` beside a planner is the recorded ego.
    #[arg(long = "planner", value_name = "NAME|COMMAND", action = clap::ArgAction::Append)]
    planners: Vec<String>,
    /// Do not wait for the planner: a trajectory counts from the time step at which it is there, until then the one
    /// before is driven. Measured times differ from run to run, and with them the drive.
    #[arg(long, requires = "planners")]
    real_time: bool,
}

/// A planner that was named.
#[derive(Debug, Clone)]
pub struct PlannerChoice {
    /// Its name: that of the configuration, else its command.
    pub name: String,
    /// Its process; `None` for the built-in planner.
    pub external: Option<Arc<ExternalPlanner>>,
    /// It is the recorded ego.
    pub is_recorded: bool,
}

impl PlannerOptions {
    /// The planners that were named, in order; none for the built-in one without a word about it.
    ///
    /// # Errors
    /// One of them is neither known nor a program.
    pub fn chosen(
        &self,
        config: &Config,
        timeout: Option<f64>,
    ) -> Result<Vec<PlannerChoice>, Failure> {
        if timeout.is_some() && self.planners.is_empty() {
            return Err(Failure::input(
                "--set timeout is for a planner that is a process: --planner NAME",
            ));
        }
        let planners = self.planners.iter();
        planners
            .map(|said| self.choice(said, config, timeout))
            .collect()
    }

    /// The one planner that was named, for commands that take only one.
    ///
    /// # Errors
    /// See [`Self::chosen`]; several are named.
    pub fn only(
        &self,
        config: &Config,
        timeout: Option<f64>,
    ) -> Result<Option<PlannerChoice>, Failure> {
        let mut chosen = self.chosen(config, timeout)?;
        match chosen.len() {
            0 | 1 => Ok(chosen.pop()),
            count => Err(Failure::input(format!(
                "{count} planners are named, but only one can drive here"
            ))),
        }
    }

    /// The planner of this name or command, with nothing else said about it.
    ///
    /// # Errors
    /// It is neither known nor a program.
    pub fn named(said: &str, config: &Config) -> Result<PlannerChoice, Failure> {
        let alone = Self {
            planners: vec![said.into()],
            real_time: false,
        };
        alone.choice(said, config, None)
    }

    fn choice(
        &self,
        said: &str,
        config: &Config,
        timeout: Option<f64>,
    ) -> Result<PlannerChoice, Failure> {
        let name = output::visible(said);
        if said == BUILT_IN {
            return if self.real_time && self.planners.len() == 1 {
                Err(Failure::input(
                    "--real-time needs a planner that is a process; the built-in planner is always waited for",
                ))
            } else {
                Ok(PlannerChoice {
                    name,
                    external: None,
                    is_recorded: false,
                })
            };
        }
        let known = config.external_planners();
        let found = known.iter().find(|(known, _)| known == said);
        // Only beside a planner: alone there is nothing to drive.
        if said == RECORDED && found.is_none() && self.planners.len() == 2 {
            return Ok(PlannerChoice {
                name,
                external: None,
                is_recorded: true,
            });
        }
        let mut options = match found {
            Some((_, options)) => options.clone(),
            None => command(said, known.iter().map(|(name, _)| name.as_str()))?,
        };
        if let Some(program) = options.command.first().filter(|p| !is_program(p)) {
            let of = match found {
                Some(_) => format!("`command` of [planner.{name}] in config.toml"),
                None => format!("--planner {name}"),
            };
            let program = output::visible(program);
            return Err(Failure::input(format!("{of}: no such program: {program}")));
        }
        if let Some(seconds) = timeout {
            options.cycle = Duration::from_secs_f64(seconds);
        }
        if self.real_time {
            options.clock = Clock::Real;
        }
        let external = Some(Arc::new(ExternalPlanner::new(name.clone(), options)));
        Ok(PlannerChoice {
            name,
            external,
            is_recorded: false,
        })
    }
}

/// Name and version of a planner as its process says them, asked with the first scenario that can be driven; nothing
/// where it does not get ready.
pub fn identity(
    entries: &[Entry],
    problem: Option<i64>,
    settings: &Settings,
    planner: &Arc<ExternalPlanner>,
    cancel: &Cancel,
) -> Option<(String, String)> {
    let mut prepared =
        { entries.iter() }.filter_map(|entry| request(entry, problem, settings).ok());
    let prepared = prepared.next()?.driven_by(Some(Arc::clone(planner)));
    let said = prepared.greet(cancel).ok()??;
    let shown = |text: &str| output::visible(text);
    Some((shown(&said.name), shown(&said.version))).filter(|(name, _)| !name.is_empty())
}

/// The options of a command that is no name of a planner.
fn command<'a>(
    said: &str,
    known: impl Iterator<Item = &'a str>,
) -> Result<ExternalOptions, Failure> {
    let words = ExternalOptions::split_command(said)
        .map_err(|why| Failure::input(format!("--planner {said}: {why}")))?;
    // A name that is mistyped is no program.
    if let [program] = &words[..]
        && !is_program(program)
    {
        let all: Vec<&str> = std::iter::once(BUILT_IN).chain(known).collect();
        return Err(Failure::input(format!(
            "--planner {program}: no planner of this name and no such program{}; available: {}",
            did_you_mean(program, all.iter().copied()),
            all.join(", ")
        )));
    }
    Ok(ExternalOptions::new(words))
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
