//! The forecast given to the planner: recorded motions, constant velocity, or along the lanes.

use super::traffic::{Body, Extent, Traffic};
use crate::scenario::prediction::{Model, ObservedHistory, Predictor};
use crate::scenario::{Obstacle, ObstacleRole, Scenario};

/// Source of the others' future.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Forecast {
    /// The recorded future itself: an oracle, which no vehicle has.
    Recorded,
    /// Straight on with the present velocity.
    ConstantVelocity,
    /// Along the lanes, or on with the present turn, each as likely as it looks.
    Lane,
}

impl Forecast {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Recorded, Self::ConstantVelocity, Self::Lane];

    /// Its name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Recorded => "recorded",
            Self::ConstantVelocity => "constant-velocity",
            Self::Lane => "lane",
        }
    }

    /// The one with this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }
}

/// Makes forecasts for the obstacles of one scenario.
#[derive(Debug)]
pub struct Forecaster<'a> {
    scenario: &'a Scenario,
    forecast: Forecast,
    /// The obstacle whose place the ego takes.
    without: Option<i64>,
}

/// Seconds of observed history available to a forecast.
const MEMORY: f64 = 1.0;

/// Ways that are less likely are not looked at.
const LEAST: f64 = 0.05;

impl<'a> Forecaster<'a> {
    /// A forecaster for all obstacles of `scenario` except `without`.
    #[must_use]
    pub fn new(scenario: &'a Scenario, forecast: Forecast, without: Option<i64>) -> Self {
        Self {
            scenario,
            forecast,
            without,
        }
    }

    /// The bodies of all obstacles for `steps` steps from `now` on.
    #[must_use]
    pub fn traffic(&self, now: i64, steps: usize) -> Traffic {
        match self.forecast {
            Forecast::Recorded => self.recorded(now, steps),
            Forecast::ConstantVelocity => self.predicted(now, steps, Model::ConstantVelocity),
            Forecast::Lane => self.predicted(now, steps, Model::AlongLanes),
        }
    }

    fn bodies(&self) -> impl Iterator<Item = &'a Obstacle> + use<'a> {
        let without = self.without;
        self.scenario.obstacles.iter().filter(move |o| {
            matches!(o.role, ObstacleRole::Static | ObstacleRole::Dynamic) && Some(o.id) != without
        })
    }

    fn recorded(&self, now: i64, steps: usize) -> Traffic {
        let mut traffic = Traffic::new(steps);
        for obstacle in self.bodies() {
            let body = traffic.add(Body {
                id: obstacle.id,
                likelihood: 1.0,
                avoided: true,
            });
            for k in 0..=steps {
                let step = now + k as i64;
                if let (Some(footprint), Some(motion)) =
                    (obstacle.footprint_at(step), obstacle.motion_at(step))
                {
                    traffic.occupy(body, k, footprint, &motion.pose, motion.velocity);
                }
            }
        }
        traffic
    }

    fn predicted(&self, now: i64, steps: usize, model: Model) -> Traffic {
        let dt = self.scenario.dt();
        let mut traffic = Traffic::new(steps);
        let memory = (MEMORY / dt).round() as i64;
        let past = ObservedHistory::of_traffic(self.scenario, now - memory..=now, self.without);
        let mut predictor = Predictor::new(&past, model);
        for seen in past.others() {
            let prediction = predictor.predict(seen, steps as f64 * dt);
            let likeliest = prediction
                .courses
                .iter()
                .map(|c| c.weight)
                .fold(0.0, f64::max);
            // The middle one of the speeds, which are in order.
            let Some(speeds) = prediction.speeds.get(prediction.speeds.len() / 2) else {
                continue;
            };
            let extent = Extent::from_footprint(seen.footprint);
            for course in prediction
                .courses
                .iter()
                .filter(|c| c.weight >= LEAST.min(likeliest))
            {
                let body = traffic.add(Body {
                    id: seen.who.id,
                    likelihood: course.weight,
                    avoided: course.weight >= likeliest,
                });
                let mut next = speeds.distance(0.0);
                for k in 0..=steps {
                    let driven = next;
                    next = speeds.distance((k + 1) as f64 * dt);
                    let pose = course.path.pose_at(driven);
                    let velocity = (next - driven) / dt;
                    traffic.occupy_box(body, k, extent, &pose, velocity);
                }
            }
        }
        traffic
    }
}
