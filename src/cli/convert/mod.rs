//! `nearmiss convert`: rewrites scenarios of any format, or a part of them, as CommonRoad XML, as OpenSCENARIO for
//! simulators, or as tables of tracks.

mod crop;
mod formats;
mod target;

use std::io::Write;
use std::path::{Path, PathBuf};

use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_formats::commonroad::NewFile;
use nearmiss_workflow::SimulatedEgo;
use serde::{Deserialize, Serialize};

use super::ending::interrupted;
use super::files::Inputs;
use super::many_files::{Failed, Job, ManyFiles, NEXT, RunJournal, Unit, holds};
use super::open::{clash, found};
use super::{Failure, Outcome, output};
use crop::CropOptions;
use formats::ego_beside;
use target::{Target, TargetOptions};

/// Arguments of `convert`.
#[derive(Debug, clap::Args, Serialize)]
pub struct Convert {
    /// Scenario files of any format, folders or names of bundled scenarios.
    #[arg(required = true)]
    #[serde(skip)]
    paths: Vec<PathBuf>,
    /// File to write (.xml, .xosc, .csv or .parquet), or an existing folder; several scenarios need a folder [default:
    /// standard output, for formats of one file].
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
    target: TargetOptions,
    #[command(flatten)]
    #[serde(flatten)]
    crop: CropOptions,
}

/// Runs `convert`.
pub fn run(arguments: &Convert) -> Outcome {
    let target = arguments.target.wanted(arguments.output.as_deref())?;
    if target != Target::CommonRoad && arguments.schema {
        return Err(Failure::input(
            "--schema applies to CommonRoad 2020a; other formats have no schema that it checks",
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
            "{} and {} would both become {}; convert them into different folders",
            a.display(),
            b.display(),
            target.file_name(&a.name),
        )));
    }
    let journal = arguments.many.journal("convert", folder, arguments)?;
    let ego = if target.has_ego() {
        arguments.target.ego(target, &entries)?
    } else {
        SimulatedEgo::Free
    };
    // Before anything is written, so that no file is left half written.
    let stop = interrupted(true);
    let conversion = Conversion {
        arguments,
        target,
        ego,
        folder,
        inputs: Inputs::of(&entries),
        journal,
        cancel: Cancel::from_flag(&stop),
    };
    let (mut failed, mut unfit) = (Failed::of(entries.len()), 0);
    let to_file = conversion.file(None).is_some();
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
    target: Target,
    /// The ego of formats that have one.
    ego: SimulatedEgo,
    folder: Option<&'a Path>,
    inputs: Inputs,
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
    fn file(&self, entry: Option<&Entry>) -> Option<PathBuf> {
        match (self.folder, entry) {
            (Some(folder), Some(entry)) => Some(folder.join(self.target.file_name(&entry.name))),
            (Some(folder), None) => Some(folder.to_path_buf()),
            // As elsewhere, `-` is the standard output.
            (None, _) => self
                .arguments
                .output
                .clone()
                .filter(|path| path.as_os_str() != "-"),
        }
    }

    /// Converts a scenario. Nothing is written yet.
    fn convert(&self, entry: &Entry) -> Result<Converted, Failure> {
        let file = self.file(Some(entry));
        let (arguments, cancel) = (self.arguments, &self.cancel);
        let crop = &arguments.crop;
        match self.target {
            Target::CommonRoad => formats::commonroad(entry, file, crop, arguments.schema),
            Target::CommonRoad2018b => formats::commonroad_2018b(entry, file, crop),
            Target::OpenScenario => formats::openscenario(entry, file, crop, &self.ego, cancel),
            target @ (Target::Tracks | Target::Interaction | Target::HighD) => {
                formats::tables(entry, file, target, crop, &self.ego, cancel)
            }
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

    /// Whether a file is the scenario's own, and all of it is written: of CommonRoad, as CommonRoad.
    fn rewrites(&self, entry: &Entry, path: &Path) -> bool {
        let is_whole = self.target == Target::CommonRoad && self.arguments.crop.is_whole();
        let whole = |path: &Path| path.canonicalize().ok();
        let own = || entry.file().and_then(|own| whole(&own));
        is_whole && path.exists() && own() == whole(path) && !entry.is_recording()
    }

    fn write(&self, entry: &Entry, converted: Converted) -> Result<(Vec<PathBuf>, Notes), Failure> {
        let own_ego = self.file(Some(entry)).map(|path| ego_beside(&path));
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
            if !self.rewrites(entry, path) {
                self.inputs.spare(Some(path))?;
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
