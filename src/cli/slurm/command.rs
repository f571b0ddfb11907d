//! The command that is run in parts: which can be, and what has to be given with it.

use std::path::Path;

use clap::FromArgMatches;

use super::super::open::configuration;
use super::super::{Arguments, Command, Failure, help, output};
use nearmiss_ask::prompts::Library;
use nearmiss_settings::TextFile;
use nearmiss_study::evaluation::validate;
use nearmiss_workflow::Experiment;

/// Becomes the number of the part.
pub const PART: &str = "{part}";

/// A command with its arguments.
#[derive(Debug)]
pub struct PartCommand {
    /// Its words, the name first.
    pub words: Vec<String>,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    /// Answers in a store; the most that the experiment file lets a run cost, US dollars.
    Evaluate { budget: Option<f64> },
    /// Files in the folder of -o.
    Files,
}

/// Commands that work on parts.
const KNOWN: &str = "evaluate, metrics, index, plan, generate, render and convert";

impl PartCommand {
    /// Checks a command as the program would, with the part that scripts add.
    pub fn new(words: &[String], parts: u32) -> Result<Self, Failure> {
        let name = words.first().map_or("", String::as_str);
        let wrong = |why: &str| Err(Failure::input(format!("`nearmiss {name} …`: {why}")));
        let has = |option: &str| {
            let with_value = format!("{option}=");
            let given = |word: &String| word == option || word.starts_with(&with_value);
            words.iter().any(given)
        };
        for option in ["--shard", "--resume"] {
            if has(option) {
                return wrong(&format!("leave out {option}, which the script adds"));
            }
        }
        if has("--overwrite") {
            return wrong(
                "leave out --overwrite: a part that is started again would begin from the start",
            );
        }
        let command = parsed(words, name, parts)?;
        let kind = match &command {
            Command::Evaluate(arguments) => {
                let file = arguments.in_parts();
                Kind::Evaluate {
                    budget: budget(file.map_err(Failure::input)?)?,
                }
            }
            Command::Generate(arguments) => {
                let report = arguments.report().map(|file| file.to_string_lossy());
                if let Some(report) = report.filter(|report| !report.contains(PART)) {
                    return wrong(&format!(
                        "--report {report}: every part would write this file; {PART} in its name becomes the number of the part"
                    ));
                }
                Kind::Files
            }
            Command::Metrics(arguments) => match arguments.folder() {
                Some(_) => Kind::Files,
                None => return wrong("it needs a folder for Parquet parts: -o FOLDER"),
            },
            Command::Index(_) | Command::Plan(_) | Command::Render(_) | Command::Convert(_) => {
                Kind::Files
            }
            _ => return wrong(&format!("it takes no --shard; {KNOWN} do")),
        };
        Ok(Self {
            words: words.to_vec(),
            kind,
        })
    }

    /// Whether the parts are joined by a second script; files need none.
    pub fn is_joined(&self) -> bool {
        matches!(self.kind, Kind::Evaluate { .. })
    }

    /// What the script adds behind the part.
    pub fn more(&self) -> &'static str {
        match self.kind {
            // It goes on with the batch in the store of the part.
            Kind::Evaluate { .. } => "",
            Kind::Files => " --resume",
        }
    }

    /// What to know before it is submitted.
    pub fn notes(&self, parts: u32) -> Vec<String> {
        match self.kind {
            Kind::Evaluate {
                budget: Some(budget),
            } if parts > 1 => vec![format!(
                "each part has the budget of the experiment file, {budget} USD: together at most {} USD",
                budget * f64::from(parts)
            )],
            _ => Vec::new(),
        }
    }
}

/// The arguments as the program reads them in a part.
fn parsed(words: &[String], name: &str, parts: u32) -> Result<Command, Failure> {
    let program = ["nearmiss".to_string()];
    let mut more = vec!["--shard".to_string(), format!("1/{parts}")];
    if name != "evaluate" {
        more.push("--resume".into());
    }
    let known = [
        "evaluate", "metrics", "index", "plan", "generate", "render", "convert",
    ];
    if !known.contains(&name) {
        return Err(Failure::input(format!(
            "`nearmiss {name} …` cannot be run in parts; {KNOWN} can"
        )));
    }
    let all = program.iter().chain(words).chain(&more);
    let found = help::program().try_get_matches_from(all);
    let parsed = found.and_then(|found| Arguments::from_arg_matches(&found));
    let parsed = parsed.map_err(|error| {
        let said = error.render().to_string();
        let first = said.split("\n\n").next().unwrap_or_default();
        let first = first.trim_start_matches("error: ").trim_end();
        Failure::input(format!("`nearmiss {name} …`: {first}"))
    })?;
    parsed
        .command
        .ok_or_else(|| Failure::input(format!("expected a command: {KNOWN}")))
}

/// The budget of an experiment file, which has to be without mistakes.
fn budget(file: &Path) -> Result<Option<f64>, Failure> {
    let (folders, _) = configuration()?;
    let library = validate(Library::load(Some(&folders.prompts())));
    let text = TextFile::read(file).map_err(Failure::input)?.text;
    let experiment = Experiment::from_toml(&text, file, &library);
    let experiment = experiment.map_err(|mistakes| Failure::input(output::visible(&mistakes)))?;
    Ok(experiment.budget)
}
