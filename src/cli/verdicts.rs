//! `nearmiss` without a terminal: says so, and prints the built-in judge's verdicts.

use std::path::PathBuf;

use clap::CommandFactory;
use rayon::prelude::*;

use super::open::{found, scene_with};
use super::{Failure, Outcome, output};
use nearmiss_formats::{EgoSelection, Entry, bundled};
use nearmiss_scene::judge::{self, judge_collision};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::Scene;
use nearmiss_workflow::experiment_among;

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
