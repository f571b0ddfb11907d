//! Obstacles: all road users but the ego, and objects on or beside the road.

use serde::{Serialize, Serializer};

use super::occupied::{Region, Regions};
use super::{
    ObstacleRole, ObstacleType, Position, Quantity, Sample, Signal, State, StateField, Steps, Track,
};
use nearmiss_base::geometry::{Footprint, Shape, Vector};

/// Another participant, or a thing in the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// Unique in the scenario.
    pub id: i64,
    /// Whether it moves, stands, or is only feared.
    pub role: ObstacleRole,
    /// Its type.
    pub kind: ObstacleType,
    /// The region it covers, in its own frame; phantom obstacles have none.
    pub footprint: Option<Footprint>,
    /// Its first state; environment and phantom obstacles have none.
    pub initial: Option<State>,
    /// Its motion afterwards.
    pub prediction: Prediction,
    /// Its signals in order of time; the first may belong to the initial state.
    pub signals: Vec<SignalState>,
    track: Track,
    /// The footprint at the steps where its trailer is turned, by step.
    bent: Vec<(i64, Footprint)>,
    /// Where it may be, of a body that is given as an occupancy set.
    regions: Regions,
}

/// Everything that a file says about an obstacle.
#[derive(Debug, Clone, PartialEq)]
pub struct ObstacleParts {
    /// Unique in the scenario.
    pub id: i64,
    /// Whether it moves, stands, or is only feared.
    pub role: ObstacleRole,
    /// Its type.
    pub kind: ObstacleType,
    /// The region it covers, in its own frame.
    pub footprint: Option<Footprint>,
    /// Its first state.
    pub initial: Option<State>,
    /// Its motion afterwards.
    pub prediction: Prediction,
    /// Its signals.
    pub signals: Vec<SignalState>,
}

/// What an obstacle signals at a time; what is not said is not known.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SignalState {
    /// When.
    #[serde(rename = "time_step")]
    pub time: Steps,
    /// The signals that are said, on or off, in the file's order.
    #[serde(serialize_with = "by_name")]
    pub signals: Vec<(Signal, bool)>,
}

fn by_name<S: Serializer>(signals: &[(Signal, bool)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(signals.iter().copied())
}

/// What an obstacle does after its first state.
#[derive(Debug, Clone, PartialEq)]
pub enum Prediction {
    /// The file gives none.
    None,
    /// It follows these states.
    Trajectory(Vec<State>),
    /// It is somewhere in these regions of the world.
    Occupancies(Vec<Occupancy>),
}

/// A region of the world that an obstacle may cover for a while.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Occupancy {
    /// When.
    #[serde(rename = "time_step")]
    pub time: Steps,
    /// Where, in world coordinates.
    #[serde(rename = "shape")]
    pub region: Shape,
}

impl ObstacleParts {
    /// The uncertainty of its motion, in a sentence: states that give a region instead of a point.
    #[must_use]
    pub fn uncertainty(&self) -> Option<String> {
        let region = |s: &&State| matches!(s.position, Some(Position::Region(_)));
        match self.states().filter(region).count() {
            0 => None,
            count => Some(format!(
                "position is a region in {count} states; its centre is used"
            )),
        }
    }

    /// Where its heading is worked out, in a sentence: states with a place that say no orientation.
    #[must_use]
    pub fn without_orientation(&self) -> Option<String> {
        let is_round = |footprint: &Footprint| matches!(footprint.shape(), Shape::Circle { .. });
        let bare = |s: &&State| {
            s.position.is_some() && s.orientation.is_none() && s.point_mass_velocity().is_none()
        };
        let count = self.states().filter(bare).count();
        let turns = self.footprint.as_ref().is_some_and(|body| !is_round(body));
        (turns && count > 0).then(|| {
            format!(
                "no orientation in {count} states; taken from its motion, else along the x axis"
            )
        })
    }

    fn states(&self) -> impl Iterator<Item = &State> {
        let later: &[State] = match &self.prediction {
            Prediction::Trajectory(states) => states,
            _ => &[],
        };
        self.initial.iter().chain(later)
    }
}

