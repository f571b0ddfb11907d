//! `nearmiss inspect` of a folder or several files: a line for each scenario.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::interrupt::interrupted;
use crate::many_files::{Failed, Job, NEXT};
use crate::open::{found, not_opened};
use crate::row_file::{Labels, short_hash};
use crate::{Failure, Outcome, json, output};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::scenario::Severity;
use nearmiss_workflow::{OpenRequest, OpenedScene, open};

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
pub fn run(paths: &[PathBuf], as_json: bool) -> Outcome {
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
