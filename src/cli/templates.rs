//! The templates of commands that ask.

use super::{Failure, output};
use nearmiss_ask::prompts::{Library, Problem};
use nearmiss_settings::Folders;
use nearmiss_study::evaluation::validate;

/// The templates that questions are made of. Files that are not in use are told.
///
/// # Errors
/// One that is in use is broken: nothing is sent in its place.
pub fn templates(folders: &Folders) -> Result<Library, Failure> {
    let library = validate(Library::load(Some(&folders.prompts())));
    let (stop, told): (Vec<&Problem>, Vec<_>) = library.problems.iter().partition(|p| p.stops());
    for problem in told {
        output::say(&format!("nearmiss: {problem}"));
    }
    let all: Vec<String> = stop.iter().map(ToString::to_string).collect();
    if all.is_empty() {
        Ok(library)
    } else {
        Err(Failure::input(all.join("\n")))
    }
}
