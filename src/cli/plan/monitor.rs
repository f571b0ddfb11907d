//! `plan --monitor`: which judge watches the drives, what it said of them, and what its questions cost.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nearmiss_ask::prompts::Library;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::Entry;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::{Config, Folders};
use nearmiss_store::Store;
use nearmiss_study::evaluation::Judge;
use nearmiss_workflow::drive::{MonitorRecord, median};
use nearmiss_workflow::{Monitor, MonitorCost, Server, prepare_beside};
use schemars::JsonSchema;
use serde::Serialize;
use tokio::runtime::Runtime;

use crate::ask::budget;
use crate::many_files::{Job, NEXT};
use crate::open::{configured_models, configured_parameters, judge_of, runtime, user_thresholds};
use crate::prompts::templates;
use crate::{Failure, Outcome, output};

/// A judge beside the planner.
#[derive(Debug, clap::Args, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct MonitorOptions {
    /// Ask a judge the safety question during the drive: reference/geometry or provider/model. Answers take effect when
    /// they arrive; those of models are stored.
    #[arg(long, value_name = "MODEL")]
    monitor: Option<String>,
    /// Simulated seconds between two questions, 0.05 to 60, rounded to a time step.
    #[arg(long, value_name = "SECONDS", default_value_t = EVERY, value_parser = interval, requires = "monitor")]
    monitor_every: f64,
    /// Fixed latency of every answer in seconds, 0 to 60, instead of the measured one.
    #[arg(long, value_name = "SECONDS", value_parser = latency, requires = "monitor")]
    monitor_latency: Option<f64>,
    /// Brake fully instead of following the plan while the latest answer is critical.
    #[arg(long, value_name = "VERDICT", value_parser = ["critical"], requires = "monitor")]
    brake_on: Option<String>,
    /// Server address of the monitor, instead of the provider's own.
    #[arg(long, value_name = "URL", requires = "monitor")]
    base_url: Option<String>,
    /// Maximum cost of all answers of the monitor in US dollars; needs a known price and a token limit [default:
    /// `budget` in config.toml, else none].
    #[arg(long, value_name = "USD", requires = "monitor", allow_negative_numbers = true, value_parser = budget)]
    budget: Option<f64>,
    /// Ask the model even if its answer is stored.
    #[arg(long, requires = "monitor")]
    fresh: bool,
    /// Print the number of questions and their maximum cost; send and write nothing.
    #[arg(long, requires = "monitor")]
    #[serde(skip)]
    dry_run: bool,
}

/// Seconds between two questions.
const EVERY: f64 = 1.0;

fn interval(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|s| (0.05..=60.0).contains(s));
    seconds.ok_or_else(|| "expected 0.05 to 60 seconds".into())
}

fn latency(text: &str) -> Result<f64, String> {
    let seconds = text.parse().ok().filter(|s| (0.0..=60.0).contains(s));
    seconds.ok_or_else(|| "expected 0 to 60 seconds".into())
}

/// A judge, ready to watch drives.
pub struct MonitorSetup {
    judge: Judge,
    library: Library,
    thresholds: Arc<Thresholds>,
    store: Option<Arc<Store>>,
    runtime: Runtime,
    settings: nearmiss_study::evaluation::Settings,
    every: f64,
    latency: Option<f64>,
    brake: bool,
    fresh: bool,
    budget: Option<f64>,
}

impl MonitorOptions {
    /// Whether there is a monitor.
    pub fn is_asked(&self) -> bool {
        self.monitor.is_some()
    }

    /// Whether the drives are only counted.
    pub fn is_dry_run(&self) -> bool {
        self.dry_run
    }

