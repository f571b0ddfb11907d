//! Reads solutions from XML: elements in any order, every error with its place.

use std::collections::HashSet;

use jiff::civil::{Date, DateTime};

use super::{
    BenchmarkId, COST_FUNCTIONS, POINT_MASS_COSTS, ProblemSolution, Solution, SolutionState,
    SolutionTrajectory, TrajectoryKind, legal,
};
use crate::commonroad::ReadError;
use crate::commonroad::builder::refused_step;
use crate::commonroad::xml::{Element, Xml, decoded, short};
use nearmiss_scene::scenario::plausibility::{doubtful, missing_steps};
use nearmiss_scene::scenario::{Quantity, Severity, StateField, Steps, VehicleModel, identity};

const ROOT: &str = "CommonRoadSolution";

/// Reads a CommonRoad solution from `bytes`; `file` names it in errors.
///
/// # Errors
/// A mistake in a solution, with line, column, element and the expectation.
pub fn read_solution(bytes: &[u8], file: &str) -> Result<Solution, ReadError> {
    let text = decoded(bytes, file)?;
    let mut xml = Xml::new(&text, file);
    let Some(root) = xml.next()? else {
        let message = "no XML element; a solution starts with <CommonRoadSolution …>";
        return Err(xml.fail(0, message.into()));
    };
    if root.name != ROOT {
        let message = format!(
            "the root is <{}>; a solution starts with <CommonRoadSolution …>",
            short(root.name)
        );
        return Err(xml.fail(root.at, message));
    }
    let id = id(&mut xml, root)?;
    let (date, computation_time) = (date(&mut xml, root), computation_time(&mut xml, root));
    let processor = processor(&mut xml, root);
    let mut trajectories = Vec::new();
    while let Some(child) = xml.next()? {
        let kinds = TrajectoryKind::ALL;
        let Some(kind) = kinds.iter().copied().find(|k| k.element() == child.name) else {
            let known: Vec<_> = kinds.iter().map(|k| k.element()).collect();
            let message = format!(
                "<{}> is not a trajectory; available: {}",
                short(child.name),
                known.join(", ")
            );
            return Err(xml.fail(child.at, message));
        };
        let problem = xml.id_attribute(child, "planningProblem")?;
        let trajectory = trajectory(&mut xml, child, kind)?;
        trajectories.push((child, problem, trajectory));
    }
    if trajectories.len() != id.vehicles.len() {
        let message = format!(
            "benchmark_id names {} vehicle(s), but there are {} trajectories; each vehicle needs one",
            id.vehicles.len(),
            trajectories.len()
        );
        return Err(xml.fail_in(root, message));
    }
    let (mut problems, mut solved) = (Vec::new(), HashSet::new());
    for ((element, planning_problem, trajectory), ((model, vehicle), cost)) in trajectories
        .into_iter()
        .zip(id.vehicles.into_iter().zip(id.costs))
    {
        let kind = trajectory.kind();
        if !kind.fits(model) {
            let message = format!(
                "benchmark_id gives this vehicle the model {model}, which has no <{}>",
                kind.element()
            );
            return Err(xml.fail_in(element, message));
        }
        if !solved.insert(planning_problem) {
            let message = format!("planning problem {planning_problem} is already solved");
            return Err(xml.fail_in(element, message));
        }
        if model == VehicleModel::Pm && !POINT_MASS_COSTS.contains(&&cost[..]) {
            let message = format!(
                "cost function {} is not defined for a point mass; commonroad-io does not read this file",
                short(&cost)
            );
            xml.note(Severity::Note, element, message);
        }
        problems.push(ProblemSolution {
            planning_problem,
            model,
            vehicle,
            cost,
            trajectory,
        });
    }
    Ok(Solution {
        scenario_id: id.scenario,
        version: id.version,
        date,
        computation_time,
        processor,
        problems,
        diagnostics: xml.into_diagnostics(),
    })
}

fn id<'a>(xml: &mut Xml<'a>, root: Element<'a>) -> Result<BenchmarkId, ReadError> {
    let Some(text) = xml.attribute(root, "benchmark_id") else {
        let message =
            "<CommonRoadSolution> has no benchmark_id, which names the scenario and the vehicle";
        return Err(xml.fail(root.at, message.into()));
    };
    let id = BenchmarkId::parse(&text).map_err(|why| {
        xml.fail(
            root.at,
            format!(
                "benchmark_id=\"{}\": {}",
                text.chars().take(120).collect::<String>(),
                why
            ),
        )
    })?;
    let note = |message| xml.note(Severity::Note, root, message);
    if !identity::is_valid(&id.scenario) {
        note(format!(
            "scenario `{}` does not follow the naming scheme of benchmark ids",
            short(&id.scenario)
        ));
    }
    for cost in &id.costs {
        if !COST_FUNCTIONS.contains(&&cost[..]) {
            note(format!("unknown cost function `{}`", short(cost)));
        }
    }
    Ok(id)
}

/// The date, to the second; what cannot be used is left out with a diagnostic.
fn date<'a>(xml: &mut Xml<'a>, root: Element<'a>) -> Option<DateTime> {
    let date = xml.attribute(root, "date")?;
    let text = date.trim();
    let zoned = || {
        let there: jiff::Timestamp = text.parse().ok()?;
        Some(there.to_zoned(jiff::tz::TimeZone::UTC).datetime())
    };
    let (read, assumed) = if let Ok(date) = text
        .parse::<Date>()
        .map(|d| d.to_datetime(jiff::civil::Time::midnight()))
        && !text.contains(['T', 't', ' '])
    {
        (date, Some("no time of day; taken as midnight"))
    } else if let Some(date) = zoned() {
        (date, Some("with an offset from UTC; taken as UTC"))
    } else if let Ok(date) = text.parse::<DateTime>() {
        (date, None)
    } else {
        let message = format!("date=\"{}\" is not a date and was left out", short(text));
        xml.note(Severity::Warning, root, message);
        return None;
    };
    if let Some(assumed) = assumed {
        let message = format!("date=\"{}\" {assumed}", short(text));
        xml.note(Severity::Note, root, message);
    }
    let whole = read.with().subsec_nanosecond(0).build().ok()?;
    if whole != read {
        let message = "date: the fraction of a second was left out";
        xml.note(Severity::Note, root, message.into());
    }
    Some(whole)
}

