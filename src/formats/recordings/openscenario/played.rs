//! How entities move: as a player recorded it, where the file leaves something open, or as the file tells it.

use std::path::Path;

use super::NO_ROADS;
use super::entities::Entity;
use super::motion::Motions;
use super::player_log;
use super::storyboard::{AllMotions, motions};
use super::tracks::{Course, Named, Timeline, recorded};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::ids::Ids;
use crate::recordings::opendrive::Network;
use crate::recordings::opendrive::tree::Node;
use crate::recordings::report::Report;
use nearmiss_base::system;

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
        if is_open && let Ok(read) = system::read_file(&log, system::LARGEST) {
            let text = String::from_utf8_lossy(&read).into_owned();
            hashed.push(read);
            let shown = log.display().to_string();
            let seen = player_log::read(&text, &Report::about(shown.clone()))?;
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
