//! The table of outcomes: one line a scenario, printed as it finishes, and a summary; as a file with `--table`.
//!
//! It reads records, so drives that an earlier run has finished are shown like new ones.

use std::path::{Path, PathBuf};

use nearmiss_drive::simulation::{CollisionKind, ContactSide, HitFromBehind};
use nearmiss_scene::traffic_rules::Rule;
use nearmiss_workflow::drive::{DriveRecord, median};

use super::driven::{self, RuleCounts};
use super::monitor;
use crate::files::Labels;
use crate::many_files::RunJournal;
use crate::output::Align::{Left, Right};
use crate::output::{
    self, Cell, Column, ForSpreadsheet, Format, Kind, Row, Table, TableFormat, TableWriter, Target,
    counted, line,
};
use crate::{Failure, Outcome};

/// The outcomes, in the order in which they are listed.
pub const OUTCOMES: [&str; 6] = [
    "goal",
    "collision",
    "timeout",
    "off_road",
    "infeasible",
    "planner_error",
];

/// The columns that drives have where a planner is named.
const FIGURES: [&str; 4] = ["brake m/s²", "jerk m/s³", "goal s", "near miss"];

/// What the columns behind the scenario's name are called.
const TITLES: [&str; 7] = [
    "outcome",
    "with",
    "sides",
    "steps",
    "cycles",
    "ms/cycle",
    "emergency",
];

/// Longer names push the columns behind them.
const WIDEST: usize = 48;

/// The table in the making.
#[derive(Default)]
pub struct OutcomeTable {
    /// Columns of the scenarios' names.
    labels: Labels,
    width: usize,
    counts: [usize; OUTCOMES.len()],
    /// Collisions in which the ego's front is the side that is touched.
    by_front: usize,
    /// Collisions in which traffic that knew nothing of the ego drove into its rear.
    unaware: usize,
    /// Obstacles that reacted.
    reacted: usize,
    /// Drives with steps that the vehicle cannot do.
    undrivable: usize,
    /// Rules that were broken.
    rules: RuleCounts,
    /// Milliseconds of every scenario's middle cycle.
    ms: Vec<f64>,
    /// Whether it has the columns of a monitor.
    monitored: bool,
    /// What monitors said of all drives.
    monitor: monitor::Totals,
    /// Whether it has the figures of drives.
    compared: bool,
    /// Serious injuries that are expected of collisions, and collisions that no injury curve tells.
    serious: f64,
    untold: usize,
    /// Collisions in which the ego was rear-ended.
    rear_ended: usize,
    /// Milliseconds of every scenario's middle cycle beside the planner's own.
    overhead: Vec<f64>,
    /// The planner's process, as it names itself, and what it was told.
    planner: Option<String>,
}

impl OutcomeTable {
    /// A table of scenarios that are called so.
    pub fn new(labels: Labels, monitored: bool, compared: bool) -> Self {
        Self {
            width: labels.longest().clamp("scenario".len(), WIDEST),
            labels,
            monitored,
            compared,
            ..Self::default()
        }
    }

    pub fn header(&self) -> String {
        let monitor: &[&str] = if self.monitored {
            &monitor::HEADER
        } else {
            &[]
        };
        let figures: &[&str] = if self.compared { &FIGURES } else { &[] };
        self.line("scenario", &TITLES, &[monitor, figures].concat())
    }

    /// Counts a drive, and shows it as a line.
    pub fn row(&mut self, drive: &DriveRecord) -> String {
        let outcome = drive.outcome.as_str();
        if let Some(place) = OUTCOMES.iter().position(|known| *known == outcome) {
            self.counts[place] += 1;
        }
        self.ms.extend(drive.median_cycle_ms);
        let (mut with, mut sides) = ("-".into(), "-".into());
        if let (Some(id), Some(own), Some(other)) =
            (drive.collision_with, &drive.ego_side, &drive.other_side)
        {
            let kind = drive.collision_kind.as_deref();
            self.by_front += usize::from(own == ContactSide::Front.name());
            self.rear_ended += usize::from(kind == Some(CollisionKind::RearEnded.name()));
            with = id.to_string();
            sides = format!("ego's {own}, other's {other}");
        }
        let mut last = match (drive.emergency_cycles, drive.braking_cycles) {
            (0, _) => "-".into(),
            (n, 0) => n.to_string(),
            (n, braking) => format!("{n} ({braking} braking)"),
        };
        for remark in self.remarks(drive) {
            last.push_str(&format!("  ({remark})"));
        }
        let cells = [
            outcome,
            &with,
            &sides,
            &drive.steps.to_string(),
            &drive.cycles.to_string(),
            &number(drive.median_cycle_ms),
            &last,
        ];
        let process = drive.external_planner.as_ref();
        self.overhead
            .extend(process.and_then(|process| process.median_overhead_ms));
        self.planner = self.planner.take().or_else(|| drive.planner_summary());
        let monitor = drive.monitor.as_ref();
        monitor
            .into_iter()
            .for_each(|report| self.monitor.add(report));
        let monitored = monitor.filter(|_| self.monitored).map(monitor::cells);
        let figures = self.compared.then(|| figures(drive));
        let more = monitored.iter().flatten().chain(figures.iter().flatten());
        let more: Vec<&str> = more.map(String::as_str).collect();
        let label = self.labels.of(&drive.scenario, &drive.file);
        self.line(&label, &cells, &more)
    }

