//! Who is on the road: bodies of usual sizes, and obstacles made of a drive or standing still.

use std::error::Error;

use nearmiss::geometry::{Footprint, Pose, Shape};
use nearmiss::scenario::{
    Obstacle, ObstacleParts, ObstacleRole, ObstacleType, Position, Prediction, Quantity, State,
    Steps,
};

use super::drive::{DT, Drive, Moment};
use super::{place, rounded};

/// A body: what it is, length and width in metres.
pub type Body = (ObstacleType, f64, f64);

/// A compact car.
pub const CAR: Body = (ObstacleType::Car, 4.3, 1.78);
/// An estate car.
pub const ESTATE: Body = (ObstacleType::Car, 4.78, 1.85);
/// A delivery van.
pub const VAN: Body = (ObstacleType::Car, 5.9, 2.02);
/// A taxi.
pub const TAXI: Body = (ObstacleType::Taxi, 4.9, 1.86);
/// A rigid lorry.
pub const TRUCK: Body = (ObstacleType::Truck, 9.2, 2.5);
/// A long lorry, as one stiff box.
pub const SEMITRAILER: Body = (ObstacleType::Truck, 16.5, 2.55);
/// A city bus.
pub const BUS: Body = (ObstacleType::Bus, 12.0, 2.55);
/// A motorcycle with its rider.
pub const MOTORCYCLE: Body = (ObstacleType::Motorcycle, 2.2, 0.85);
/// A bicycle with its rider.
pub const BICYCLE: Body = (ObstacleType::Bicycle, 1.8, 0.65);
/// A pedestrian; a disc, as wide as long.
pub const PEDESTRIAN: Body = (ObstacleType::Pedestrian, 0.6, 0.6);

/// Everybody but the ego, as they are put on the road.
#[derive(Debug)]
pub struct Cast {
    last: usize,
    /// In the order of their ids.
    pub obstacles: Vec<Obstacle>,
}

impl Cast {
    /// An empty cast; all will be recorded at the steps 0 to `last`.
    pub fn until(last: usize) -> Self {
        Self {
            last,
            obstacles: Vec::new(),
        }
    }

    /// A moving participant.
    pub fn add(&mut self, id: i64, body: Body, drive: &Drive) -> Result<(), Box<dyn Error>> {
        let moments = drive.moments(self.last);
        let mut states = (0..)
            .zip(&moments)
            .map(|(step, moment)| state(step, moment));
        let (initial, later) = (states.next(), Prediction::Trajectory(states.collect()));
        self.push(id, ObstacleRole::Dynamic, body, initial, later)
    }

    /// Something that stands there all the time.
    pub fn park(&mut self, id: i64, body: Body, pose: Pose) -> Result<(), Box<dyn Error>> {
        let moment = Moment {
            pose,
            velocity: 0.0,
            acceleration: 0.0,
            yaw_rate: 0.0,
        };
        let body = (ObstacleType::ParkedVehicle, body.1, body.2);
        let initial = Some(state(0, &moment));
        self.push(id, ObstacleRole::Static, body, initial, Prediction::None)
    }

    fn push(
        &mut self,
        id: i64,
        role: ObstacleRole,
        (kind, length, width): Body,
        initial: Option<State>,
        later: Prediction,
    ) -> Result<(), Box<dyn Error>> {
        let shape = if kind == ObstacleType::Pedestrian {
            Shape::Circle {
                radius: width / 2.0,
                center: nearmiss::geometry::Point::origin(),
            }
        } else {
            Shape::rectangle(length, width)
        };
        let footprint = Some(Footprint::new(shape)?);
        self.obstacles.push(Obstacle::new(
            ObstacleParts {
                id,
                role,
                kind,
                footprint,
                initial,
                prediction: later,
                signals: Vec::new(),
            },
            DT,
        ));
        Ok(())
    }
}

/// A moment as a state of a file.
pub fn state(step: i64, moment: &Moment) -> State {
    let exact = |value| Some(Quantity::Exact(rounded(value)));
    State {
        position: Some(Position::Point(place(moment.pose.position))),
        orientation: exact(moment.pose.heading),
        velocity: exact(moment.velocity),
        acceleration: exact(moment.acceleration),
        ..State::at(Steps::exact(step))
    }
}
