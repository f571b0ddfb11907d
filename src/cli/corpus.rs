//! `nearmiss corpus`: an index of many scenarios; how many windows it holds, and windows drawn so that they cover that.

use std::collections::HashSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Policy;
use nearmiss_render::{Format, Palette, Picture, coverage_picture};
use nearmiss_scene::corpus::{
    self, Axis, Candidate, Columns, Coverage, IndexError, Part, PartRow, SEVERITIES, SampledWindow,
    Sampler,
};
use nearmiss_scene::metrics::SEVERITY_NAMES;
use nearmiss_workflow::drive::Solver;
use nearmiss_workflow::{index_parts, read_index};
use schemars::JsonSchema;
use serde::Serialize;

use super::output::{self, Target};
use super::{Failure, Outcome, find, hard, index, json, rate};

/// Subcommands of `corpus`.
#[derive(Debug, clap::Subcommand)]
pub enum Corpus {
    /// Measure every window of every pair of road users in many scenarios.
    Index(Box<index::Index>),
    /// Count the windows of an index by manoeuvre, road and severity.
    Show(index::Show),
    /// Estimate how often egos meet a manoeuvre: events per hour and per kilometre, with intervals.
    Rate(rate::Rates),
    /// Search an index by terms, or in plain English with a model.
    Find(find::Find),
    /// Draw a stratified sample of windows or scenarios from an index.
    Sample(Sample),
}

/// Runs `corpus`.
pub fn run(command: &Corpus) -> Outcome {
    match command {
        Corpus::Index(arguments) => index::run(arguments),
        Corpus::Show(arguments) => index::show(arguments),
        Corpus::Rate(arguments) => rate::run(arguments),
        Corpus::Find(arguments) => find::run(arguments),
        Corpus::Sample(arguments) => sample(arguments),
    }
}

/// Arguments of `corpus show`.
#[derive(Debug, clap::Args)]
pub struct Show {
    /// Index folder.
    folder: PathBuf,
    #[command(flatten)]
    format: output::FormatOption,
    /// Also draw the table to FILE (.svg or .png).
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long, requires = "output")]
    overwrite: bool,
}

/// The table for programs.
#[derive(Serialize, JsonSchema)]
pub struct ShowDocument {
    /// Number of windows.
    windows: u64,
    /// Windows by manoeuvre and road: `manoeuvre`, `road` and `counts`, whose place is the severity from 0 (contact)
    /// to 5 (none).
    coverage: Vec<ShowRow>,
}

#[derive(Serialize, JsonSchema)]
struct ShowRow {
    manoeuvre: String,
    road: String,
    counts: [u64; SEVERITIES],
}

/// Prints the table.
pub fn show(arguments: &Show) -> Outcome {
    let coverage = coverage(&arguments.folder)?;
    if let Some(path) = &arguments.output {
        let picture = coverage_picture(&coverage, &Palette::paper());
        save_picture(&picture, path, arguments.overwrite)?;
    }
    if arguments.format.is_json() {
        output::document(&document(&coverage))
    } else {
        output::text(&text(&coverage))
    }
}

fn coverage(folder: &Path) -> Result<Coverage, Failure> {
    // Answers do not matter here, and nothing cancels.
    let read = read_index(folder, &[], &Cancel::default(), &mut |_, _| {});
    let index = read.map_err(Failure::input)?;
    Ok(index.map_or_else(Coverage::default, |index| index.coverage()))
}

fn document(coverage: &Coverage) -> ShowDocument {
    let row = |(cell, counts): (&corpus::Cell, &[u64; SEVERITIES])| ShowRow {
        manoeuvre: output::visible(&cell.manoeuvre),
        road: output::visible(&cell.road),
        counts: *counts,
    };
    ShowDocument {
        windows: coverage.totals().iter().sum(),
        coverage: coverage.rows().map(row).collect(),
    }
}