    /// Counts what is to be noted of a drive, and says it.
    fn remarks(&mut self, drive: &DriveRecord) -> Vec<String> {
        let mut remarks = Vec::new();
        if let Some(impact) = &drive.impact {
            remarks.push(impact.to_string());
        }
        if drive.collision_with.is_some() {
            match drive.impact.and_then(|impact| impact.p_serious) {
                Some(risk) => self.serious += risk,
                None => self.untold += 1,
            }
        }
        if let Some(hit) = &drive.hit_from_behind {
            self.unaware += usize::from(hit == HitFromBehind::Unaware.name());
            remarks.push(format!("hit from behind, {hit}"));
        }
        if drive.reacted > 0 {
            self.reacted += drive.reacted;
            remarks.push(format!("{} reacted", drive.reacted));
        }
        self.rules.add(drive);
        remarks.extend(driven::broken_rules_note(drive));
        self.undrivable += usize::from(drive.beyond_vehicle.is_some());
        remarks.extend(drive.beyond_vehicle.as_ref().map(ToString::to_string));
        remarks.extend(drive.note.clone());
        remarks
    }

    /// The columns of a monitor stand before the last one, which may be long.
    fn line(&self, scenario: &str, cells: &[&str; 7], more: &[&str]) -> String {
        let mut columns = vec![
            Left(self.width),
            Left(if self.compared { 13 } else { 10 }),
            Right(8),
            Left(26),
            Right(5),
            Right(6),
            Right(8),
        ];
        columns.extend(more.iter().map(|_| Right(10)));
        let (last, first) = (&cells[6..], &cells[..6]);
        let all: Vec<&str> = [&[scenario], first, more, last].concat();
        line("  ", &columns, &all)
    }

    /// How many ended how, on one line; `missed` were not driven.
    pub fn sum(mut self, missed: usize) -> String {
        let driven: usize = self.counts.iter().sum();
        let mut parts = Vec::new();
        for (outcome, count) in OUTCOMES.iter().zip(self.counts) {
            match (count, *outcome) {
                (0, _) => {}
                (n, "collision") if self.compared => parts.push(format!(
                    "{n} collision ({} ran into another, {} rear-ended, {} side)",
                    self.by_front,
                    self.rear_ended,
                    n - self.by_front - self.rear_ended
                )),
                (n, "collision") => {
                    let unaware = match self.unaware {
                        0 => String::new(),
                        n => format!(", {n} hit from behind by unaware traffic"),
                    };
                    parts.push(format!(
                        "{n} collision ({} with the ego's front{unaware})",
                        self.by_front
                    ));
                }
                (n, outcome) => parts.push(format!("{n} {outcome}")),
            }
        }
        if missed > 0 {
            parts.push(format!("{missed} not planned"));
        }
        if self.reacted > 0 {
            let reacted = counted(self.reacted, "obstacle");
            parts.push(format!("{reacted} reacted"));
        }
        self.ms.sort_by(f64::total_cmp);
        let ms = median(&self.ms).map_or(String::new(), |ms| format!("; median cycle {ms:.1} ms"));
        let all = driven + missed;
        let scenarios = if all == 1 { "scenario" } else { "scenarios" };
        self.overhead.sort_by(f64::total_cmp);
        let planner = self.planner.map_or(String::new(), |planner| {
            let overhead =
                median(&self.overhead).map_or(String::new(), |ms| format!("; overhead {ms:.2} ms"));
            format!("planner {planner}{overhead}\n")
        });
        let rules = self.rules.line().unwrap_or_default();
        let beyond = match self.undrivable {
            0 => String::new(),
            n => format!(
                "drives with steps beyond the vehicle: {n}; their comfort comes from the speeds that the planner says\n"
            ),
        };
        let parts = parts.join(", ");
        let harm = match (self.counts[1], self.untold) {
            (0, _) => String::new(),
            (all, untold) if all == untold => "serious injuries expected: no curve tells\n".into(),
            (_, untold) => {
                let without = match untold {
                    0 => String::new(),
                    n => format!("; {} without an injury curve", counted(n, "collision")),
                };
                format!("serious injuries expected: {:.3}{without}\n", self.serious)
            }
        };
        let monitor = self.monitor.line().unwrap_or_default();
        format!("{all} {scenarios}: {parts}{ms}\n{harm}{monitor}{rules}{beyond}{planner}")
    }
}

