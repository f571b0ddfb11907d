//! `nearmiss plan`: drives the ego through scenarios with the planner, and reports the outcomes.

pub mod as_ego;
mod compare;
mod differences;
mod document;
mod driven;
mod export;
mod figures;
mod files;
mod monitor;
mod monitor_record;
mod monitor_table;
mod options;
mod places;
mod planners;
mod rules;
mod table;

use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::interrupt::{INTERRUPTED, interrupted};
use super::many_files::Progressed;
use super::open::{configuration, found};
use super::parallel::in_order;
use super::progress::Progress;
use super::row_file::Labels;
use super::set::{Assignment, assignment, settings};
use super::{Failure, Outcome, output};
pub use compare::ComparisonRecord;
pub use document::{
    CycleRecord, DriveRecord, NotDrivenRecord, PlannerFailure, StandardErrorRecord,
};
use driven::DrivenScenario;
use export::Export;
use files::{Files, Targets};
use monitor::MonitorOptions;
pub use monitor_record::MonitorDryRun;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Outcome as Ended;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::VehicleType;
use nearmiss_workflow::PlanError;
pub use options::{PlannerSettings, ProblemOption};
pub use planners::{PlannerOptions, identity};
use table::Table;

/// Arguments of `plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Outcomes: goal, collision (with the obstacle and the side of either body), timeout, off_road, infeasible, \
planner_error (the planner's process failed).\n\
Exit status: 0 all drives reach the goal or run out of time; 1 some end otherwise or could not be planned; \
2 usage or input error; 130 interrupted.")]
pub struct PlanArguments {
    /// Scenario files, folders or names of bundled scenarios.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    #[command(flatten)]
    how: ProblemOption,
    /// Change a setting of the planner, with the keys of [planner] in config.toml: prediction (recorded,
    /// constant-velocity, lane), traffic (recorded, reactive), rules (obey, off), replan (steps), horizon (seconds),
    /// vehicle (1 to 4) and others, and timeout (seconds a cycle) of a process. See `nearmiss help configuration`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = assignment::<PlannerSettings>)]
    set: Vec<Assignment>,
    #[command(flatten)]
    planners: PlannerOptions,
    #[command(flatten)]
    monitor: MonitorOptions,
    #[command(flatten)]
    format: output::FormatOption,
    /// Write a table with a row for each drive: outcome, kind of collision, comfort, time to the goal, near misses, time
    /// a cycle; .csv, .json, .jsonl or .parquet. With two planners each scenario has two rows.
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
    let set: PlannerSettings = settings(&arguments.set).map_err(Failure::input)?;
    let settings = set.over(&config)?;
    let entries = arguments.files.part_of(found(&arguments.paths)?);
    if entries.is_empty() {
        return Ok(());
    }
    let problem = arguments.how.planning_problem;
    let planners = arguments.planners.chosen(&config, set.timeout)?;
    if planners.len() > 1 {
        return compare::run(arguments, &entries, &planners, &settings);
    }
    let planner = planners.first();
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
    let said = match external {
        None => format!("{settings:?} {problem:?} {:?}", arguments.monitor),
        Some(planner) => format!(
            "{settings:?} {problem:?} {:?} {:?}",
            arguments.monitor,
            planner.options()
        ),
    };
    // Runs of versions that knew no other traffic can be resumed.
    let said = said
        .replace(", traffic: Recorded", "")
        .replace(", rules: Off", "");
    let named = options::named(&settings, problem, external.map(|planner| &**planner));
    let targets = arguments
        .files
        .begin(&arguments.paths, &entries, (&said, named))?;
    let finished = targets.finished();
    let cancel = Cancel::from_flag(&stop);
    if let (Some(finished), Some(external)) = (&finished, external) {
        let identity = || planners::identity(&entries, problem, &settings, external, &cancel);
        finished.by_same_planner(identity)?;
    }
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
    let mut job = Job {
        arguments,
        entries: &entries,
        targets,
        export: Export::begin(
            (arguments.table.as_deref(), arguments.spreadsheet),
            arguments.files.overwrites(),
            finished.clone(),
        )?,
        table: Table::new(Labels::new(&entries), monitor.is_some(), planner.is_some()),
        begun: false,
        gone: false,
        next: 0,
        kept: 0,
        harmed: 0,
        failed: 0,
        missed: Missing::default(),
    };
    let progress = Progress::new(entries.len(), "scenarios", true);
    let mut failure = None;
    in_order(
        entries.len(),
        &stop,
        |i| {
            let known = finished.as_ref().map(|finished| finished.of(&entries[i]));
            if let Some(notes) = known.as_ref().and_then(|known| known.finished.clone()) {
                return Some(Work::Kept(notes));
            }
            let driven = driven::drive(
                &entries[i],
                problem,
                &settings,
                planner,
                (monitor.as_ref(), arguments.files.keeps_log()),
                &cancel,
            )?;
            Some(Work::Driven(driven.map(Box::new), known))
        },
        |work| {
            // A drive that was cut short is none.
            let Some(work) = work else {
                return ControlFlow::Break(());
            };
            let mut taken = Ok(ControlFlow::Continue(()));
            progress.suspend(|| {
                taken = match work {
                    Work::Kept(notes) => job.keep(&notes),
                    Work::Driven(driven, known) => job.take(driven, known),
                };
            });
            progress.step();
            taken.unwrap_or_else(|error| {
                failure = Some(error);
                ControlFlow::Break(())
            })
        },
    );
    drop(progress);
    job.end(failure, stop.load(Ordering::Relaxed))
}

/// What a run notes of a drive for the run that continues it.
#[derive(Serialize, Deserialize)]
pub struct FinishedDrive {
    pub document: DriveRecord,
    /// Whether it ended at the goal or out of time.
    unharmed: bool,
}

/// What became of a scenario.
enum Work {
    /// An earlier run has driven it, with these notes.
    Kept(Value),
    /// It was driven, with what an earlier run has of it.
    Driven(Result<Box<DrivenScenario>, PlanError>, Option<Progressed>),
}

/// How many scenarios were not driven.
#[derive(Debug, Default)]
struct Missing {
    /// They cannot be read, or what was asked does not go with them.
    input: usize,
    /// There is nothing to drive in them.
    finding: usize,
}

/// The work so far.
struct Job<'a> {
    arguments: &'a PlanArguments,
    entries: &'a [Entry],
    targets: Targets<'a>,
    table: Table,
    /// The table in a file.
    export: Option<Export>,
    /// The table has a header.
    begun: bool,
    /// The reader of the table is gone.
    gone: bool,
    /// Place of the next scenario.
    next: usize,
    /// Scenarios that an earlier run has driven.
    kept: usize,
    harmed: usize,
    /// Drives that an error of the planner's process ended.
    failed: usize,
    missed: Missing,
}