    /// The judge, if one is named.
    pub fn setup(
        &self,
        folders: &Folders,
        config: &Config,
    ) -> Result<Option<MonitorSetup>, Failure> {
        let Some(model) = &self.monitor else {
            return Ok(None);
        };
        let mut providers = config.provider.clone();
        if let Some(url) = &self.base_url {
            let named = model
                .split_once('/')
                .filter(|(name, _)| *name != "reference");
            let (name, _) = named.ok_or_else(|| {
                Failure::input(
                    "--base-url needs --monitor provider/model with any provider name, e.g. local/default",
                )
            })?;
            let server = Server {
                url,
                ..Server::default()
            };
            server.overlay(&mut providers, name);
        }
        let budget = self.budget.or(config.budget);
        let models = configured_models(&providers, folders, configured_parameters(config), budget);
        let judge = judge_of(&models, model)?;
        if matches!(judge, Judge::Recorded(_)) {
            return Err(Failure::input(format!(
                "--monitor {model}: recorded answers are about recorded drives; name reference/geometry or a model that can be asked"
            )));
        }
        let library = templates(folders)?;
        let store = match judge {
            Judge::Model(_) => Some(Arc::new(
                Store::open(&folders.store()).map_err(Failure::input)?,
            )),
            _ => None,
        };
        Ok(Some(MonitorSetup {
            judge,
            library,
            thresholds: Arc::new(user_thresholds(folders)?),
            store,
            runtime: runtime(1)?,
            settings: nearmiss_study::evaluation::Settings {
                history: config.history,
                ..Default::default()
            },
            every: self.monitor_every,
            latency: self.monitor_latency,
            brake: self.brake_on.is_some(),
            fresh: self.fresh,
            budget,
        }))
    }
}

impl MonitorSetup {
    /// What watches one drive.
    pub fn monitor(&self) -> Monitor<'_> {
        Monitor {
            judge: &self.judge,
            library: &self.library,
            settings: self.settings,
            thresholds: Arc::clone(&self.thresholds),
            store: self.store.clone(),
            runtime: self.runtime.handle(),
            every: self.every,
            latency: self.latency,
            brake: self.brake,
            fresh: self.fresh,
        }
    }

    /// Says what the questions cost before any is sent; nothing of the built-in judge, which is free.
    pub fn announce(
        &self,
        entries: &[Entry],
        problem: Option<i64>,
        settings: &Settings,
        stop: &Arc<AtomicBool>,
    ) -> Outcome {
        if matches!(self.judge, Judge::Model(_)) {
            let cost = self.cost(entries, problem, settings, stop)?;
            output::say(&format!("nearmiss: {}", self.words(&cost)));
        }
        Ok(())
    }

    /// Writes what the questions cost; nothing is sent.
    pub fn dry_run(
        &self,
        entries: &[Entry],
        problem: Option<i64>,
        settings: &Settings,
        stop: &Arc<AtomicBool>,
        as_json: bool,
    ) -> Outcome {
        let cost = self.cost(entries, problem, settings, stop)?;
        if as_json {
            return output::document(&MonitorDryRun {
                model: self.judge.id().into(),
                scenarios: entries.len(),
                questions: cost.questions,
                input_tokens: cost.tokens,
                most_usd: cost.most_usd,
                budget_usd: self.budget,
            });
        }
        output::text(&format!("{}\n", self.words(&cost)))
    }

    /// The questions of all drives, as if no warning braked; of scenarios that cannot be planned none.
    fn cost(
        &self,
        entries: &[Entry],
        problem: Option<i64>,
        settings: &Settings,
        stop: &Arc<AtomicBool>,
    ) -> Result<MonitorCost, Failure> {
        let cancel = Cancel::from_flag(stop);
        let none = || MonitorCost {
            most_usd: Some(0.0),
            ..MonitorCost::default()
        };
        let mut all = none();
        let one = |entry: &Entry| {
            let prepared = prepare_beside(entry, problem, settings);
            match prepared.map(|prepared| prepared.monitor_cost(&self.monitor(), &cancel)) {
                Ok(Ok(cost)) => cost,
                // The drive itself says why.
                Ok(Err(_)) | Err(_) => Some(none()),
            }
        };
        let done = Job::new("scenarios", stop).run(entries, one, |_, cost| {
            all = all.and(cost);
            NEXT
        });
        done.end("nothing was sent")?;
        Ok(all)
    }

    fn words(&self, cost: &MonitorCost) -> String {
        let braking = if self.brake {
            ", counted without braking"
        } else {
            ""
        };
        let price = match (cost.most_usd, &self.judge) {
            (_, Judge::Reference) => "free: the built-in judge".into(),
            (Some(usd), _) => format!("at most ${usd:.4}, less what the store has"),
            (None, _) => {
                "cost not bounded: no price or no token limit (max_tokens in config.toml)".into()
            }
        };
        let budget = self
            .budget
            .map_or(String::new(), |usd| format!("; budget ${usd}"));
        format!(
            "{}: {}, about {} tokens{braking}; {price}{budget}",
            self.judge.id(),
            output::counted(cost.questions, "question"),
            cost.tokens,
        )
    }
}

