//! Output files of planning: motion of the ego, solution, scenario, log of cycles; refused before hours of planning, not after.

use std::io::Write;
use std::path::{Path, PathBuf};

use nearmiss_formats::commonroad::{self, NewFile, SaveError, save};
use nearmiss_formats::{Entry, EntryLocation, write_recording};
use nearmiss_scene::scenario::VehicleModel;
use nearmiss_workflow::drive::DrivenScenario;
use serde::Serialize;

use super::{CycleRecord, StandardErrorRecord};
use crate::Failure;
use crate::files::Inputs;
use crate::many_files::{ManyFiles, RunJournal, holds};
use crate::open::clash;
use crate::output::{self, Target, file_of, refused};

/// What to write.
#[derive(Debug, clap::Args)]
pub struct Files {
    /// Write the ego's motion as CSV with the columns of `ego_trajectory.csv`
    ///
    /// FILE, - for standard output, or an existing folder for NAME/ego_trajectory.csv. Several scenarios need a folder.
    /// Positions are vehicle centres.
    #[arg(short, long, value_name = "FILE|FOLDER")]
    output: Option<PathBuf>,
    /// Also write each scenario with its simulated traffic to the folder of -o, as NAME/NAME.xml
    ///
    /// `nearmiss FOLDER` then opens it with this ego. The folder must not be one that scenarios are read from.
    #[arg(long, requires = "output")]
    with_scenario: bool,
    /// Write the ego's motion as a CommonRoad solution
    ///
    /// FILE, or an existing folder for solution_KS2_SM1_NAME_2020a.xml. Positions are vehicle centres, as CommonRoad's
    /// collision check expects; the KS model itself refers to the rear axle.
    #[arg(long, value_name = "FILE|FOLDER")]
    solution: Option<PathBuf>,
    /// Vehicle model of the solution: kinematic single-track (KS) or point mass (PM).
    #[arg(long, value_name = "MODEL", value_parser = ["KS", "PM"], default_value = "KS", ignore_case = true)]
    solution_model: String,
    /// Write one JSON line per planning cycle: candidates, rejections, cost and chosen states; for external planners
    /// also their standard error.
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Replace existing files.
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    many: ManyFiles,
}

/// Output paths, checked before anything is planned.
pub struct Targets<'a> {
    files: &'a Files,
    log: Option<Target>,
}

/// The options of [`Files`] that a run which is continued must have had.
#[derive(Serialize)]
#[serde(rename_all = "kebab-case")]
struct FileOptions<'a, P> {
    #[serde(flatten)]
    planning: &'a P,
    solution: Option<&'a Path>,
    solution_model: Option<&'a str>,
    with_scenario: Option<&'static str>,
}

impl Files {
    /// Whether anything is written beside standard output.
    pub fn any(&self) -> bool {
        file_of(self.output.as_deref()).is_some() || self.solution.is_some() || self.log.is_some()
    }

    /// Whether there is a log of all cycles.
    pub fn keeps_log(&self) -> bool {
        self.log.is_some()
    }

    /// Whether existing files are replaced.
    pub fn overwrites(&self) -> bool {
        self.overwrite
    }

    /// Whether an earlier run is continued.
    pub fn resumes(&self) -> bool {
        self.many.resume
    }

    /// Whether the ego goes to standard output.
    pub fn to_stdout(&self) -> bool {
        self.output.is_some() && file_of(self.output.as_deref()).is_none()
    }

    /// Whether the ego is written as CSV.
    pub fn has_ego(&self) -> bool {
        self.output.is_some()
    }

    /// Whether the vehicle is found again where the ego is read, as solutions lie with the egos.
    pub fn names_vehicle(&self) -> bool {
        let folder =
            |path: &Option<PathBuf>| path.as_deref().filter(|p| p.is_dir())?.canonicalize().ok();
        let egos = folder(&self.output);
        egos.is_some() && egos == folder(&self.solution)
    }

