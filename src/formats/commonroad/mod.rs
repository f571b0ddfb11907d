//! CommonRoad files: reads XML and protobuf, writes XML; every diagnostic has its place.

mod before_2018b;
pub(super) mod builder;
mod conform;
mod elements;
mod encoding;
mod obstacles;
mod protobuf;
mod road;
mod solution;
pub(super) mod writer;
mod writer_2018b;
pub(super) mod xml;
mod xml_reader;

use std::path::{Path, PathBuf};

use nearmiss_base::system;
use nearmiss_scene::scenario::Scenario;

pub use builder::ReadError;
pub use conform::{Conformed, conform};
pub(super) use encoding::{beginning, foreign, without_marks};
pub use nearmiss_base::system::{NewFile, SaveError, save};
pub(super) use protobuf::wire;
pub use solution::{
    Field, ProblemSolution, Solution, SolutionError, SolutionState, SolutionTrajectory,
    TrajectoryKind, read_solution, write_solution,
};
pub use writer::{WriteError, write};
pub use writer_2018b::write_2018b;
pub use xml_reader::{Root, Unrecognised, root_of, root_of_file};
pub(super) use xml_reader::{beginning_of_file, is_scenario, root_name_of};

/// Reads a CommonRoad scenario, XML or protobuf, from `bytes`; `file` names it in errors.
///
/// The format is detected from the first bytes, or by the name's ending `.pb` if those are damaged.
///
/// # Errors
/// Not a scenario: with line, column, element and what was expected there. A dynamic or scenario file of the 2024
/// protobuf format, which needs its sibling files: use [`read_file`].
pub fn read(bytes: &[u8], file: &str) -> Result<Scenario, ReadError> {
    dispatch(bytes, file, None)
}

/// Reads a CommonRoad scenario, XML or protobuf, from a file.
///
/// For a scenario file of the 2024 protobuf format the map and the dynamic file are read too, for a dynamic file
/// the map: from the same folder, by the ids in them and by their names. The hash is that of the bytes of map,
/// dynamic and scenario file one after the other.
///
/// # Errors
/// The file or one that it needs cannot be read, or see [`read`].
pub fn read_file(path: &Path) -> Result<Scenario, ReadError> {
    let file = path.display().to_string();
    let bytes = system::read_file(path, system::LARGEST).map_err(|e| ReadError::io(&file, &e))?;
    dispatch(&bytes, &file, Some(path))
}

fn dispatch(bytes: &[u8], file: &str, path: Option<&Path>) -> Result<Scenario, ReadError> {
    if protobuf::is_meant(bytes, file) {
        protobuf::read(bytes, file, path)
    } else {
        xml_reader::scenario(bytes, file)
    }
}

/// Whether a file's name is that of a protobuf file.
pub(super) fn is_protobuf_name(path: &Path) -> bool {
    protobuf::is_protobuf_name(path)
}

/// Whether a file's name is that of an XML file.
pub(super) fn is_xml_name(path: &Path) -> bool {
    path.extension()
        .is_some_and(|x| x.eq_ignore_ascii_case("xml"))
}

/// The protobuf files among those of one folder that are scenarios, and not part of one of the others; and those that
/// are nothing known.
pub(super) fn protobuf_scenarios(
    files: Vec<PathBuf>,
) -> (Vec<PathBuf>, Vec<(PathBuf, Unrecognised)>) {
    protobuf::scenarios(files)
}

/// The name of the scenario in a file: the file's name without its extension and the `-SC` of 2024 protobuf.
pub(super) fn scenario_name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    protobuf::scenario_name(path).unwrap_or_else(|| stem.to_string_lossy().into_owned())
}