fn text(coverage: &Coverage) -> String {
    let line = |manoeuvre: &str, road: &str, counts: &[u64; SEVERITIES]| {
        let mut cells: [String; SEVERITIES + 3] = Default::default();
        cells[0] = manoeuvre.into();
        cells[1] = road.into();
        for (cell, count) in cells[2..].iter_mut().zip(counts) {
            *cell = match count {
                0 => "·".into(),
                count => count.to_string(),
            };
        }
        cells[SEVERITIES + 2] = counts.iter().sum::<u64>().to_string();
        cells
    };
    let mut head: [String; SEVERITIES + 3] = Default::default();
    head[0] = "manoeuvre".into();
    head[1] = "road".into();
    for (cell, name) in head[2..].iter_mut().zip(SEVERITY_NAMES) {
        *cell = name.into();
    }
    head[SEVERITIES + 2] = "all".into();
    let mut rows = vec![head];
    let of_cell =
        |(c, counts): (&corpus::Cell, &[u64; SEVERITIES])| line(&c.manoeuvre, &c.road, counts);
    rows.extend(coverage.rows().map(of_cell));
    rows.push(line("all", "", &coverage.totals()));
    let right: Vec<usize> = (2..SEVERITIES + 3).collect();
    output::table_lines(&rows, &right).collect()
}

/// Saves a picture under a name that says its format.
pub fn save_picture(picture: &Picture, path: &Path, overwrite: bool) -> Outcome {
    let format = Format::of_file(path)
        .filter(|format| format.is_picture())
        .ok_or_else(|| {
            Failure::input(format!("-o {}: name a file .svg or .png", path.display()))
        })?;
    let bytes = format
        .encode(picture, format.usual_dpi())
        .map_err(|e| Failure::input(format!("{}: {e}", path.display())))?;
    Target::begin(Some(path), overwrite)?.save(&bytes)?;
    output::say(&format!("nearmiss: wrote {}", path.display()));
    Ok(())
}

