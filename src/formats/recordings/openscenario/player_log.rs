//! What a player has recorded of a scenario, and how entities move by it where the file leaves something open.

use std::collections::BTreeMap;
use std::path::Path;

use nearmiss_base::geometry::{Point, Pose};
use nearmiss_base::system;

use super::NO_ROADS;
use super::entities::Entity;
use super::motion::Motions;
use super::storyboard::{AllMotions, motions};
use super::tracks::{Course, Named, Timeline, recorded};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::Ids;
use crate::recordings::opendrive::Network;
use crate::recordings::opendrive::tree::Node;
use crate::recordings::report::Report;

/// A state of an entity.
#[derive(Debug, Clone, Copy)]
pub struct RecordedState {
    /// Seconds.
    pub time: f64,
    pub pose: Pose,
    /// m/s.
    pub speed: f64,
    /// The middle of its body, from its position, and its length and width, metres.
    pub body: (Point, f64, f64),
}

/// Reads a log; entities by name.
pub fn read(
    text: &str,
    report: &Report,
) -> Result<BTreeMap<String, Vec<RecordedState>>, ReadError> {
    let mut lines = text.lines().enumerate();
    let header = lines
        .by_ref()
        .find(|(_, line)| line.contains("TimeStamp"))
        .ok_or_else(|| {
            report.fail("no line with `TimeStamp`; not a log of esmini (--csv_logger)")
        })?;
    let names: Vec<&str> = header.1.split(',').map(str::trim).collect();
    let own: Vec<&str> = names.iter().filter_map(|n| n.strip_prefix("#1 ")).collect();
    let column = |name: &str| {
        own.iter().position(|n| n.starts_with(name)).ok_or_else(|| {
            report
                .row(header.0 + 1, name)
                .fail("no such column; write the log with esmini --csv_logger")
        })
    };
    let place = column("Entity_Name")?;
    let wanted = [
        "World_Position_X",
        "World_Position_Y",
        "World_Heading_Angle",
        "Current_Speed",
        "bb_x",
        "bb_y",
        "bb_length",
        "bb_width",
    ];
    let wanted: Vec<usize> = wanted.iter().map(|n| column(n)).collect::<Result<_, _>>()?;
    let time = names
        .iter()
        .position(|n| n.starts_with("TimeStamp"))
        .unwrap_or(1);
    let first = names.iter().position(|n| n.starts_with("#1 ")).unwrap_or(2);
    let mut all: BTreeMap<String, Vec<RecordedState>> = BTreeMap::new();
    for (i, line) in lines {
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        if cells.len() <= first {
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
            let position = row.point(x, y)?;
            let seen = RecordedState {
                time: now,
                pose: Pose { position, heading },
                speed,
                body: (Point::new(bx, by), length, width),
            };
            all.entry(name.to_string()).or_default().push(seen);
            at += own.len();
            // Entities end with an empty cell.
            while cells.get(at).is_some_and(|c| c.is_empty()) {
                at += 1;
            }
        }
    }
    Ok(all)
}

/// A scenario whose entities move.
pub struct Played<'a> {
    pub root: &'a Node,
    pub file: &'a Path,
    pub entities: &'a [Entity],
    pub ego: Option<&'a Entity>,
    pub timeline: Timeline,
}

impl Played<'_> {
    /// The time step and the tracks. What else is read for them is added to what is hashed.
    pub fn tracks(
        &self,
        roads: &Result<Network, String>,
        report: &Report,
        ids: &mut Ids,
        hashed: &mut Vec<Vec<u8>>,
    ) -> Result<(f64, Named), ReadError> {
        let motions = motions(self.root, roads.as_ref().ok(), report).map_err(|mut error| {
            if let Err(why) = roads
                && why != NO_ROADS
            {
                error.message = format!("{} ({why})", error.message);
            }
            error
        });
        let mut strangers: Vec<&String> = { motions.iter().flat_map(|all| all.keys()) }
            .filter(|name| self.entities.iter().all(|entity| entity.name != **name))
            .collect();
        strangers.sort();
        for name in strangers {
            let words = format!("acts on `{name}`, which is no entity of the file; not used");
            report.at("Storyboard").warn(words);
        }
        // What only a player works out, or what nothing tells: a recording beside it has that.
        let is_open = match &motions {
            Err(_) => true,
            Ok(all) => {
                let open = |m: &Motions| m.unknown().is_some() || m.is_controlled;
                !self.course(all).halts().is_empty() || all.values().any(open)
            }
        };
        let log = self.file.with_extension("csv");
        if is_open && let Ok(bytes) = system::read_file(&log, system::LARGEST) {
            let text = String::from_utf8_lossy(&bytes).into_owned();
            hashed.push(bytes);
            let shown = log.display().to_string();
            let seen = read(&text, &Report::about(shown.clone()))?;
            report.note(format!("motion as a player recorded it in {shown}"));
            // The player did what stands there.
            self.root
                .child("Storyboard")
                .into_iter()
                .for_each(Node::skip);
            return Ok(recorded(self.entities, seen, report, ids));
        }
        let motions = motions?;
        self.check(&motions, &log, report)?;
        Ok((self.timeline.dt, self.course(&motions).tracks(report, ids)))
    }

    fn course<'a>(&'a self, motions: &'a AllMotions) -> Course<'a> {
        Course {
            entities: self.entities,
            motions,
            timeline: self.timeline,
        }
    }

    /// Refuses what only a player works out; says what is taken for something where players may do another.
    fn check(&self, motions: &AllMotions, log: &Path, report: &Report) -> Result<(), ReadError> {
        let recording = log.display();
        for entity in self.entities {
            let Some(motion) = motions.get(&entity.name) else {
                continue;
            };
            let is_ego = self.ego.is_some_and(|ego| ego.name == entity.name);
            // A driver under test is to drive it.
            let is_left_out = is_ego && motion.other.is_none() && motion.is_free();
            if let Some(does) = motion.unknown().filter(|_| !is_left_out) {
                let at = report.at(format!("entity `{}`", entity.name));
                return Err(at.fail(format!(
                    "{does}, which only a player works out; put its recording beside it as {recording}: \
                     esmini --osc {} --headless --fixed_timestep 0.1 --csv_logger {recording}",
                    self.file.display(),
                )));
            }
        }
        let course = self.course(motions);
        let halts = course.halts();
        let halts = halts
            .iter()
            .map(|(name, at)| format!("`{name}` from {at} s"));
        let halts: Vec<String> = halts.collect();
        if !halts.is_empty() {
            report.at("").warn(format!(
                "trajectories end before the scenario; their entities are taken to stand there: {}; players may drive \
                 them on, which a recording beside it as {recording} tells",
                halts.join(", ")
            ));
        }
        let controlled = self.entities.iter().filter(|e| {
            let motion = motions.get(&e.name);
            motion.is_some_and(|m| m.is_controlled && !m.is_free())
        });
        let controlled: Vec<String> = controlled.map(|e| format!("`{}`", e.name)).collect();
        if !controlled.is_empty() {
            report.at("").warn(format!(
                "controllers are not read, only the trajectories of their entities: {}; a player's recording beside it as \
                 {recording} tells what they do",
                controlled.join(", ")
            ));
        }
        Ok(())
    }
}
