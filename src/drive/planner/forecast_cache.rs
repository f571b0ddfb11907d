//! Forecasts of obstacles that move as recorded, made once for the many drives of a search.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use super::forecast::{Forecast, Forecaster, hypotheses};
use super::traffic::{Body, Occupied};
use nearmiss_scene::scenario::prediction::{Model, Observed, Predictor, TrackedObject};
use nearmiss_scene::scenario::{Motion, Scenario};

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
    pub fn of(&self, seen: &Observed<'_>) -> Option<&[Hypothesis]> {
        let cached = self.cached.iter().find(|cached| cached.who == seen.who)?;
        let obstacle = self.cache.scenario.obstacle(seen.who.id)?;
        let same =
            cached.past == seen.motions && obstacle.footprint_at(self.now) == Some(seen.footprint);
        same.then_some(&cached.hypotheses)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
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
            .map(|o| first.of(o).is_some())
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
