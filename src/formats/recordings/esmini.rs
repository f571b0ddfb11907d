//! esmini's log (`--csv_logger`): a row a moment, with a group of columns an entity side by side.

use std::collections::BTreeMap;

use nearmiss_base::geometry::{Point, Pose};
use nearmiss_scene::scenario::plausibility::refused_time_step;

use super::Report;
use super::assembly::TrackState;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;

/// Lines in which the header of a log is.
const MOST_BEFORE: usize = 20;

/// The column of times.
const TIME: &str = "TimeStamp";

/// Before the names of the columns of the first entity.
const FIRST: &str = "#1 ";

/// Times that are no more before 0 are at 0, seconds.
const SAME_TIME: f64 = 1e-6;

/// Seconds between two steps, where the log tells none.
const STEP: f64 = 0.1;

/// Whether a file that begins so is a log.
pub fn is_log(head: &[u8]) -> bool {
    let head = String::from_utf8_lossy(head);
    let mut lines = head.lines().take(MOST_BEFORE);
    lines.any(|line| line.contains(TIME) && line.contains("#1 Entity_Name"))
}

/// A log.
#[derive(Debug)]
pub struct Log {
    /// What wrote it, with its version.
    pub player: String,
    /// The states of entities, by name, in the order of the log.
    pub entities: BTreeMap<String, Vec<LoggedState>>,
    /// Columns of an entity that are not used.
    pub unused: Vec<String>,
    /// Seconds between two moments.
    pub time_step: f64,
}

/// A state of an entity.
#[derive(Debug, Clone, Copy)]
pub struct LoggedState {
    /// Seconds.
    time: f64,
    /// From 1.
    line: usize,
    pose: Pose,
    /// m/s.
    speed: f64,
    /// The middle of its body, from its position, metres.
    center: Point,
    /// Length and width of its body, metres.
    pub size: (f64, f64),
}

/// The columns of an entity that are used.
const COLUMNS: [&str; 8] = [
    "World_Position_X",
    "World_Position_Y",
    "World_Heading_Angle",
    "Current_Speed",
    "bb_x",
    "bb_y",
    "bb_length",
    "bb_width",
];

/// The column of its name.
const NAME: &str = "Entity_Name";

impl Log {
    /// Leaves out ghosts, and what is before time 0, which is noted; `is_entity` tells which names are those of entities, where
    /// more is known of them than the log tells.
    pub fn bodies(mut self, is_entity: Option<&dyn Fn(&str) -> bool>, report: &Report) -> Self {
        let names: Vec<String> = self.entities.keys().cloned().collect();
        let in_log = |name: &str| names.iter().any(|known| known == name);
        let ghosts: Vec<&String> = names
            .iter()
            .filter(|name| match is_entity {
                Some(is_entity) => is_ghost(name, is_entity) && !is_entity(name),
                None => is_ghost(name, &in_log),
            })
            .collect();
        for ghost in &ghosts {
            self.entities.remove(*ghost);
        }
        report.note_count(ghosts.len(), |n| {
            let ghosts: Vec<&str> = ghosts.iter().map(|name| name.as_str()).collect();
            let names = ghosts.join(", ");
            format!("ghosts, which drive ahead of their entities in esmini and are no bodies, left out: {n} ({names})")
        });
        let mut early = 0;
        for states in self.entities.values_mut() {
            let before = states.len();
            states.retain(|s| s.time > -SAME_TIME);
            early += before - states.len();
        }
        report.note_count(early, |n| {
            format!("states before time 0, when only ghosts drive, left out: {n}")
        });
        self.entities.retain(|_, states| !states.is_empty());
        self.once(report);
        self.time_step = self.between();
        self
    }

    /// Puts the states of each entity in order of time and leaves out those at a time that it has already.
    fn once(&mut self, report: &Report) {
        let mut twice: Option<(usize, &str)> = None;
        let mut count = 0;
        for (name, states) in &mut self.entities {
            states.sort_by(|a, b| a.time.total_cmp(&b.time));
            states.dedup_by(|state, kept| {
                let is_same = state.time - kept.time < SAME_TIME;
                if is_same {
                    count += 1;
                    let first = (state.line, name.as_str());
                    twice = Some(twice.map_or(first, |known| known.min(first)));
                }
                is_same
            });
        }
        if let Some((line, name)) = twice {
            let at = report.row(line, format!("entity `{name}`"));
            at.warn(format!(
                "repeated times of an entity: {count}, this one first; the first state at each is used"
            ));
        }
    }

