//! `nearmiss inspect SOLUTION`: what a CommonRoad solution says.

use std::collections::BTreeMap;
use std::path::Path;

use nearmiss_base::system;
use nearmiss_formats::commonroad::{self, ProblemSolution, Solution, SolutionState};
use nearmiss_scene::scenario::{Diagnostic, identity};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::{Failure, Outcome, output};

/// Prints the solution in the file at `path`.
pub(super) fn inspect(path: &Path, as_json: bool) -> Outcome {
    let file = path.display().to_string();
    let bytes = system::read_file(path, system::LARGEST).map_err(|e| Failure::system(&file, &e))?;
    let solution = commonroad::read_solution(&bytes, &file).map_err(Failure::input)?;
    if as_json {
        output::document(&SolutionDocument::new(&solution))
    } else {
        output::text(&output::visible(&summary(path, &solution)))
    }
}

fn summary(path: &Path, solution: &Solution) -> String {
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