impl Obstacle {
    /// An obstacle, with its motion worked out for time steps of `dt` seconds.
    #[must_use]
    pub fn new(parts: ObstacleParts, dt: f64) -> Self {
        let states = || parts.states();
        let bent = parts
            .footprint
            .iter()
            .flat_map(|straight| states().filter_map(|s| bent(straight, s)));
        let track = Track::new(states().filter_map(sample).collect(), dt, None);
        let bodily = matches!(parts.role, ObstacleRole::Static | ObstacleRole::Dynamic);
        let regions = match &parts.prediction {
            Prediction::Occupancies(all) if bodily => {
                Regions::new(all, track.iter().next().map(|(step, _)| step))
            }
            _ => Regions::default(),
        };
        Self {
            bent: bent.collect(),
            track,
            regions,
            id: parts.id,
            role: parts.role,
            kind: parts.kind,
            footprint: parts.footprint,
            initial: parts.initial,
            prediction: parts.prediction,
            signals: parts.signals,
        }
    }

    /// Its recorded motion, one entry a time step; what an occupancy set says of it is none.
    ///
    /// A static obstacle has a single entry, which holds at all times: ask [`super::Scene`].
    #[must_use]
    pub fn track(&self) -> &Track {
        &self.track
    }

    /// The region it covers at a step, in its own frame: that of a semi-trailer truck turns at the hitch.
    #[must_use]
    pub fn footprint_at(&self, step: i64) -> Option<&Footprint> {
        if let Some(region) = self.region_at(step) {
            return Some(&region.footprint);
        }
        // One that stands has the body of its first state for ever.
        let step = match self.role {
            ObstacleRole::Static => self.track.steps().start,
            _ => step,
        };
        let bent = self.bent.iter().find(|(at, _)| *at == step);
        bent.map(|(_, footprint)| footprint)
            .or(self.footprint.as_ref())
    }

    /// The region it covers in its own frame, or the first one of an occupancy set.
    #[must_use]
    pub fn any_footprint(&self) -> Option<&Footprint> {
        let set = || self.regions.first().map(|region| &region.footprint);
        self.footprint.as_ref().or_else(set)
    }

    /// Whether an occupancy set says where it may be: then its motion is not known.
    #[must_use]
    pub fn is_set_based(&self) -> bool {
        !self.regions.is_empty()
    }

    /// Whether its body at a step is a region that it may cover, of an occupancy set: it has a place there, and no
    /// heading or velocity.
    #[must_use]
    pub fn is_occupancy_at(&self, step: i64) -> bool {
        self.region_at(step).is_some()
    }

    /// The region of its occupancy set at a step, where nothing better is known.
    pub(super) fn region_at(&self, step: i64) -> Option<&Region> {
        match self.role {
            ObstacleRole::Static => {
                let is_known = !self.track.steps().is_empty();
                self.regions.first().filter(|_| !is_known)
            }
            _ => self.regions.at(step),
        }
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

/// The footprint with the trailer turned as in the state; `None` without a trailer that turns.
fn bent(straight: &Footprint, state: &State) -> Option<(i64, Footprint)> {
    let angle = state.quantity(StateField::HitchAngle)?;
    let shape = straight.shape().hitched_at(angle.middle())?;
    Some((state.time.from, Footprint::new(shape).ok()?))
}

/// A point mass slower than this has no heading, m/s.
const STANDSTILL: f64 = 1e-3;

/// The motion in a state; `None` if it gives no position.
pub(super) fn sample(state: &State) -> Option<Sample> {
    let vector = state.point_mass_velocity();
    let direction = vector.filter(|v| v.norm() > STANDSTILL);
    let said = |quantity: Option<Quantity>| quantity.map(|q| q.middle());
    // A point mass may also give its velocity along the world's two axes.
    let across = vector.and(state.quantity(StateField::AccelerationY));
    let acceleration = match (said(state.acceleration), across) {
        (Some(x), Some(y)) => {
            let vector = Vector::new(x, y.middle());
            direction.map(|v| v.normalize().dot(&vector))
        }
        (along, _) => along,
    };
    Some(Sample {
        step: state.time.from,
        position: state.middle()?,
        heading: direction
            .map(|v| v.y.atan2(v.x))
            .or(said(state.orientation)),
        velocity: vector.map(|v| v.norm()).or(said(state.velocity)),
        acceleration,
    })
}
