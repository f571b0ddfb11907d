//! Tracks of entities: what they follow step by step, or what a player has recorded of them.

use std::collections::BTreeMap;
use std::path::Path;

use nearmiss_base::geometry::{Point, Pose};
use nearmiss_base::system;
use nearmiss_scene::scenario::ObstacleType;
use nearmiss_scene::scenario::plausibility::refused_coordinate;

use super::entities::{Entity, catalog_files};
use super::motion::Motions;
use super::player::{self, NotPlayed};
use super::storyboard::{AllMotions, motions};
use super::{NO_ROADS, road_file};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::openscenario::SINGLE_STATES;
use crate::recordings::Report;
use crate::recordings::assembly::{Ids, RecordedTrack, TrackState};
use crate::recordings::esmini::{self, Log};
use crate::recordings::opendrive::Network;
use crate::recordings::opendrive::tree::Node;

/// Steps of a scenario at most.
const MOST_STEPS: i64 = 100_000;

/// The times of a scenario.
#[derive(Debug, Clone, Copy)]
pub struct Timeline {
    /// Seconds between two steps.
    pub dt: f64,
    /// The step at time 0.
    pub origin: i64,
    /// When it ends, where that is a moment, seconds.
    pub end: Option<f64>,
}

/// The id that is an entity's name. Exports may have ids of 0 and less; elsewhere those are only names.
pub fn own_number(entity: &Entity) -> Option<i64> {
    let id: i64 = entity.name.parse().ok()?;
    let is_own = id > 0 || entity.property("commonroad_type").is_some();
    (is_own && id.to_string() == entity.name).then_some(id)
}

fn id_of(entity: &Entity, ids: &mut Ids) -> i64 {
    match (own_number(entity), entity.property("commonroad_id")) {
        (Some(id), _) => id,
        (None, Some(written)) => match written.parse() {
            Ok(id) => ids.keep(id),
            Err(_) => ids.fresh(),
        },
        (None, None) => ids.fresh(),
    }
}

/// States before and after which an entity is away, as exports tell them; steps count from time 0.
fn single_states(entity: &Entity, origin: i64) -> Vec<(i64, Pose)> {
    let words = entity.property(SINGLE_STATES).unwrap_or_default();
    let words: Vec<&str> = words.split_whitespace().collect();
    let state = |words: &[&str]| -> Option<(i64, Pose)> {
        let number = |i: usize| words.get(i)?.parse::<f64>().ok().filter(|v| v.is_finite());
        let place = |i: usize| number(i).filter(|v| refused_coordinate(*v).is_none());
        let step = words.first()?.parse::<i64>().ok()?.checked_sub(origin)?;
        let pose = Pose {
            position: Point::new(place(1)?, place(2)?),
            heading: number(3)?,
        };
        (0..=MOST_STEPS).contains(&step).then_some((step, pose))
    };
    words.chunks(4).filter_map(state).collect()
}

/// Tracks by the names of their entities.
pub type Named = Vec<(String, RecordedTrack)>;

/// How entities move, over which time.
struct Course<'a> {
    entities: &'a [Entity],
    motions: &'a AllMotions,
    timeline: Timeline,
}

