//! Writes solutions as schema-valid XML.

use std::collections::HashSet;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};

use super::id::{self, is_word, legal};
use super::{ProblemSolution, Solution, SolutionError};
use crate::commonroad::WriteError;
use crate::commonroad::xml_writer::{XmlWriter, number};

/// The solution as an XML file in UTF-8. The same solution gives the same bytes.
///
/// The schema has an order of the trajectories' kinds, and the benchmark id lists the vehicles in the order
/// of the file: a cooperative solution of several kinds is written in the schema's order, ids and all.
/// Trajectories with a trailer are not in the schema; they are written as commonroad-io writes them, last.
///
/// # Errors
/// The solution is not one that can be read back: see [`SolutionError`].
pub fn write_solution(solution: &Solution) -> Result<Vec<u8>, SolutionError> {
    check(solution)?;
    let mut order: Vec<&ProblemSolution> = solution.problems.iter().collect();
    order.sort_by_key(|p| p.trajectory.kind());
    document(solution, &order).map_err(|e| SolutionError::Write(e.to_string()))
}

fn document(solution: &Solution, order: &[&ProblemSolution]) -> Result<Vec<u8>, WriteError> {
    let mut out = XmlWriter {
        xml: Writer::new_with_indent(Vec::new(), b' ', 2),
    };
    out.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let mut root = vec![("benchmark_id", id::compose(solution, order))];
    let time = solution.computation_time.map(number);
    root.extend(time.map(|t| ("computation_time", t)));
    let date = solution.date.map(|d| d.strftime("%Y-%m-%dT%H:%M:%S"));
    root.extend(date.map(|d| ("date", d.to_string())));
    let processor = solution.processor.clone();
    root.extend(processor.map(|p| ("processor_name", p)));
    out.element("CommonRoadSolution", &root, |out| {
        order.iter().try_for_each(|p| problem(out, p))
    })?;
    let mut bytes = out.xml.into_inner();
    bytes.push(b'\n');
    Ok(bytes)
}

fn problem(out: &mut XmlWriter, solved: &ProblemSolution) -> Result<(), WriteError> {
    let kind = solved.trajectory.kind();
    let of = [("planningProblem", solved.planning_problem.to_string())];
    out.element(kind.element(), &of, |out| {
        solved.trajectory.states().iter().try_for_each(|state| {
            out.element(kind.state_element(), &[], |out| {
                let pairs = kind.fields().iter().zip(&state.values);
                pairs
                    .into_iter()
                    .try_for_each(|(field, value)| out.leaf(field.name, &number(*value)))?;
                out.leaf("time", &state.step.to_string())
            })
        })
    })
}

fn check(solution: &Solution) -> Result<(), SolutionError> {
    if solution.problems.is_empty() {
        return Err(SolutionError::Empty);
    }
    let word = |what, value: &str, why| SolutionError::Word {
        what,
        value: value.to_string(),
        why,
    };
    for (what, value) in [
        ("scenario id", &solution.scenario_id),
        ("version", &solution.version),
    ] {
        let id = |c: char| !c.is_whitespace() && c != ':';
        if value.is_empty() || !legal(value) || !value.chars().all(id) {
            return Err(word(what, value, "must be a word without colons"));
        }
    }
    if let Some(name) = &solution.processor
        && !legal(name)
    {
        return Err(word("processor", name, "contains control characters"));
    }
    if let Some(time) = solution.computation_time
        && !(time.is_finite() && time > 0.0)
    {
        return Err(SolutionError::ComputationTime(time.to_string()));
    }
    let mut solved = HashSet::new();
    for problem in &solution.problems {
        let kind = problem.trajectory.kind();
        if !kind.fits(problem.model) {
            return Err(SolutionError::Model {
                problem: problem.planning_problem,
                model: problem.model,
                element: kind.element(),
            });
        }
        if !solved.insert(problem.planning_problem) {
            return Err(SolutionError::Twice(problem.planning_problem));
        }
        if !is_word(&problem.cost) {
            return Err(word(
                "cost function",
                &problem.cost,
                "must consist of letters and digits",
            ));
        }
    }
    Ok(())
}
