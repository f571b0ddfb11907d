//! `nearmiss convert`: rewrites scenarios of any format as CommonRoad 2020a XML, or as OpenSCENARIO for simulators.

mod ego;
mod simulator;

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::interrupt::interrupted;
use super::many_files::{Failed, Job, ManyFiles, NEXT, RunJournal, Unit, holds};
use super::open::{clash, found};
use super::{Failure, Outcome, output};
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_formats::commonroad::{NewFile, conform, write};
use nearmiss_scene::scenario::{alike, in_short};
use nearmiss_workflow::{SimulatedEgo, VariantOrigin};

/// Arguments of `convert`.
#[derive(Debug, clap::Args, Serialize)]
pub struct Convert {
    /// Scenario files of any format, folders or names of bundled scenarios.
    #[arg(required = true)]
    #[serde(skip)]
    paths: Vec<PathBuf>,
    /// File to write (.xml or .xosc), or an existing folder; several scenarios need a folder [default: standard output,
    /// CommonRoad only].
    #[arg(short, long, value_name = "PATH")]
    #[serde(skip)]
    output: Option<PathBuf>,
    /// CommonRoad: change what the published schema does not allow, and report each change.
    #[arg(long)]
    schema: bool,
    /// Replace existing files.
    #[arg(long)]
    #[serde(skip)]
    overwrite: bool,
    #[command(flatten)]
    #[serde(skip)]
    many: ManyFiles,
    #[command(flatten)]
    #[serde(flatten)]
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
    let journal = arguments.many.journal("convert", folder, arguments)?;
    let ego = if for_simulators {
        Some(arguments.simulator.ego(&entries)?)
    } else {
        None
    };
    // Before anything is written, so that no file is left half written.
    let stop = interrupted(true);
    let conversion = Conversion {
        arguments,
        ego,
        folder,
        journal,
        cancel: Cancel::from_flag(&stop),
    };
    let (mut failed, mut unfit) = (Failed::of(entries.len()), 0);
    let to_file = conversion.target(None).is_some();
    let done = Job::new("scenarios", &stop).writing_file(to_file).run(
        &entries,
        |entry| {
            let convert = || Some(conversion.convert(entry));
            conversion.journal.unit(entry, convert)
        },
        |entry, unit| {
            match unit.and_then(|unit| conversion.take(entry, unit)) {
                Ok(Notes { fits }) => unfit += usize::from(!fits),
                Err(failure) => failed.add(failure),
            }
            NEXT
        },
    );
    done.end(match folder {
        Some(_) => "finished files are kept; the same command with --resume continues",
        None => "",
    })?;
    if failed.count == 0 && unfit > 0 && arguments.schema {
        return Err(Failure::finding(format!(
            "{unfit} of {} do not conform to the schema; see above",
            output::counted(entries.len(), "scenario")
        )));
    }
    failed.end("converted")
}

/// What holds for all scenarios of a call.
struct Conversion<'a> {
    arguments: &'a Convert,
    /// The ego for simulators; `None` where CommonRoad is written.
    ego: Option<SimulatedEgo>,
    folder: Option<&'a Path>,
    journal: RunJournal,
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

/// What is noted of a scenario that is written.
#[derive(Serialize, Deserialize)]
struct Notes {
    /// Whether it fits the schema.
    fits: bool,
}

impl Conversion<'_> {
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

    /// Converts a scenario. Nothing is written yet.
    fn convert(&self, entry: &Entry) -> Result<Converted, Failure> {
        let target = self.target(Some(entry));
        match &self.ego {
            Some(ego) => simulator::convert(entry, target, ego, &self.cancel),
            None => commonroad(entry, target, self.arguments),
        }
    }

    /// Writes a scenario, unless an earlier run has done it.
    fn take(
        &self,
        entry: &Entry,
        unit: Unit<Notes, Result<Converted, Failure>>,
    ) -> Result<Notes, Failure> {
        match unit {
            Unit::Kept(notes) => Ok(notes),
            Unit::New(converted, earlier) => {
                let converted = converted?;
                let write = || self.write(entry, converted);
                self.journal.write(entry, earlier, write)
            }
        }
    }

    fn write(&self, entry: &Entry, converted: Converted) -> Result<(Vec<PathBuf>, Notes), Failure> {
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
        converted.said.iter().for_each(|said| output::say(said));
        let files = converted.files.into_iter().map(|(path, _)| path);
        let fits = converted.fits;
        Ok((files.collect(), Notes { fits }))
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