/// What the questions of a monitor cost.
#[derive(Debug, Serialize, JsonSchema)]
pub struct MonitorDryRun {
    /// The judge.
    pub model: String,
    /// Scenarios.
    pub scenarios: usize,
    /// Questions at most.
    pub questions: usize,
    /// Tokens of all questions, estimated.
    pub input_tokens: u64,
    /// Maximum cost, US dollars; null if it is not bounded.
    pub most_usd: Option<f64>,
    /// The budget, US dollars.
    pub budget_usd: Option<f64>,
}

/// Names of the columns of a monitor in the table.
pub const HEADER: [&str; 7] = [
    "warnings",
    "first s",
    "lead s",
    "false/min",
    "latency s",
    "brakes s",
    "braked s",
];

/// The cells of these columns.
pub fn cells(report: &MonitorRecord) -> [String; 7] {
    let number = |value: Option<f64>, decimals: usize| {
        value.map_or("-".into(), |value| format!("{value:.decimals$}"))
    };
    let warnings = match (report.warnings.len(), report.without_verdict) {
        (warnings, 0) => warnings.to_string(),
        (warnings, n) => format!("{warnings} ({n} unanswered)"),
    };
    [
        warnings,
        number(report.first_warning_seconds, 1),
        number(report.lead_seconds, 1),
        number(report.false_alarms_per_minute, 1),
        number(report.latency_in_force_seconds, 3),
        number(report.first_braking_seconds, 1),
        number(report.braked_seconds.filter(|s| *s > 0.0), 1),
    ]
}

/// What monitors said of all drives.
#[derive(Debug, Default)]
pub struct Totals {
    drives: usize,
    warnings: usize,
    false_alarms: usize,
    incidents: usize,
    leads: Vec<f64>,
    braked: usize,
    seconds: f64,
}

impl Totals {
    /// Counts a drive.
    pub fn add(&mut self, report: &MonitorRecord) {
        self.drives += 1;
        self.warnings += report.warnings.len();
        self.false_alarms += report.false_alarms;
        self.incidents += usize::from(report.incident.is_some());
        self.leads.extend(report.lead_seconds);
        self.braked += usize::from(report.braked_steps > 0);
        self.seconds += report.braked_seconds.unwrap_or(0.0);
    }

    /// The line below the table; nothing without a monitor.
    pub fn line(mut self) -> Option<String> {
        (self.drives > 0).then(|| {
            self.leads.sort_by(f64::total_cmp);
            let lead = median(&self.leads);
            let lead = lead.map_or(String::new(), |lead| format!(", median lead {lead:.1} s"));
            let braked = match self.braked {
                0 => String::new(),
                n => format!(
                    "; braked in {} for {:.1} s",
                    output::counted(n, "drive"),
                    self.seconds
                ),
            };
            format!(
                "monitor: {}, {}; warned before {} of {}{lead}{braked}\n",
                output::counted(self.warnings, "warning"),
                output::counted(self.false_alarms, "false alarm"),
                self.leads.len(),
                output::counted(self.incidents, "incident"),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latency_in_force_and_the_braking_are_shown_and_all_drives_are_summed_up() {
        let one = MonitorRecord {
            warnings: vec![[3, 9]],
            first_warning_seconds: Some(0.3),
            lead_seconds: Some(1.2),
            false_alarms_per_minute: Some(0.0),
            median_latency_seconds: Some(0.001),
            latency_in_force_seconds: Some(0.4),
            incident: Some("contact".into()),
            braked_steps: 7,
            braked_seconds: Some(0.7),
            first_braking_seconds: Some(0.3),
            ..MonitorRecord::default()
        };
        let wanted = ["1", "0.3", "1.2", "0.0", "0.400", "0.3", "0.7"];
        assert_eq!(cells(&one), wanted);
        let quiet = MonitorRecord::default();
        assert_eq!(cells(&quiet), ["0", "-", "-", "-", "-", "-", "-"]);
        let mut totals = Totals::default();
        totals.add(&one);
        totals.add(&quiet);
        let line = totals.line().unwrap_or_default();
        let wanted = "monitor: 1 warning, 0 false alarms; warned before 1 of 1 incident, median lead 1.2 s; braked in 1 drive for 0.7 s\n";
        assert_eq!(line, wanted);
        assert_eq!(Totals::default().line(), None);
    }
}
