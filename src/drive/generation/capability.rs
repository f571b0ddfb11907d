//! Physical limits of road users, by kind.

use super::style::AttackStyle;
use crate::planner::Limits;
use nearmiss_scene::scenario::{HumanLimits, Obstacle, ObstacleType, VehicleType};

/// Physical limits of one road user, as a single-track vehicle of its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capability {
    /// Sizes, speeds, forces and steering.
    pub limits: Limits,
    /// The largest change of the acceleration along the heading, m/s³.
    pub jerk: f64,
    /// What a squared jerk costs beside a squared metre from where one is to be, m²/(m/s³)²: the more, the smoother one
    /// drives and the less exactly.
    pub jerk_cost: f64,
    /// The largest acceleration forward, m/s²; infinite where only engine and grip limit it.
    pub speeding_up: f64,
    /// The largest acceleration across the heading, m/s²; infinite where only the grip limits it.
    pub lateral: f64,
    /// Whether it has to stay on the road.
    pub on_road: bool,
}

/// Change of a car's acceleration in an emergency braking, m/s³: brakes build up their force within a few tenths of a
/// second.
const JERK: f64 = 30.0;

/// Jerks cost next to nothing where a vehicle goes to its limits.
const JERK_COST: f64 = 2e-4;

/// Share of a long vehicle's length that lies between its axles, and from the rear axle to its middle.
const LONG_WHEELBASE: f64 = 0.5;
const LONG_REAR: f64 = 0.25;

impl Capability {
    /// That of an obstacle; `None` for what has no body of one size, or does not move by itself.
    ///
    /// Cars have the limits of CommonRoad's vehicle 2 (BMW 320i), whose axles they are given; trucks and buses those of
    /// vehicle 4 with axles by their length. Motorcycles, bicycles and pedestrians are single-track vehicles with
    /// numbers of our own: a pedestrian one that turns almost on the spot, and may leave the road.
    ///
    /// In [`AttackStyle::Human`], no more of it than [`HumanLimits`] allow.
    #[must_use]
    pub fn for_obstacle(obstacle: &Obstacle, style: AttackStyle) -> Option<Self> {
        let able = Self::of_vehicle(obstacle)?;
        Some(match style {
            AttackStyle::Human => able.of_person(&HumanLimits::of(obstacle.kind)),
            AttackStyle::Limit => able,
        })
    }

    fn of_vehicle(obstacle: &Obstacle) -> Option<Self> {
        let (length, width) = obstacle.footprint.as_ref()?.shape().size();
        let car = Limits::for_vehicle(VehicleType::Bmw320i);
        let truck = Limits::for_vehicle(VehicleType::Truck);
        let sized = |limits: Limits| Limits {
            length,
            width,
            ..limits
        };
        let axles = |limits: Limits, wheelbase: f64, rear_to_centre: f64| Limits {
            wheelbase,
            rear_to_centre,
            ..sized(limits)
        };
        let small = |speed: f64, acceleration: f64, steering: f64, steering_rate: f64| Limits {
            acceleration,
            speed,
            switch_speed: speed,
            steering,
            steering_rate,
            ..axles(car, 0.6 * length, 0.3 * length)
        };
        let (limits, jerk, on_road) = match obstacle.kind {
            ObstacleType::Car
            | ObstacleType::Taxi
            | ObstacleType::PriorityVehicle
            | ObstacleType::ParkedVehicle => (sized(car), JERK, true),
            ObstacleType::Truck | ObstacleType::Bus => {
                let limits = axles(truck, LONG_WHEELBASE * length, LONG_REAR * length);
                (limits, JERK, true)
            }
            ObstacleType::Motorcycle => (small(50.0, 9.0, 0.6, 0.8), JERK, true),
            ObstacleType::Bicycle => (small(15.0, 5.0, 0.8, 1.0), JERK, true),
            ObstacleType::Pedestrian => (small(5.0, 4.0, 1.3, 5.0), JERK, false),
            _ => return None,
        };
        Some(Self {
            limits,
            jerk,
            jerk_cost: JERK_COST,
            speeding_up: f64::INFINITY,
            lateral: f64::INFINITY,
            on_road,
        })
    }

    /// The same with `share` (0 to 1) of what it can do: what is made within it passes the whole after rounding.
    #[must_use]
    pub fn scaled(self, share: f64) -> Self {
        Self {
            limits: self.limits.scaled(share),
            jerk: self.jerk * share,
            speeding_up: self.speeding_up * share,
            lateral: self.lateral * share,
            ..self
        }
    }
}
