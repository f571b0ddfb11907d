//! `nearmiss inspect`: prints the contents and the problems of a scenario or solution, of a folder in a line for each.

mod document;

pub use document::ScenarioDocument;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nearmiss_base::system;
use nearmiss_formats::commonroad::{
    self, ProblemSolution, Root, Solution, SolutionState, root_of_file,
};
use nearmiss_formats::{EgoError, EgoSelection, Entry, EntryLocation};
use nearmiss_scene::scenario::{Diagnostic, Ego, Scenario, Severity, identity, in_short};
use nearmiss_workflow::{OpenRequest, OpenedScene, open};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::ending::interrupted;
use super::files::{Labels, short_hash};
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
        return inspect_solution(path, arguments.format.is_json());
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
        stand_in: open::stand_in(),
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
