//! Planner settings: from `--set`, else the configuration, else the defaults.

use std::collections::BTreeMap;

use serde::Serialize;
use toml::Value;

use super::monitor::MonitorOptions;
use super::planners::BUILT_IN;
use crate::{Failure, knobs};
use nearmiss_drive::simulation::{ExternalPlanner, Settings};
use nearmiss_record::fields::Layers;
use nearmiss_settings::{Config, Planning};

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
