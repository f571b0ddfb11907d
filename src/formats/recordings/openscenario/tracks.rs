//! Tracks of entities: what they follow step by step, or what a player recorded.

use std::collections::{BTreeMap, HashMap};

use super::STEP;
use super::entities::Entity;
use super::motion::Motions;
use super::player_log::Seen;
use crate::formats::commonroad::builder::SourceLocation;
use crate::formats::openscenario::SINGLE_STATES;
use crate::formats::recordings::assembly::{RecordedTrack, TrackState};
use crate::formats::recordings::ids::Ids;
use crate::formats::recordings::report::Report;
use crate::geometry::{Point, Pose};
use crate::scenario::plausibility::limits::{refused_coordinate, refused_time_step};

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

/// The tracks of entities that follow trajectories or stand.
pub fn followed(
    entities: &[Entity],
    motions: &HashMap<String, Motions>,
    timeline: Timeline,
    report: &Report,
    ids: &mut Ids,
) -> Named {
    let Timeline { dt, origin, end } = timeline;
    let origin = origin.clamp(-MOST_STEPS, MOST_STEPS);
    let last = |m: &Motions| {
        let ends = m.followed.iter().filter_map(|f| f.vertices.last());
        ends.map(|(t, _)| *t).fold(0.0, f64::max)
    };
    let longest = motions.values().map(last).fold(0.0, f64::max);
    // The moment of the end may be a little before the last step, or none of ours at all.
    let until = end
        .filter(|e| *e > 0.0 && *e < 1e5)
        .map_or(longest, |e| e.max(longest));
    let steps = ((until / dt + 0.01).floor() as i64).clamp(0, MOST_STEPS);
    let mut all = Vec::new();
    for entity in entities {
        let Some(motion) = motions.get(&entity.name) else {
            report.note(format!(
                "entity `{}` has no position; left out",
                entity.name
            ));
            continue;
        };
        if motion.is_free() {
            report.note(format!(
                "entity `{}` begins at {} m/s and follows nothing; left out (a player's recording beside it would have its motion)",
                entity.name, motion.speed
            ));
            continue;
        }
        let mut poses: BTreeMap<i64, Pose> = BTreeMap::new();
        for step in 0..=steps {
            let time = step as f64 * dt;
            let on_way = motion.followed.iter().find_map(|f| f.at(time));
            let pose = match (on_way, motion.followed.is_empty()) {
                (Some(pose), _) => pose,
                (None, true) => match motion.start {
                    Some(start) if is_there(motion, time, dt) => start,
                    _ => continue,
                },
                (None, false) => continue,
            };
            poses.insert(step, pose);
        }
        poses.extend(single_states(entity, origin));
        let speeds = entity.numbers("commonroad_velocity");
        let accelerations = entity.numbers("commonroad_acceleration");
        let stands = motion.followed.is_empty();
        let values = |all: &Option<Vec<f64>>| all.as_ref().map_or(0, Vec::len);
        for (name, count) in [
            ("commonroad_velocity", values(&speeds)),
            ("commonroad_acceleration", values(&accelerations)),
        ] {
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
        let states = poses
            .iter()
            .enumerate()
            .map(|(i, (step, pose))| TrackState {
                step: *step + origin,
                position: entity.position(pose),
                heading: pose.heading,
                velocity: whole(&speeds, i).or(stands.then_some(0.0)),
                acceleration: whole(&accelerations, i),
            });
        let mut states: Vec<TrackState> = states.collect();
        let is_static = stands && entity.property("commonroad_role") == Some("static");
        if is_static {
            states.truncate(1);
        }
        let track = RecordedTrack {
            id: id_of(entity, ids),
            kind: entity.kind,
            length: entity.length,
            width: entity.width,
            shape: entity.shape.clone(),
            is_static,
            states,
        };
        all.push((entity.name.clone(), track));
    }
    all
}

/// Whether an entity that stands is there at a moment.
fn is_there(motion: &Motions, time: f64, dt: f64) -> bool {
    // What is triggered at a moment is done in the step that begins there.
    let done = |moments: &[f64]| moments.iter().filter(|m| **m < time - dt / 2.0).count();
    let (came, went) = (done(&motion.appears), done(&motion.vanishes));
    match motion.is_late {
        true => came > went,
        false => came >= went,
    }
}

/// The tracks of a player's recording, and its time step.
pub fn recorded(
    entities: &[Entity],
    seen: BTreeMap<String, Vec<Seen>>,
    ids: &mut Ids,
) -> (f64, Named) {
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
        let kind = entity.map_or(crate::scenario::ObstacleType::Car, |e| e.kind);
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
