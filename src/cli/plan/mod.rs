//! `nearmiss plan`: drives the ego through scenarios with the planner, and reports the outcomes.

pub mod as_ego;
mod compare;
mod document;
mod driven;
mod files;
mod monitor;
mod options;
mod standing;
mod table;

use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::ending::interrupted;
use super::files::Labels;
use super::many_files::{Done, Job, RunJournal, Unit};
use super::open::{configuration, found};
use super::{Failure, Outcome, knobs, output};
pub use compare::ComparisonRecord;
pub use document::{CycleRecord, NotDrivenRecord, StandardErrorRecord};
use files::{Files, Targets};
pub use monitor::MonitorDryRun;
use monitor::MonitorOptions;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{Policy, Settings};
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::VehicleType;
use nearmiss_workflow::PlanError;
use nearmiss_workflow::drive::{
    BUILT_IN, DriveOptions, DriveRecord, DrivenScenario, PlannerChoice, drive_entry,
};
use options::RunOptions;
pub use options::{PlannerOptions, ProblemOption, identity, planning};
use table::{Export, OutcomeTable};

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Outcomes: goal, collision (with the obstacle and the sides of both bodies), timeout, off_road, infeasible, \
planner_error (the planner's process failed).\n\
Exit status: 0 all drives reach the goal or run out of time; 1 some end otherwise or could not be planned; \
2 usage or input error; 130 interrupted.")]
pub struct PlanArguments {
    /// Scenario files, folders or names of bundled scenarios.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    #[command(flatten)]
    how: ProblemOption,
    /// Change a setting of the planner, a key of [planner] in config.toml
    ///
    /// Among them: prediction (recorded, constant-velocity, lane), traffic (recorded, reactive), rules (obey, off),
    /// replan (steps), horizon (seconds), vehicle (1 to 4). timeout (seconds per cycle) is for external planners. See
    /// `nearmiss help configuration`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = knobs::setting)]
    set: Vec<(String, String)>,
    #[command(flatten)]
    planners: PlannerOptions,
    /// Driver models to compare with the planner, such as cc,fsm: paired outcomes and harm; `nearmiss drivers` lists
    /// them.
    #[arg(long = "driver", value_name = "DRIVERS", value_delimiter = ',', value_parser = options::driver_with_rule)]
    drivers: Vec<Policy>,
    #[command(flatten)]
    monitor: MonitorOptions,
    #[command(flatten)]
    format: output::FormatOption,
    /// Write a table with one row per drive (.csv, .json, .jsonl or .parquet)
    ///
    /// Columns: outcome, kind of collision, comfort, time to the goal, near misses, time per cycle. With two planners
    /// each scenario has two rows.
    #[arg(long, value_name = "FILE")]
    table: Option<PathBuf>,
    #[command(flatten)]
    spreadsheet: output::ForSpreadsheet,
    #[command(flatten)]
    files: Files,
}

/// Runs `plan`.
pub fn run(arguments: &PlanArguments) -> Outcome {
    if arguments.files.to_stdout() && arguments.format.is_json() {
        return Err(Failure::input(
            "-o - and --format json both write to standard output; name a file for -o",
        ));
    }
    let (folders, config) = configuration()?;
    let planning = planning(&arguments.set, &config)?;
    let settings = Settings::from(&planning);
    let entries = arguments.files.part_of(found(&arguments.paths)?);
    if entries.is_empty() {
        return Ok(());
    }
    let problem = arguments.how.planning_problem;
    let mut planners = arguments.planners.chosen(&config, planning.timeout)?;
    if !arguments.drivers.is_empty() && planners.is_empty() {
        planners.push(PlannerChoice {
            name: BUILT_IN.into(),
            ..PlannerChoice::default()
        });
    }
    planners.extend(arguments.drivers.iter().copied().map(PlannerChoice::from));
    if planners.len() > 1 {
        return compare::run(arguments, &entries, &planners, &settings);
    }
    let planner = planners.first();
    let settings = Settings {
        policy: planner.and_then(|planner| planner.policy),
        ..settings
    };
    let setup = arguments.monitor.setup(&folders, &config)?;
    let stop = interrupted(true);
    if let Some(setup) = setup.as_ref().filter(|_| arguments.monitor.is_dry_run()) {
        return setup.dry_run(
            &entries,
            problem,
            &settings,
            &stop,
            arguments.format.is_json(),
        );
    }
    let external = planner.and_then(|planner| planner.external.as_ref());
    let targets = arguments.files.begin(&arguments.paths, &entries)?;
    let journal = arguments.files.journal(&RunOptions::new(
        &settings,
        problem,
        external.map(|planner| &**planner),
        arguments.monitor.is_asked().then_some(&arguments.monitor),
    ))?;
    let cancel = Cancel::from_flag(&stop);
    check_earlier_drives(&journal, setup.is_some(), || {
        options::identity(&entries, problem, &settings, external?, &cancel)
    })?;
    let unnamed = arguments.files.has_ego() && !arguments.files.names_vehicle();
    if unnamed && settings.planner.vehicle != VehicleType::Bmw320i {
        output::say(&format!(
            "nearmiss: the CSV cannot hold the vehicle's size and is read as a {}, but this is a {}; --solution with the folder of -o keeps it, or open the solution with --ego",
            VehicleType::Bmw320i.name(),
            settings.planner.vehicle.name()
        ));
    }
    if let Some(setup) = &setup {
        setup.announce(&entries, problem, &settings, &stop)?;
    }
    let monitor = setup.as_ref().map(|setup| setup.monitor());
    let mut drives = Drives {
        arguments,
        entries: &entries,
        journal: &journal,
        targets,
        export: Export::begin(
            (arguments.table.as_deref(), arguments.spreadsheet),
            arguments.files.overwrites(),
            &journal,
        )?,
        table: OutcomeTable::new(Labels::new(&entries), monitor.is_some(), planner.is_some()),
        begun: false,
        gone: false,
        kept: 0,
        harmed: 0,
        failed: 0,
        missed: Missing::default(),
    };
    let work = |entry: &Entry| {
        journal.unit(entry, || {
            drive_entry(
                entry,
                problem,
                &settings,
                DriveOptions {
                    planner,
                    monitor: monitor.as_ref(),
                    counts: arguments.files.keeps_log(),
                },
                &cancel,
            )
            .map(Box::new)
        })
    };
    let done = Job::new("scenarios", &stop).run(&entries, work, |entry, unit| {
        drives.take(entry, unit?)?;
        Ok(drives.next_one())
    });
    drives.end(done)
}

/// Refuses drives of an earlier run that had a planner whose process says another name or version than `now`, or a
/// monitor that the first layout of journals did not note. A planner that cannot be asked is compared where it drives:
/// nowhere.
fn check_earlier_drives(
    journal: &RunJournal,
    is_monitored: bool,
    now: impl FnOnce() -> Option<(String, String)>,
) -> Outcome {
    let drives = journal.notes().map(|drive: FinishedDrive| drive.document);
    let drives: Vec<DriveRecord> = drives.collect();
    let refused = |why: &str| {
        let folder = journal.folder().unwrap_or(Path::new("."));
        Err(Failure::input(output::visible(&format!(
            "{}: the drives in this folder {why}; choose another folder, or leave out --resume and start again with --overwrite",
            folder.display()
        ))))
    };
    if drives.iter().any(|drive| drive.monitor.is_some()) && !is_monitored {
        return refused("had a monitor, and none is asked for");
    }
    let processes = drives
        .into_iter()
        .filter_map(|drive| drive.external_planner);
    let mut then: Vec<(String, String)> = processes
        .map(|process| (process.name, process.version))
        .filter(|(name, _)| !name.is_empty())
        .collect();
    then.sort();
    then.dedup();
    if then.is_empty() {
        return Ok(());
    }
    let Some(now) = now() else {
        return Ok(());
    };
    match then.iter().find(|then| **then != now) {
        None => Ok(()),
        Some(then) => refused(&format!(
            "are of planner {}, which is {} now",
            format!("{} {}", then.0, then.1).trim(),
            format!("{} {}", now.0, now.1).trim()
        )),
    }
}

/// What a run notes of a drive for the run that continues it.
#[derive(Serialize, Deserialize)]
struct FinishedDrive {
    document: DriveRecord,
    /// Whether it ended at the goal or out of time.
    unharmed: bool,
}

/// A scenario that was driven, now or by an earlier run, or why it was not.
type DrivenUnit = Unit<FinishedDrive, Box<Result<DrivenScenario, PlanError>>>;

/// How many scenarios were not driven.
#[derive(Debug, Default)]
struct Missing {
    /// They cannot be read, or what was asked does not go with them.
    input: usize,
    /// There is nothing to drive in them.
    finding: usize,
}

/// The work so far.
struct Drives<'a> {
    arguments: &'a PlanArguments,
    entries: &'a [Entry],
    journal: &'a RunJournal,
    targets: Targets<'a>,
    table: OutcomeTable,
    /// The table in a file.
    export: Option<Export>,
    /// The table has a header.
    begun: bool,
    /// The reader of the table is gone.
    gone: bool,
    /// Scenarios that an earlier run has driven.
    kept: usize,
    harmed: usize,
    /// Drives that an error of the planner's process ended.
    failed: usize,
    missed: Missing,
}