    /// The shortest time between two moments, seconds.
    fn between(&self) -> f64 {
        let mut times: Vec<f64> = self.entities.values().flatten().map(|s| s.time).collect();
        times.sort_by(f64::total_cmp);
        times.dedup_by(|a, b| (*a - *b).abs() < SAME_TIME);
        let between = times
            .windows(2)
            .map(|p| p[1] - p[0])
            .fold(f64::INFINITY, f64::min);
        match refused_time_step(between) {
            None => (between * 1e6).round() / 1e6,
            Some(_) => STEP,
        }
    }

    /// The states of an entity at the steps of the log.
    pub fn states(&self, of: &[LoggedState]) -> Vec<TrackState> {
        let at_steps = of.iter().map(|s| TrackState {
            step: (s.time / self.time_step).round() as i64,
            position: s.pose.to_world(&s.center),
            heading: s.pose.heading,
            velocity: Some(s.speed),
            acceleration: None,
        });
        let mut states: Vec<TrackState> = at_steps.collect();
        // Times that are no steps of the log.
        states.dedup_by_key(|s| s.step);
        states
    }
}

/// Whether this is the name of a ghost: esmini lets one drive ahead of an entity, for a controller to look at.
fn is_ghost(name: &str, is_entity: &dyn Fn(&str) -> bool) -> bool {
    name.strip_suffix("_ghost").is_some_and(is_entity)
}

/// What wrote a log, by the lines before its header.
fn player(before: &[&str]) -> String {
    let told = |key: &str| {
        let mut lines = before.iter();
        let after = lines.find_map(|line| line.trim().strip_prefix(key)?.strip_prefix(':'))?;
        let value = after.split(',').next().unwrap_or_default().trim();
        (!value.is_empty() && !value.starts_with("N/A")).then(|| value.to_string())
    };
    let version = told("esmini GIT TAG")
        .or_else(|| told("esmini BUILD VERSION"))
        .or_else(|| told("esmini GIT REV"))
        .or_else(|| told("Version"));
    match version {
        Some(version) => {
            let number = version.trim_start_matches("esmini").trim();
            format!("esmini {}", number.chars().take(60).collect::<String>())
        }
        None => "esmini (a build that tells no version)".into(),
    }
}

