//! The table of outcomes: one line a scenario, printed as it finishes, and a summary.
//!
//! It reads the drives as `plan --format json` prints them, so those that an earlier run has finished are shown like new ones.

use serde_json::Value;

use super::driven::median;
use super::monitor_table as monitor;
use super::rules::{self, RuleCounts};
use crate::output::Align::{Left, Right};
use crate::output::{counted, line, visible};
use crate::row_file::Labels;
use nearmiss_drive::simulation::{CollisionKind, ContactSide, HitFromBehind};

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
const HEADER: [&str; 7] = [
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
pub struct Table {
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
    /// Collisions in which the ego was rear-ended.
    rear_ended: usize,
    /// Milliseconds of every scenario's middle cycle beside the planner's own.
    overhead: Vec<f64>,
    /// The planner's process, as it names itself, and what it was told.
    told: Option<String>,
}

impl Table {
    /// A table of scenarios that are called so.
    pub fn new(labels: Labels, monitored: bool, compared: bool) -> Self {
        Self {
            width: labels.longest().clamp("scenario".len(), WIDEST),
            labels,
            counts: [0; OUTCOMES.len()],
            by_front: 0,
            unaware: 0,
            reacted: 0,
            undrivable: 0,
            rules: RuleCounts::default(),
            ms: Vec::new(),
            monitored,
            monitor: monitor::Totals::default(),
            compared,
            rear_ended: 0,
            overhead: Vec::new(),
            told: None,
        }
    }

    pub fn header(&self) -> String {
        let monitor: &[&str] = if self.monitored {
            &monitor::HEADER
        } else {
            &[]
        };
        let figures: &[&str] = if self.compared { &FIGURES } else { &[] };
        self.line("scenario", &HEADER, &[monitor, figures].concat())
    }

    /// Counts a drive, and shows it as a line.
    pub fn row(&mut self, drive: &Value) -> String {
        let text = |key: &str| drive[key].as_str().unwrap_or_default();
        let count = |key: &str| drive[key].as_u64().unwrap_or(0);
        let name = text("outcome");
        if let Some(place) = OUTCOMES.iter().position(|outcome| *outcome == name) {
            self.counts[place] += 1;
        }
        let ms = drive["median_cycle_ms"].as_f64();
        self.ms.extend(ms);
        let (mut with, mut sides) = ("-".into(), "-".into());
        if let Some(id) = drive["collision_with"].as_i64() {
            let (own, other) = (text("ego_side"), text("other_side"));
            let kind = text("collision_kind");
            self.by_front += usize::from(own == ContactSide::Front.name());
            self.rear_ended += usize::from(kind == CollisionKind::RearEnded.name());
            with = id.to_string();
            sides = format!("ego's {own}, other's {other}");
        }
        let mut last = match (count("emergency_cycles"), count("braking_cycles")) {
            (0, _) => "-".into(),
            (n, 0) => n.to_string(),
            (n, braking) => format!("{n} ({braking} braking)"),
        };
        let mut remarks = Vec::new();
        if let Some(hit) = drive["hit_from_behind"].as_str() {
            self.unaware += usize::from(hit == HitFromBehind::Unaware.name());
            remarks.push(format!("hit from behind, {hit}"));
        }
        let reacted = count("reacted") as usize;
        if reacted > 0 {
            self.reacted += reacted;
            remarks.push(format!("{reacted} reacted"));
        }
        self.rules.add(drive);
        self.monitor.add(&drive["monitor"]);
        remarks.extend(rules::words(drive));
        let beyond = beyond_vehicle(&drive["external_planner"]);
        self.undrivable += usize::from(beyond.is_some());
        remarks.extend(beyond);
        remarks.extend(drive["note"].as_str().map(str::to_string));
        for remark in remarks {
            last.push_str(&format!("  ({remark})"));
        }
        let cells = [
            name,
            &with,
            &sides,
            &count("steps").to_string(),
            &count("cycles").to_string(),
            &number(&drive["median_cycle_ms"]),
            &last,
        ];
        let overhead = drive["external_planner"]["median_overhead_ms"].as_f64();
        self.overhead.extend(overhead);
        self.told = self.told.take().or_else(|| told_of(drive));
        let monitor = drive["monitor"].is_object().then_some(&drive["monitor"]);
        let monitored = monitor.filter(|_| self.monitored).map(monitor::cells);
        let figures = self.compared.then(|| figures(drive));
        let more = monitored.iter().flatten().chain(figures.iter().flatten());
        let more: Vec<&str> = more.map(String::as_str).collect();
        let label = self.labels.of(text("scenario"), text("file"));
        self.line(&label, &cells, &more)
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
        let told = self.told.map_or(String::new(), |told| {
            let overhead =
                median(&self.overhead).map_or(String::new(), |ms| format!("; overhead {ms:.2} ms"));
            format!("planner {told}{overhead}\n")
        });
        let rules = self.rules.line().unwrap_or_default();
        let beyond = match self.undrivable {
            0 => String::new(),
            n => format!(
                "drives with steps beyond the vehicle: {n}; their comfort comes from the speeds that the planner says\n"
            ),
        };
        let parts = parts.join(", ");
        let monitor = self.monitor.line().unwrap_or_default();
        format!("{all} {scenarios}: {parts}{ms}\n{monitor}{rules}{beyond}{told}")
    }
}

/// A number with one decimal.
fn number(value: &Value) -> String {
    { value.as_f64() }.map_or("-".into(), |value| format!("{value:.1}"))
}

/// The figures of a drive.
fn figures(drive: &Value) -> [String; 4] {
    [
        number(&drive["largest_deceleration"]),
        number(&drive["mean_jerk"]),
        number(&drive["seconds_to_goal"]),
        { drive["near_misses"].as_u64() }.map_or("-".into(), |n| n.to_string()),
    ]
}

/// What of a drive the vehicle cannot do; nothing where it can do all.
pub fn beyond_vehicle(planner: &Value) -> Option<String> {
    let steps = planner["undrivable"].as_u64().filter(|n| *n > 0)? as usize;
    let first = planner["first_undrivable_step"].as_i64()?;
    let worst = &planner["worst_undrivable"];
    let counted = counted(steps, "step");
    let begins = format!("{counted} beyond the vehicle, first: step {first}");
    Some(match (worst["bound"].as_str(), worst["value"].as_f64()) {
        (Some(bound), Some(value)) => format!(
            "{begins}, worst: {bound} {value:.2} {} at step {}, at most {:.2}",
            worst["unit"].as_str().unwrap_or_default(),
            worst["step"],
            worst["limit"].as_f64().unwrap_or_default()
        ),
        // Of earlier versions.
        _ => begins,
    })
}

/// A planner's process and what it was told; nothing where it never got ready.
pub fn told_of(drive: &Value) -> Option<String> {
    let report = &drive["external_planner"];
    let text = |key: &str| report[key].as_str().unwrap_or_default();
    let name = Some(text("name")).filter(|name| !name.is_empty())?;
    let version = match text("version") {
        "" => String::new(),
        version => format!(" {version}"),
    };
    let predictions = match text("predictions") {
        "" => "no predictions".into(),
        from => format!("prediction {from}"),
    };
    let told = format!(
        "{name}{version}: {} time, {predictions}, {} earlier states",
        text("clock"),
        report["history"].as_u64().unwrap_or(0)
    );
    Some(visible(&told))
}