/// Arguments of `sample`.
#[derive(Debug, clap::Args)]
pub struct Sample {
    /// Index folder; see `nearmiss corpus index`.
    folder: PathBuf,
    /// Strata to balance, separated by commas: manoeuvre, road, severity. Each combination contributes equally while
    /// its windows last.
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
    /// Random seed; the same seed draws the same windows from the same index.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Draw only scenarios that all baselines fail and a drive proves solvable, each once; drives scenarios until N are
    /// found.
    #[arg(long)]
    hard: bool,
    /// Output format [default: from the file name, else table].
    #[arg(long, value_enum)]
    format: Option<SampleFormat>,
    #[command(flatten)]
    output: output::OutputFile,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum SampleFormat {
    /// A line per window, with the reason it was drawn.
    Table,
    /// Scenario paths only, each once.
    Paths,
    /// JSON lines: one object per window.
    #[value(alias = "jsonl")]
    Json,
    /// An experiment file that asks about the drawn scenarios; add models to run it.
    Toml,
}

/// What the endings of names ask for.
const ENDINGS: &[(&str, SampleFormat)] = &[
    ("txt", SampleFormat::Table),
    ("json", SampleFormat::Json),
    ("jsonl", SampleFormat::Json),
    ("ndjson", SampleFormat::Json),
    ("toml", SampleFormat::Toml),
];

/// A drawn window for programs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct SampleLine {
    scenario: String,
    pub(super) file: String,
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
    /// With --hard: whose drive proves that the scenario can be solved.
    pub(super) solved_by: Option<Solver>,
    /// With --hard: how the drives of the baselines end (constant-velocity, lane-following, idm), the outcome or the kind of
    /// collision.
    pub(super) baselines: Option<Vec<&'static str>>,
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
fn sample(arguments: &Sample) -> Outcome {
    let most = usize::try_from(arguments.number).map_err(Failure::input)?;
    let (asked, file) = (arguments.format, arguments.output.file());
    let known = (ENDINGS, ".txt, .json, .jsonl and .toml");
    let format = output::format_of(asked, file, SampleFormat::Table, known)?;
    let kept = if arguments.hard { usize::MAX } else { most };
    let mut sampler = Sampler::new(arguments.seed, kept);
    for part in index_parts(&arguments.folder).map_err(Failure::input)? {
        let part = Part::open(&part).map_err(Failure::input)?;
        let read = part.read(&Columns::new(&TEXTS, &INTEGERS), &mut |row| {
            let line = sample_line(row)?;
            sampler.offer(candidate(&line, &arguments.by), line);
            Ok(ControlFlow::Continue(()))
        });
        let _ = read.map_err(Failure::input)?;
    }
    let cells = sampler.cells();
    let (drawn, job) = if arguments.hard {
        let (drawn, job) = hard::drawn(sampler.into_order(), most)?;
        (drawn, Some(job))
    } else {
        (sampler.draw(), None)
    };
    let lines: Vec<SampleLine> = drawn.into_iter().map(with_reason).collect();
    if lines.len() < most && !arguments.hard {
        output::say(&format!(
            "nearmiss: {} drawn from {cells} cells; one window of each scenario a cell, and no more are there",
            output::counted(lines.len(), "window")
        ));
    }
    let text = match format {
        SampleFormat::Table => sample_table(&lines),
        SampleFormat::Paths => paths(&lines).map(|path| format!("{path}\n")).collect(),
        SampleFormat::Json => {
            let documents = lines.iter().map(|line| {
                let document = json::Output::document(line).map_err(Failure::input)?;
                output::json_line(&document)
            });
            documents.collect::<Result<String, Failure>>()?
        }
        SampleFormat::Toml => toml(&lines, arguments)?,
    };
    match arguments.output.file() {
        None => output::text(&text)?,
        Some(file) => {
            Target::begin(Some(file), arguments.output.overwrites())?.save(text.as_bytes())?;
        }
    }
    job.map_or(Ok(()), |job| job.end("those found until then are written"))
}

/// A row of the index.
fn sample_line(row: &PartRow<'_>) -> Result<SampleLine, IndexError> {
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
        solved_by: None,
        baselines: None,
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
    let cell = candidate.cell.join(", ");
    let mut reason = format!("{drawn} of {windows} in {cell}");
    if let Some(solver) = row.solved_by {
        let ends = row.baselines.as_deref().unwrap_or_default();
        let ends = Policy::BASELINES.iter().zip(ends);
        let ends: Vec<String> = ends.map(|(p, end)| format!("{} {end}", p.name())).collect();
        reason += &format!("; {}; solved by {}", ends.join(", "), solver.words());
    }
    SampleLine { reason, ..row }
}

fn sample_table(lines: &[SampleLine]) -> String {
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
        "# Drawn with `nearmiss corpus sample --by {} -n {} --seed {}{}`. Add models, and run it with `nearmiss evaluate FILE`.\n",
        by.join(","),
        arguments.number,
        arguments.seed,
        if arguments.hard { " --hard" } else { "" }
    );
    text.push_str("scenarios = [\n");
    let scenarios: Vec<&str> = paths(lines).collect();
    output::say(&format!(
        "nearmiss: an experiment asks about windows of its own in these {}; --format json has the {} drawn",
        output::counted(scenarios.len(), "scenario"),
        output::counted(lines.len(), "window"),
    ));
    for file in scenarios {
        let windows = lines.iter().filter(|line| line.file == file);
        let solver = windows.clone().find_map(|line| line.solved_by);
        let solved = solver.map_or(String::new(), |s| format!(", solved by {}", s.words()));
        let drawn = windows.count();
        let path = serde_json::to_string(file).map_err(Failure::input)?;
        let drawn = output::counted(drawn, "window");
        text.push_str(&format!("    {path}, # {drawn} drawn{solved}\n"));
    }
    text.push_str("]\n");
    Ok(text)
}
