//! Everyone and everything on the road but the ego.

use super::{ObstacleRole, ObstacleType, Sample, Signal, State, Steps, Track};
use crate::geometry::{Footprint, Shape};

/// Another participant, or a thing in the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// Unique in the scenario.
    pub id: i64,
    /// Whether it moves, stands, or is only feared.
    pub role: ObstacleRole,
    /// What it is.
    pub kind: ObstacleType,
    /// The region it covers, in its own frame; phantom obstacles have none.
    pub footprint: Option<Footprint>,
    /// Its first state; environment and phantom obstacles have none.
    pub initial: Option<State>,
    /// What it does afterwards.
    pub prediction: Prediction,
    /// What it signals, in order of time; the first may belong to the initial state.
    pub signals: Vec<SignalState>,
    track: Track,
}

/// Everything that a file says about an obstacle.
#[derive(Debug, Clone, PartialEq)]
pub struct ObstacleParts {
    /// Unique in the scenario.
    pub id: i64,
    /// Whether it moves, stands, or is only feared.
    pub role: ObstacleRole,
    /// What it is.
    pub kind: ObstacleType,
    /// The region it covers, in its own frame.
    pub footprint: Option<Footprint>,
    /// Its first state.
    pub initial: Option<State>,
    /// What it does afterwards.
    pub prediction: Prediction,
    /// What it signals.
    pub signals: Vec<SignalState>,
}

/// What an obstacle signals at a time; what is not said is not known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SignalState {
    /// When.
    pub time: Steps,
    /// The signals that are said, on or off, in the file's order.
    pub signals: Vec<(Signal, bool)>,
}

/// What an obstacle does after its first state.
#[derive(Debug, Clone, PartialEq)]
pub enum Prediction {
    /// Nothing is said.
    None,
    /// It follows these states.
    Trajectory(Vec<State>),
    /// It is somewhere in these regions of the world.
    Occupancies(Vec<Occupancy>),
}

/// A region of the world that an obstacle may cover for a while.
#[derive(Debug, Clone, PartialEq)]
pub struct Occupancy {
    /// When.
    pub time: Steps,
    /// Where, in world coordinates.
    pub region: Shape,
}

impl Obstacle {
    /// An obstacle, with its motion worked out for time steps of `dt` seconds.
    #[must_use]
    pub fn new(parts: ObstacleParts, dt: f64) -> Self {
        let later: &[State] = match &parts.prediction {
            Prediction::Trajectory(states) => states,
            _ => &[],
        };
        let samples = parts.initial.iter().chain(later).filter_map(sample);
        Self {
            track: Track::new(samples.collect(), dt, None),
            id: parts.id,
            role: parts.role,
            kind: parts.kind,
            footprint: parts.footprint,
            initial: parts.initial,
            prediction: parts.prediction,
            signals: parts.signals,
        }
    }

    /// Its recorded motion, one entry a time step.
    ///
    /// A static obstacle has a single entry, which holds at all times: ask [`super::Scene`].
    #[must_use]
    pub fn track(&self) -> &Track {
        &self.track
    }

    /// Its recorded states, the first included.
    pub fn states(&self) -> impl Iterator<Item = &State> {
        let later: &[State] = match &self.prediction {
            Prediction::Trajectory(states) => states,
            _ => &[],
        };
        self.initial.iter().chain(later)
    }
}

fn sample(state: &State) -> Option<Sample> {
    Some(Sample {
        step: state.time.from,
        position: state.point()?,
        heading: state.orientation.map(|q| q.middle()),
        velocity: state.velocity.map(|q| q.middle()),
        acceleration: state.acceleration.map(|q| q.middle()),
    })
}
