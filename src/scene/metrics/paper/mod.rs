//! The convention of the paper's published tables, defects and all; never the default.
//!
//! *From Words to Collisions* (Gao et al.) published its measures as `relative_metrics.csv`, those within 30 m as
//! `close_relative_metrics.csv`, and risk scores of one example as `risk_scores_*.csv`. This module computes the
//! same numbers from the same scenarios, so that results can be held against the published ones. It keeps what
//! the published tables do, which the measures of [`crate::metrics`] do not:
//!
//! - every participant, the ego too, is 4.508 m long and 1.610 m wide, and its box is never turned: centres that are
//!   less than one length apart along the ego's heading overlap along it, and the same across it with the width;
//! - the ego's heading, velocity and acceleration are those written in its recording, where the heading is 0 at
//!   standstill
//!   and velocity and acceleration are one step ahead of the position;
//! - accelerations are compared along the axes of the map, not of the ego;
//! - who overlaps along an axis has a time of 0 along it, whether it comes closer or not;
//! - the risk score takes its thresholds from the published code, which are not those of the published prompt, grades
//!   the
//!   rounded numbers, truncates instead of rounding, and gives `Behind` the weight of a diagonal.
//!
//! There is a row for every state of the trajectory of a dynamic obstacle at whose time step the ego has a row. The
//! initial states, which lie before the trajectories, have none, and static obstacles and those without a trajectory
//! have none.

mod relation;
mod risk;

use std::collections::{HashMap, HashSet};

use nearmiss_base::geometry::Pose;

use crate::scenario::{
    EgoSource, Motion, Obstacle, ObstacleRole, Prediction, Sample, Scene, State,
};

pub use relation::{Across, Along, Direction, LENGTH, Relation, WIDTH};
pub use risk::{AcrossMotion, AlongMotion, Risk};

/// Obstacles whose centre is farther than this from the ego's, metres, are in no `close_relative_metrics.csv`.
pub const RADIUS: f64 = 30.0;

/// One obstacle at one time step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Time step.
    pub timestep: i64,
    /// Id of the obstacle.
    pub obstacle: i64,
    /// From centre to centre, metres; not rounded.
    pub distance: f64,
    /// Its position and motion, rounded to two decimals.
    pub relation: Relation,
    /// The score of the rounded numbers.
    pub risk: Risk,
}

/// States so far apart or so fast that their difference is beyond all numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "obstacle {obstacle} at step {timestep}: position, velocity or acceleration too large to compare with the ego's"
)]
pub struct TooLarge {
    /// Which obstacle.
    pub obstacle: i64,
    /// When.
    pub timestep: i64,
}

/// The rows of a scene in the published order: by time step, then by id.
///
/// The ego's row of a time step is taken as it was recorded ([`crate::scenario::Ego::recorded`]), and so are the
/// states of the obstacles. What a recording or a state does not say (the published ones say everything) is that of
/// the filled [`crate::scenario::Track`], and so is everything about an ego that is an obstacle of the scenario.
///
/// # Errors
/// [`TooLarge`], where a row would hold no finite number.
pub fn rows(scene: &Scene) -> Result<Vec<Row>, TooLarge> {
    let recorded: HashMap<i64, &Sample> = scene.ego.recorded.iter().map(|s| (s.step, s)).collect();
    let taken = match scene.ego.source {
        EgoSource::Obstacle(id) => Some(id),
        _ => None,
    };
    let mut rows = Vec::new();
    for obstacle in &scene.scenario.obstacles {
        let (ObstacleRole::Dynamic, Prediction::Trajectory(states)) =
            (obstacle.role, &obstacle.prediction)
        else {
            continue;
        };
        if Some(obstacle.id) == taken {
            continue;
        }
        let mut seen = HashSet::new();
        for state in states {
            let timestep = state.time.from;
            let filled = scene.ego.track.at(timestep);
            let ego = filled.map(|f| as_recorded(f, recorded.get(&timestep).copied()));
            let Some((ego, other)) = ego.zip(as_said(obstacle, state)) else {
                continue;
            };
            // A time step that is there twice counts once, as everywhere.
            if !seen.insert(timestep) {
                continue;
            }
            let unknown = TooLarge {
                obstacle: obstacle.id,
                timestep,
            };
            let relation = Relation::new(&ego, &other).ok_or(unknown)?.rounded();
            let apart = other.pose.position - ego.pose.position;
            let distance = apart.x.hypot(apart.y);
            if !distance.is_finite() {
                return Err(unknown);
            }
            rows.push(Row {
                timestep,
                obstacle: obstacle.id,
                distance,
                relation,
                risk: Risk::score(&relation),
            });
        }
    }
    rows.sort_by_key(|row| (row.timestep, row.obstacle));
    Ok(rows)
}

/// A filled motion with everything replaced that the recording says.
fn as_recorded(filled: &Motion, sample: Option<&Sample>) -> Motion {
    let Some(sample) = sample else {
        return *filled;
    };
    Motion {
        pose: Pose {
            position: sample.position,
            heading: sample.heading.unwrap_or(filled.pose.heading),
        },
        velocity: sample.velocity.unwrap_or(filled.velocity),
        acceleration: sample.acceleration.unwrap_or(filled.acceleration),
    }
}

/// The motion that a state says; `None` if it has no position.
fn as_said(obstacle: &Obstacle, state: &State) -> Option<Motion> {
    let filled = *obstacle.track().at(state.time.from)?;
    let position = state.point()?;
    // A point mass has its velocity in two parts, which the track has put together.
    if state.point_mass_velocity().is_some() {
        return Some(filled);
    }
    let sample = Sample {
        step: state.time.from,
        position,
        heading: state.orientation.map(|q| q.middle()),
        velocity: state.velocity.map(|q| q.middle()),
        acceleration: state.acceleration.map(|q| q.middle()),
    };
    Some(as_recorded(&filled, Some(&sample)))
}
