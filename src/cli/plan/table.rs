//! The table of outcomes: one line a scenario, printed as it finishes, and a summary.

use super::driven::{DrivenScenario, median};
use super::monitor;
use super::rules::{self, RuleCounts};
use crate::cli::output::Align::{Left, Right};
use crate::cli::output::{counted, line, visible};
use crate::planner::Emergency;
use crate::simulation::{CollisionKind, ContactSide, ExternalReport, HitFromBehind};

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
const FIGURES: [&str; 4] = ["brake", "jerk", "goal s", "near miss"];

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
    width: usize,
    counts: [usize; OUTCOMES.len()],
    /// Collisions in which the ego's front is the side that is touched.
    by_front: usize,
    /// Collisions in which traffic that knew nothing of the ego drove into its rear.
    unaware: usize,
    /// Obstacles that reacted.
    reacted: usize,
    /// Rules that were broken.
    rules: RuleCounts,
    /// Milliseconds of every scenario's middle cycle.
    ms: Vec<f64>,
    /// Whether it has the columns of a monitor.
    monitored: bool,
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
    /// A table of scenarios with names at most `longest` characters long.
    pub fn new(longest: usize, monitored: bool, compared: bool) -> Self {
        Self {
            width: longest.clamp("scenario".len(), WIDEST),
            counts: [0; OUTCOMES.len()],
            by_front: 0,
            unaware: 0,
            reacted: 0,
            rules: RuleCounts::default(),
            ms: Vec::new(),
            monitored,
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
    pub fn row(&mut self, driven: &DrivenScenario) -> String {
        let name = driven.outcome().name();
        if let Some(place) = OUTCOMES.iter().position(|outcome| *outcome == name) {
            self.counts[place] += 1;
        }
        let ms = driven.milliseconds().map(|(median, _)| median);
        self.ms.extend(ms);
        let (mut with, mut sides) = ("-".into(), "-".into());
        if let Some(c) = driven.collision() {
            self.by_front += usize::from(c.ego == ContactSide::Front);
            self.rear_ended += usize::from(c.kind() == CollisionKind::RearEnded);
            with = c.with.to_string();
            sides = format!("ego's {}, other's {}", c.ego.name(), c.other.name());
        }
        let braking = driven
            .emergencies()
            .filter(|e| *e == Emergency::Braking)
            .count();
        let emergencies = driven.emergencies().count();
        let mut emergency = match emergencies {
            0 => "-".into(),
            n if braking == 0 => n.to_string(),
            n => format!("{n} ({braking} braking)"),
        };
        let reacted = driven.drive.traffic.reactions.len();
        if let Some(hit) = driven.drive.hit_from_behind() {
            self.unaware += usize::from(hit == HitFromBehind::Unaware);
            emergency.push_str(&format!("  (hit from behind, {})", hit.name()));
        }
        if reacted > 0 {
            self.reacted += reacted;
            emergency.push_str(&format!("  ({reacted} reacted)"));
        }
        self.rules.add(driven);
        if let Some(broken) = rules::words(driven) {
            emergency.push_str(&format!("  ({broken})"));
        }
        if let Some(note) = driven.note() {
            emergency.push_str(&format!("  ({note})"));
        }
        let cells = [
            name,
            &with,
            &sides,
            &driven.steps().to_string(),
            &driven.drive.cycles.len().to_string(),
            &ms.map_or("-".into(), |ms| format!("{ms:.1}")),
            &emergency,
        ];
        self.overhead.extend(driven.overhead());
        self.told = self.told.take().or_else(|| told_of(driven));
        let monitored = driven.monitor.as_ref().map(monitor::cells);
        let figures = self.compared.then(|| figures(driven));
        let more = monitored.iter().flatten().chain(figures.iter().flatten());
        let more: Vec<&str> = more.map(String::as_str).collect();
        self.line(&driven.name, &cells, &more)
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
        columns.extend(more.iter().map(|_| Right(9)));
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
            let overhead = median(&self.overhead);
            let overhead = overhead.map_or(String::new(), |ms| format!("; overhead {ms:.2} ms"));
            format!("planner {told}{overhead}\n")
        });
        let rules = self.rules.line().unwrap_or_default();
        format!("{all} {scenarios}: {}{ms}\n{rules}{told}", parts.join(", "))
    }
}

/// The figures of a drive.
fn figures(driven: &DrivenScenario) -> [String; 4] {
    let drive = &driven.drive;
    let number = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.1}"));
    [
        format!("{:.1}", drive.largest_deceleration()),
        number(drive.jerk().map(|(mean, _)| mean)),
        number(drive.seconds_to_goal()),
        driven.near_misses.map_or("-".into(), |n| n.to_string()),
    ]
}

/// A planner's process and what it was told; nothing where it never got ready.
pub fn told_of(driven: &DrivenScenario) -> Option<String> {
    let report = driven.drive.external.as_ref();
    let report: &ExternalReport = report.filter(|report| !report.name.is_empty())?;
    let version = match report.version.as_str() {
        "" => String::new(),
        version => format!(" {version}"),
    };
    let predictions = match report.predictions {
        true => format!("prediction {}", driven.settings.forecast.name()),
        false => "no predictions".into(),
    };
    let told = format!(
        "{}{version}: {} time, {predictions}, {} earlier states",
        report.name,
        report.clock.name(),
        report.history
    );
    Some(visible(&told))
}
