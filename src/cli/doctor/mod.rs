//! `nearmiss doctor`: checks everything the program needs, and says how to fix what is wrong.

mod files;
mod models;
mod planners;
mod store;
mod terminal;

use schemars::JsonSchema;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

use super::{Failure, Outcome, Workbench, json, output};
use nearmiss_settings::{Config, Folders};

pub use files::open_to_others;

/// Arguments of `doctor`.
#[derive(Debug, clap::Args)]
pub struct Doctor {
    #[command(flatten)]
    format: output::FormatOption,
    /// Also ask every provider with a key for its list of models; without it nothing leaves this machine.
    #[arg(long)]
    online: bool,
}

/// How something is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema, IntoStaticStr, VariantArray)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
enum State {
    Ok,
    Warning,
    Problem,
}

nearmiss_record::named!(State);

/// A line: what was looked at, how it is, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
struct Finding {
    area: &'static str,
    state: State,
    what: String,
    todo: Option<String>,
}

/// What was found, for programs.
#[derive(Serialize, JsonSchema)]
pub struct Document {
    /// Version of nearmiss.
    version: &'static str,
    /// Findings: area, state (ok, warning, problem), what and todo.
    findings: Vec<Finding>,
    /// Number of warnings.
    warnings: usize,
    /// Number of problems.
    problems: usize,
}

impl json::Output for Document {
    const NAME: &'static str = "doctor";
    const TITLE: &'static str = "`doctor --format json`: findings of the check";
}

impl Finding {
    fn ok(area: &'static str, what: impl Into<String>) -> Self {
        Self {
            area,
            state: State::Ok,
            what: what.into(),
            todo: None,
        }
    }

    fn warning(area: &'static str, what: impl Into<String>, todo: impl Into<String>) -> Self {
        Self {
            state: State::Warning,
            todo: Some(todo.into()),
            ..Self::ok(area, what)
        }
    }

    fn problem(area: &'static str, what: impl Into<String>, todo: impl Into<String>) -> Self {
        Self {
            state: State::Problem,
            ..Self::warning(area, what, todo)
        }
    }

    fn line(&self) -> String {
        let todo = self.todo.iter().map(|todo| format!("; {todo}"));
        let todo: String = todo.collect();
        let state = self.state.name();
        format!("{state:<8} {:<11} {}{todo}\n", self.area, self.what)
    }
}

/// Runs `doctor`.
pub fn run(arguments: &Doctor, workbench: &Workbench) -> Outcome {
    let mut found = vec![program()];
    found.extend(terminal::look(&(workbench.terminal)()));
    match Folders::find() {
        Ok(folders) => {
            let (config, said) = files::config(&folders);
            found.extend(said);
            found.extend(files::look(&folders, &config, workbench));
            found.extend(store::look(&folders));
            found.extend(models::look(&folders, &config, arguments.online)?);
            found.extend(planners::look(&config));
        }
        Err(error) => {
            let todo = "set both variables";
            found.push(Finding::problem("folders", error, todo));
        }
    }
    let count = |state: State| found.iter().filter(|f| f.state == state).count();
    let (warnings, problems) = (count(State::Warning), count(State::Problem));
    if arguments.format.is_json() {
        output::document(&Document {
            version: env!("CARGO_PKG_VERSION"),
            findings: found.clone(),
            warnings,
            problems,
        })?;
    } else {
        let text: String = found.iter().map(Finding::line).collect();
        output::text(&output::visible(&text))?;
    }
    if problems == 0 {
        return Ok(());
    }
    Err(Failure::finding(format!(
        "{problems} of {} lines are problems",
        found.len()
    )))
}

fn program() -> Finding {
    let build = if cfg!(debug_assertions) {
        "a debug build: slow; `cargo build --release` makes a fast one"
    } else {
        "a release build"
    };
    let version = env!("CARGO_PKG_VERSION");
    let (system, machine) = (std::env::consts::OS, std::env::consts::ARCH);
    Finding::ok(
        "program",
        format!("nearmiss {version}, {build}, for {system} on {machine}"),
    )
}

/// The configuration; the defaults where it cannot be used.
fn usable(read: Result<Config, nearmiss_settings::ConfigError>) -> (Config, Vec<String>) {
    match read {
        Ok(config) => (config, Vec::new()),
        Err(error) => (Config::default(), error.mistakes_in_words().collect()),
    }
}