impl Course<'_> {
    /// The last moment at which anything happens, or that of the end where it is later, seconds.
    fn until(&self) -> f64 {
        let last = self
            .motions
            .values()
            .map(Motions::until)
            .fold(0.0, f64::max);
        // The moment of the end may be a little before the last step, or none of ours at all.
        let end = self.timeline.end.filter(|e| *e > 0.0 && *e < 1e5);
        end.map_or(last, |end| end.max(last))
    }

    /// Entities that are still moving where their trajectories end, and when, seconds: they stand there from then on.
    fn halts(&self) -> Vec<(&str, f64)> {
        let until = self.until();
        let halts = |e: &Entity| self.motions.get(&e.name)?.halts(until, self.timeline.dt);
        // An export tells of each of its states.
        let open = self
            .entities
            .iter()
            .filter(|e| e.property(VELOCITIES).is_none());
        open.filter_map(|e| Some((e.name.as_str(), halts(e)?)))
            .collect()
    }

    /// The tracks of entities that follow trajectories or stand.
    fn tracks(&self, report: &Report, ids: &mut Ids) -> Named {
        let dt = self.timeline.dt;
        let until = self.until();
        let all = (until / dt + 0.01).floor() as i64;
        let steps = all.clamp(0, MOST_STEPS);
        if steps < all {
            let last = steps as f64 * dt;
            report.at("").warn(format!(
                "{all} steps until {until} s; no more than {steps} are read, until {last} s"
            ));
        }
        let mut tracks = Vec::new();
        for entity in self.entities {
            let name = &entity.name;
            match self.motions.get(name) {
                None => report.note(format!("entity `{name}` has no position; left out")),
                Some(motion) if motion.is_free() => {
                    let does = motion.unknown().unwrap_or_default();
                    report.note(format!(
                        "entity `{name}` {does}; left out (a player's recording beside it would have its motion)"
                    ));
                }
                Some(motion) => {
                    let track = self.track(entity, motion, steps, report, ids);
                    tracks.push((name.clone(), track));
                }
            }
        }
        tracks
    }

    fn track(
        &self,
        entity: &Entity,
        motion: &Motions,
        steps: i64,
        report: &Report,
        ids: &mut Ids,
    ) -> RecordedTrack {
        let dt = self.timeline.dt;
        let origin = self.timeline.origin.clamp(-MOST_STEPS, MOST_STEPS);
        let stands = motion.followed.is_empty();
        let speeds = entity.numbers(VELOCITIES);
        let accelerations = entity.numbers(ACCELERATIONS);
        let poses = |holds: &dyn Fn(f64) -> bool| -> BTreeMap<i64, Pose> {
            let at = |step: i64| {
                let time = step as f64 * dt;
                let pose = motion.pose_at(time).filter(|_| holds(time))?;
                Some((step, pose))
            };
            let mut poses: BTreeMap<i64, Pose> = (0..=steps).filter_map(at).collect();
            poses.extend(single_states(entity, origin));
            poses
        };
        let on_its_way = poses(&|time| motion.is_on_its_way(time));
        // An export tells each of its states: it is not there at other times, where its trajectory goes on behind the end.
        let is_told = !stands
            && speeds
                .as_ref()
                .is_some_and(|all| all.len() == on_its_way.len());
        let poses = if is_told {
            on_its_way
        } else {
            poses(&|time| motion.is_there(time, dt))
        };
        for (name, values) in [(VELOCITIES, &speeds), (ACCELERATIONS, &accelerations)] {
            let count = values.as_ref().map_or(0, Vec::len);
            let is_one_for_all = stands && count == 1;
            if entity.property(name).is_some() && count != poses.len() && !is_one_for_all {
                let at = report.at(format!("entity `{}`", entity.name));
                at.warn(format!(
                    "`{name}` has {count} numbers for {} states; computed from the positions",
                    poses.len()
                ));
            }
        }
        let whole = |all: &Option<Vec<f64>>, i: usize| match all {
            Some(all) if all.len() == poses.len() => all.get(i).copied(),
            // One that stands has one state for all times.
            Some(all) if stands && all.len() == 1 => all.first().copied(),
            _ => None,
        };
        let states = poses.iter().enumerate().map(|(i, (step, pose))| {
            let rests = !motion.is_on_its_way(*step as f64 * dt);
            TrackState {
                step: *step + origin,
                position: entity.position(pose),
                heading: pose.heading,
                velocity: whole(&speeds, i).or(rests.then_some(0.0)),
                acceleration: whole(&accelerations, i),
            }
        });
        let mut states: Vec<TrackState> = states.collect();
        let is_static = stands && entity.property("commonroad_role") == Some("static");
        if is_static {
            states.truncate(1);
        }
        RecordedTrack {
            id: id_of(entity, ids),
            kind: entity.kind,
            length: entity.length,
            width: entity.width,
            shape: entity.shape.clone(),
            is_static,
            states,
        }
    }
}

/// Properties with the velocities and accelerations of an export, one a state.
const VELOCITIES: &str = "commonroad_velocity";

const ACCELERATIONS: &str = "commonroad_acceleration";

/// The tracks of a player's recording.
fn recorded(entities: &[Entity], log: &Log, ids: &mut Ids) -> Named {
    let tracks = log.entities.iter().filter_map(|(name, states)| {
        let entity = entities.iter().find(|e| e.name == *name);
        let (length, width) = states.first()?.size;
        let track = RecordedTrack {
            id: match entity {
                Some(entity) => id_of(entity, ids),
                None => ids.fresh(),
            },
            kind: entity.map_or(ObstacleType::Car, |e| e.kind),
            length,
            width,
            shape: None,
            is_static: false,
            states: log.states(states),
        };
        Some((name.clone(), track))
    });
    tracks.collect()
}

/// An error for which there is one more reason.
fn and(mut error: ReadError, why: &str) -> ReadError {
    error.message = format!("{}; {why}", error.message);
    error
}

/// A scenario whose entities move.
pub struct Played<'a> {
    pub root: &'a Node,
    pub file: &'a Path,
    pub entities: &'a [Entity],
    pub ego: Option<&'a Entity>,
    /// Whether it is an export of this program.
    pub is_export: bool,
    pub timeline: Timeline,
}

/// How the entities of a scenario move.
pub struct Motion {
    /// Seconds.
    pub time_step: f64,
    pub tracks: Named,
    /// Who worked it out, with its version, where that was done for this reading.
    pub player: Option<String>,
}

