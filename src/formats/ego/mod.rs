//! Egos from files: recordings, planner logs and solutions, told apart by their content and checked.

mod error;
mod find;
mod log;
mod recording;
mod solution;
mod table;

use std::path::Path;

use nearmiss_base::geometry::Point;
use nearmiss_base::system;
use nearmiss_scene::scenario::plausibility::{
    FASTEST, LARGEST_NUMBER, MOST_TURNS, Row, and_more, doubts, is_tiny, missing_steps,
    refused_coordinate,
};
use nearmiss_scene::scenario::{
    Diagnostic, Ego, LONGEST_TRACK, Obstacle, Sample, Scenario, Severity,
};

use super::commonroad::{Root, foreign, read_solution, root_of, without_marks};

pub use error::EgoError;
pub(crate) use find::RECORDING;
pub use find::{EGO_FILES, EgoSelection, PlannerDrives, find_recording};
pub use recording::{USUAL as USUAL_VEHICLE, write_recording, write_sized_recording};
pub use solution::ego_of_solution;
pub(super) use solution::sized;

/// Reads an ego for `scenario` from `bytes` in any of the formats; `file` names them in errors.
///
/// What is in the bytes decides, not the name: XML is a solution, a header with `trajectory_number` a log of
/// Frenetix, one with `timestep` a recording. `planning_problem` chooses among the egos of a cooperative
/// solution or of a recording of several; without it the one of the scenario's first planning problem is taken of a
/// solution, with a diagnostic, and none of a recording.
///
/// # Errors
/// It is none of these, it is broken, or it has no ego for that planning problem.
pub fn read_ego(
    bytes: &[u8],
    file: &str,
    scenario: &Scenario,
    planning_problem: Option<i64>,
) -> Result<Ego, EgoError> {
    let bytes = without_marks(bytes);
    let unknown = |why: &str| EgoError::Unknown {
        file: file.to_string(),
        why: why.to_string(),
    };
    if let Some(what) = foreign(bytes) {
        return Err(unknown(&format!("this is {what}")));
    }
    if bytes.trim_ascii_start().starts_with(b"<") {
        if root_of(bytes) == Root::Scenario {
            return Err(unknown("this is a scenario"));
        }
        let solution = read_solution(bytes, file)?;
        let mut ego = ego_of_solution(&solution, file, scenario, planning_problem)?;
        let doubts = check(&ego, scenario, &Lines::default());
        ego.diagnostics.extend(doubts);
        return Ok(ego);
    }
    let header = bytes.split(|&b| b == b'\n').next().unwrap_or_default();
    let header = table::plain(&String::from_utf8_lossy(header));
    let has = |word: &str| header.contains(&table::plain(word));
    if has("unique_id") && has("trajectory_number") {
        return Err(unknown(
            "these are all sampled trajectories of a planner; the driven one is in logs.csv",
        ));
    }
    let (mut ego, lines) = if has("trajectory_number") {
        log::read(bytes, file, scenario, planning_problem)?
    } else if has("timestep") || has("x_position") {
        recording::read_chosen(bytes, file, scenario, planning_problem)?
    } else {
        return Err(unknown("unknown header in line 1"));
    };
    let doubts = check(&ego, scenario, &lines);
    ego.diagnostics.extend(doubts);
    match planning_problem {
        Some(problem) if problem != ego.id => Err(EgoError::NoSuchProblem {
            file: file.to_string(),
            problem,
            known: ego.id.to_string(),
        }),
        _ => Ok(ego),
    }
}

/// Reads an ego for `scenario` from a file; see [`read_ego`].
///
/// # Errors
/// The file cannot be read, or see [`read_ego`].
pub fn read_ego_file(
    path: &Path,
    scenario: &Scenario,
    planning_problem: Option<i64>,
) -> Result<Ego, EgoError> {
    let file = path.display().to_string();
    let bytes = system::read_file(path, system::LARGEST).map_err(|source| EgoError::Io {
        file: file.clone(),
        source,
    })?;
    read_ego(&bytes, &file, scenario, planning_problem)
}

/// Something assumed about an ego as a whole.
fn assumed(severity: Severity, message: String) -> Diagnostic {
    Diagnostic {
        severity,
        line: 0,
        element: String::new(),
        message,
    }
}

/// An ego farther from every lanelet than this, metres, is on another map.
const OFF_MAP: f64 = 500.0;

/// Largest plausible acceleration, m/s².
const MAX_ACCELERATION: f64 = 50.0;

/// An ego that begins farther from its planning problem than this, metres, may be of another scenario.
const START_TOLERANCE: f64 = 1.0;

/// The lines of a file by the time steps that they tell of; none where a file has no lines.
#[derive(Debug, Default)]
struct Lines(Vec<(i64, u64)>);

impl Lines {
    pub fn new(steps: impl Iterator<Item = (i64, u64)>) -> Self {
        let mut lines: Vec<_> = steps.collect();
        lines.sort_unstable();
        Self(lines)
    }

    /// The line of a step, or of the last one before it, which a planner's row may tell of, too.
    fn line_of(&self, step: i64) -> usize {
        let place = self.0.partition_point(|(at, _)| *at <= step);
        let line = place.checked_sub(1).map_or(0, |place| self.0[place].1);
        usize::try_from(line).unwrap_or(0)
    }
}

