//! `nearmiss convert`: rewrites scenarios of any format as CommonRoad 2020a XML, or as OpenSCENARIO for simulators.

mod ego;
mod simulator;

use std::collections::BTreeMap;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use serde_json::json;

use super::interrupt::{INTERRUPTED, interrupted};
use super::many_files::{FinishedFiles, ManyFiles, Progressed, holds};
use super::open::{clash, found};
use super::parallel::in_order;
use super::progress::Progress;
use super::{Failure, Outcome, output};
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_formats::commonroad::{NewFile, conform, write};
use nearmiss_scene::scenario::{alike, in_short};
use nearmiss_workflow::{SimulatedEgo, VariantOrigin};

/// Arguments of `convert`.
#[derive(Debug, clap::Args)]
pub struct Convert {
    /// Scenario files of any format, folders or names of bundled scenarios.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// File to write (.xml or .xosc), or an existing folder; several scenarios need a folder [default: standard output,
    /// CommonRoad only].
    #[arg(short, long, value_name = "PATH")]
    output: Option<PathBuf>,
    /// CommonRoad: change what the published schema does not allow, and report each change.
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
    if for_simulators && arguments.schema {
        return Err(Failure::input(
            "--schema applies to CommonRoad; OpenSCENARIO files conform to their own schema",
        ));
    }
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
    let settings = if for_simulators {
        format!("openscenario {}", arguments.simulator.settings())
    } else {
        format!("schema {}", arguments.schema)
    };
    let finished = arguments
        .many
        .finished_files("convert", folder, (settings, BTreeMap::new()))?;
    let ego = if for_simulators {
        Some(arguments.simulator.ego(&entries)?)
    } else {
        None
    };
    // Before anything is written, so that no file is left half written.
    let stop = interrupted(true);
    let job = Job {
        arguments,
        ego,
        folder,
        finished,
        cancel: Cancel::from_flag(&stop),
    };
    let (mut failed, mut unfit) = (0, 0);
    let mut ended = None;
    let mut left = entries.iter();
    let progress = Progress::new(entries.len(), "scenarios", job.target(None).is_some());
    in_order(
        entries.len(),
        &stop,
        |i| job.convert(&entries[i]),
        |converted| {
            let Some(entry) = left.next() else {
                return ControlFlow::Break(());
            };
            let taken = converted.and_then(|converted| job.take(entry, converted, &progress));
            match taken {
                Ok(fits) => unfit += usize::from(!fits),
                Err(failure) if entries.len() == 1 => {
                    ended = Some(failure);
                    return ControlFlow::Break(());
                }
                Err(failure) => {
                    failed += 1;
                    progress.suspend(|| failure.say());
                }
            }
            progress.step();
            ControlFlow::Continue(())
        },
    );
    drop(progress);
    if stop.load(Ordering::Relaxed) {
        return Err(job.stopped());
    }
    if let Some(failure) = ended {
        return Err(failure);
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

/// What holds for all scenarios of a call.
struct Job<'a> {
    arguments: &'a Convert,
    /// The ego for simulators; `None` where CommonRoad is written.
    ego: Option<SimulatedEgo>,
    folder: Option<&'a Path>,
    finished: Option<FinishedFiles>,
    cancel: Cancel,
}

/// A scenario as it is written.
#[derive(Default)]
struct Converted {
    /// In the order in which they are written.
    files: Vec<(PathBuf, Vec<u8>)>,
    /// For standard output.
    printed: Option<String>,
    /// What is said of it.
    said: Vec<String>,
    /// Whether it fits the schema.
    fits: bool,
}

/// What is to be done with a scenario.
enum Step {
    /// Nothing: an earlier run has done it; whether it fits the schema.
    Kept(bool),
    /// It is written.
    Write(Converted, Option<Progressed>),
}

impl Job<'_> {
    /// The file of a scenario; nothing where it is printed.
    fn target(&self, entry: Option<&Entry>) -> Option<PathBuf> {
        let named = |folder: &Path| match entry {
            Some(entry) if self.ego.is_some() => simulator::target(folder, entry),
            Some(entry) => folder.join(format!("{}.xml", entry.name)),
            None => folder.to_path_buf(),
        };
        match self.folder {
            Some(folder) => Some(named(folder)),
            // As elsewhere, `-` is the standard output.
            None => self
                .arguments
                .output
                .clone()
                .filter(|path| path.as_os_str() != "-"),
        }
    }