impl Drives<'_> {
    /// Writes and shows the next scenario, or counts it as an earlier run has left it.
    fn take(&mut self, entry: &Entry, unit: DrivenUnit) -> Outcome {
        let (driven, earlier) = match unit {
            Unit::Kept(drive) => {
                self.kept += 1;
                return self.count(&drive);
            }
            Unit::New(driven, earlier) => (*driven, earlier),
        };
        let driven = match driven {
            Ok(driven) => driven,
            Err(error) => return self.miss(entry, &error),
        };
        driven
            .too_coarse()
            .iter()
            .for_each(|words| output::say(words));
        // Files first: who reads a line finds them. What cannot be written of one scenario does not end the others.
        let journal = self.journal;
        let written = journal.write(entry, earlier, || {
            let files = self.targets.write(entry, &driven)?;
            let drive = FinishedDrive {
                document: DriveRecord::new(&driven),
                unharmed: driven.unharmed(),
            };
            Ok((files, drive))
        });
        match written {
            Ok(drive) => self.count(&drive),
            Err(failure) if self.entries.len() == 1 => Err(failure),
            Err(failure) => {
                self.missed.input += 1;
                failure.say();
                Ok(())
            }
        }
    }

    /// Says why a scenario was not driven.
    fn miss(&mut self, entry: &Entry, error: &PlanError) -> Outcome {
        let is_finding = matches!(error, PlanError::NothingToPlan(_));
        if self.arguments.format.is_json() {
            self.line(&NotDrivenRecord::new(entry, error))?;
        }
        if self.entries.len() == 1 && !is_finding {
            return Err(Failure::input(error));
        }
        if is_finding {
            self.missed.finding += 1;
        } else {
            self.missed.input += 1;
        }
        output::say(&format!("nearmiss: {error}"));
        Ok(())
    }

    /// Counts and shows a drive.
    fn count(&mut self, drive: &FinishedDrive) -> Outcome {
        self.harmed += usize::from(!drive.unharmed);
        self.failed += usize::from(drive.document.outcome == "planner_error");
        self.report(&drive.document)
    }

    /// Shows a drive, whenever it was driven.
    fn report(&mut self, drive: &DriveRecord) -> Result<(), Failure> {
        if let Some(export) = &mut self.export {
            export.add(drive)?;
        }
        if self.arguments.format.is_json() {
            return self.line(drive);
        }
        if !std::mem::replace(&mut self.begun, true) {
            let header = self.table.header();
            self.show(&header)?;
        }
        let row = self.table.row(drive);
        self.show(&row)
    }

    /// Files are wanted even where the table is not.
    fn next_one(&self) -> ControlFlow<()> {
        if self.gone && !self.arguments.files.any() && self.export.is_none() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    fn line(&mut self, value: &impl Serialize) -> Result<(), Failure> {
        let line = output::json_line(value)?;
        self.show(&line)
    }

    /// Writes to standard output at once; where that is taken by the ego, to standard error.
    fn show(&mut self, text: &str) -> Result<(), Failure> {
        if self.arguments.files.to_stdout() {
            output::lines(text);
            return Ok(());
        }
        if self.gone {
            return Ok(());
        }
        let mut out = io::stdout().lock();
        match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => self.gone = true,
            Err(error) => return Err(Failure::system("standard output", &error)),
            Ok(()) => {}
        }
        Ok(())
    }

    /// The sum, and the exit status.
    fn end(mut self, done: Done) -> Outcome {
        let (missed, all) = (self.missed.input + self.missed.finding, self.entries.len());
        if !self.arguments.format.is_json() && done.count > 0 && (all > 1 || self.begun) {
            let sum = std::mem::replace(
                &mut self.table,
                OutcomeTable::new(Labels::default(), false, false),
            )
            .sum(missed);
            self.show(&sum)?;
        }
        if self.kept > 0 {
            output::say(&format!(
                "nearmiss: {} of an earlier run kept",
                output::counted(self.kept, "drive")
            ));
        }
        self.targets.finish()?;
        self.export
            .map_or(Ok(()), |export| export.finish(self.journal))?;
        done.end(if self.arguments.files.resumes() {
            "their files are kept; the same command continues"
        } else {
            "their files are kept"
        })?;
        let finding = |message| Err(Failure::finding(message));
        let harm = match self.failed {
            0 => "ended in a collision, off the road or infeasible",
            _ => "ended in a collision, off the road, infeasible or with an error of the planner",
        };
        match (self.harmed, missed) {
            (0, 0) => Ok(()),
            _ if self.missed.input == all => Err(Failure::input(format!(
                "none of the {all} scenarios could be planned"
            ))),
            (0, n) => finding(format!(
                "{n} of {} could not be planned",
                output::counted(all, "scenario")
            )),
            (n, 0) => finding(format!("{n} of {} {harm}", output::counted(all, "drive"))),
            (n, m) => finding(format!(
                "{n} of {} {harm}, and {} could not be planned",
                output::counted(all - m, "drive"),
                output::counted(m, "scenario")
            )),
        }
    }
}
