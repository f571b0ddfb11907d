//! Writes `plan`: what a planner's process is told of the scene at a time step.

use super::hello::goals;
use super::protocol::{
    EgoState, LightState, Obstacle, PastState, PlanMessage, Prediction, Ready, ReferencePoint,
};
use crate::planner::{Forecaster, Limits, Traffic, VehicleState};
use crate::simulation::Driver;
use nearmiss_base::geometry::{Footprint, Vector};
use nearmiss_scene::scenario::prediction::{Observed, ObservedHistory};
use nearmiss_scene::scenario::{Motion, ObstacleType, Scenario};

/// What a planner is told of one step, after what it asked for.
pub(super) struct Teller<'a> {
    driver: &'a Driver,
    scenario: &'a Scenario,
    first: i64,
    ready: &'a Ready,
}

impl<'a> Teller<'a> {
    /// Of a drive that began at step `first`.
    pub fn new(driver: &'a Driver, scenario: &'a Scenario, first: i64, ready: &'a Ready) -> Self {
        Self {
            driver,
            scenario,
            first,
            ready,
        }
    }

    /// The scene at `step`, where the ego is in `state`. Nothing later than `step` is in it, but for predictions of the
    /// recorded future where the drive's settings ask for those.
    pub fn message(&self, state: &VehicleState, step: i64) -> PlanMessage {
        let (driver, scenario) = (self.driver, self.scenario);
        let settings = driver.settings();
        let history = i64::try_from(self.ready.history).unwrap_or(i64::MAX);
        let since = step.saturating_sub(history);
        let past = ObservedHistory::of_traffic(scenario, since..=step, settings.without);
        let traffic = self.ready.predictions.then(|| {
            let forecaster = Forecaster::new(scenario, settings.forecast, settings.without);
            forecaster.traffic(step, settings.planner.steps(driver.dt()))
        });
        let moving = past.others().iter().filter(|other| !other.who.parked);
        let lights = scenario.network.lights.iter();
        PlanMessage {
            step,
            time: (step - self.first) as f64 * driver.dt(),
            ego: ego(state, driver.limits(), self.ready.reference_point),
            obstacles: moving
                .map(|other| self.moving(other, step, traffic.as_ref()))
                .collect(),
            lights: lights
                .map(|light| LightState {
                    id: light.id,
                    color: light.color_at(step).name(),
                })
                .collect(),
            goals: goals(driver.problem(), step),
        }
    }

    /// Whether the acceleration of an obstacle at `step` is not recorded and its first, and so is worked out from the
    /// state after it, which the planner does not know yet.
    fn is_from_the_next(&self, id: i64, step: i64) -> bool {
        self.scenario.obstacle(id).is_some_and(|obstacle| {
            let said = obstacle
                .initial
                .as_ref()
                .and_then(|first| first.acceleration);
            obstacle.track().steps().start == step && said.is_none()
        })
    }

    fn moving(&self, other: &Observed<'_>, step: i64, traffic: Option<&Traffic>) -> Obstacle {
        let kind = other.who.kind.unwrap_or(ObstacleType::Unknown);
        let earlier = other.motions.iter().filter(|(at, _)| *at < step);
        let mut now = *other.motion;
        if self.is_from_the_next(other.who.id, step) {
            now.acceleration = 0.0;
        }
        Obstacle {
            history: earlier.map(|(at, motion)| past(*at, motion)).collect(),
            predictions: traffic
                .map_or_else(Vec::new, |traffic| predictions(traffic, other.who.id)),
            ..obstacle(other.who.id, kind, other.footprint, &now)
        }
    }
}

/// An obstacle without history and predictions.
pub(super) fn obstacle(
    id: i64,
    kind: ObstacleType,
    footprint: &Footprint,
    motion: &Motion,
) -> Obstacle {
    let corners = || footprint.corners().iter().map(|p| p.coords);
    let least = corners().fold(Vector::repeat(f64::INFINITY), |a, b| a.inf(&b));
    let most = corners().fold(Vector::repeat(f64::NEG_INFINITY), |a, b| a.sup(&b));
    let (size, middle) = (most - least, (most + least) / 2.0);
    Obstacle {
        id,
        r#type: kind.name(),
        length: size.x,
        width: size.y,
        box_middle: [middle.x, middle.y],
        x: motion.pose.position.x,
        y: motion.pose.position.y,
        heading: motion.pose.heading,
        velocity: motion.velocity,
        acceleration: motion.acceleration,
        history: Vec::new(),
        predictions: Vec::new(),
    }
}

fn past(step: i64, motion: &Motion) -> PastState {
    PastState {
        step,
        x: motion.pose.position.x,
        y: motion.pose.position.y,
        heading: motion.pose.heading,
        velocity: motion.velocity,
        acceleration: motion.acceleration,
    }
}

/// To millionths: predictions are most of a message, and digits that say nothing take time on both sides.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// The predicted motions of an obstacle that is there now, the likeliest first, each until it is no longer there.
fn predictions(traffic: &Traffic, id: i64) -> Vec<Prediction> {
    let bodies = traffic.bodies.iter().enumerate();
    let own = bodies.filter(|(_, body)| body.id == id);
    let mut found: Vec<Prediction> = own
        .map(|(place, body)| {
            let steps = (0..=traffic.horizon()).map_while(|step| {
                let there = traffic.at(step).iter().find(|o| o.body == place)?;
                let heading = there.sin.atan2(there.cos);
                Some([there.x, there.y, heading, there.velocity].map(rounded))
            });
            Prediction {
                probability: body.likelihood,
                states: steps.collect(),
            }
        })
        .collect();
    found.retain(|prediction| !prediction.states.is_empty());
    found.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    found
}

fn ego(state: &VehicleState, limits: &Limits, point: ReferencePoint) -> EgoState {
    let pose = match point {
        ReferencePoint::RearAxle => state.rear,
        ReferencePoint::Centre => state.centre(limits).pose,
    };
    EgoState {
        reference_point: point,
        x: pose.position.x,
        y: pose.position.y,
        heading: pose.heading,
        velocity: state.velocity,
        acceleration: state.acceleration,
        steering: limits.steering_of(state.curvature),
        yaw_rate: state.velocity * state.curvature,
    }
}
