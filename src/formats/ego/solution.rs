//! The ego of a CommonRoad solution, and the vehicle size that one beside a recording gives.
//!
//! The vehicle size of a recorded ego, from a solution beside the recording with the same motion.
//!
//! A recording cannot store the vehicle; `nearmiss plan` writes a solution beside it, which names one.

use std::path::{Path, PathBuf};

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{
    Diagnostic, Ego, EgoSource, PlanningProblem, Sample, Scenario, Severity, Track, VehicleModel,
    VehicleType, identity,
};

use super::recording::usual_size;
use super::{EgoError, assumed, read_ego_file};
use crate::commonroad::{ProblemSolution, Solution, TrajectoryKind};

/// A point mass slower than this, m/s, has no direction.
const STANDSTILL: f64 = 0.01;

/// A solution begins at its planning problem's initial state; the drivability checker lets it miss by so many metres.
const START_TOLERANCE: f64 = 0.1;

/// The vehicle that solves one planning problem, as the ego of `scenario`; `file` names the solution.
///
/// Positions are taken as the centre of the vehicle, whatever its model: solutions begin at the initial state
/// of their planning problem, which is of the centre; commonroad-io and the checker of commonroad-drivability-checker
/// put the vehicle's rectangle there; and the CommonRoad planners shift from the rear axle to the centre when they
/// write. (The differential equations of the models speak of the rear axle, for KS, and the centre of gravity, for ST
/// and MB; that is not where a solution's positions are.) Velocity is taken along the heading: of a point mass its
/// whole, turned to its direction; of a single-track model, which gives it along its slip, the part along the heading.
///
/// The size is that of the vehicle type, of a vehicle with trailer the tractor's.
///
/// # Errors
/// The solution has no such planning problem, the scenario has other ones, or it is solved by inputs, not states.
pub fn ego_of_solution(
    solution: &Solution,
    file: &str,
    scenario: &Scenario,
    planning_problem: Option<i64>,
) -> Result<Ego, EgoError> {
    let mut diagnostics = Vec::new();
    check_scenario(solution, file, scenario, planning_problem)?;
    let solved = choose(solution, file, scenario, planning_problem, &mut diagnostics)?;
    let kind = solved.trajectory.kind();
    if kind.is_input() {
        return Err(EgoError::Inputs {
            file: file.to_string(),
            problem: solved.planning_problem,
            element: kind.element(),
        });
    }
    let problems = &scenario.planning_problems;
    let problem = problems.iter().find(|p| p.id == solved.planning_problem);
    let samples: Vec<Sample> = samples(solved);
    diagnostics.extend(about(solution, solved, scenario, problem, &samples));
    let resting = problem.and_then(|p| p.initial.orientation);
    Ok(Ego {
        id: solved.planning_problem,
        source: EgoSource::Solution {
            file: file.to_string(),
            vehicle: solved.vehicle_id(),
            planning_problem: solved.planning_problem,
        },
        footprint: solved.vehicle.footprint(),
        track: Track::new(samples.clone(), scenario.dt(), resting.map(|q| q.middle())),
        recorded: samples,
        diagnostics,
    })
}

/// # Errors
/// The scenario has planning problems, and neither the wanted nor any other of the solution's is among them.
fn check_scenario(
    solution: &Solution,
    file: &str,
    scenario: &Scenario,
    wanted: Option<i64>,
) -> Result<(), EgoError> {
    let known: Vec<i64> = scenario.planning_problems.iter().map(|p| p.id).collect();
    let solved = solution.problems.iter().map(|p| p.planning_problem);
    let asked: Vec<i64> = match wanted {
        Some(problem) if solution.problem(problem).is_some() => vec![problem],
        _ => solved.collect(),
    };
    if known.is_empty() || asked.iter().any(|problem| known.contains(problem)) {
        return Ok(());
    }
    Err(EgoError::Foreign {
        file: file.to_string(),
        problems: listed(&asked),
        of: solution.scenario_id.clone(),
        scenario: named(scenario).to_string(),
        known: listed(&known),
    })
}

fn listed(ids: &[i64]) -> String {
    let ids: Vec<String> = ids.iter().map(i64::to_string).collect();
    ids.join(", ")
}

/// A scenario's benchmark id, for people.
fn named(scenario: &Scenario) -> &str {
    match scenario.header.benchmark_id.as_str() {
        "" => "one without a benchmark id",
        id => id,
    }
}

fn choose<'a>(
    solution: &'a Solution,
    file: &str,
    scenario: &Scenario,
    wanted: Option<i64>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<&'a ProblemSolution, EgoError> {
    let known = || {
        let ids = solution.problems.iter().map(|p| p.planning_problem);
        listed(&ids.collect::<Vec<_>>())
    };
    if let Some(problem) = wanted {
        return solution
            .problem(problem)
            .ok_or_else(|| EgoError::NoSuchProblem {
                file: file.to_string(),
                problem,
                known: known(),
            });
    }
    if let [only] = &solution.problems[..] {
        return Ok(only);
    }
    let first = scenario.planning_problems.first();
    let solved = first
        .and_then(|p| solution.problem(p.id))
        .ok_or_else(|| EgoError::Several {
            file: file.to_string(),
            known: known(),
        })?;
    let message = format!(
        "a cooperative solution of the planning problems {}; the vehicle of problem {} is the ego, the others are left out",
        known(),
        solved.planning_problem
    );
    diagnostics.push(assumed(Severity::Warning, message));
    Ok(solved)
}