/// Reads a log.
///
/// # Errors
/// It is none, or a number is none: with line and column.
pub fn read(text: &str, report: &Report) -> Result<Log, ReadError> {
    let mut before = Vec::new();
    let mut lines = text.lines().enumerate();
    let header = lines.by_ref().find(|(_, line)| {
        let is_header = line.contains(TIME);
        if !is_header && before.len() < MOST_BEFORE {
            before.push(*line);
        }
        is_header
    });
    let header = header.ok_or_else(|| {
        report.fail("no line with `TimeStamp`; not a log of esmini (--csv_logger)")
    })?;
    let names: Vec<&str> = header.1.split(',').map(str::trim).collect();
    let own: Vec<&str> = names.iter().filter_map(|n| n.strip_prefix(FIRST)).collect();
    let column = |name: &str| {
        own.iter().position(|n| n.starts_with(name)).ok_or_else(|| {
            report
                .row(header.0 + 1, name)
                .fail("no such column; write the log with esmini --csv_logger")
        })
    };
    let place = column(NAME)?;
    let wanted: Vec<usize> = COLUMNS
        .iter()
        .map(|n| column(n))
        .collect::<Result<_, _>>()?;
    let is_used = |i: usize| i == place || wanted.contains(&i);
    let unused = own.iter().enumerate().filter(|(i, _)| !is_used(*i));
    let time = names.iter().position(|n| n.starts_with(TIME)).unwrap_or(1);
    let first = names.iter().position(|n| n.starts_with(FIRST)).unwrap_or(2);
    let mut log = Log {
        player: player(&before),
        entities: BTreeMap::new(),
        unused: unused
            .map(|(_, name)| name.split(['[', ' ']).next().unwrap_or(name).to_string())
            .collect(),
        time_step: STEP,
    };
    let (mut cut, mut first_cut) = (0, 0);
    let mut note_cut = |line: usize| {
        cut += 1;
        if first_cut == 0 {
            first_cut = line;
        }
    };
    for (i, line) in lines {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if cells.len() <= first {
            if !line.trim().is_empty() {
                note_cut(i + 1);
            }
            continue;
        }
        let number = |at: usize| -> Result<f64, ReadError> {
            let cell = cells.get(at).copied().unwrap_or_default();
            let value = cell.parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| {
                let shown: String = cell.chars().take(40).collect();
                report
                    .row(i + 1, names.get(at).copied().unwrap_or("column"))
                    .fail(format!("`{shown}` is not a number"))
            })
        };
        let now = number(time)?;
        let mut at = first;
        while at + own.len() <= cells.len() {
            let name = cells[at + place];
            let mut values = [0.0; 8];
            for (value, column) in values.iter_mut().zip(&wanted) {
                *value = number(at + column)?;
            }
            let [x, y, heading, speed, bx, by, length, width] = values;
            let row = report.row(i + 1, name);
            let state = LoggedState {
                time: now,
                line: i + 1,
                pose: Pose {
                    position: row.point(x, y)?,
                    heading,
                },
                speed,
                center: Point::new(bx, by),
                size: (length, width),
            };
            match log.entities.get_mut(name) {
                Some(states) => states.push(state),
                None => {
                    log.entities.insert(name.to_string(), vec![state]);
                }
            }
            at += own.len();
            // Entities end with an empty cell.
            while cells.get(at).is_some_and(|c| c.is_empty()) {
                at += 1;
            }
        }
        if cells.iter().skip(at).any(|cell| !cell.is_empty()) {
            note_cut(i + 1);
        }
    }
    if cut > 0 {
        let at = report.row(first_cut, "");
        at.warn(format!(
            "lines cut off: {cut}, this one first; the entity that is cut is left out"
        ));
    }
    Ok(log)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use nearmiss_scene::scenario::Severity;

    #[test]
    fn bodies_are_where_their_middles_are_without_ghosts_and_times_before_0() {
        let mut text = String::from(
            "x\nIndex [-], TimeStamp [s], #1 Entity_Name [-], #1 Current_Speed [m/s], #1 bb_x [m], #1 bb_y [m], #1 bb_length [m], #1 bb_width [m], #1 World_Position_X [m], #1 World_Position_Y [m], #1 World_Heading_Angle [rad], #1 lane_id, \n",
        );
        for time in ["-0.05", "0.0", "0.05", "0.10"] {
            let of = |name: &str| {
                format!("{name}, 3.0, 1.5, 0.0, 5.0, 2.0, 7.0, 1.0, 1.5707963267948966, -1, ")
            };
            text += &format!("0, {time}, {}, {}\n", of("car"), of("car_ghost"));
        }
        assert!(is_log(text.as_bytes()));
        let report = Report::about("x.csv");
        let log = read(&text, &report).unwrap().bodies(None, &report);
        assert_eq!((log.entities.len(), log.time_step), (1, 0.05));
        assert_eq!(log.unused, ["lane_id"]);
        let car = &log.entities["car"];
        let states = log.states(car);
        assert_eq!((states.len(), states[2].step), (3, 2));
        assert!((states[0].position - Point::new(7.0, 2.5)).norm() < 1e-9);
        assert_eq!((car[0].size, states[0].velocity), ((5.0, 2.0), Some(3.0)));
        // A line twice, one that ends within an entity, and one before it.
        let last = text.lines().next_back().unwrap().to_string();
        let odd = format!("{text}{last}\n0, 0.15, car, 3.0, 1.5\n0, 0.2\n\n");
        let report = Report::about("odd.csv");
        let log = read(&odd, &report).unwrap().bodies(None, &report);
        assert_eq!(log.states(&log.entities["car"]).len(), 3);
        let said = report.into_diagnostics().into_iter();
        let said: Vec<(usize, String)> = said
            .filter(|d| d.severity == Severity::Warning)
            .map(|d| (d.line, d.message))
            .collect();
        let lines: Vec<usize> = said.iter().map(|said| said.0).collect();
        assert_eq!(lines, [8, 7], "{said:?}");
        assert!(said[0].1.starts_with("lines cut off: 2,"), "{said:?}");
        // Doubles of ghosts are left out with them.
        let twice = "repeated times of an entity: 1,";
        assert!(said[1].1.starts_with(twice), "{said:?}");
        let report = Report::about("x.csv");
        let bad = read(&text.replace("7.0", "seven"), &report).unwrap_err();
        assert_eq!(
            (bad.line, bad.message.as_str()),
            (3, "`seven` is not a number")
        );
    }

    #[test]
    fn the_player_is_called_by_the_best_that_its_log_tells() {
        let of = |lines: &[&str]| player(lines);
        let build = "esmini BUILD VERSION: 2.40.0-0-abc";
        assert_eq!(of(&["esmini GIT TAG: v3.6.0", build]), "esmini v3.6.0");
        assert_eq!(of(&["esmini GIT TAG: N/A", build]), "esmini 2.40.0-0-abc");
        assert_eq!(of(&["Version: esmini 2.1"]), "esmini 2.1");
        assert!(of(&["esmini GIT REV: N/A"]).contains("no version"));
    }
}