impl Job<'_> {
    /// Counts the next scenario as an earlier run has left it.
    fn keep(&mut self, notes: &Value) -> Result<ControlFlow<()>, Failure> {
        self.next += 1;
        self.kept += 1;
        let drive = FinishedDrive::deserialize(notes).map_err(|why| {
            Failure::input(format!("the notes of an earlier run cannot be read: {why}"))
        })?;
        self.harmed += usize::from(!drive.unharmed);
        self.failed += usize::from(drive.document.outcome == "planner_error");
        self.report(&drive.document)?;
        Ok(self.next_one())
    }

    /// Shows and writes the next scenario.
    fn take(
        &mut self,
        driven: Result<Box<DrivenScenario>, PlanError>,
        known: Option<Progressed>,
    ) -> Result<ControlFlow<()>, Failure> {
        let entry = &self.entries[self.next];
        self.next += 1;
        let driven = match driven {
            Ok(driven) => driven,
            Err(error) => {
                let is_finding = matches!(error, PlanError::NothingToPlan(_));
                if self.arguments.format.is_json() {
                    self.line(&NotDrivenRecord::new(entry, &error))?;
                }
                if self.entries.len() == 1 && !is_finding {
                    return Err(Failure::input(error));
                }
                if is_finding {
                    self.missed.finding += 1
                } else {
                    self.missed.input += 1
                }
                output::say(&format!("nearmiss: {error}"));
                return Ok(self.next_one());
            }
        };
        self.harmed += usize::from(!driven.unharmed());
        self.failed += usize::from(matches!(driven.outcome(), Ended::PlannerError(_)));
        // Files first: who reads a line finds them. What cannot be written of one scenario does not end the others.
        if let Err(failure) = self.targets.write(entry, &driven, known) {
            if self.entries.len() == 1 {
                return Err(failure);
            }
            self.missed.input += 1;
            failure.say();
            return Ok(self.next_one());
        }
        self.report(&DriveRecord::new(&driven))?;
        Ok(self.next_one())
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
    fn end(mut self, failure: Option<Failure>, interrupted: bool) -> Outcome {
        let (missed, all) = (self.missed.input + self.missed.finding, self.entries.len());
        if !self.arguments.format.is_json() && self.next > 0 && (all > 1 || self.begun) {
            let sum =
                std::mem::replace(&mut self.table, Table::new(Labels::default(), false, false))
                    .sum(missed);
            self.show(&sum)?;
        }
        if self.kept > 0 {
            output::say(&format!(
                "nearmiss: {} of an earlier run kept",
                output::counted(self.kept, "drive")
            ));
        }
        let (done, harmed) = (self.next, self.harmed);
        self.targets.finish()?;
        self.export.map_or(Ok(()), Export::finish)?;
        if let Some(failure) = failure {
            return Err(failure);
        }
        if interrupted {
            return Err(Failure {
                message: format!(
                    "interrupted after {done} of {all} scenarios; their files are kept{}",
                    if self.arguments.files.resumes() {
                        "; the same command continues"
                    } else {
                        ""
                    }
                ),
                status: INTERRUPTED,
            });
        }
        let finding = |message| Err(Failure::finding(message));
        let harm = match self.failed {
            0 => "ended in a collision, off the road or infeasible",
            _ => "ended in a collision, off the road, infeasible or with an error of the planner",
        };
        match (harmed, missed) {
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