fn samples(solved: &ProblemSolution) -> Vec<Sample> {
    let trajectory = &solved.trajectory;
    let states = trajectory.states().iter();
    let samples = states.filter_map(|state| {
        let value = |name| trajectory.value(state, name);
        let (heading, velocity) = match trajectory.kind() {
            TrajectoryKind::Pm => {
                let (x, y) = (value("xVelocity")?, value("yVelocity")?);
                let speed = x.hypot(y);
                ((speed >= STANDSTILL).then(|| y.atan2(x)), speed)
            }
            TrajectoryKind::St => {
                let along = value("velocity")? * value("slipAngle")?.cos();
                (value("orientation"), along)
            }
            _ => (value("orientation"), value("velocity")?),
        };
        Some(Sample {
            step: state.step,
            position: Point::new(value("x")?, value("y")?),
            heading,
            velocity: Some(velocity),
            acceleration: None,
        })
    });
    samples.collect()
}

/// Caveats about the ego.
fn about(
    solution: &Solution,
    solved: &ProblemSolution,
    scenario: &Scenario,
    problem: Option<&PlanningProblem>,
    samples: &[Sample],
) -> Vec<Diagnostic> {
    let mut found = vec![assumed(
        Severity::Note,
        format!(
            "no size given; assuming its vehicle, {}; positions are its centre",
            solved.vehicle
        ),
    )];
    let mut warn = |message| found.push(assumed(Severity::Warning, message));
    if solved.trajectory.kind() == TrajectoryKind::Kst {
        warn("the trailer is ignored; the ego is the tractor alone".into());
    }
    let id = &scenario.header.benchmark_id;
    if *id != solution.scenario_id && identity::normalized(id) != solution.scenario_id {
        warn(format!(
            "a solution of scenario {of}, but the open scenario is {}, whose planning problem has the same id; unless both are the same scenario, open {of}",
            named(scenario),
            of = solution.scenario_id,
        ));
    }
    match problem {
        None => warn("the scenario has no planning problem to compare with".into()),
        Some(problem) => {
            let start = samples.first().map(|s| s.position);
            let gap = start
                .zip(problem.initial.point())
                .map(|(a, b)| (a - b).norm());
            if let Some(gap) = gap.filter(|gap| *gap > START_TOLERANCE) {
                warn(format!(
                    "starts {gap:.2} m from the start of its planning problem; if its positions are not the vehicle's centre, all distances are wrong by as much"
                ));
            }
        }
    }
    found
}

/// Positions of the same motion differ by rounding only, metres.
const ROUNDING: f64 = 1e-3;

/// `ego` of the file `recording`, with the vehicle of the solution that lies with it, is called as `nearmiss plan`
/// calls it, and has the same positions at the same steps; as it was where there is none, also where what lies there
/// is broken or tells another motion, which says nothing about this one.
#[must_use]
pub fn sized(mut ego: Ego, recording: &Path, name: &str, scenario: &Scenario) -> Ego {
    let usual = usual_size();
    if !matches!(ego.source, EgoSource::Recording(_)) || !ego.diagnostics.contains(&usual) {
        return ego;
    }
    let files = candidates(recording, name, &scenario.header.version);
    let same = files.into_iter().find_map(|file| {
        let solved = read_ego_file(&file, scenario, Some(ego.id)).ok()?;
        same_motion(&ego.track, &solved.track).then_some((file, solved))
    });
    if let Some((file, solved)) = same {
        ego.diagnostics.retain(|d| *d != usual);
        let vehicle = match &solved.source {
            EgoSource::Solution { vehicle, .. } => vehicle.as_str(),
            _ => "",
        };
        ego.diagnostics.push(assumed(
            Severity::Note,
            format!(
                "no size given; assuming the vehicle of {}, which has the same motion, {vehicle}",
                file.display()
            ),
        ));
        ego.footprint = solved.footprint;
    }
    ego
}

/// The solutions with states that `nearmiss plan` may have written with a recording: in its folder, and where that is
/// the scenario's own, beside it.
fn candidates(recording: &Path, name: &str, version: &str) -> Vec<PathBuf> {
    let own = recording.parent();
    let above = own.filter(|folder| folder.file_name().is_some_and(|f| f == name));
    let folders = [own, above.and_then(Path::parent)];
    let mut files = Vec::new();
    for folder in folders.into_iter().flatten() {
        for model in [VehicleModel::Ks, VehicleModel::Pm] {
            for vehicle in VehicleType::ALL {
                let number = vehicle.number();
                files.push(
                    folder.join(format!("solution_{model}{number}_SM1_{name}_{version}.xml")),
                );
            }
        }
    }
    files.retain(|file| file.is_file());
    files
}

fn same_motion(a: &Track, b: &Track) -> bool {
    a.steps() == b.steps()
        && a.steps().all(|step| match (a.at(step), b.at(step)) {
            (Some(a), Some(b)) => (a.pose.position - b.pose.position).norm() < ROUNDING,
            (a, b) => a.is_none() && b.is_none(),
        })
}
