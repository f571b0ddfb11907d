//! Egos from files: recordings, planner logs and solutions, told apart by their content.

mod checks;
mod error;
mod find;
mod log;
mod planner_drives;
mod recording;
mod selection;
mod solution;
mod table;
mod vehicle_size;

use std::path::Path;

use checks::Lines;
pub use error::EgoError;
pub use find::find_recording;
pub use planner_drives::PlannerDrives;
pub use recording::{USUAL as USUAL_VEHICLE, write_recording, write_sized_recording};
pub use selection::EgoSelection;
pub use solution::ego_of_solution;
pub(super) use vehicle_size::sized;

use super::commonroad::{Root, foreign, read_solution, root_of, without_marks};
use nearmiss_base::system;
use nearmiss_scene::scenario::{Diagnostic, Ego, Scenario, Severity};

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
        let doubts = checks::check(&ego, scenario, &Lines::default());
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
    let doubts = checks::check(&ego, scenario, &lines);
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
