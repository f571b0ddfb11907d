//! `nearmiss inspect`: prints the contents and the problems of a scenario or solution.

mod document;
mod folder;
mod solution;
mod states;
mod summary;
mod traffic;

pub use document::ScenarioDocument;
pub use folder::FolderLine;
pub use solution::SolutionDocument;
use std::path::PathBuf;

use super::open::{self, EgoChoice};
use super::{Failure, Outcome, output};
use nearmiss_formats::EntryLocation;
use nearmiss_formats::commonroad::{Root, root_of_file};

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
pub struct Inspect {
    /// CommonRoad scenario or solution, name of a bundled scenario, or folder; of several, one line each.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    format: output::FormatOption,
    #[command(flatten)]
    ego: EgoChoice,
}

/// Runs `inspect`.
pub fn run(arguments: &Inspect) -> Outcome {
    let file = match arguments.files.as_slice() {
        [file] if !file.is_dir() => file,
        several if arguments.ego.is_beside() => {
            return folder::run(several, arguments.format.is_json());
        }
        [folder] => {
            return Err(Failure::input(format!(
                "{} is a folder; --ego needs one scenario",
                folder.display()
            )));
        }
        _ => return Err(Failure::input("--ego needs one scenario")),
    };
    let entry = open::entry(file)?;
    if let EntryLocation::File(path) = &entry.place
        && root_of_file(path) == Root::Solution
    {
        if !arguments.ego.is_beside() {
            return Err(Failure::input(format!(
                "{0} is a solution; name its scenario instead, with --ego {0}",
                path.display()
            )));
        }
        return solution::run(path, arguments.format.is_json());
    }
    let wanted = arguments.ego.wanted(std::slice::from_ref(&entry))?;
    let scenario = entry.read().map_err(Failure::input)?;
    let ego = wanted.resolve(&entry, &scenario);
    if arguments.format.is_json() {
        output::document(&ScenarioDocument::new(&entry, &scenario, &ego))?;
    } else {
        output::text(&summary::summary(&entry, &scenario, &ego))?;
    }
    // The scenario is shown all the same.
    ego.map(|_| ()).map_err(open::advised)
}
