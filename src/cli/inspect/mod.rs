//! `nearmiss inspect`: prints the contents and the problems of a scenario or solution, of several a row for each.

mod document;
mod rows;

pub use document::ScenarioDocument;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::system;
use nearmiss_formats::commonroad::{
    self, ProblemSolution, Root, Solution, SolutionState, root_of_file,
};
use nearmiss_formats::{EGO_FILES, EgoError, Entry, EntryLocation};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Diagnostic, Ego, Scenario, Scene, identity, in_short};
use nearmiss_settings::Folders;
use nearmiss_workflow::{OpenedScene, Overview, ScenarioRow, Verdicts};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::open::{self, EgoChoice, stand_in, user_thresholds};
use super::{Failure, Outcome, json, output};

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
pub struct Inspect {
    /// Scenarios, recordings, solutions, names of bundled scenarios, or folders; of several, a row for each scenario, the
    /// most severe first.
    #[arg(required = true, value_name = "PATH")]
    files: Vec<PathBuf>,
    /// Rows of these scenarios alone: terms of the list's filter, such as 'ttc < 1.5 tag:urban' or 'severity<=1'; see
    /// `nearmiss help finding`.
    #[arg(long = "where", value_name = "TERMS")]
    terms: Option<String>,
    /// The most severe N rows.
    #[arg(long, value_name = "N")]
    top: Option<usize>,
    /// Form of the output; of one scenario `table` is its page and `json` everything in it [default: from the file name,
    /// else table].
    #[arg(long, value_enum)]
    format: Option<Format>,
    #[command(flatten)]
    output: output::OutputFile,
    #[command(flatten)]
    ego: EgoChoice,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// Text for people.
    #[value(alias = "text")]
    Table,
    /// CSV with a header: a row for each scenario.
    Csv,
    /// JSON: one object; of several, one a line.
    #[value(alias = "jsonl")]
    Json,
    /// Apache Parquet with units and meanings as metadata: a row for each scenario; needs a file.
    Parquet,
}

/// What the endings of names ask for.
const ENDINGS: &[(&str, Format)] = &[
    ("txt", Format::Table),
    ("csv", Format::Csv),
    ("json", Format::Json),
    ("jsonl", Format::Json),
    ("ndjson", Format::Json),
    ("parquet", Format::Parquet),
];

impl Format {
    /// The format of a table for programs; none of text.
    fn of_table(self) -> Option<output::Format> {
        match self {
            Self::Table => None,
            Self::Csv => Some(output::Format::Csv),
            Self::Json => Some(output::Format::Json),
            Self::Parquet => Some(output::Format::Parquet),
        }
    }
}

impl Inspect {
    /// Whether rows are asked for, and not the page of the only file.
    fn asks_for_rows(&self, format: Format) -> bool {
        let several = self.files.len() > 1 || self.files.iter().any(|file| file.is_dir());
        let selects = self.terms.is_some() || self.top.is_some() || self.output.file().is_some();
        several || selects || matches!(format, Format::Csv | Format::Parquet)
    }
}

/// Runs `inspect`.
pub fn run(arguments: &Inspect) -> Outcome {
    let known = (ENDINGS, ".txt, .csv, .json, .jsonl, .ndjson and .parquet");
    let file = arguments.output.file();
    let format = output::format_of(arguments.format, file, Format::Table, known)?;
    if arguments.asks_for_rows(format) {
        return match arguments.files.as_slice() {
            _ if arguments.ego.is_beside() => rows::run(arguments, format),
            [folder] if folder.is_dir() => Err(Failure::input(format!(
                "{} is a folder; --ego needs one scenario",
                folder.display()
            ))),
            _ => Err(Failure::input(
                "--ego needs the page of one scenario; leave out the other files, --where, --top and -o",
            )),
        };
    }
    let (file, as_json) = (&arguments.files[0], format == Format::Json);
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
        return inspect_solution(path, as_json);
    }
    let wanted = arguments.ego.wanted(std::slice::from_ref(&entry))?;
    let scenario = entry.read().map_err(Failure::input)?;
    let mut lacks = String::from("no recording found");
    let ego = match wanted.resolve(&entry, &scenario) {
        Ok(None) if arguments.ego.is_beside() => {
            let scene = stand_in().scene(&entry, &scenario);
            if let Err(why) = &scene {
                lacks = format!("{why} ({EGO_FILES})");
            }
            Ok(scene.ok().map(|scene| scene.ego.clone()))
        }
        ego => ego,
    };
    let row = { ego.as_ref().ok().and_then(Option::as_ref) }
        .map(|ego| row(&entry, &scenario, ego))
        .transpose()?;
    if as_json {
        let document = ScenarioDocument::new(&entry, &scenario, &ego, row.as_ref());
        output::document(&document)?;
    } else {
        let moment = row.as_ref().and_then(moment_words);
        output::text(&summary(&entry, &scenario, &ego, &lacks, moment.as_deref()))?;
    }
    // The scenario is shown all the same.
    ego.map(|_| ()).map_err(open::advised)
}

