//! The forecast given to the planner: recorded motions, made once for many drives, constant velocity, or along the lanes.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use strum::{IntoStaticStr, VariantArray};

use nearmiss_scene::scenario::prediction::{
    Model, Observed, ObservedHistory, Predictor, TrackedObject,
};
use nearmiss_scene::scenario::{Motion, Obstacle, ObstacleRole, Scenario};

use super::traffic::{Body, Extent, Occupied, Traffic};

/// Source of the others' future.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum Forecast {
    /// The recorded future itself: an oracle, which no vehicle has.
    Recorded,
    /// Straight on with the present velocity.
    ConstantVelocity,
    /// Along the lanes, or on with the present turn, each as likely as it looks.
    Lane,
}

nearmiss_record::named!(Forecast, "prediction");

impl Forecast {
    /// The model that predicts; `None` for the recorded future.
    pub(super) fn model(self) -> Option<Model> {
        match self {
            Self::Recorded => None,
            Self::ConstantVelocity => Some(Model::ConstantVelocity),
            Self::Lane => Some(Model::AlongLanes),
        }
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
const MIN_LIKELIHOOD: f64 = 0.05;

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
            match cached.as_ref().and_then(|cached| cached.hypotheses(seen)) {
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
    for course in courses.filter(|c| c.weight >= MIN_LIKELIHOOD.min(likeliest)) {
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

/// One way that an obstacle may go, with its box at each step from now on.
#[derive(Debug)]
pub(super) struct Hypothesis {
    pub body: Body,
    pub boxes: Vec<Occupied>,
}

/// The forecasts in one scenario, step by step, each made when it is first asked for.
///
/// A forecast looks at the road and at an obstacle's own past alone. So it holds in every scenario with the same road for
/// an obstacle with the same past, and drives are the same with and without the cache.
#[derive(Debug)]
pub struct ForecastCache {
    scenario: Arc<Scenario>,
    forecast: Forecast,
    without: Option<i64>,
    /// Steps of a forecast.
    horizon: usize,
    /// The first step that is cached.
    first: i64,
    steps: Vec<OnceLock<Vec<Cached>>>,
    /// Boxes that may still be kept.
    room: AtomicUsize,
}

/// What is known of an obstacle at a step.
#[derive(Debug)]
struct Cached {
    who: TrackedObject,
    past: Vec<(i64, Motion)>,
    hypotheses: Vec<Hypothesis>,
}

/// The forecasts of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct CachedStep<'a> {
    cache: &'a ForecastCache,
    now: i64,
    cached: &'a [Cached],
}

/// Once so many boxes are kept, about 70 MB, forecasts of further steps are made anew each time.
const MOST_BOXES: usize = 1_000_000;

impl ForecastCache {
    /// An empty cache for the obstacles of `scenario` except `without`, for forecasts of `horizon` steps that are made
    /// at the steps from `first` to `last`.
    #[must_use]
    pub fn new(
        scenario: Arc<Scenario>,
        forecast: Forecast,
        without: Option<i64>,
        horizon: usize,
        (first, last): (i64, i64),
    ) -> Self {
        let count = (last - first + 1).max(0) as usize;
        Self {
            scenario,
            forecast,
            without,
            horizon,
            first,
            steps: (0..count).map(|_| OnceLock::new()).collect(),
            room: AtomicUsize::new(MOST_BOXES),
        }
    }

    /// The forecasts of `horizon` steps that are made at step `now`; `None` where others than those are cached.
    pub(super) fn at(&self, now: i64, horizon: usize, model: Model) -> Option<CachedStep<'_>> {
        if self.horizon != horizon || self.forecast.model() != Some(model) {
            return None;
        }
        let place = usize::try_from(now - self.first).ok()?;
        let cached = self.steps.get(place)?.get_or_init(|| self.make(now, model));
        Some(CachedStep {
            cache: self,
            now,
            cached,
        })
    }

    fn make(&self, now: i64, model: Model) -> Vec<Cached> {
        if self.room.load(Ordering::Relaxed) == 0 {
            return Vec::new();
        }
        let past = Forecaster::new(&self.scenario, self.forecast, self.without).past(now);
        let mut predictor = Predictor::new(&past, model);
        let mut boxes = 0;
        let others = past.others().iter();
        let cached = others
            .map(|seen| {
                let mut found = Vec::new();
                hypotheses(&mut predictor, seen, self.horizon, &mut |one| {
                    boxes += one.boxes.len();
                    found.push(one);
                });
                Cached {
                    who: seen.who,
                    past: seen.motions.to_vec(),
                    hypotheses: found,
                }
            })
            .collect();
        let less = |room: usize| Some(room.saturating_sub(boxes));
        let relaxed = Ordering::Relaxed;
        // The closure always gives a value.
        let _ = self.room.fetch_update(relaxed, relaxed, less);
        cached
    }
}

impl CachedStep<'_> {
    /// The hypotheses about an obstacle; `None` where it moved otherwise until now.
    pub fn hypotheses(&self, seen: &Observed<'_>) -> Option<&[Hypothesis]> {
        let cached = self.cached.iter().find(|cached| cached.who == seen.who)?;
        let obstacle = self.cache.scenario.obstacle(seen.who.id)?;
        let same =
            cached.past == seen.motions && obstacle.footprint_at(self.now) == Some(seen.footprint);
        same.then_some(&cached.hypotheses)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use nearmiss_formats::bundled;

    #[test]
    fn cached_forecasts_are_those_made_anew_also_of_an_obstacle_that_moves_otherwise() {
        let all = bundled();
        let entry = all.iter().find(|e| e.name.contains("Merge")).unwrap();
        let recorded = Arc::new(Scenario::clone(&entry.read().unwrap()));
        let mut changed = Scenario::clone(&recorded);
        // Two vehicles with each other's past.
        let [a, b, ..] = changed.obstacles.as_mut_slice() else {
            panic!("two obstacles");
        };
        std::mem::swap(&mut a.id, &mut b.id);
        let forecast = Forecast::Lane;
        let (horizon, last) = (20, 30);
        let cache = ForecastCache::new(recorded.clone(), forecast, None, horizon, (0, last));
        let mut boxes = 0;
        for scenario in [&*recorded, &changed] {
            for now in [0, 10, last, last + 5] {
                let anew = Forecaster::new(scenario, forecast, None);
                let cached = Forecaster::new(scenario, forecast, None).cached(Some(&cache));
                let traffic = anew.traffic(now, horizon);
                boxes += traffic.at(horizon).len();
                assert_eq!(cached.traffic(now, horizon), traffic, "step {now}");
            }
        }
        assert!(boxes > 0);
        let first = cache.at(10, horizon, Model::AlongLanes).unwrap();
        let past = Forecaster::new(&changed, forecast, None).past(10);
        let known: Vec<bool> = past
            .others()
            .iter()
            .map(|o| first.hypotheses(o).is_some())
            .collect();
        assert!(known.contains(&true) && known.contains(&false), "{known:?}");
        assert!(cache.at(10, horizon + 1, Model::AlongLanes).is_none());
        assert!(cache.at(last + 1, horizon, Model::AlongLanes).is_none());
        let full = ForecastCache {
            room: AtomicUsize::new(0),
            ..ForecastCache::new(recorded.clone(), forecast, None, horizon, (0, last))
        };
        let cached = Forecaster::new(&recorded, forecast, None).cached(Some(&full));
        let anew = Forecaster::new(&recorded, forecast, None);
        assert_eq!(cached.traffic(10, horizon), anew.traffic(10, horizon));
    }
}
