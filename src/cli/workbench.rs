//! The program without a command: what the workbench opens, by the arguments, or the built-in judge's verdicts without a terminal.

use std::path::{Path, PathBuf};

use clap::CommandFactory;
use nearmiss_formats::{EgoSelection, Entry, bundled};
use nearmiss_scene::judge::{self, judge_collision};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::Scene;
use nearmiss_workflow::{experiment_among, find, index_parts};
use rayon::prelude::*;

use super::open::{advised, check_reading, found, resolved, scene_with};
use super::{Arguments, Failure, Outcome, output};

/// The paths that the workbench opens.
///
/// # Errors
/// A scenario does not exist, or a name is the beginning of several: in words, with suggestions; or an option for tables
/// applies to none of them.
pub fn chosen_paths(arguments: &Arguments) -> Result<Vec<PathBuf>, Failure> {
    let of_argument = |path: &PathBuf| {
        resolved(path).map_err(|failure| Failure {
            message: as_command(path, failure.message),
            ..failure
        })
    };
    let paths: Vec<PathBuf> = arguments
        .paths
        .iter()
        .map(of_argument)
        .collect::<Result<_, _>>()?;
    // Without paths there may be an index, or what is opened later.
    if arguments.command.is_none() && !paths.is_empty() {
        check_reading(&paths, None)?;
    }
    Ok(paths)
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

/// Whether a user is there to look at a screen and press keys.
#[must_use]
pub fn has_terminal() -> bool {
    use std::io::IsTerminal;
    if dumb() {
        return false;
    }
    let keys = || std::io::stdin().is_terminal() || std::fs::File::open("/dev/tty").is_ok();
    std::io::stdout().is_terminal() && keys()
}

/// Whether the terminal says that it can only write lines.
fn dumb() -> bool {
    std::env::var_os("TERM").is_some_and(|term| term == "dumb")
}

/// A table of the built-in judge's verdicts on the scenarios at `paths`, or on the bundled ones, with this ego.
///
/// # Errors
/// No scenario can be found or judged.
pub fn without_terminal(paths: &[PathBuf], ego: &EgoSelection) -> Outcome {
    if let Some(file) = experiment_among(paths).map_err(Failure::input)? {
        let file = file.display();
        return Err(Failure::input(format!(
            "{}; `nearmiss evaluate {file} --dry-run` says what the experiment asks, without --dry-run it asks",
            no_screen()
        )));
    }
    // What cannot be found is said alone: nothing comes after the heading then.
    let entries = if paths.is_empty() {
        bundled()
    } else {
        found(paths)?
    };
    output::say(&format!(
        "nearmiss: {}: the workbench cannot open. These commands work without it: {} (see `nearmiss --help`).\n\
         Verdicts of the built-in judge, {}, on the collision task:",
        no_screen(),
        commands().join(", "),
        judge::MODEL
    ));
    let lines: Vec<Result<String, Failure>> = entries
        .par_iter()
        .map(|e| scene_with(e, ego).map(|s| line(e, &s)))
        .collect();
    let mut failed = 0;
    for line in lines {
        match line {
            Ok(line) => output::text(&line)?,
            Err(failure) => {
                failed += 1;
                failure.say();
            }
        }
    }
    if failed > 0 {
        return Err(Failure::finding(format!(
            "{} could not be judged",
            output::of_scenarios(failed, entries.len())
        )));
    }
    Ok(())
}

/// Why the workbench cannot open.
fn no_screen() -> &'static str {
    if dumb() {
        "this terminal cannot move its cursor (TERM=dumb)"
    } else {
        "no terminal here"
    }
}

/// The names of all commands.
fn commands() -> Vec<String> {
    let program = super::Arguments::command();
    let all = program.get_subcommands();
    all.map(|command| command.get_name().to_string()).collect()
}

fn line(entry: &Entry, scene: &Scene) -> String {
    let verdict = judge_collision(scene, Thresholds::shipped()).verdict;
    let text = format!(
        "{:<28} {:<13} {}\n",
        entry.name,
        verdict.word(),
        verdict.justification
    );
    output::visible(&text)
}
