//! Scenes turned, mirrored, moved or with other numbers: what happens stays the same; changes in words.

mod contents;
mod plane;

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use nearmiss_base::geometry::{Point, Vector};

use super::{ContentHash, EgoSource, Scenario, Scene};
use plane::Plane;

pub use plane::in_frame;

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
            Self::Renumber(_) => contents::renumbered(scene, &ids),
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
            Self::Renumber(seed) => contents::ids(scenario, *seed),
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

/// A text that names no change of a scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "invalid transform `{text}`: {why}; available: rotate:DEGREES, mirror, move:X,Y (metres), renumber:SEED"
)]
pub struct TransformError {
    /// What was said, at most 40 characters of it.
    pub text: String,
    /// What is wrong with it.
    pub why: &'static str,
}

/// Largest rotation, degrees.
const MOST_DEGREES: f64 = 360.0;

/// Farther from the origin less than a micrometre would be told apart, metres.
const FARTHEST: f64 = 1e6;

impl FromStr for Transform {
    type Err = TransformError;

    fn from_str(text: &str) -> Result<Self, TransformError> {
        let (kind, values) = match text.trim().split_once(':') {
            Some((kind, values)) => (kind, Some(values)),
            None => (text.trim(), None),
        };
        let wrong = |why| TransformError {
            text: text.chars().take(40).collect(),
            why,
        };
        let number = |text: &str, most: f64| {
            let number = text.trim().parse::<f64>().ok();
            number.filter(|n| n.abs() <= most)
        };
        match (kind, values) {
            ("mirror", None) => Ok(Self::Mirror),
            ("mirror", Some(_)) => Err(wrong("mirror takes no value")),
            ("rotate", Some(degrees)) => match number(degrees, MOST_DEGREES) {
                Some(degrees) => Ok(Self::Rotate(degrees.to_radians())),
                None => Err(wrong("expected degrees from -360 to 360")),
            },
            ("move", Some(values)) => {
                let values = values
                    .split_once(',')
                    .map(|(x, y)| (number(x, FARTHEST), number(y, FARTHEST)));
                match values {
                    Some((Some(x), Some(y))) => Ok(Self::Move(x, y)),
                    _ => Err(wrong("expected two numbers of at most 1000000 metres")),
                }
            }
            ("renumber", Some(seed)) => match seed.trim().parse() {
                Ok(seed) => Ok(Self::Renumber(seed)),
                Err(_) => Err(wrong("expected a non-negative whole number")),
            },
            ("rotate" | "move" | "renumber", None) => Err(wrong("expected a value after a colon")),
            _ => Err(wrong("unknown name")),
        }
    }
}

impl fmt::Display for Transform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // Radians are not as round as the degrees they were made from.
            Self::Rotate(angle) => {
                write!(f, "rotate:{}", (angle.to_degrees() * 1e9).round() / 1e9)
            }
            Self::Mirror => f.write_str("mirror"),
            Self::Move(x, y) => write!(f, "move:{x},{y}"),
            Self::Renumber(seed) => write!(f, "renumber:{seed}"),
        }
    }
}

impl Transform {
    /// The name under which answers about the changed scene are kept: the scenario's name, and the change in brackets.
    #[must_use]
    pub fn name(&self, scenario: &str) -> String {
        format!("{scenario} [{self}]")
    }

    /// A name taken apart: that of the scenario, and the change if it has one.
    #[must_use]
    pub fn of_name(name: &str) -> (&str, Option<Self>) {
        let parts = name
            .strip_suffix(']')
            .and_then(|rest| rest.rsplit_once(" ["));
        match parts.map(|(scenario, change)| (scenario, change.parse().ok())) {
            Some((scenario, Some(change))) => (scenario, Some(change)),
            _ => (name, None),
        }
    }
}

impl nearmiss_record::fields::Word for Transform {
    /// A move has a comma between its numbers.
    const SEPARATORS: &'static [char] = &[';', ' '];

    fn of_word(word: &str) -> Result<Self, String> {
        word.parse().map_err(|error: TransformError| {
            let hint = if word.contains(',') {
                "; several are separated by semicolons or spaces"
            } else {
                ""
            };
            format!("{error}{hint}")
        })
    }

    fn word(&self) -> String {
        self.to_string()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    #[test]
    fn what_is_written_reads_back() {
        for text in [
            "rotate:90",
            "rotate:-37.25",
            "rotate:0.1",
            "mirror",
            "move:1000,-500",
            "move:0.5,0",
            "renumber:1",
            "renumber:18446744073709551615",
        ] {
            let read: Transform = text.parse().unwrap();
            assert_eq!(read.to_string(), text);
            assert_eq!(read.to_string().parse::<Transform>().unwrap(), read);
            let name = read.name("DEU_Bremen-1_10_T-1");
            assert_eq!(
                Transform::of_name(&name),
                ("DEU_Bremen-1_10_T-1", Some(read))
            );
        }
        assert_eq!(Transform::of_name("A [b]"), ("A [b]", None));
        assert_eq!(Transform::of_name("A"), ("A", None));
    }

    #[test]
    fn what_is_no_change_is_refused_with_the_reason() {
        for (text, why) in [
            ("rotate", "after a colon"),
            ("rotate:NaN", "degrees"),
            ("rotate:400", "degrees"),
            ("mirror:x", "takes no value"),
            ("move:1", "two numbers"),
            ("move:1,inf", "two numbers"),
            ("renumber:-1", "non-negative"),
            ("shear:1", "unknown name"),
            ("", "unknown name"),
        ] {
            let error = text.parse::<Transform>().unwrap_err().to_string();
            assert!(
                error.contains(why) && error.contains("rotate:DEGREES"),
                "{error}"
            );
        }
    }
}