/// A number with one decimal.
fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.1}"))
}

/// The figures of a drive.
fn figures(drive: &DriveRecord) -> [String; 4] {
    [
        number(Some(drive.largest_deceleration)),
        number(drive.mean_jerk),
        number(drive.seconds_to_goal),
        { drive.near_misses }.map_or("-".into(), |n| n.to_string()),
    ]
}

/// The columns of drives, and behind them one for each rule with what became of it.
fn columns() -> Vec<Column> {
    let rules = Rule::ALL.iter().map(|rule| Column {
        name: format!("rule_{}", rule.name()).into(),
        ..Column::new("", Kind::Text, "", "what became of the traffic rule").optional()
    });
    nearmiss_record::columns::<DriveRecord>()
        .into_iter()
        .chain(rules)
        .collect()
}

/// The table in the making; none where none is asked for.
pub struct Export {
    file: PathBuf,
    format: Format,
    spreadsheet: ForSpreadsheet,
    target: Target,
    rows: Vec<Row>,
}

impl Export {
    /// Begins a table in this file.
    ///
    /// # Errors
    /// Its ending is unknown, or it cannot be written, or it exists and is not that of the run that is continued.
    pub fn begin(
        (file, spreadsheet): (Option<&Path>, ForSpreadsheet),
        overwrite: bool,
        run: &RunJournal,
    ) -> Result<Option<Self>, Failure> {
        let Some(file) = file else {
            spreadsheet.check(false)?;
            return Ok(None);
        };
        let format = output::format_of_name(file, TableFormat::ENDINGS).ok_or_else(|| {
            Failure::input(format!(
                "--table {}: unknown file extension; known are {}",
                file.display(),
                TableFormat::KNOWN
            ))
        })?;
        let format = Format::from(format);
        spreadsheet.check(format == Format::Csv)?;
        let run_folder = run.folder().filter(|_| !overwrite && file.exists());
        if let Some(folder) = run_folder.filter(|_| !run.wrote_table(file)) {
            return Err(Failure::input(format!(
                "--table {}: exists, and is not the table of the run in {} or was changed since; name another file, or replace it with --overwrite",
                file.display(),
                folder.display()
            )));
        }
        Ok(Some(Self {
            file: file.to_path_buf(),
            format,
            spreadsheet,
            target: Target::begin(Some(file), overwrite || run_folder.is_some())?,
            rows: Vec::new(),
        }))
    }

    /// Adds a drive.
    ///
    /// # Errors
    /// Never in practice: a record has a row.
    pub fn add(&mut self, drive: &DriveRecord) -> Outcome {
        let mut row = nearmiss_record::row(drive).map_err(Failure::input)?;
        row.extend(Rule::ALL.iter().map(|rule| {
            let found = drive.rules.iter().find(|one| one.rule == rule.name());
            found.map_or(Cell::None(""), |one| one.status.clone().into())
        }));
        self.rows.push(row);
        Ok(())
    }

    /// Writes the table of a run.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(self, run: &RunJournal) -> Outcome {
        let mut table = Table::new("drives", columns());
        table.for_spreadsheet = self.spreadsheet.is_asked();
        let rows = table.encode(self.format, self.rows);
        let written =
            TableWriter::begin(self.target, self.format, &table).and_then(|mut writer| {
                writer.write(rows)?;
                writer.finish()
            });
        match output::written(Some(&self.file), written)? {
            Some(target) => target.finish()?,
            None => return Ok(()),
        }
        run.note_table(&self.file)
    }
}
