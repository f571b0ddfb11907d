//! Which planners drive (`--planner`), and their settings: from `--set`, else the configuration, else the defaults.

use std::collections::BTreeMap;
use std::sync::Arc;

use nearmiss_drive::driver::driver;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{Clock, ExternalPlanner, Policy, Settings};
use nearmiss_formats::Entry;
use nearmiss_record::fields::Layers;
use nearmiss_settings::{Config, Planning};
use nearmiss_workflow::drive::{BUILT_IN, PlannerChoice, RECORDED};
use nearmiss_workflow::prepare_beside;
use serde::Serialize;
use toml::Value;

use super::monitor::MonitorOptions;
use crate::{Failure, knobs, output};

/// Which planning problem is solved.
#[derive(Debug, clap::Args)]
pub struct ProblemOption {
    /// Planning problem to solve [default: that of the recorded ego, else the first of each scenario].
    #[arg(long, value_name = "ID", allow_negative_numbers = true)]
    pub planning_problem: Option<i64>,
}

/// How motions are planned: as the configuration says, and over that what is set.
pub fn planning(set: &[(String, String)], config: &Config) -> Result<Planning, Failure> {
    let mut layers = Layers::default();
    layers.fields("config.toml: planner.", &config.planning());
    knobs::read(layers, set)
}

/// The settings of a run by the names of the configuration and of options.
#[derive(Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct RunOptions<'a> {
    #[serde(flatten)]
    planning: BTreeMap<String, Value>,
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
            planning: Planning::values(settings).into_iter().collect(),
            planner: match (settings.policy, process) {
                (Some(policy), _) => policy.name().into(),
                (None, Some(options)) => options.command.join(" "),
                (None, None) => BUILT_IN.into(),
            },
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

/// A driver that can drive: the ideal one has no rule.
pub fn driver_with_rule(word: &str) -> Result<Policy, String> {
    let driver = driver(word.trim())?;
    Policy::named(driver.id).ok_or_else(|| format!("{} has no rule to drive by", driver.name))
}

/// Planners that are processes.
#[derive(Debug, Clone, clap::Args)]
pub struct PlannerOptions {
    /// Planner that drives the ego [default: nearmiss]
    ///
    /// `nearmiss` (built-in), a [planner.NAME] of config.toml, or a command that speaks the planner protocol, without
    /// shell syntax (`nearmiss help planners`). `plan` compares two planners by paired differences with intervals; one
    /// of them may be `recorded`, the recorded ego.
    #[arg(long = "planner", value_name = "NAME|COMMAND", action = clap::ArgAction::Append)]
    planners: Vec<String>,
    /// Run in real time: a trajectory takes effect at the step it arrives, and the previous one is followed until then.
    /// Results vary between runs.
    #[arg(long, requires = "planners")]
    real_time: bool,
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

    fn choice(
        &self,
        said: &str,
        config: &Config,
        timeout: Option<f64>,
    ) -> Result<PlannerChoice, Failure> {
        let is_alone = self.planners.len() == 1;
        if said == BUILT_IN && self.real_time && is_alone {
            return Err(Failure::input(
                "--real-time needs a planner that is a process; the built-in planner is always waited for",
            ));
        }
        let known = config.external_planners();
        // Only beside a planner: alone there is nothing to drive.
        if said == RECORDED && self.planners.len() == 2 && !known.iter().any(|(k, _)| k == said) {
            return Ok(PlannerChoice {
                name: output::visible(said),
                is_recorded: true,
                ..PlannerChoice::default()
            });
        }
        let clock = if self.real_time {
            Clock::Real
        } else {
            Clock::Simulated
        };
        PlannerChoice::named(said, "--planner ", config, timeout, clock).map_err(Failure::input)
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
        { entries.iter() }.filter_map(|entry| prepare_beside(entry, problem, settings).ok());
    let prepared = prepared.next()?.driven_by(Some(Arc::clone(planner)));
    let said = prepared.greet(cancel).ok()??;
    let shown = |text: &str| output::visible(text);
    Some((shown(&said.name), shown(&said.version))).filter(|(name, _)| !name.is_empty())
}