/// A value of an ego's file, if it can be meant.
///
/// # Errors
/// It is out of all reason.
fn plausible_number(
    value: f64,
    file: &str,
    line: u64,
    column: &'static str,
) -> Result<f64, EgoError> {
    let why = if column.contains("position") {
        refused_coordinate(value)
    } else {
        (value.abs() > LARGEST_NUMBER).then(|| format!("`{value}` is implausible"))
    };
    match why {
        None => Ok(value),
        Some(why) => Err(EgoError::Absurd {
            file: file.to_string(),
            line,
            column,
            why,
        }),
    }
}

/// A diagnostic of rows that run back in time, by their steps in file order; `line` is the line of a row.
fn order(steps: &[i64], line: impl Fn(usize) -> u64) -> Option<Diagnostic> {
    let back = steps.windows(2).position(|pair| pair[1] < pair[0])?;
    let falling = steps.len() > 2 && steps.windows(2).all(|pair| pair[1] < pair[0]);
    let message = if falling {
        "the rows run backwards in time and were sorted"
    } else {
        "the rows are not in time order and were sorted"
    };
    Some(Diagnostic {
        line: usize::try_from(line(back + 1)).unwrap_or(0),
        ..assumed(Severity::Warning, message.into())
    })
}

/// Caveats about this ego for readers of its numbers.
fn check(ego: &Ego, scenario: &Scenario, lines: &Lines) -> Vec<Diagnostic> {
    let mut found = states(ego, scenario, lines);
    let mut warn = |message: String| found.push(assumed(Severity::Warning, message));
    let (own, theirs) = (ego.track.steps(), scenario.steps());
    let moving = scenario
        .obstacles
        .iter()
        .any(|o| o.track().iter().count() > 1);
    if moving && (own.end <= theirs.start || own.start >= theirs.end) {
        warn(format!(
            "recorded from step {} to {}, but the obstacles from {} to {}: no common step; is it from another scenario?",
            own.start,
            own.end - 1,
            theirs.start,
            theirs.end - 1
        ));
    }
    let problem = scenario.planning_problems.iter().find(|p| p.id == ego.id);
    let start = problem.and_then(|p| Some((p.initial.time.from, p.initial.point()?)));
    if let Some((step, planned)) = start
        && let Some(first) = ego.track.at(step)
    {
        let off = (first.pose.position - planned).norm();
        if off > START_TOLERANCE {
            warn(format!(
                "starts {off:.2} m from the start of planning problem {}; is it from another scenario?",
                ego.id
            ));
        }
    }
    found
}

/// Contradictions between its states, and with the road, with their lines.
fn states(ego: &Ego, scenario: &Scenario, lines: &Lines) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut warn = |step: i64, message: String| {
        found.push(Diagnostic {
            line: lines.line_of(step),
            ..assumed(Severity::Warning, message)
        });
    };
    let recorded = &ego.recorded;
    let steps: Vec<i64> = recorded.iter().map(|s| s.step).collect();
    if let Some((place, message)) = missing_steps(&steps) {
        warn(steps[place], message);
    }
    let late = |s: &&Sample| s.step.saturating_sub(steps[0]) > LONGEST_TRACK;
    if let Some(late) = recorded.iter().find(late) {
        warn(
            late.step,
            format!("rows more than {LONGEST_TRACK} steps after the first were left out"),
        );
    }
    if let Some(jump) = ego.track.jump(scenario.dt()) {
        warn(jump.to, jump.to_string());
    }
    let rows = recorded.iter().enumerate();
    let rows: Vec<Row> = rows
        .map(|(place, sample)| Row {
            place,
            sample: *sample,
        })
        .collect();
    for (place, message) in doubts(&rows, scenario.dt(), false) {
        warn(steps[place], message);
    }
    let around = scenario.network.bounds();
    let first = |other: &Obstacle| Some(other.track().iter().next()?.1.pose.position);
    let others: Vec<Point> = match around {
        Some(_) => Vec::new(),
        None => scenario.obstacles.iter().filter_map(first).collect(),
    };
    type Doubt<'a> = &'a dyn Fn(&Sample) -> Option<String>;
    let each: [Doubt<'_>; 6] = [
        &|s| {
            let heading = s.heading?;
            (heading.abs() > MOST_TURNS * std::f64::consts::TAU).then(|| {
                format!("heading {heading}, read as radians, is many turns; is it in degrees?")
            })
        },
        &|s| {
            let fast = s.velocity.filter(|v| v.abs() > FASTEST)?;
            Some(format!("{fast} m/s is faster than any road user"))
        },
        &|s| {
            let hard = s.acceleration.filter(|a| a.abs() > MAX_ACCELERATION)?;
            Some(format!("{hard} m/s² is more than any vehicle can do"))
        },
        &|s| {
            let off = around?.squared_distance(&s.position).sqrt();
            (off > OFF_MAP)
                .then(|| format!("{off:.0} m from every lanelet; is it from another map?"))
        },
        &|s| {
            let others = others.iter().filter(|_| s.step == steps[0]);
            let away = others.map(|other| (other - s.position).norm());
            let off = away.min_by(f64::total_cmp)?;
            (off > OFF_MAP).then(|| {
                format!("{off:.0} m from where each road user begins; is it from another scenario?")
            })
        },
        &|s| {
            let values = [s.position.x, s.position.y];
            let more = [s.heading, s.velocity, s.acceleration];
            let mut all = values.into_iter().chain(more.into_iter().flatten());
            let tiny = all.find(|v| is_tiny(*v))?;
            Some(format!("`{tiny:e}` is implausibly close to 0; used as is"))
        },
    ];
    for doubt in each {
        let mut said = recorded.iter().filter_map(|s| Some((s.step, doubt(s)?)));
        if let Some((step, first)) = said.next() {
            warn(step, and_more(first, said.count()));
        }
    }
    found
}
