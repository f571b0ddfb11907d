//! `nearmiss convert`: rewrites scenarios as CommonRoad 2020a XML, or for simulators.

mod simulator;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::many_files::{FinishedFiles, ManyFiles, holds};
use super::open::{clash, found};
use super::{Failure, Outcome, output};
use crate::formats::Entry;
use crate::formats::commonroad::{conform, save, write};
use crate::scenario::{alike, in_short};

/// Arguments of `convert`.
#[derive(Debug, clap::Args)]
pub struct Convert {
    /// Scenario files, folders or names of bundled scenarios.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// File to write, or an existing folder; several scenarios need a folder [default: standard output].
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,
    /// Change what the published schema does not allow, and report each change.
    #[arg(long)]
    schema: bool,
    /// Replace existing files.
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    many: ManyFiles,
    #[command(flatten)]
    simulator: simulator::SimulatorOptions,
}

/// Runs `convert`.
pub fn run(arguments: &Convert) -> Outcome {
    let for_simulators = arguments.simulator.wanted(arguments.output.as_deref())?;
    let entries = arguments.many.part.of(found(&arguments.paths)?);
    let folder = arguments.output.as_deref().filter(|path| path.is_dir());
    if entries.len() > 1 && folder.is_none() {
        return Err(Failure::input(format!(
            "{} scenarios need an existing folder: -o FOLDER",
            entries.len()
        )));
    }
    if let Some((a, b)) = folder.and_then(|_| clash(&entries)) {
        return Err(Failure::input(format!(
            "{} and {} would both become {}.{}; convert them into different folders",
            a.display(),
            b.display(),
            a.name,
            if for_simulators { "xosc" } else { "xml" }
        )));
    }
    let settings = match for_simulators {
        true => format!("openscenario {}", arguments.simulator.settings()),
        false => format!("schema {}", arguments.schema),
    };
    let finished = arguments
        .many
        .finished_files("convert", folder, (settings, BTreeMap::new()))?;
    let (mut failed, mut unfit) = (0, 0);
    for entry in &entries {
        let target = match folder {
            Some(folder) if for_simulators => Some(simulator::target(folder, entry)),
            Some(folder) => Some(folder.join(format!("{}.xml", entry.name))),
            // As elsewhere, `-` is the standard output.
            None => arguments
                .output
                .clone()
                .filter(|path| path.as_os_str() != "-"),
        };
        let target = target.as_deref();
        match convert_once(entry, target, arguments, for_simulators, finished.as_ref()) {
            Ok(fits) => unfit += usize::from(!fits),
            Err(failure) if entries.len() == 1 => return Err(failure),
            Err(failure) => {
                failed += 1;
                failure.say();
            }
        }
    }
    let finding = |message| Failure::finding(message);
    match (failed, unfit) {
        _ if entries.is_empty() => Ok(()),
        (0, 0) => Ok(()),
        (0, _) if !arguments.schema => Ok(()),
        (0, n) => Err(finding(format!(
            "{n} of {} do not conform to the schema; see above",
            output::counted(entries.len(), "scenario")
        ))),
        (n, _) if n == entries.len() => Err(Failure::input("no scenario could be converted")),
        (n, _) => Err(finding(format!(
            "{n} of {} scenarios could not be converted",
            entries.len()
        ))),
    }
}

/// The same as [`convert`], unless an earlier run has done it.
fn convert_once(
    entry: &Entry,
    target: Option<&Path>,
    arguments: &Convert,
    for_simulators: bool,
    finished: Option<&FinishedFiles>,
) -> Result<bool, Failure> {
    let write = || match for_simulators {
        true => simulator::convert(entry, target, arguments).map(|()| true),
        false => convert(entry, target, arguments),
    };
    let (Some(finished), Some(path)) = (finished, target) else {
        return write();
    };
    let known = finished.of(entry);
    if let Some(notes) = &known.finished {
        return Ok(notes["fits"] == true);
    }
    finished.make_room(&known)?;
    let fits = write()?;
    let files = match for_simulators {
        true => simulator::files(path).to_vec(),
        false => vec![path.to_path_buf()],
    };
    finished.add(entry, known, &files, json!({ "fits": fits }))?;
    Ok(fits)
}

/// Writes one scenario; says whether it fits the schema.
fn convert(entry: &Entry, target: Option<&Path>, arguments: &Convert) -> Result<bool, Failure> {
    let scenario = entry.read().map_err(Failure::input)?;
    let conformed = conform(&scenario);
    let name = &entry.name;
    let written = if arguments.schema {
        &conformed.scenario
    } else {
        &scenario
    };
    let bytes = write(written).map_err(Failure::input)?;
    match target {
        Some(path) if arguments.many.resume && holds(path, &bytes) => {}
        Some(path) => save(path, &bytes, arguments.overwrite).map_err(|e| {
            let hint = if path.exists() { " (--overwrite)" } else { "" };
            Failure::input(format!("{e}{hint}"))
        })?,
        None => output::text(&output::escaped_xml(&String::from_utf8_lossy(&bytes)))?,
    }
    for (_, said) in in_short(&scenario.diagnostics) {
        output::say(&format!("{name}: reading: {said}"));
    }
    let (changes, violations) = (&conformed.changes, &conformed.violations);
    if arguments.schema {
        for change in alike(changes) {
            output::say(&format!("{name}: {change}"));
        }
        for violation in alike(violations) {
            output::say(&format!("{name}: does not conform: {violation}"));
        }
    } else if changes.len() + violations.len() > 0 {
        let count = changes.len() + violations.len();
        let things = if count == 1 {
            "element does"
        } else {
            "elements do"
        };
        output::say(&format!(
            "{name}: written as read; {count} {things} not conform to the 2020a schema; --schema lists and fixes them"
        ));
    }
    Ok(violations.is_empty())
}
