//! `nearmiss corpus sample`: draws windows from an index so that they cover what it holds.

use std::collections::HashSet;
use std::ops::ControlFlow;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use super::output::{self, Target};
use super::{Failure, Outcome, json};
use nearmiss_scene::corpus::{
    Axis, Candidate, Columns, IndexError, Part, PartRow, SampledWindow, Sampler,
};
use nearmiss_scene::metrics::SEVERITY_NAMES;
use nearmiss_workflow::index_parts;

/// Arguments of `sample`.
#[derive(Debug, clap::Args)]
pub struct Sample {
    /// Folder of an index, see `nearmiss corpus index`.
    folder: PathBuf,
    /// What windows are told apart by, separated by commas: manoeuvre, road, severity. From each combination the same
    /// number is drawn, as far as it has as many.
    #[arg(
        long,
        value_name = "AXIS",
        value_delimiter = ',',
        default_value = "manoeuvre,road,severity"
    )]
    by: Vec<Axis>,
    /// Number of windows.
    #[arg(short, long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    number: u32,
    /// Seed; the same seed draws the same windows from the same index.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Form of the output [default: from the file name, else table].
    #[arg(long, value_enum)]
    format: Option<Format>,
    #[command(flatten)]
    output: output::OutputFile,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// A line for each window, with the reason for drawing it.
    Table,
    /// Paths of scenarios alone, each once.
    Paths,
    /// JSON lines: one object for each window.
    #[value(alias = "jsonl")]
    Json,
    /// An experiment file that asks about the drawn scenarios; add its models.
    Toml,
}

/// What the endings of names ask for.
const ENDINGS: &[(&str, Format)] = &[
    ("txt", Format::Table),
    ("json", Format::Json),
    ("jsonl", Format::Json),
    ("ndjson", Format::Json),
    ("toml", Format::Toml),
];

/// A drawn window for programs.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SampleLine {
    scenario: String,
    file: String,
    /// Source of the ego: recorded or obstacle.
    ego_source: String,
    /// Id of the ego.
    ego_id: i64,
    obstacle: i64,
    /// First and last step of the window.
    window: [i64; 2],
    /// What the obstacle does to the ego, such as cut_in, following or crossing.
    manoeuvre: String,
    /// Kind of road under the ego.
    road: String,
    /// Severity of the most severe step of the window, 0 (contact) to 5 (none).
    severity: u8,
    /// Why it was drawn.
    reason: String,
}

impl json::Output for SampleLine {
    const NAME: &'static str = "corpus-sample";
    const TITLE: &'static str = "`corpus sample --format json`: one drawn window a line";
}

const TEXTS: [&str; 5] = ["scenario", "file", "ego_source", "manoeuvre", "road"];
const INTEGERS: [&str; 5] = [
    "ego_id",
    "obstacle_id",
    "first_step",
    "last_step",
    "severity",
];

/// Runs `sample`.
pub fn run(arguments: &Sample) -> Outcome {
    let most = usize::try_from(arguments.number).map_err(Failure::input)?;
    let (asked, file) = (arguments.format, arguments.output.file());
    let known = (ENDINGS, ".txt, .json, .jsonl and .toml");
    let format = output::format_of(asked, file, Format::Table, known)?;
    let mut sampler = Sampler::new(arguments.seed, most);
    for part in index_parts(&arguments.folder).map_err(Failure::input)? {
        let part = Part::open(&part).map_err(Failure::input)?;
        let read = part.read(&Columns::new(&TEXTS, &INTEGERS), &mut |row| {
            let line = line(row)?;
            sampler.offer(candidate(&line, &arguments.by), line);
            Ok(ControlFlow::Continue(()))
        });
        let _ = read.map_err(Failure::input)?;
    }
    let cells = sampler.cells();
    let drawn = sampler.draw();
    let lines: Vec<SampleLine> = drawn.into_iter().map(with_reason).collect();
    if lines.len() < most {
        output::say(&format!(
            "nearmiss: {} drawn from {cells} cells; one window of each scenario a cell, and no more are there",
            output::counted(lines.len(), "window")
        ));
    }
    let text = match format {
        Format::Table => table(&lines),
        Format::Paths => paths(&lines).map(|path| format!("{path}\n")).collect(),
        Format::Json => {
            let documents = lines.iter().map(|line| {
                let document = json::Output::document(line).map_err(Failure::input)?;
                output::json_line(&document)
            });
            documents.collect::<Result<String, Failure>>()?
        }
        Format::Toml => toml(&lines, arguments)?,
    };
    match arguments.output.file() {
        None => output::text(&text),
        Some(file) => {
            Target::begin(Some(file), arguments.output.overwrites())?.save(text.as_bytes())
        }
    }
}

