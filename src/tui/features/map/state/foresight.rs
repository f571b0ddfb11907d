//! Predicted paths of an obstacle: those of the built-in judge, and constant velocity.

use std::sync::Arc;

use super::{Foreseen, On};
use nearmiss_base::geometry::Point;
use nearmiss_scene::judge::Criterion;
use nearmiss_scene::scenario::prediction::{Observed, ObservedHistory, Prediction, Predictor};
use nearmiss_scene::scenario::{Scene, Window};

/// Whose paths are "near": within this distance of the ego, metres, centre to centre, and no more than so many.
const NEAR: f64 = 40.0;
const MAX_PATHS: usize = 12;

/// Seconds between two points of a path.
const TICK: f64 = 0.2;

/// Less likely paths are not drawn, 0 to 1.
const MIN_PROBABILITY: f64 = 0.05;

/// The paths of one participant.
#[derive(Debug, Clone, PartialEq)]
pub struct Future {
    /// The ego or the obstacle.
    pub who: On,
    /// The predicted courses at the middle speed, each with its probability, the likeliest first.
    pub courses: Vec<(f64, Vec<Point>)>,
    /// Constant velocity: straight on as recorded at the step.
    pub straight: Vec<Point>,
}

/// A request for paths, from which everything else follows.
#[derive(Debug, Clone)]
pub struct PathRequest {
    scene: Arc<Scene>,
    step: i64,
    history: usize,
    whose: Foreseen,
    picked: Option<i64>,
}

impl PathRequest {
    fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene)
            && (self.step, self.history, self.whose) == (other.step, other.history, other.whose)
            && (self.picked == other.picked || self.whose == Foreseen::Near)
    }

    /// Predicts the paths, as the built-in judge does.
    #[must_use]
    pub fn predict(&self) -> Vec<Future> {
        futures(self)
    }
}

/// The paths into the future at one step.
#[derive(Debug, Default)]
pub struct Foresight {
    requested: Option<PathRequest>,
    /// Whose paths are drawn, with them.
    pub futures: Vec<Future>,
}

/// No paths.
pub static NO_FORESIGHT: Foresight = Foresight {
    requested: None,
    futures: Vec::new(),
};

impl Foresight {
    /// How far ahead the paths go, seconds: as far as the built-in judge looks.
    pub const HORIZON: f64 = Criterion::REFERENCE.horizon;

    /// A request for the paths that are to be shown, unless it was made before. Paths of the step before stay until the
    /// new ones arrive; those of another scene or selection go.
    pub fn request(
        &mut self,
        scene: Option<&Arc<Scene>>,
        step: i64,
        history: usize,
        whose: Foreseen,
        picked: Option<i64>,
    ) -> Option<PathRequest> {
        let Some(scene) = scene.filter(|_| whose != Foreseen::Off) else {
            *self = Self::default();
            return None;
        };
        let request = PathRequest {
            scene: scene.clone(),
            step,
            history,
            whose,
            picked,
        };
        if let Some(before) = &self.requested {
            if before.is(&request) {
                return None;
            }
            let moved = PathRequest {
                step: before.step,
                ..request.clone()
            };
            if !before.is(&moved) {
                self.futures.clear();
            }
        }
        self.requested = Some(request.clone());
        Some(request)
    }

    /// Takes paths, if nothing newer was requested.
    pub fn take(&mut self, request: &PathRequest, futures: Vec<Future>) {
        if self.requested.as_ref().is_some_and(|now| now.is(request)) {
            self.futures = futures;
        }
    }
}

fn futures(asked: &PathRequest) -> Vec<Future> {
    let window = Window::ending_at(&asked.scene, asked.step, asked.history);
    let past = ObservedHistory::from_window(&asked.scene, &window);
    let mut predictor = Predictor::new(&past, Criterion::REFERENCE.model);
    let mut future = |who, seen: &Observed<'_>| Future {
        who,
        courses: courses(&predictor.predict(seen, Foresight::HORIZON)),
        straight: straight(seen),
    };
    let obstacle = |o: &Observed<'_>| On::Obstacle(o.who.id);
    if asked.whose == Foreseen::Picked {
        let picked = past
            .others()
            .iter()
            .filter(|o| Some(o.who.id) == asked.picked);
        return picked.map(|o| future(obstacle(o), o)).collect();
    }
    let Some(ego) = past.ego() else {
        return Vec::new();
    };
    let away = |o: &Observed<'_>| (o.motion.pose.position - ego.motion.pose.position).norm();
    let moving = past.others().iter().filter(|o| !o.who.parked);
    let mut near: Vec<_> = moving
        .map(|o| (away(o), o))
        .filter(|(d, _)| *d <= NEAR)
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.truncate(MAX_PATHS);
    let mut found = vec![future(On::Ego, ego)];
    found.extend(near.into_iter().map(|(_, o)| future(obstacle(o), o)));
    found
}

fn moments() -> impl Iterator<Item = f64> {
    let count = (Foresight::HORIZON / TICK).round() as usize;
    (0..=count).map(|k| k as f64 * TICK)
}

fn courses(prediction: &Prediction) -> Vec<(f64, Vec<Point>)> {
    // The speeds are equally likely and in order.
    let Some(speeds) = prediction.speeds.get(prediction.speeds.len() / 2) else {
        return Vec::new();
    };
    let likely = prediction
        .courses
        .iter()
        .filter(|c| c.weight >= MIN_PROBABILITY);
    let mut found: Vec<(f64, Vec<Point>)> = likely
        .map(|course| {
            let at = |t| course.path.pose_at(speeds.distance(t)).position;
            (course.weight, moments().map(at).collect())
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
}

fn straight(seen: &Observed<'_>) -> Vec<Point> {
    let (from, velocity) = (seen.motion.pose.position, seen.motion.velocity_vector());
    let moving = if seen.who.parked { 0.0 } else { 1.0 };
    moments().map(|t| from + velocity * (t * moving)).collect()
}
