//! Tracks of entities: what they follow step by step, or what a player has recorded of them.

use std::collections::BTreeMap;
use std::path::Path;

use nearmiss_base::geometry::{Point, Pose};
use nearmiss_base::system;
use nearmiss_scene::scenario::plausibility::{refused_coordinate, refused_time_step};

use super::entities::Entity;
use super::motion::Motions;
use super::storyboard::{AllMotions, motions};
use super::trajectory::SAME_TIME;
use super::{NO_ROADS, STEP};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::openscenario::SINGLE_STATES;
use crate::recordings::Report;
use crate::recordings::assembly::{Ids, RecordedTrack, TrackState};
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

/// Whether an entity of a recording is the ghost of another one: esmini lets it drive ahead, for a controller to look at.
fn is_ghost(name: &str, entities: &[Entity]) -> bool {
    let is_entity = |name: &str| entities.iter().any(|e| e.name == name);
    let of = name.strip_suffix("_ghost");
    of.is_some_and(is_entity) && !is_entity(name)
}

/// The tracks of a player's recording, and its time step.
fn recorded(
    entities: &[Entity],
    mut seen: BTreeMap<String, Vec<RecordedState>>,
    report: &Report,
    ids: &mut Ids,
) -> (f64, Named) {
    let ghosts: Vec<String> = seen
        .keys()
        .filter(|n| is_ghost(n, entities))
        .cloned()
        .collect();
    ghosts.iter().for_each(|name| {
        seen.remove(name);
    });
    report.note_count(ghosts.len(), |n| {
        let names = ghosts.join(", ");
        format!("ghosts, which drive ahead of their entities in esmini and are no bodies, left out: {n} ({names})")
    });
    let mut early = 0;
    for states in seen.values_mut() {
        let before = states.len();
        states.retain(|s| s.time > -SAME_TIME);
        early += before - states.len();
    }
    report.note_count(early, |n| {
        format!("states before time 0, when only ghosts drive, left out: {n}")
    });
    let mut times: Vec<f64> = seen.values().flatten().map(|s| s.time).collect();
    times.sort_by(f64::total_cmp);
    times.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    let between = times
        .windows(2)
        .map(|p| p[1] - p[0])
        .fold(f64::INFINITY, f64::min);
    let dt = match refused_time_step(between) {
        None => (between * 1e6).round() / 1e6,
        Some(_) => STEP,
    };
    let mut all = Vec::new();
    for (name, states) in seen {
        let entity = entities.iter().find(|e| e.name == name);
        let Some(first) = states.first() else {
            continue;
        };
        let (center, length, width) = first.body;
        let id = match entity {
            Some(entity) => id_of(entity, ids),
            None => ids.fresh(),
        };
        let kind = entity.map_or(nearmiss_scene::scenario::ObstacleType::Car, |e| e.kind);
        let mut states: Vec<TrackState> = states
            .iter()
            .map(|s| TrackState {
                step: (s.time / dt).round() as i64,
                position: s.pose.to_world(&center),
                heading: s.pose.heading,
                velocity: Some(s.speed),
                acceleration: None,
            })
            .collect();
        states.sort_by_key(|s| s.step);
        states.dedup_by_key(|s| s.step);
        let track = RecordedTrack {
            id,
            kind,
            length,
            width,
            shape: None,
            is_static: false,
            states,
        };
        all.push((name, track));
    }
    (dt, all)
}

/// A state of an entity.
#[derive(Debug, Clone, Copy)]
struct RecordedState {
    /// Seconds.
    time: f64,
    pose: Pose,
    /// m/s.
    speed: f64,
    /// The middle of its body, from its position, and its length and width, metres.
    body: (Point, f64, f64),
}

/// Reads a log; entities by name.
fn read(text: &str, report: &Report) -> Result<BTreeMap<String, Vec<RecordedState>>, ReadError> {
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