    /// Begins the log, after a look at where everything would go.
    ///
    /// # Errors
    /// Something is in the way: a file that is there, an input, two scenarios of the same name; or there is no folder
    /// for several scenarios, nothing can be written there, or the scenarios would be found twice at `paths`.
    pub fn begin(&self, paths: &[PathBuf], entries: &[Entry]) -> Result<Targets<'_>, Failure> {
        if self.many.resume && self.log.is_some() {
            return Err(Failure::input(
                "--log and --resume exclude each other: the log has the cycles of one run",
            ));
        }
        for (flag, path) in [("--solution", &self.solution), ("--log", &self.log)] {
            if path.as_deref() == Some(Path::new("-")) {
                return Err(Failure::input(format!(
                    "{flag} -: standard output is already in use; name a file"
                )));
            }
        }
        let several = entries.len() > 1;
        for (flag, path) in [("-o", &self.output), ("--solution", &self.solution)] {
            let Some(path) = path else { continue };
            if several && !path.is_dir() {
                return Err(Failure::input(format!(
                    "{} scenarios need an existing folder ({flag} FOLDER), but {} is not one; create it first",
                    entries.len(),
                    path.display()
                )));
            }
            named_rightly(flag, path)?;
        }
        if self.with_scenario && !self.output.as_ref().is_some_and(|path| path.is_dir()) {
            return Err(Failure::input(
                "--with-scenario needs an existing folder: -o FOLDER",
            ));
        }
        if (self.output.is_some() || self.solution.is_some())
            && let Some((a, b)) = clash(entries)
        {
            return Err(Failure::input(format!(
                "{} and {} are both called {} and would be written to the same file; plan them into separate folders",
                a.display(),
                b.display(),
                a.name
            )));
        }
        self.refuse_inputs(entries)?;
        if let Some(folder) = &self.output {
            let copied = entries.iter().filter(|e| self.scenario_of(e).is_some());
            no_second_copies(folder, paths, copied)?;
        }
        for entry in entries {
            let targets = [self.ego_of(entry), self.scenario_of(entry)];
            let there = targets.into_iter().flatten().find(|path| path.exists());
            // Those of an earlier run are compared one by one.
            let kept = self.overwrite || self.many.resume;
            if let Some(path) = there.filter(|_| !kept) {
                return Err(refused(&SaveError::Exists(path)));
            }
        }
        for (flag, path) in [
            ("-o", file_of(self.output.as_deref())),
            ("--solution", self.solution.as_deref()),
        ] {
            path.map_or(Ok(()), |path| writable(flag, path, self.overwrite))?;
        }
        let log = self
            .log
            .as_deref()
            .map(|path| Target::begin(Some(path), self.overwrite));
        Ok(Targets {
            files: self,
            log: log.transpose()?,
        })
    }

    /// What earlier runs with these settings have finished.
    ///
    /// # Errors
    /// Those in the folder have other settings.
    pub fn journal(&self, planning: &impl Serialize) -> Result<RunJournal, Failure> {
        let solution = self.solution.as_deref();
        let settings = FileOptions {
            planning,
            solution,
            solution_model: solution.map(|_| self.solution_model.as_str()),
            with_scenario: self.with_scenario.then_some("yes"),
        };
        let folder = self.output.as_deref().filter(|path| path.is_dir());
        self.many.journal("plan", folder, &settings)
    }

    /// The scenarios of the part that is planned.
    pub fn part_of(&self, entries: Vec<Entry>) -> Vec<Entry> {
        self.many.part.of(entries)
    }

    /// The file that a scenario's ego goes to.
    fn ego_of(&self, entry: &Entry) -> Option<PathBuf> {
        let path = file_of(self.output.as_deref())?;
        Some(if path.is_dir() {
            path.join(&entry.name).join("ego_trajectory.csv")
        } else {
            path.to_path_buf()
        })
    }

    /// The file that a scenario is written to, where that is wanted; `None` if it lies there already.
    fn scenario_of(&self, entry: &Entry) -> Option<PathBuf> {
        let folder = self.output.as_deref().filter(|_| self.with_scenario)?;
        let path = folder.join(&entry.name).join(format!("{}.xml", entry.name));
        let own = matches!(&entry.place, EntryLocation::File(own) if same(own, &path));
        (!own).then_some(path)
    }

    /// No scenario that is read is ever written over, and no file twice.
    fn refuse_inputs(&self, entries: &[Entry]) -> Result<(), Failure> {
        let named = [
            file_of(self.output.as_deref()),
            self.solution.as_deref(),
            self.log.as_deref(),
        ];
        let named: Vec<&Path> = named
            .into_iter()
            .flatten()
            .filter(|p| !p.is_dir())
            .collect();
        for (place, path) in named.iter().enumerate() {
            if named[..place].contains(path) {
                return Err(Failure::input(format!(
                    "{}: two outputs would be written to this file; name another one",
                    path.display()
                )));
            }
        }
        let copies = entries.iter().filter_map(|entry| self.scenario_of(entry));
        let mut all = named.into_iter().map(Path::to_path_buf).chain(copies);
        let inputs = Inputs::of(entries);
        all.try_for_each(|path| inputs.spare(Some(&path)))
    }
}

impl Targets<'_> {
    /// Writes all that is wanted of a drive; the files that were written.
    pub fn write(
        &mut self,
        entry: &Entry,
        driven: &DrivenScenario,
    ) -> Result<Vec<PathBuf>, Failure> {
        let mut written = Vec::new();
        if let Some(log) = &mut self.log {
            let mut write = |line: Result<String, Failure>| {
                log.write_all(line?.as_bytes())
                    .map_err(|e| Failure::system("--log", &e))
            };
            for cycle in &driven.drive.cycles {
                write(output::json_line(&CycleRecord::new(driven, cycle)))?;
            }
            if let Some(stderr) = StandardErrorRecord::new(driven) {
                write(output::json_line(&stderr))?;
            }
        }
        let files = self.files;
        if files.to_stdout() {
            let bytes = write_recording(driven.problem, &driven.drive.track());
            output::text(&String::from_utf8_lossy(&bytes.map_err(Failure::input)?))?;
        }
        if let Some(path) = files.ego_of(entry) {
            let bytes = write_recording(driven.problem, &driven.drive.track());
            files.save(&path, &bytes.map_err(Failure::input)?)?;
            written.push(path);
        }
        if let Some(path) = files.scenario_of(entry) {
            let reacted = driven.drive.traffic.scenario.is_some();
            let bytes = match entry.source() {
                Ok(xml) if !reacted => xml.into_bytes(),
                // Protobuf has no text, and traffic that reacted is in no file; both are written as `convert` writes.
                _ => commonroad::write(&driven.scenario).map_err(Failure::input)?,
            };
            files.save(&path, &bytes)?;
            written.push(path);
        }
        if let Some(path) = &files.solution {
            written.push(files.write_solution(path, entry, driven)?);
        }
        Ok(written)
    }

    /// Puts the log in its place.
    pub fn finish(self) -> Result<(), Failure> {
        self.log.map_or(Ok(()), Target::finish)
    }
}

