//! The forecast given to the planner: recorded motions, constant velocity, or along the lanes.

use super::forecast_cache::{ForecastCache, Hypothesis};
use super::traffic::{Body, Extent, Traffic};
use nearmiss_scene::scenario::prediction::{Model, Observed, ObservedHistory, Predictor};
use nearmiss_scene::scenario::{Obstacle, ObstacleRole, Scenario};

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

    /// The model that predicts; `None` for the recorded future.
    pub(super) fn model(self) -> Option<Model> {
        match self {
            Self::Recorded => None,
            Self::ConstantVelocity => Some(Model::ConstantVelocity),
            Self::Lane => Some(Model::AlongLanes),
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
    cache: Option<&'a ForecastCache>,
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
            cache: None,
        }
    }

    /// The same, which takes from `cache` what is there of obstacles that move as recorded: the forecasts do not change.
    #[must_use]
    pub fn cached(self, cache: Option<&'a ForecastCache>) -> Self {
        Self { cache, ..self }
    }

    /// The bodies of all obstacles for `steps` steps from `now` on.
    #[must_use]
    pub fn traffic(&self, now: i64, steps: usize) -> Traffic {
        match self.forecast.model() {
            None => self.recorded(now, steps),
            Some(model) => self.predicted(now, steps, model),
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
            add_as_given(&mut traffic, obstacle, now);
        }
        traffic
    }

    fn predicted(&self, now: i64, steps: usize, model: Model) -> Traffic {
        let mut traffic = Traffic::new(steps);
        let past = self.past(now);
        let mut predictor = Predictor::new(&past, model);
        let cached = self.cache.and_then(|cache| cache.at(now, steps, model));
        // An occupancy set is a prediction itself, and known.
        let sets = self.bodies().filter(|o| o.is_set_based());
        sets.for_each(|obstacle| add_as_given(&mut traffic, obstacle, now));
        let is_set = |id| {
            self.scenario
                .obstacle(id)
                .is_some_and(Obstacle::is_set_based)
        };
        for seen in past.others().iter().filter(|seen| !is_set(seen.who.id)) {
            match cached.as_ref().and_then(|cached| cached.of(seen)) {
                Some(known) => known.iter().for_each(|one| traffic.add_all(one)),
                None => hypotheses(&mut predictor, seen, steps, &mut |one| {
                    traffic.add_all(&one)
                }),
            }
        }
        traffic
    }

    /// What is known of the others at a step.
    pub(super) fn past(&self, now: i64) -> ObservedHistory<'a> {
        let memory = (MEMORY / self.scenario.dt()).round() as i64;
        ObservedHistory::of_traffic(self.scenario, now - memory..=now, self.without)
    }
}

/// Adds the bodies that the scenario itself gives an obstacle from now on.
fn add_as_given(traffic: &mut Traffic, obstacle: &Obstacle, now: i64) {
    let body = traffic.add(Body {
        id: obstacle.id,
        likelihood: 1.0,
        avoided: true,
    });
    for k in 0..=traffic.horizon() {
        let step = now + k as i64;
        if let (Some(footprint), Some(motion)) =
            (obstacle.footprint_at(step), obstacle.motion_at(step))
        {
            traffic.occupy(body, k, footprint, &motion.pose, motion.velocity);
        }
    }
}

/// The hypotheses about an obstacle for `steps` steps from now on.
pub(super) fn hypotheses(
    predictor: &mut Predictor<'_>,
    seen: &Observed<'_>,
    steps: usize,
    found: &mut dyn FnMut(Hypothesis),
) {
    let dt = seen.dt;
    let prediction = predictor.predict(seen, steps as f64 * dt);
    let weights = prediction.courses.iter().map(|c| c.weight);
    let likeliest = weights.fold(0.0, f64::max);
    // The middle one of the speeds, which are in order.
    let Some(speeds) = prediction.speeds.get(prediction.speeds.len() / 2) else {
        return;
    };
    let extent = Extent::from_footprint(seen.footprint);
    let courses = prediction.courses.iter();
    for course in courses.filter(|c| c.weight >= LEAST.min(likeliest)) {
        let mut next = speeds.distance(0.0);
        let boxes = (0..=steps).map(|k| {
            let driven = next;
            next = speeds.distance((k + 1) as f64 * dt);
            let velocity = (next - driven) / dt;
            extent.at(&course.path.pose_at(driven), velocity)
        });
        found(Hypothesis {
            body: Body {
                id: seen.who.id,
                likelihood: course.weight,
                avoided: course.weight >= likeliest,
            },
            boxes: boxes.collect(),
        });
    }
}