    /// Converts a scenario, unless an earlier run has done it. Nothing is written yet.
    fn convert(&self, entry: &Entry) -> Result<Step, Failure> {
        let target = self.target(Some(entry));
        let known = match (&self.finished, &target) {
            (Some(finished), Some(_)) => Some(finished.of(entry)),
            _ => None,
        };
        if let Some(notes) = known.as_ref().and_then(|k| k.finished.as_ref()) {
            return Ok(Step::Kept(notes["fits"] == true));
        }
        let converted = match &self.ego {
            Some(ego) => simulator::convert(entry, target, ego, &self.cancel)?,
            None => commonroad(entry, target, self.arguments)?,
        };
        Ok(Step::Write(converted, known))
    }

    /// Writes a scenario; says whether it fits the schema.
    fn take(&self, entry: &Entry, step: Step, progress: &Progress) -> Result<bool, Failure> {
        let (converted, known) = match step {
            Step::Kept(fits) => return Ok(fits),
            Step::Write(converted, known) => (converted, known),
        };
        if let (Some(finished), Some(known)) = (&self.finished, &known) {
            finished.make_room(known)?;
        }
        let own_ego = self.target(Some(entry)).map(|path| ego::beside(&path));
        let refused = |path: &Path, error: &dyn std::fmt::Display| {
            let hint = if path.exists() { " (--overwrite)" } else { "" };
            Failure::input(format!("{error}{hint}"))
        };
        // All are begun before one is there, so that none is left without the others.
        let mut begun = Vec::new();
        for (path, bytes) in converted.files.iter().rev() {
            // A scenario that is rewritten in its place has its ego already.
            let may_hold = self.arguments.many.resume || Some(path) == own_ego.as_ref();
            if may_hold && holds(path, bytes) {
                continue;
            }
            let mut file =
                NewFile::begin(path, self.arguments.overwrite).map_err(|e| refused(path, &e))?;
            file.write_all(bytes)
                .map_err(|e| Failure::system(path.display(), &e))?;
            begun.push((path, file));
        }
        for (path, file) in begun.into_iter().rev() {
            file.finish().map_err(|e| refused(path, &e))?;
        }
        if let Some(text) = &converted.printed {
            output::text(text)?;
        }
        progress.suspend(|| converted.said.iter().for_each(|said| output::say(said)));
        if let (Some(finished), Some(known)) = (&self.finished, known) {
            let files = converted.files.into_iter().map(|(path, _)| path);
            let files: Vec<PathBuf> = files.collect();
            finished.add(entry, known, &files, json!({ "fits": converted.fits }))?;
        }
        Ok(converted.fits)
    }

    fn stopped(&self) -> Failure {
        let words = match self.folder {
            Some(_) => {
                "interrupted; finished files are kept; the same command with --resume continues"
            }
            None => "interrupted",
        };
        Failure {
            message: words.into(),
            status: INTERRUPTED,
        }
    }
}

/// A scenario as CommonRoad XML.
fn commonroad(
    entry: &Entry,
    target: Option<PathBuf>,
    arguments: &Convert,
) -> Result<Converted, Failure> {
    let scenario = entry.read().map_err(Failure::input)?;
    let conformed = conform(&scenario);
    let name = &entry.name;
    let written = if arguments.schema {
        &conformed.scenario
    } else {
        &scenario
    };
    let bytes = write(written).map_err(Failure::input)?;
    let mut done = Converted::default();
    match (&target, ego::recording(entry, &scenario)) {
        (_, Ok(None)) => {}
        // Before the scenario, so that it is never there without.
        (Some(path), Ok(Some(recording))) => done.files.push((ego::beside(path), recording)),
        (None, Ok(Some(_))) => done.said.push(format!(
            "{name}: the ego is left out; -o FILE.xml writes it beside the scenario"
        )),
        (_, Err(error)) => done
            .said
            .push(format!("{name}: the ego is left out: {error}")),
    }
    if VariantOrigin::read(entry).is_some() {
        done.said.push(format!(
            "{name}: its manifest and the drives of good drivers are of the original file, and not copied"
        ));
    }
    match target {
        Some(path) => done.files.push((path, bytes)),
        None => done.printed = Some(output::escaped_xml(&String::from_utf8_lossy(&bytes))),
    }
    let said = &mut done.said;
    for (_, words) in in_short(&scenario.diagnostics) {
        said.push(format!("{name}: reading: {words}"));
    }
    let (changes, violations) = (&conformed.changes, &conformed.violations);
    if arguments.schema {
        let changed = alike(changes).into_iter().map(|c| format!("{name}: {c}"));
        said.extend(changed);
        let unfit = alike(violations).into_iter();
        said.extend(unfit.map(|v| format!("{name}: does not conform: {v}")));
    } else if changes.len() + violations.len() > 0 {
        let count = changes.len() + violations.len();
        let things = if count == 1 {
            "element does"
        } else {
            "elements do"
        };
        said.push(format!(
            "{name}: written as read; {count} {things} not conform to the 2020a schema; --schema lists and fixes them"
        ));
    }
    done.fits = violations.is_empty();
    Ok(done)
}