impl Files {
    fn write_solution(
        &self,
        path: &Path,
        entry: &Entry,
        driven: &DrivenScenario,
    ) -> Result<PathBuf, Failure> {
        let model = VehicleModel::parse(&self.solution_model.to_uppercase());
        let header = &driven.scenario.header;
        let wrong = |e| Failure::input(format!("{}: {e}", entry.display()));
        let solution = driven
            .drive
            .solution(
                header,
                driven.problem,
                model.unwrap_or(VehicleModel::Ks),
                driven.settings.planner.vehicle,
            )
            .map_err(wrong)?;
        let solved = solution.problems.iter();
        let how = solved.map(|s| format!("{}_{}", s.vehicle_id(), s.cost));
        let path = if path.is_dir() {
            path.join(format!(
                "solution_{}_{}_{}.xml",
                how.collect::<Vec<_>>().join("_"),
                entry.name,
                header.version
            ))
        } else {
            path.to_path_buf()
        };
        let bytes = commonroad::write_solution(&solution).map_err(wrong)?;
        self.save(&path, &bytes)?;
        Ok(path)
    }

    /// Saves a file; below a folder that was named, the scenario's own folder is made.
    fn save(&self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        if let Some(folder) = path.parent()
            && folder
                .parent()
                .is_some_and(|p| self.output.as_deref() == Some(p))
            && !folder.is_dir()
        {
            std::fs::create_dir(folder).map_err(|e| Failure::system(folder.display(), &e))?;
        }
        if self.many.resume && holds(path, bytes) {
            return Ok(());
        }
        save(path, bytes, self.overwrite).map_err(|e| refused(&e))
    }
}

fn same(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Refuses a place that is named as a folder and is none.
fn named_rightly(flag: &str, path: &Path) -> Result<(), Failure> {
    let text = path.to_string_lossy();
    if !text.ends_with(std::path::is_separator) || path.is_dir() {
        return Ok(());
    }
    Err(Failure::input(format!(
        "{flag} {text}: no such folder; create it first"
    )))
}

/// Tries to make a file at a place, or in it where it is a folder; nothing stays behind.
fn writable(flag: &str, path: &Path, overwrite: bool) -> Result<(), Failure> {
    let tried = if path.is_dir() {
        NewFile::begin(&path.join(".nearmiss"), true)
    } else {
        NewFile::begin(path, overwrite)
    };
    tried.map(drop).map_err(|error| match error {
        SaveError::Exists(_) => refused(&error),
        SaveError::Io { .. } => Failure::input(format!(
            "{flag} {}: not writable ({}); choose another folder",
            path.display(),
            error
        )),
        _ => Failure::input(format!("{flag} {error}")),
    })
}

/// Refuses copies of scenarios in a folder where the same scenarios are found: each would be there twice.
///
/// `paths` are what was named, `copied` the scenarios of which a copy would be written into `folder`.
fn no_second_copies<'a>(
    folder: &Path,
    paths: &[PathBuf],
    copied: impl Iterator<Item = &'a Entry>,
) -> Result<(), Failure> {
    let Ok(whole) = folder.canonicalize() else {
        return Ok(());
    };
    let mut copied = copied.peekable();
    if copied.peek().is_none() {
        return Ok(());
    }
    let within = |outer: &PathBuf| {
        let outer = outer.canonicalize().ok().filter(|outer| outer.is_dir());
        outer.is_some_and(|outer| whole.starts_with(outer))
    };
    let read_from = paths.iter().find(|path| within(path));
    let mut files = copied.filter_map(|entry| match &entry.place {
        EntryLocation::File(path) => path.canonicalize().ok(),
        EntryLocation::Bundled(_) => None,
    });
    let inside = files.find(|file| file.starts_with(&whole));
    let found = match (&inside, read_from) {
        (Some(_), _) => folder,
        (None, Some(path)) => path,
        (None, None) => return Ok(()),
    };
    // An ego in NAME/ belongs to the NAME.xml beside it.
    let without = match inside {
        Some(file) if file.parent() == Some(&whole) => {
            ", or drop --with-scenario: egos are found beside their scenarios"
        }
        _ => "",
    };
    Err(Failure::input(format!(
        "--with-scenario -o {}: the scenarios are read from {}, so each copy would be found as a second scenario of the same name; choose a folder outside it{without}",
        folder.display(),
        found.display()
    )))
}
