//! `nearmiss inspect`: prints the contents and the problems of a scenario or solution, of a folder in a line for each.

mod document;
mod solution;

pub use document::ScenarioDocument;
pub use solution::SolutionDocument;

use std::path::PathBuf;

use nearmiss_formats::commonroad::{Root, root_of_file};
use nearmiss_formats::{EgoError, EgoSelection, Entry, EntryLocation};
use nearmiss_scene::scenario::{Ego, Scenario, Severity, in_short};
use nearmiss_workflow::{OpenRequest, OpenedScene, open};
use schemars::JsonSchema;
use serde::Serialize;

use super::files::{Labels, short_hash};
use super::interrupt::interrupted;
use super::many_files::{Failed, Job, NEXT};
use super::open::{self, EgoChoice, found, not_opened};
use super::{Failure, Outcome, json, output};

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
pub struct Inspect {
    /// CommonRoad scenario or solution, name of a bundled scenario, or folder; of several, one line each.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    format: output::FormatOption,
    #[command(flatten)]
    ego: EgoChoice,
}

/// Runs `inspect`.
pub fn run(arguments: &Inspect) -> Outcome {
    let file = match arguments.files.as_slice() {
        [file] if !file.is_dir() => file,
        several if arguments.ego.is_beside() => {
            return inspect_folder(several, arguments.format.is_json());
        }
        [folder] => {
            return Err(Failure::input(format!(
                "{} is a folder; --ego needs one scenario",
                folder.display()
            )));
        }
        _ => return Err(Failure::input("--ego needs one scenario")),
    };
    let entry = open::entry(file)?;
    if let EntryLocation::File(path) = &entry.place
        && root_of_file(path) == Root::Solution
    {
        if !arguments.ego.is_beside() {
            return Err(Failure::input(format!(
                "{0} is a solution; name its scenario instead, with --ego {0}",
                path.display()
            )));
        }
        return solution::run(path, arguments.format.is_json());
    }
    let wanted = arguments.ego.wanted(std::slice::from_ref(&entry))?;
    let scenario = entry.read().map_err(Failure::input)?;
    let ego = wanted.resolve(&entry, &scenario);
    if arguments.format.is_json() {
        output::document(&ScenarioDocument::new(&entry, &scenario, &ego))?;
    } else {
        output::text(&summary(&entry, &scenario, &ego))?;
    }
    // The scenario is shown all the same.
    ego.map(|_| ()).map_err(open::advised)
}

fn summary(entry: &Entry, scenario: &Scenario, ego: &Result<Option<Ego>, EgoError>) -> String {
    let id = match scenario.header.benchmark_id.as_str() {
        "" => "(no benchmark id)",
        id => id,
    };
    let mut text = format!("{id}\n");
    let mut line = |word: &str, said: &str| text.push_str(&format!("  {word:<11} {said}\n"));
    line("file", &entry.display());
    line("hash", &scenario.hash.to_string());
    for (word, said) in scenario.summary() {
        line(word, &said);
    }
    let possible = scenario.possible_egos();
    match ego {
        Ok(Some(ego)) => {
            let (first, last) = (ego.track.steps().start, ego.track.steps().end - 1);
            line(
                "ego",
                &format!("{}, {}, steps {first} to {last}", ego.id, ego.source),
            );
            for (_, doubt) in in_short(&ego.diagnostics) {
                line("", &doubt);
            }
        }
        Ok(None) => line("ego", "no recording found"),
        Err(error) => line("ego", &format!("cannot be read: {error}")),
    }
    if possible.is_empty() {
        line("as ego", "no obstacle has a trajectory");
    } else {
        let ids: Vec<String> = possible.iter().map(i64::to_string).collect();
        line(
            "as ego",
            &format!("--ego takes obstacle {}", ids.join(", ")),
        );
    }
    text.push_str(&document::summary(scenario));
    if scenario.diagnostics.is_empty() {
        text.push_str("  diagnostics none\n");
    }
    for (_, diagnostic) in in_short(&scenario.diagnostics) {
        text.push_str(&format!("  {diagnostic}\n"));
    }
    output::visible(&text)
}

