//! `nearmiss convert`: rewrites scenarios of any format, or a part of them, as CommonRoad XML, as OpenSCENARIO for
//! simulators, or as tables of tracks.

mod crop;
mod target;

use std::path::{Path, PathBuf};

use nearmiss_drive::planner::Cancel;
use nearmiss_formats::commonroad::SaveError;
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_workflow::SimulatedEgo;
use nearmiss_workflow::convert::{ConvertRequest, Converted, Part, Target, WriteError, convert};
use serde::{Deserialize, Serialize};

use super::ending::interrupted;
use super::files::Inputs;
use super::many_files::{Failed, Job, ManyFiles, NEXT, RunJournal, Unit};
use super::open::{clash, configuration, found};
use super::{Failure, Outcome, output};
use crop::CropOptions;
use target::TargetOptions;

/// Arguments of `convert`.
#[derive(Debug, clap::Args, Serialize)]
pub struct Convert {
    /// Scenario files of any format, folders or names of bundled scenarios.
    #[arg(required = true)]
    #[serde(skip)]
    paths: Vec<PathBuf>,
    /// File to write (.xml, .xosc, .csv, .parquet or .arrow) or an existing folder; several scenarios need a folder
    /// [default: standard output, for formats of one file].
    #[arg(short, long, value_name = "PATH")]
    #[serde(skip)]
    output: Option<PathBuf>,
    /// Change what the published CommonRoad schema does not allow, and report each change (CommonRoad only).
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
        SimulatedEgo::Follows(EgoSelection::Beside)
    };
    // Before anything is written, so that no file is left half written.
    let stop = interrupted(true);
    let conversion = Conversion {
        arguments,
        target,
        part: arguments.crop.part(),
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
    part: Part,
    ego: SimulatedEgo,
    folder: Option<&'a Path>,
    inputs: Inputs,
    journal: RunJournal,
    cancel: Cancel,
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

    /// The conversion of a scenario to its file.
    fn request<'a>(&'a self, entry: &'a Entry, file: Option<&'a Path>) -> ConvertRequest<'a> {
        ConvertRequest {
            entry,
            target: self.target,
            file,
            part: &self.part,
            ego: &self.ego,
            to_schema: self.arguments.schema,
        }
    }

    /// Converts a scenario. Nothing is written yet.
    fn convert(&self, entry: &Entry) -> Result<Converted, Failure> {
        let file = self.file(Some(entry));
        let request = self.request(entry, file.as_deref());
        let settings = || {
            let (_, config) = configuration().map_err(|failure| failure.message)?;
            Ok((&config.planning()).into())
        };
        convert(&request, settings, &self.cancel).map_err(Failure::input)
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
        let (file, resumes) = (self.file(Some(entry)), self.arguments.many.resume);
        let request = self.request(entry, file.as_deref());
        save_converted(
            &request,
            &converted,
            [self.arguments.overwrite, resumes],
            &self.inputs,
        )?;
        let files = converted.files.into_iter().map(|(path, _)| path);
        let fits = converted.fits;
        Ok((files.collect(), Notes { fits }))
    }
}

/// Writes the files of a scenario, prints what has none, and says what is said of it: whether it overwrites files, and whether it
/// goes on with an earlier run.
pub fn save_converted(
    request: &ConvertRequest<'_>,
    converted: &Converted,
    [overwrite, resumes]: [bool; 2],
    inputs: &Inputs,
) -> Outcome {
    let saved = request.save(&converted.files, overwrite, resumes, |path| {
        inputs.have(path)
    });
    saved.map_err(|error| match error {
        WriteError::Save(SaveError::Exists(_)) => Failure::input(format!("{error} (--overwrite)")),
        _ => Failure::input(error),
    })?;
    if let Some(text) = &converted.printed {
        output::text(text)?;
    }
    converted.said.iter().for_each(|said| output::say(said));
    Ok(())
}