fn processor<'a>(xml: &mut Xml<'a>, root: Element<'a>) -> Option<String> {
    let name = xml.attribute(root, "processor_name")?.into_owned();
    if legal(&name) {
        return Some(name);
    }
    let message = "processor_name has control characters and was left out";
    xml.note(Severity::Warning, root, message.into());
    None
}

fn computation_time<'a>(xml: &mut Xml<'a>, root: Element<'a>) -> Option<f64> {
    let text = xml.attribute(root, "computation_time")?;
    let seconds = text.trim().parse::<f64>().ok();
    let usable = seconds.filter(|s| s.is_finite() && *s > 0.0);
    if usable.is_none() {
        let message = format!(
            "computation_time=\"{}\" is not a positive number of seconds and was left out",
            short(&text)
        );
        xml.note(Severity::Warning, root, message);
    }
    usable
}

fn trajectory<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    kind: TrajectoryKind,
) -> Result<SolutionTrajectory, ReadError> {
    let (mut states, mut seen) = (Vec::<SolutionState>::new(), HashSet::new());
    let (mut disorder, mut doubts) = (None, Doubts::default());
    let mut places = Vec::new();
    while let Some(child) = xml.next()? {
        if child.name != kind.state_element() {
            let message = format!(
                "<{}> in a <{}>; it holds <{}>",
                short(child.name),
                kind.element(),
                kind.state_element()
            );
            return Err(xml.fail(child.at, message));
        }
        let state = state(xml, child, kind, &mut doubts)?;
        xml.check_count(element, states.len(), "states")?;
        if !seen.insert(state.step) {
            let message = format!(
                "time step {} is given twice; each step needs one state",
                state.step
            );
            return Err(xml.fail_in(child, message));
        }
        if states.last().is_some_and(|last| last.step > state.step) {
            disorder = disorder.or(Some(child));
        }
        places.push((state.step, child));
        states.push(state);
    }
    // Inputs hold until the next one.
    if !kind.is_input() {
        places.sort_by_key(|(step, _)| *step);
        let steps: Vec<i64> = places.iter().map(|(step, _)| *step).collect();
        if let Some((place, message)) = missing_steps(&steps) {
            xml.note(Severity::Warning, places[place].1, message);
        }
    }
    if let Some(child) = disorder {
        let message = "states were not in time order and have been sorted";
        xml.note(Severity::Note, child, message.into());
    }
    SolutionTrajectory::new(kind, states).map_err(|e| xml.fail_in(element, e.to_string()))
}

/// The quantities of which it was said already that they can hardly be true: of each once.
#[derive(Default)]
struct Doubts(HashSet<StateField>);

impl Doubts {
    fn look<'a>(&mut self, xml: &mut Xml<'a>, element: Element<'a>, value: f64) {
        let field = match element.name {
            "xVelocity" | "yVelocity" => Some(StateField::VelocityY),
            "xAcceleration" | "yAcceleration" => Some(StateField::AccelerationY),
            "hitch_angle" => Some(StateField::HitchAngle),
            name => StateField::parse(name),
        };
        let doubt = field.and_then(|field| Some((field, doubtful(field, Quantity::Exact(value))?)));
        if let Some((field, message)) = doubt
            && self.0.insert(field)
        {
            xml.note(Severity::Warning, element, message);
        }
    }
}

fn state<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    kind: TrajectoryKind,
    doubts: &mut Doubts,
) -> Result<SolutionState, ReadError> {
    let fields = kind.fields();
    let mut values = vec![None; fields.len()];
    let mut time = None;
    while let Some(child) = xml.next()? {
        let repeated = if child.name == "time" {
            time.replace(xml.integer(child)?).is_some()
        } else {
            // The name that follows the rule of the others; commonroad-io writes the other one.
            let name = match child.name {
                "hitchAngle" => "hitch_angle",
                name => name,
            };
            match fields.iter().position(|f| f.name == name) {
                Some(place) => {
                    let value = match name {
                        "x" | "y" => xml.coordinate(child)?,
                        _ => xml.number(child)?,
                    };
                    doubts.look(xml, child, value);
                    values[place].replace(value).is_some()
                }
                None => {
                    xml.skip_unknown(child)?;
                    false
                }
            }
        };
        if repeated {
            let message = "given twice; the last one is used";
            xml.note(Severity::Warning, child, message.into());
        }
    }
    let missing = |name: &str| {
        let names: Vec<_> = fields.iter().map(|f| f.name).collect();
        format!(
            "<{name}> is missing; a <{}> holds {}, time",
            kind.state_element(),
            names.join(", ")
        )
    };
    let Some(step) = time else {
        return Err(xml.fail_in(element, missing("time")));
    };
    if let Some(message) = refused_step(Steps::exact(step)) {
        return Err(xml.fail_in(element, message));
    }
    if let Some(place) = values.iter().position(Option::is_none) {
        return Err(xml.fail_in(element, missing(fields[place].name)));
    }
    let values = values.into_iter().flatten().collect();
    Ok(SolutionState { step, values })
}
