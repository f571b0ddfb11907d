//! CommonRoad files: XML in and out, with line numbers for everything that is wrong.

mod conform;
mod elements;
mod error;
mod location;
mod obstacles;
mod out;
mod planning;
mod reader;
mod references;
mod road;
mod root;
mod save;
mod sign_ids;
mod solution;
mod speed_limits;
mod states;
mod surroundings;
mod trucks;
mod writer;
mod xml;

use std::path::Path;

pub use conform::{Conformed, conform};
pub use error::ReadError;
pub use root::{Root, root_of, root_of_file};
pub use save::{SaveError, save};
pub use solution::{
    Field, ProblemSolution, Solution, SolutionError, SolutionState, SolutionTrajectory,
    TrajectoryKind, read_solution, write_solution,
};
pub use writer::{WriteError, write};

use super::Scenario;

/// Reads a CommonRoad XML scenario from `bytes`; `file` names it in errors.
///
/// # Errors
/// What is not a scenario: with line, column, element and what was expected there.
pub fn read(bytes: &[u8], file: &str) -> Result<Scenario, ReadError> {
    reader::scenario(bytes, file)
}

/// Reads a CommonRoad XML scenario from a file.
///
/// # Errors
/// The file cannot be read, or see [`read`].
pub fn read_file(path: &Path) -> Result<Scenario, ReadError> {
    let file = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|e| ReadError::io(&file, &e))?;
    read(&bytes, &file)
}
