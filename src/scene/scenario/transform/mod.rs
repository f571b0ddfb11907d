//! Scenes turned, mirrored, moved or with other numbers: what happens stays the same, only how it is written differs.

mod plane;
mod renumber;
mod road;
mod states;
mod traffic;
mod words;

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{ContentHash, EgoSource, Scenario, Scene};
use nearmiss_base::geometry::{Point, Vector};
use plane::Plane;

pub use plane::in_frame;
pub use words::TransformError;

/// A change of a scene that changes nothing about how dangerous it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transform {
    /// Turned counter-clockwise about the middle of the road by so many radians.
    Rotate(f64),
    /// Mirrored at the x axis: left becomes right, and who drove on the right drives on the left.
    Mirror,
    /// Shifted by so many metres along x and y.
    Move(f64, f64),
    /// The obstacles have each other's ids, in an order that the seed decides; see [`Transform::ids`].
    Renumber(u64),
}

/// A scene after a [`Transform`].
#[derive(Debug, Clone, PartialEq)]
pub struct Transformed {
    /// The scene.
    pub scene: Scene,
    /// From the ids of its obstacles to those of the original.
    pub ids: BTreeMap<i64, i64>,
}

impl Transformed {
    /// The original's id of an obstacle; one that no obstacle has stays as it is.
    #[must_use]
    pub fn original(&self, id: i64) -> i64 {
        self.ids.get(&id).copied().unwrap_or(id)
    }
}

impl Transform {
    /// The scene after this change: road, markings, signs, lights, obstacles, plans and ego.
    ///
    /// An interval of a velocity along the world's axes becomes the smallest one that holds it, and a truck as a region
    /// of the world becomes its boxes. How the map lies on the Earth is forgotten where the map is moved. The
    /// scenario's hash becomes one of the original's and of the change. Where two roads of a crossing are said to be
    /// left of the same third one, its mirror image can name only the first of them. Whether a sign is known to have
    /// a mirror image is up to a table; the rule of right before left stays.
    #[must_use]
    pub fn apply(&self, scene: &Scene) -> Transformed {
        let ids = self.ids(&scene.scenario);
        let mut changed = match self {
            Self::Renumber(_) => renumber::renumbered(scene, &ids),
            _ => placed(scene, &self.plane(scene)),
        };
        let text = format!("{} {self}", scene.scenario.hash);
        Arc::make_mut(&mut changed.scenario).hash = ContentHash::digest(text.as_bytes());
        Transformed {
            scene: changed,
            ids,
        }
    }

    /// From the ids that the obstacles of a scenario have afterwards to those that they have in it.
    #[must_use]
    pub fn ids(&self, scenario: &Scenario) -> BTreeMap<i64, i64> {
        match self {
            Self::Renumber(seed) => renumber::ids(scenario, *seed),
            _ => scenario.obstacles.iter().map(|o| (o.id, o.id)).collect(),
        }
    }

    fn plane(&self, scene: &Scene) -> Plane {
        match *self {
            Self::Rotate(angle) => Plane::turn(angle, centre(scene)),
            Self::Mirror => Plane::mirror(),
            Self::Move(x, y) => Plane::shift(Vector::new(x, y)),
            Self::Renumber(_) => Plane::shift(Vector::zeros()),
        }
    }
}

/// The mean of the points of the road's borders, without a road that of the ego's places: it goes with the scene
/// wherever that is turned or moved, which the middle of a box around it would not.
fn centre(scene: &Scene) -> Point {
    let lanelets = &scene.scenario.network.lanelets;
    let road = lanelets
        .iter()
        .flat_map(|l| [&l.left, &l.right])
        .flat_map(|bound| bound.points.iter().copied());
    let ego = || scene.ego.track.iter().map(|(_, m)| m.pose.position);
    mean(road)
        .or_else(|| mean(ego()))
        .unwrap_or(Point::origin())
}

fn mean(points: impl Iterator<Item = Point>) -> Option<Point> {
    let (sum, count) = points.fold((Vector::zeros(), 0_u32), |(sum, count), p| {
        (sum + p.coords, count + 1)
    });
    (count > 0).then(|| Point::from(sum / f64::from(count)))
}

fn placed(scene: &Scene, plane: &Plane) -> Scene {
    let before = &*scene.scenario;
    let dt = before.dt();
    let obstacles = before.obstacles.iter();
    let problems = before.planning_problems.iter();
    let mut location = before.location.clone();
    if let Some(location) = &mut location {
        location.transformation = None;
    }
    let scenario = Arc::new(Scenario {
        header: before.header.clone(),
        location,
        tags: before.tags.clone(),
        network: plane.network(&before.network),
        obstacles: obstacles.map(|o| plane.obstacle(o, dt)).collect(),
        planning_problems: problems.map(|p| plane.problem(p)).collect(),
        recorded_ego: None,
        diagnostics: before.diagnostics.clone(),
        hash: before.hash,
    });
    let mut ego = plane.ego(&scene.ego, dt);
    if let EgoSource::Obstacle(id) = ego.source {
        // The two are one vehicle, to the last digit.
        if let Some(obstacle) = scenario.obstacle(id) {
            ego.track = obstacle.track().clone();
        }
    }
    Scene::new(scenario, ego)
}
