//! Builds a solution from an ego's motion, and writes solutions as schema-valid XML.

use std::collections::HashSet;

use nearmiss_base::geometry::angle_between;
use nearmiss_scene::scenario::{Header, Motion, Track, VehicleModel, VehicleType};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};

use super::{
    ProblemSolution, Solution, SolutionError, SolutionState, SolutionTrajectory, TrajectoryKind,
    is_word, legal,
};
use crate::commonroad::WriteError;
use crate::commonroad::writer::{XmlWriter, number};

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
    let mut root = vec![("benchmark_id", super::compose_benchmark_id(solution, order))];
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

/// The default cost function; it is defined for every model except the point mass.
const COST: &str = "SM1";

/// The one that is defined for a point mass.
const POINT_MASS_COST: &str = "JB1";

/// A vehicle that moves less than this between two steps, metres, does not show how its wheels stand.
const STANDSTILL: f64 = 0.005;

impl Solution {
    /// How one vehicle solves one planning problem of the scenario with this header. It does not say when and where
    /// it was made: the same motion gives the same file.
    #[must_use]
    pub fn of_problem(header: &Header, solved: ProblemSolution) -> Self {
        Self {
            scenario_id: header.benchmark_id.clone(),
            version: header.version.clone(),
            date: None,
            computation_time: None,
            processor: None,
            problems: vec![solved],
            diagnostics: Vec::new(),
        }
    }
}

impl ProblemSolution {
    /// The recorded steps of `track`, `dt` seconds apart, as states of `model`.
    ///
    /// Positions stay the centre of the vehicle, as solutions have them. A point mass gets the velocity along the
    /// heading. The kinematic single-track model gets the steering angle with which a vehicle of this wheelbase turns
    /// as the track does until the next step, δ = atan(l · Δψ / Δs); at standstill and at the end it is held, and it is
    /// 0 before the first movement. Whether the vehicle could steer so is not checked.
    ///
    /// # Errors
    /// The track is empty, or the model has states that do not follow from an ego's motion.
    pub fn of_track(
        track: &Track,
        dt: f64,
        planning_problem: i64,
        model: VehicleModel,
        vehicle: VehicleType,
    ) -> Result<Self, SolutionError> {
        let motions: Vec<(i64, &Motion)> = track.iter().collect();
        let (kind, cost, values): (_, _, Vec<Vec<f64>>) = match model {
            VehicleModel::Pm => (TrajectoryKind::Pm, POINT_MASS_COST, {
                let motions = motions.iter();
                motions.map(|(_, m)| point_mass(m)).collect()
            }),
            VehicleModel::Ks => (TrajectoryKind::Ks, COST, {
                let steering = steering(&motions, dt, vehicle.wheelbase());
                let pairs = motions.iter().zip(steering);
                pairs.map(|((_, m), s)| single_track(m, s)).collect()
            }),
            VehicleModel::St | VehicleModel::Mb | VehicleModel::Kst => {
                return Err(SolutionError::NotDerivable(model));
            }
        };
        let states = motions
            .iter()
            .zip(values)
            .map(|((step, _), values)| SolutionState {
                step: *step,
                values,
            });
        Ok(Self {
            planning_problem,
            model,
            vehicle,
            cost: cost.into(),
            trajectory: SolutionTrajectory::new(kind, states.collect())?,
        })
    }
}

fn point_mass(motion: &Motion) -> Vec<f64> {
    let (at, velocity) = (motion.pose.position, motion.velocity_vector());
    vec![at.x, at.y, velocity.x, velocity.y]
}

fn single_track(motion: &Motion, steering: f64) -> Vec<f64> {
    let pose = motion.pose;
    vec![
        pose.position.x,
        pose.position.y,
        steering,
        motion.velocity,
        pose.heading,
    ]
}

fn steering(motions: &[(i64, &Motion)], dt: f64, wheelbase: f64) -> Vec<f64> {
    let mut angles = Vec::with_capacity(motions.len());
    let mut held = 0.0;
    for pair in motions.windows(2) {
        let [(from, before), (to, after)] = pair else {
            continue;
        };
        let time = (to - from) as f64 * dt;
        let distance = f64::midpoint(before.velocity, after.velocity) * time;
        if distance.abs() >= STANDSTILL {
            let turn = angle_between(before.pose.heading, after.pose.heading);
            held = (wheelbase * turn / distance).atan();
        }
        angles.push(held);
    }
    angles.push(held);
    angles
}