impl Played<'_> {
    /// The motion of its entities. What else is read for that is added to what is hashed.
    pub fn motion(
        &self,
        roads: &Result<Network, String>,
        report: &Report,
        ids: &mut Ids,
        hashed: &mut Vec<Vec<u8>>,
    ) -> Result<Motion, ReadError> {
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
        // What only a player works out, or what nothing tells: a recording has that.
        let is_open = |ego_counts: bool| match &motions {
            Err(_) => true,
            Ok(all) => {
                let open = |(name, m): (&String, &Motions)| {
                    let counts = ego_counts || !self.is_left_out(name, m);
                    counts && (m.unknown().is_some() || m.is_controlled)
                };
                !self.course(all).halts().is_empty() || all.iter().any(open)
            }
        };
        let beside = self.file.with_extension("csv");
        if is_open(true)
            && let Ok(bytes) = system::read_file(&beside, system::LARGEST)
        {
            let shown = beside.display().to_string();
            let log = self.log(&bytes, Report::about(&*shown), report)?;
            hashed.push(bytes);
            report.note(format!("motion as a player recorded it in {shown}"));
            return Ok(self.recorded(&log, ids));
        }
        // The ego of an export is free for a driver under test.
        let is_played = is_open(!self.is_export) && self.root.child("Storyboard").is_some();
        let played = is_played.then(|| {
            let mut files = vec![self.file.to_path_buf()];
            files.extend(road_file(self.root, self.file));
            files.extend(catalog_files(self.root, self.file));
            player::play(&files, self.timeline.dt)
        });
        let why = match played.transpose() {
            Ok(Some(bytes)) => {
                let shown = format!("{} as esmini played it", self.file.display());
                let log = self.log(&bytes, Report::about(shown), report)?;
                hashed.push(bytes);
                report.note(format!("motion as {} played it", log.player));
                return Ok(Motion {
                    player: Some(log.player.clone()),
                    ..self.recorded(&log, ids)
                });
            }
            Ok(None) => None,
            Err(why) => Some(why),
        };
        let motions = motions.map_err(|error| match &why {
            Some(NotPlayed::Failed(why)) => and(error, why),
            _ => error,
        })?;
        self.check(&motions, report).map_err(|error| match &why {
            Some(NotPlayed::Failed(why)) => and(error, why),
            Some(NotPlayed::NoPlayer(why)) => and(
                error,
                &format!("{why}, or put {}", self.recording_of_others()),
            ),
            None => error,
        })?;
        if let Some(NotPlayed::Failed(why)) = why {
            report.at("").warn(format!("{why}; read without a player"));
        }
        Ok(Motion {
            time_step: self.timeline.dt,
            tracks: self.course(&motions).tracks(report, ids),
            player: None,
        })
    }

    /// The recording of another player that is read, and how one is made.
    fn recording_of_others(&self) -> String {
        let beside = self.file.with_extension("csv");
        let recording = beside.display();
        format!(
            "a player's recording beside it as {recording}: esmini --osc {} --headless --fixed_timestep 0.1 --csv_logger \
             {recording}",
            self.file.display()
        )
    }

    fn log(&self, bytes: &[u8], about: Report, report: &Report) -> Result<Log, ReadError> {
        let is_entity = |name: &str| self.entities.iter().any(|e| e.name == name);
        let log = esmini::read(&String::from_utf8_lossy(bytes), &about)?;
        // Its lines are those of the log.
        let shown = about.file().to_string();
        for said in about.into_diagnostics() {
            let message = format!("{shown}: line {}: {}", said.line, said.message);
            report.at("").note(said.severity, message);
        }
        Ok(log.bodies(Some(&is_entity), report))
    }

    /// The motion of a log; its player did what stands in the storyboard.
    fn recorded(&self, log: &Log, ids: &mut Ids) -> Motion {
        let storyboard = self.root.child("Storyboard");
        storyboard.into_iter().for_each(Node::skip);
        Motion {
            time_step: log.time_step,
            tracks: recorded(self.entities, log, ids),
            player: None,
        }
    }

    fn course<'a>(&'a self, motions: &'a AllMotions) -> Course<'a> {
        Course {
            entities: self.entities,
            motions,
            timeline: self.timeline,
        }
    }

    /// Whether an entity is the ego, and free: a driver under test is to drive it.
    fn is_left_out(&self, name: &str, motion: &Motions) -> bool {
        let is_ego = self.ego.is_some_and(|ego| ego.name == name);
        is_ego && motion.other.is_none() && motion.is_free()
    }

    /// Refuses what only a player works out; says what is taken for something where players may do another.
    fn check(&self, motions: &AllMotions, report: &Report) -> Result<(), ReadError> {
        let beside = self.file.with_extension("csv");
        let recording = beside.display();
        for entity in self.entities {
            let Some(motion) = motions.get(&entity.name) else {
                continue;
            };
            let is_left_out = self.is_left_out(&entity.name, motion);
            if let Some(does) = motion.unknown().filter(|_| !is_left_out) {
                let at = report.at(format!("entity `{}`", entity.name));
                return Err(at.fail(format!("{does}, which only a player works out")));
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
