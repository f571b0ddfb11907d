//! Why an ego could not be read.

use crate::commonroad::ReadError;
use nearmiss_base::system;
use nearmiss_scene::scenario::SceneError;
use nearmiss_scene::scenario::plausibility::LATEST_STEP;

/// Why an ego could not be read.
#[derive(Debug, thiserror::Error)]
pub enum EgoError {
    /// The file cannot be opened or read.
    #[error("{file}: {}", system::error_text(source))]
    Io {
        /// Which file.
        file: String,
        /// The system's message.
        source: std::io::Error,
    },
    /// A planner has no drive in the scenario.
    #[error("{file}: not driven by {planner}: no drive of it in {folder}")]
    NoDrive {
        /// The scenario.
        file: String,
        /// The planner.
        planner: String,
        /// Where its drives are.
        folder: String,
    },
    /// It is not a file with an ego.
    #[error(
        "{file}: not an ego: {why}; an ego is a CSV file with the columns timestep, x_position and y_position, a Frenetix logs.csv, or a CommonRoad solution"
    )]
    Unknown {
        /// Which file.
        file: String,
        /// The kind found instead.
        why: String,
    },
    /// A column that is needed is not in the header.
    #[error(
        "{file}: line 1 has no column `{column}`; an ego trajectory needs timestep, x_position and y_position"
    )]
    Column {
        /// Which file.
        file: String,
        /// Which column.
        column: &'static str,
    },
    /// A column that is needed is not in the header of a log.
    #[error(
        "{file}: line 1 has no column `{column}`; a log needs trajectory_number, and x_position_vehicle_m and y_position_vehicle_m or x_positions_m, y_positions_m and theta_orientations_rad"
    )]
    LogColumn {
        /// Which file.
        file: String,
        /// Which column.
        column: &'static str,
    },
    /// The columns are not separated by commas.
    #[error("{file}: line 1: columns are separated by {separator}; use commas")]
    Separator {
        /// Which file.
        file: String,
        /// By what instead.
        separator: &'static str,
    },
    /// A value is not a number.
    #[error("{file}: line {line}: column `{column}` is `{value}`; expected a finite number")]
    Value {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
        /// Which column.
        column: &'static str,
        /// The text found.
        value: String,
    },
    /// A length or width that no vehicle has.
    #[error(
        "{file}: line {line}: column `{column}` is `{value}`; expected metres, above 0 and at most 100"
    )]
    Size {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
        /// Which column.
        column: &'static str,
        /// The text found.
        value: String,
    },
    /// The size of the vehicle changes.
    #[error(
        "{file}: line {line}: columns `length` and `width` differ from the first row; a vehicle keeps its size"
    )]
    OtherSize {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
    },
    /// A value is beyond anything that can be meant.
    #[error("{file}: line {line}: column `{column}`: {why}")]
    Absurd {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
        /// Which column.
        column: &'static str,
        /// The text found, and the accepted values.
        why: String,
    },
    /// A time step is not a whole number, or beyond all reason.
    #[error(
        "{file}: line {line}: column `{column}` is `{value}`; expected a whole time step, at most {LATEST_STEP}"
    )]
    Step {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
        /// Which column.
        column: &'static str,
        /// The text found.
        value: String,
    },
    /// Two columns could be the same one.
    #[error(
        "{file}: line 1: `{first}` and `{second}` could both be `{column}`; rename or remove one of them"
    )]
    Ambiguous {
        /// Which file.
        file: String,
        /// Which column they could be.
        column: &'static str,
        /// The name of one.
        first: String,
        /// The name of the other.
        second: String,
    },
    /// A row has fewer fields than the header.
    #[error(
        "{file}: line {line} has {found} fields, but the header {expected} columns: `{column}` is missing; write an empty field for a missing value"
    )]
    Short {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
        /// How many fields the row has.
        found: usize,
        /// How many columns there are.
        expected: usize,
        /// The first column that it has no field for.
        column: String,
    },
    /// A row has more fields than the header.
    #[error(
        "{file}: line {line} has {found} fields, but the header {expected} columns: `{value}` is one too many; do numbers contain commas?"
    )]
    Long {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
        /// How many fields the row has.
        found: usize,
        /// How many columns there are.
        expected: usize,
        /// The first field without a column.
        value: String,
    },
    /// A field is not UTF-8.
    #[error("{file}: line {line}: column `{column}` is not UTF-8; save the file as UTF-8")]
    Text {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
        /// Which column.
        column: String,
    },
    /// A quote is never closed, and takes in the lines behind it.
    #[error("{file}: line {line}: unclosed quote; close or remove it")]
    Unclosed {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
    },
    /// The id of an ego is not a whole number.
    #[error("{file}: line {line}: column `ego_id` is `{value}`; expected a whole number")]
    Id {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
        /// The text found.
        value: String,
    },
    /// A time step stands twice.
    #[error("{file}: line {line}: time step {step} is given twice; each step needs one row")]
    Repeated {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
        /// Which step.
        step: i64,
    },
    /// The file has a header and no state.
    #[error("{file}: no rows, so no ego")]
    Empty {
        /// Which file.
        file: String,
    },
    /// The file is a broken solution.
    #[error(transparent)]
    Solution(#[from] ReadError),
    /// The solution says what the driver does, not where the vehicle is.
    #[error(
        "{file}: planning problem {problem} is solved by inputs (<{element}>) without positions; a trajectory of states is needed"
    )]
    Inputs {
        /// Which file.
        file: String,
        /// Which planning problem.
        problem: i64,
        /// The element that holds the inputs.
        element: &'static str,
    },
    /// The file has no ego for this planning problem.
    #[error("{file}: no ego for planning problem {problem}; available: {known}")]
    NoSuchProblem {
        /// Which file.
        file: String,
        /// The one asked for.
        problem: i64,
        /// The ones available.
        known: String,
    },
    /// The solution is of another scenario: of planning problems which this one does not have.
    #[error(
        "{file}: solves planning problem {problems} of {of}, but the open scenario is {scenario} with planning problem {known}; {}",
        other_scenario(of, scenario)
    )]
    Foreign {
        /// Which file.
        file: String,
        /// The planning problems it solves.
        problems: String,
        /// The scenario that it is of.
        of: String,
        /// The scenario it was to be put into.
        scenario: String,
        /// The planning problems of that one.
        known: String,
    },
    /// The obstacle cannot be the ego.
    #[error("{file}: {source}")]
    Obstacle {
        /// The file with the scenario.
        file: String,
        /// The missing part.
        source: SceneError,
    },
    /// The file has egos for several planning problems, and none was chosen.
    #[error("{file}: egos for the planning problems {known}; choose one")]
    Several {
        /// Which file.
        file: String,
        /// The ones available.
        known: String,
    },
}

/// Advice for a solution of `of` where `scenario` was opened.
fn other_scenario(of: &str, scenario: &str) -> String {
    if of == scenario {
        "open the scenario file that it was made for".into()
    } else {
        format!("open {of}, or use a solution of {scenario}")
    }
}