/// A row of the index.
fn line(row: &PartRow<'_>) -> Result<SampleLine, IndexError> {
    let text = |place: usize| row.text(place).map(output::visible);
    Ok(SampleLine {
        scenario: text(0)?,
        // A bundled scenario is meant by its name.
        file: text(1)?.trim_end_matches(" (bundled)").to_string(),
        ego_source: text(2)?,
        ego_id: row.integer(0),
        obstacle: row.integer(1),
        window: [row.integer(2), row.integer(3)],
        manoeuvre: text(3)?,
        road: text(4)?,
        severity: row.severity(4)?,
        reason: String::new(),
    })
}

fn candidate(line: &SampleLine, by: &[Axis]) -> Candidate {
    let word = |axis: &Axis| match axis {
        Axis::Manoeuvre => line.manoeuvre.clone(),
        Axis::Road => line.road.clone(),
        Axis::Severity => severity_word(line.severity),
    };
    let SampleLine {
        file,
        ego_source,
        ego_id,
        obstacle,
        window: [first, last],
        ..
    } = line;
    Candidate {
        path: file.clone(),
        window: format!("{file}\n{ego_source} {ego_id} {obstacle} {first} {last}"),
        cell: by.iter().map(word).collect(),
    }
}

/// `1 conflict`: in order, and with its name.
fn severity_word(severity: u8) -> String {
    format!("{severity} {}", SEVERITY_NAMES[usize::from(severity)])
}

fn with_reason(drawn: SampledWindow<SampleLine>) -> SampleLine {
    let SampledWindow {
        candidate,
        row,
        windows,
        drawn,
    } = drawn;
    SampleLine {
        reason: format!("{drawn} of {windows} in {}", candidate.cell.join(", ")),
        ..row
    }
}

fn table(lines: &[SampleLine]) -> String {
    let head = ["file", "ego", "obstacle", "steps", "drawn"].map(String::from);
    let rows = lines.iter().map(|line| {
        let ego = match line.ego_source.as_str() {
            "recorded" => "recorded".to_string(),
            _ => line.ego_id.to_string(),
        };
        let steps = format!("{}-{}", line.window[0], line.window[1]);
        let (obstacle, reason) = (line.obstacle.to_string(), line.reason.clone());
        [line.file.clone(), ego, obstacle, steps, reason]
    });
    let rows: Vec<[String; 5]> = std::iter::once(head).chain(rows).collect();
    output::table_lines(&rows, &[1, 2, 3]).collect()
}

/// The scenarios, each once.
fn paths(lines: &[SampleLine]) -> impl Iterator<Item = &str> {
    let mut seen = HashSet::new();
    let paths = lines.iter().map(|line| line.file.as_str());
    paths.filter(move |path| seen.insert(*path))
}

fn toml(lines: &[SampleLine], arguments: &Sample) -> Result<String, Failure> {
    let by: Vec<&str> = arguments.by.iter().map(|axis| axis.name()).collect();
    let mut text = format!(
        "# Drawn with `nearmiss corpus sample --by {} -n {} --seed {}`. Add models, and run it with `nearmiss evaluate FILE`.\n",
        by.join(","),
        arguments.number,
        arguments.seed
    );
    text.push_str("scenarios = [\n");
    let scenarios: Vec<&str> = paths(lines).collect();
    output::say(&format!(
        "nearmiss: an experiment asks about windows of its own in these {}; --format json has the {} drawn",
        output::counted(scenarios.len(), "scenario"),
        output::counted(lines.len(), "window"),
    ));
    for file in scenarios {
        let drawn = lines.iter().filter(|line| line.file == file).count();
        let path = serde_json::to_string(file).map_err(Failure::input)?;
        let drawn = output::counted(drawn, "window");
        text.push_str(&format!("    {path}, # {drawn} drawn\n"));
    }
    text.push_str("]\n");
    Ok(text)
}
