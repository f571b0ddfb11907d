//! The table of outcomes: one line a scenario, printed as it finishes, and a summary.

use super::driven::{DrivenScenario, median};
use super::monitor;
use crate::cli::output::Align::{Left, Right};
use crate::cli::output::line;
use crate::planner::Emergency;
use crate::simulation::{ContactSide, HitFromBehind};

/// The outcomes, in the order in which they are listed.
const OUTCOMES: [&str; 5] = ["goal", "collision", "timeout", "off_road", "infeasible"];

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
    /// Milliseconds of every scenario's middle cycle.
    ms: Vec<f64>,
    /// Whether it has the columns of a monitor.
    monitored: bool,
}

impl Table {
    /// A table of scenarios with names at most `longest` characters long.
    pub fn new(longest: usize, monitored: bool) -> Self {
        Self {
            width: longest.clamp("scenario".len(), WIDEST),
            counts: [0; OUTCOMES.len()],
            by_front: 0,
            unaware: 0,
            reacted: 0,
            ms: Vec::new(),
            monitored,
        }
    }

    pub fn header(&self) -> String {
        let more: &[&str] = if self.monitored {
            &monitor::HEADER
        } else {
            &[]
        };
        self.line("scenario", &HEADER, more)
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
        let more = driven.monitor.as_ref().map(monitor::cells);
        let more: Vec<&str> = more.iter().flatten().map(String::as_str).collect();
        self.line(&driven.name, &cells, &more)
    }

    /// The columns of a monitor stand before the last one, which may be long.
    fn line(&self, scenario: &str, cells: &[&str; 7], more: &[&str]) -> String {
        let mut columns = vec![
            Left(self.width),
            Left(10),
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
            parts.push(format!("{} obstacles reacted", self.reacted));
        }
        self.ms.sort_by(f64::total_cmp);
        let ms = median(&self.ms).map_or(String::new(), |ms| format!("; median cycle {ms:.1} ms"));
        let all = driven + missed;
        let scenarios = if all == 1 { "scenario" } else { "scenarios" };
        format!("{all} {scenarios}: {}{ms}\n", parts.join(", "))
    }
}
