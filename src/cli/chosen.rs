//! What the workbench opens, by the arguments of the program.

use std::path::{Path, PathBuf};

use super::open::{advised, resolved};
use super::{Arguments, Failure};
use nearmiss_formats::{EgoSelection, bundled};
use nearmiss_workflow::{experiment_among, find, index_parts};

/// The paths that the workbench opens.
///
/// # Errors
/// A scenario does not exist, or a name is the beginning of several: in words, with suggestions.
pub fn chosen_paths(arguments: &Arguments) -> Result<Vec<PathBuf>, Failure> {
    let of_argument = |path: &PathBuf| {
        resolved(path).map_err(|failure| Failure {
            message: as_command(path, failure.message),
            ..failure
        })
    };
    arguments.paths.iter().map(of_argument).collect()
}

/// What is said of a path that does not exist and could have been meant as a command.
fn as_command(path: &Path, message: String) -> String {
    let is_word = path.components().count() == 1 && path.extension().is_none();
    if is_word {
        message.replacen("no such file or", "no such file, command or", 1)
    } else {
        message
    }
}

/// Who shall be the ego in the workbench, checked as far as that needs no screen.
///
/// # Errors
/// An ego is chosen, and there is a command, or the paths are not one scenario, or it cannot be the ego there.
pub fn chosen_ego(arguments: &Arguments) -> Result<EgoSelection, Failure> {
    if arguments.ego.is_beside() {
        return Ok(EgoSelection::Beside);
    }
    if arguments.command.is_some() {
        return Err(Failure::input(
            "--ego before a command applies to the workbench; put it after it: \
             nearmiss COMMAND FILE --ego ID|FILE",
        ));
    }
    if let Some(file) = experiment_among(&arguments.paths).map_err(Failure::input)? {
        return Err(Failure::input(format!(
            "--ego needs one scenario; {} asks about the ego beside each of its scenarios",
            file.display()
        )));
    }
    let entries = match &arguments.paths[..] {
        [] => bundled(),
        _ => {
            find(&chosen_paths(arguments)?)
                .map_err(Failure::input)?
                .entries
        }
    };
    let [entry] = &entries[..] else {
        return Err(Failure::input(format!(
            "--ego needs one scenario, not {}; name one file or bundled scenario",
            entries.len()
        )));
    };
    let wanted = arguments.ego.wanted(&entries)?;
    let scenario = entry.read().map_err(Failure::input)?;
    wanted.resolve(entry, &scenario).map_err(advised)?;
    Ok(wanted)
}

/// The folder of the index that the workbench opens with.
///
/// # Errors
/// There is a command, or no index in the folder.
pub fn chosen_index(arguments: &Arguments) -> Result<Option<PathBuf>, Failure> {
    let Some(folder) = &arguments.index else {
        return Ok(None);
    };
    if arguments.command.is_some() {
        return Err(Failure::input(
            "--index before a command applies to the workbench; `nearmiss corpus show FOLDER` prints an index",
        ));
    }
    index_parts(folder).map_err(Failure::input)?;
    Ok(Some(folder.clone()))
}
