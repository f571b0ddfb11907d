//! `nearmiss doctor`: checks everything the program needs, files and store first, and says how to fix what is wrong.

mod installed;
mod surroundings;

use std::path::{Path, PathBuf};

use nearmiss_ask::prompts::Library;
use nearmiss_base::system::others_may;
use nearmiss_settings::{Config, Folders, Tags};
use nearmiss_store::Health;
use schemars::JsonSchema;
use serde::Serialize;
use strum::{IntoStaticStr, VariantArray};

use super::open::user_thresholds;
use super::{Failure, Outcome, Workbench, output};
use installed::Installed;

/// Arguments of `doctor`.
#[derive(Debug, clap::Args)]
pub struct Doctor {
    #[command(flatten)]
    format: output::FormatOption,
    /// Also request the model list of every provider with a key; without it, nothing leaves this machine.
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
    /// How it was installed: wheel, debian, cargo, build, container or copy; null if its file is not found.
    installed: Option<Installed>,
    /// Findings: area, state (ok, warning, problem), what and todo.
    findings: Vec<Finding>,
    /// Number of warnings.
    warnings: usize,
    /// Number of problems.
    problems: usize,
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
    let file = std::env::current_exe().ok();
    let installed = file.as_ref().map(|file| {
        let installed = Installed::of(file, Path::new("/"));
        let words = format!("{} {}", file.display(), installed.words());
        found.push(Finding::ok("program", words));
        installed
    });
    found.extend(surroundings::check_terminal(&(workbench.terminal)()));
    match Folders::find() {
        Ok(folders) => {
            let (config, said) = check_config(&folders);
            found.extend(said);
            found.extend(check_files(&folders, &config, workbench));
            found.extend(check_store(&folders));
            found.extend(surroundings::check_models(
                &folders,
                &config,
                arguments.online,
            )?);
            found.extend(surroundings::check_planners(&config));
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
            installed,
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

/// The configuration, or the defaults, and what is to be said of it.
fn check_config(folders: &Folders) -> (Config, Vec<Finding>) {
    let path = folders.config_file();
    let shown = path.display();
    let (config, mistakes) = usable(Config::read(&path));
    let todo = "commands stop and the workbench uses the defaults until this is fixed";
    let each = mistakes.into_iter();
    let mut said: Vec<Finding> = each
        .map(|mistake| Finding::problem("config", mistake, todo))
        .collect();
    if said.is_empty() {
        let words = if path.exists() {
            format!("{shown} is valid; `nearmiss config print` shows the values in force")
        } else {
            format!("defaults (no {shown})")
        };
        said.push(Finding::ok("config", words));
    }
    (config, said)
}

/// Files that decide what is run and what it costs, and that other users can change or read: each with what to do.
pub fn open_to_others(folders: &Folders) -> Vec<(String, String)> {
    let config = folders.config_file();
    let mut found = Vec::new();
    if others_may(&config).write {
        let folder = folders.config.display();
        found.push((
            format!(
                "{}: other users can change it, and commands in it (`key_command`) are run",
                config.display()
            ),
            format!("close it with `chmod go-w {folder} {}`", config.display()),
        ));
    }
    for file in [PathBuf::from(".env"), folders.config.join(".env")] {
        if others_may(&file).read {
            let shown = file.display();
            found.push((
                format!("{shown}: other users can read the keys in it"),
                format!("close it with `chmod 600 {shown}`"),
            ));
        }
    }
    found
}

fn check_files(folders: &Folders, config: &Config, workbench: &Workbench) -> Vec<Finding> {
    let mut found = vec![
        check_folder("configuration", &folders.config, "NEARMISS_CONFIG"),
        check_folder("data", &folders.data, "NEARMISS_DATA"),
    ];
    let open = open_to_others(folders).into_iter();
    found.extend(open.map(|(what, todo)| Finding::warning("folders", what, todo)));
    found.extend(check_keys(folders, workbench));
    found.push(match user_thresholds(folders) {
        Err(failure) => Finding::problem(
            "thresholds",
            failure.message,
            "fix it or move the file away",
        ),
        Ok(_) => own_or_shipped(
            "thresholds",
            &folders.thresholds(),
            "the shipped thresholds",
        ),
    });
    found.extend(check_prompts(folders));
    found.extend(check_themes(folders, config, workbench));
    if let Err(error) = Tags::read(&folders.tags()) {
        found.push(Finding::problem(
            "tags",
            error,
            "fix it or move the file away",
        ));
    }
    found
}

fn own_or_shipped(area: &'static str, path: &Path, shipped: &str) -> Finding {
    if path.exists() {
        Finding::ok(area, format!("{} is valid", path.display()))
    } else {
        Finding::ok(area, format!("{shipped} (no {})", path.display()))
    }
}

/// Whether something can be written into a folder, or it can be made.
fn check_folder(what: &str, path: &Path, variable: &str) -> Finding {
    const AREA: &str = "folders";
    let shown = path.display();
    let set = std::env::var_os(variable).is_some_and(|value| !value.is_empty());
    let from = if set { variable } else { "the usual place" };
    let there = path.ancestors().find(|folder| folder.exists());
    let Some(there) = there.filter(|there| !there.as_os_str().is_empty()) else {
        let there = Path::new(".");
        return written(what, there, &format!("{shown} ({from})"), variable);
    };
    let words = if there == path {
        format!("{shown} ({from})")
    } else {
        format!("{shown} ({from}): created on first use")
    };
    if !there.is_dir() {
        let file = there.display();
        return Finding::problem(
            AREA,
            format!("{what}: {shown} cannot be a folder, {file} is a file"),
            format!("set {variable} to a folder"),
        );
    }
    written(what, there, &words, variable)
}

fn written(what: &str, there: &Path, words: &str, variable: &str) -> Finding {
    match tempfile::tempfile_in(there) {
        Ok(_) => Finding::ok("folders", format!("{what}: {words}")),
        Err(error) => Finding::problem(
            "folders",
            format!(
                "{what}: {words}: not writable: {}",
                nearmiss_base::system::error_text(&error)
            ),
            format!("make it writable, or set {variable} to another folder"),
        ),
    }
}

fn check_keys(folders: &Folders, workbench: &Workbench) -> Vec<Finding> {
    let path = folders.keymap();
    match (workbench.keys)(&path, None, false) {
        Ok(_) => vec![own_or_shipped("keys", &path, "the default keys")],
        Err(mistakes) => {
            let todo = "the default keys are in use until this is fixed";
            let each = mistakes.into_iter();
            each.map(|mistake| Finding::problem("keys", mistake, todo))
                .collect()
        }
    }
}

fn check_prompts(folders: &Folders) -> Vec<Finding> {
    let library = Library::load(Some(&folders.prompts()));
    if library.problems.is_empty() {
        let words = "all templates are valid; `nearmiss prompt list` lists them";
        return vec![Finding::ok("prompts", words)];
    }
    let problems = library.problems.iter();
    let todo = "fix it or move the file away; `nearmiss prompt list` lists what is in use";
    problems
        .map(|problem| Finding::problem("prompts", problem.to_string(), todo))
        .collect()
}

fn check_themes(folders: &Folders, config: &Config, workbench: &Workbench) -> Vec<Finding> {
    let chosen = config.theme.as_deref().unwrap_or("auto");
    let mistakes = (workbench.theme_mistakes)(chosen, &folders.themes());
    if mistakes.is_empty() {
        return vec![Finding::ok("themes", format!("`{chosen}` is valid"))];
    }
    let todo = "fix it or choose another theme; `nearmiss config themes` lists them";
    let each = mistakes.into_iter();
    each.map(|mistake| Finding::problem("themes", mistake, todo))
        .collect()
}

const STORE: &str = "store";

fn check_store(folders: &Folders) -> Vec<Finding> {
    let path = folders.store();
    let shown = path.display();
    let other = "move it away, or set NEARMISS_DATA to another folder";
    let health = match Health::inspect(&path) {
        Ok(Some(health)) => health,
        Ok(None) => {
            let words = format!("no {shown} yet; the first question creates it");
            return vec![Finding::ok(STORE, words)];
        }
        Err(error) => return vec![Finding::problem(STORE, format!("{shown}: {error}"), other)],
    };
    let mut found = Vec::new();
    let (version, known) = (health.version, health.known);
    found.push(match version.cmp(&known) {
        std::cmp::Ordering::Greater => Finding::problem(
            STORE,
            format!("{shown} has version {version}, this program knows {known}"),
            "update nearmiss, or set NEARMISS_DATA to another folder",
        ),
        std::cmp::Ordering::Less if version > 0 => Finding::problem(
            STORE,
            format!("{shown} has version {version}, this program knows {known}"),
            other,
        ),
        _ => {
            let runs = health.runs.unwrap_or_default();
            let kib = health.bytes.div_ceil(1024);
            Finding::ok(
                STORE,
                format!("{shown}: version {version}, {kib} KiB, {runs} runs"),
            )
        }
    });
    if health.damage.is_empty() {
        found.push(Finding::ok(STORE, "quick check passed"));
    }
    for line in &health.damage {
        let todo = format!("`nearmiss runs export -o FILE` saves what can be read; then {other}");
        found.push(Finding::problem(STORE, format!("damaged: {line}"), todo));
    }
    found.push(match health.locked {
        None => Finding::ok(STORE, "it can be written"),
        Some(why) if why.contains("locked") || why.contains("busy") => Finding::warning(
            STORE,
            format!("locked by another program ({why})"),
            "runs are stored when it is done",
        ),
        Some(why) => Finding::problem(
            STORE,
            format!("not writable: {why}"),
            "runs are not stored; make it writable, or set NEARMISS_DATA to another folder",
        ),
    });
    found
}