/// The row that it has among several.
fn row(entry: &Entry, scenario: &Arc<Scenario>, ego: &Ego) -> Result<ScenarioRow, Failure> {
    let thresholds = match Folders::find() {
        Ok(folders) => user_thresholds(&folders)?,
        Err(_) => Thresholds::shipped().clone(),
    };
    let opened = OpenedScene {
        scenario: Arc::clone(scenario),
        scene: Ok(Arc::new(Scene::new(Arc::clone(scenario), ego.clone()))),
        stands_in: false,
    };
    Ok(Overview::new(entry, &opened, &thresholds, &Verdicts::default(), None).row)
}

/// The moment that matters: `1.2 s (step 12), near miss with car 30640 (crossing): crosses 0.4 s apart, 0.1 m`.
fn moment_words(row: &ScenarioRow) -> Option<String> {
    let severity = match row.severity_name? {
        "none" => "nothing severe",
        name => name,
    };
    Some(format!(
        "{:.1} s (step {}), {severity}, with {} ({}): {}",
        row.moment?,
        row.step?,
        row.with.as_deref()?,
        row.manoeuvre?,
        row.what.as_deref()?,
    ))
}

fn summary(
    entry: &Entry,
    scenario: &Scenario,
    ego: &Result<Option<Ego>, EgoError>,
    lacks: &str,
    moment: Option<&str>,
) -> String {
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
        Ok(None) => line("ego", lacks),
        Err(error) => line("ego", &format!("cannot be read: {error}")),
    }
    if let Some(moment) = moment {
        line("moment", moment);
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

/// Prints the solution in the file at `path`.
fn inspect_solution(path: &Path, as_json: bool) -> Outcome {
    let file = path.display().to_string();
    let bytes = system::read_file(path, system::LARGEST).map_err(|e| Failure::system(&file, &e))?;
    let solution = commonroad::read_solution(&bytes, &file).map_err(Failure::input)?;
    if as_json {
        output::document(&SolutionDocument::new(&solution))
    } else {
        output::text(&output::visible(&solution_summary(path, &solution)))
    }
}

fn solution_summary(path: &Path, solution: &Solution) -> String {
    let mut text = format!(
        "{}\n  file        {}\n  format      CommonRoad solution\n  scenario    {}, version {}\n",
        solution.benchmark_id(),
        path.display(),
        solution.scenario_id,
        solution.version,
    );
    let mut made = Vec::new();
    made.extend(solution.date.map(|d| format!("{} {}", d.date(), d.time())));
    made.extend(
        solution
            .computation_time
            .map(|s| format!("computed in {s:.3} s")),
    );
    made.extend(solution.processor.as_ref().map(|p| format!("on {p}")));
    let made = if made.is_empty() {
        "not stated".into()
    } else {
        made.join(", ")
    };
    text.push_str(&format!("  made        {made}\n"));
    let step = time_step(path, &solution.scenario_id);
    for problem in &solution.problems {
        text.push_str(&problem_summary(problem, step));
    }
    if solution.diagnostics.is_empty() {
        text.push_str("  diagnostics none\n");
    }
    for d in &solution.diagnostics {
        text.push_str(&format!("  {d}\n"));
    }
    text
}

fn problem_summary(problem: &ProblemSolution, step: Option<f64>) -> String {
    let trajectory = &problem.trajectory;
    let states = trajectory.states();
    let (first, last) = (states.first(), states.last());
    let span = first.zip(last).map_or((0, 0), |(a, b)| (a.step, b.step));
    let duration = match step {
        Some(dt) => format!("{:.1} s", (span.1 - span.0) as f64 * dt),
        None => "seconds unknown (no scenario beside it to tell the step size)".into(),
    };
    let mut text = format!(
        "  problem     {}: model {} ({}), vehicle {}, cost function {}\n  \
         states      {} <{}>, steps {} to {}, {duration}\n",
        problem.planning_problem,
        problem.model,
        problem.model.full_name(),
        problem.vehicle,
        problem.cost,
        states.len(),
        trajectory.kind().state_element(),
        span.0,
        span.1,
    );
    for (name, state) in [("first", first), ("last", last)] {
        let Some(state) = state else { continue };
        let fields = trajectory.kind().fields().iter().zip(&state.values);
        let words: Vec<_> = fields
            .map(|(f, v)| format!("{} {} {}", f.name, rounded(*v), f.unit))
            .collect();
        text.push_str(&format!("  {name:<11} {}\n", words.join(", ")));
    }
    text
}

/// Three decimals are enough to recognise a state; very small and very large numbers are not spelt out.
fn rounded(value: f64) -> String {
    if value != 0.0 && !(5e-4..1e9).contains(&value.abs()) {
        format!("{value:.3e}")
    } else {
        format!("{value:.3}")
    }
}

/// Seconds between two time steps, from the scenario beside the solution; a solution does not say.
fn time_step(path: &Path, scenario: &str) -> Option<f64> {
    // An id from a file must not lead anywhere else.
    if !identity::is_valid(scenario) {
        return None;
    }
    let beside = path.with_file_name(format!("{scenario}.xml"));
    let read = commonroad::read_file(&beside).ok()?;
    Some(read.dt())
}

/// A solution.
#[derive(Serialize, JsonSchema)]
pub struct SolutionDocument<'s> {
    scenario: &'s str,
    benchmark_id: String,
    /// Version of the scenario.
    version: &'s str,
    /// Date of the solution.
    date: Option<String>,
    /// Computation time in seconds.
    computation_time: Option<f64>,
    /// Processor.
    processor: Option<&'s str>,
    /// Planning problems with vehicle model, vehicle, cost function and states.
    #[schemars(with = "Vec<Value>")]
    problems: Vec<ProblemDocument<'s>>,
    #[schemars(with = "Vec<Value>")]
    diagnostics: &'s [Diagnostic],
}