/// Titles of the columns.
const TITLES: [&str; 9] = [
    "scenario",
    "hash",
    "obstacles",
    "lanelets",
    "steps",
    "seconds",
    "ego",
    "warnings",
    "not used",
];

/// Prints a line for each scenario at some paths; one that cannot be read is said and counted.
fn inspect_folder(paths: &[PathBuf], as_json: bool) -> Outcome {
    let entries = found(paths)?;
    let labels = Labels::new(&entries);
    let mut rows = vec![TITLES.map(String::from)];
    let mut failed = Failed::of(entries.len());
    let stop = interrupted(false);
    let done = Job::new("scenarios", &stop).writing_file(false).run(
        &entries,
        |entry| Some(opened(entry).map(|scene| FolderLine::new(entry, &scene))),
        |_, line| {
            match line {
                Ok(line) if as_json => output::document(&line)?,
                Ok(line) => rows.push(line.cells(&labels)),
                Err(failure) => failed.add(failure),
            }
            NEXT
        },
    );
    done.end("")?;
    if !as_json && rows.len() > 1 {
        output::text(&output::table_lines(&rows, &[2, 3, 4, 5, 7, 8]).collect::<String>())?;
    }
    failed.end("read")
}

fn opened(entry: &Entry) -> Result<OpenedScene, Failure> {
    let request = OpenRequest {
        entry,
        ego: &EgoSelection::Beside,
        transform: None,
        strict: false,
    };
    open(&request).map_err(not_opened)
}

/// What is said of a scenario.
#[derive(Serialize, JsonSchema)]
pub struct FolderLine {
    scenario: String,
    file: String,
    /// First 12 digits of the SHA-256 of the scenario's content.
    hash: String,
    /// Number of obstacles.
    obstacles: usize,
    /// Number of lanelets.
    lanelets: usize,
    /// Number of steps.
    steps: i64,
    /// Length of the recording in seconds.
    seconds: f64,
    /// Whether an ego is recorded.
    ego: bool,
    /// Number of warnings of the parser.
    warnings: usize,
    /// Number of kinds of elements, attributes, fields or columns that stand in the file and are not used.
    not_used: usize,
}

impl json::Output for FolderLine {
    const NAME: &'static str = "inspect-folder";
    const TITLE: &'static str = "`inspect FOLDER --format json`: one scenario a line";
}

impl FolderLine {
    fn new(entry: &Entry, opened: &OpenedScene) -> Self {
        let scenario = &opened.scenario;
        let steps = scenario.steps();
        let last = (steps.end - 1 - steps.start).max(0);
        let count = |severity: Severity| {
            let diagnostics = scenario.diagnostics.iter();
            diagnostics.filter(|d| d.severity == severity).count()
        };
        Self {
            scenario: entry.name.clone(),
            file: entry.display(),
            hash: short_hash(&scenario.hash),
            obstacles: scenario.obstacles.len(),
            lanelets: scenario.network.lanelets.len(),
            steps: steps.end - steps.start,
            seconds: last as f64 * scenario.dt(),
            ego: opened.scene.is_ok(),
            warnings: count(Severity::Warning),
            not_used: count(Severity::Unused),
        }
    }

    /// What can be typed for it: of one scenario in a file its address, as its name alone would not do.
    fn typed(&self, labels: &Labels) -> String {
        if self.file.contains('#') {
            self.file.clone()
        } else {
            labels.of(&self.scenario, &self.file)
        }
    }

    fn cells(&self, labels: &Labels) -> [String; 9] {
        [
            self.typed(labels),
            self.hash.clone(),
            self.obstacles.to_string(),
            self.lanelets.to_string(),
            self.steps.to_string(),
            format!("{:.1}", self.seconds),
            if self.ego { "recorded" } else { "-" }.into(),
            self.warnings.to_string(),
            self.not_used.to_string(),
        ]
    }
}