impl json::Output for SolutionDocument<'_> {
    const NAME: &'static str = "inspect-solution";
    const TITLE: &'static str = "`inspect SOLUTION --format json`: a solution";
}

/// What a solution says of a planning problem.
#[derive(Serialize)]
struct ProblemDocument<'s> {
    planning_problem: i64,
    model: &'static str,
    vehicle: VehicleDocument,
    cost_function: &'s str,
    trajectory: &'static str,
    /// Steps and the values of their fields.
    states: Vec<StateDocument>,
}

#[derive(Serialize)]
struct VehicleDocument {
    id: u8,
    name: &'static str,
    length: f64,
    width: f64,
}

#[derive(Serialize)]
struct StateDocument {
    time_step: i64,
    #[serde(flatten)]
    values: BTreeMap<&'static str, f64>,
}

impl<'s> SolutionDocument<'s> {
    fn new(solution: &'s Solution) -> Self {
        Self {
            scenario: &solution.scenario_id,
            benchmark_id: solution.benchmark_id(),
            version: &solution.version,
            date: solution.date.map(|d| d.to_string()),
            computation_time: solution.computation_time,
            processor: solution.processor.as_deref(),
            problems: solution.problems.iter().map(problem).collect(),
            diagnostics: &solution.diagnostics,
        }
    }
}

fn problem(problem: &ProblemSolution) -> ProblemDocument<'_> {
    let trajectory = &problem.trajectory;
    let names = || trajectory.kind().fields().iter().map(|field| field.name);
    let state = |state: &SolutionState| StateDocument {
        time_step: state.step,
        values: names().zip(state.values.iter().copied()).collect(),
    };
    ProblemDocument {
        planning_problem: problem.planning_problem,
        model: problem.model.name(),
        vehicle: VehicleDocument {
            id: problem.vehicle.number(),
            name: problem.vehicle.name(),
            length: problem.vehicle.length(),
            width: problem.vehicle.width(),
        },
        cost_function: &problem.cost,
        trajectory: trajectory.kind().element(),
        states: trajectory.states().iter().map(state).collect(),
    }
}
