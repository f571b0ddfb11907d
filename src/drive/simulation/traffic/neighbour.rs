//! A body on the road now, and where it is expected to be soon.

use super::course::Course;
use nearmiss_base::geometry::{Placed, Pose};
use nearmiss_scene::scenario::prediction::Path;

/// A road user, or a thing, as the others see it at one step.
#[derive(Debug, Clone)]
pub struct Neighbour<'a> {
    /// Its place in the file's order; `None` for the ego.
    pub place: Option<usize>,
    /// Its body.
    pub body: Placed<'a>,
    /// m/s along its way.
    pub speed: f64,
    /// m/s² along its way.
    pub acceleration: f64,
    /// Its way.
    pub way: Way<'a>,
}

/// The way that a body is expected to take.
#[derive(Debug, Clone)]
pub enum Way<'a> {
    /// Straight on.
    Straight,
    /// Along a path that begins where it is.
    Path(Path),
    /// Along a course, from this distance on.
    Course(&'a Course, f64),
}

/// How a body is expected to go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Expected {
    /// As fast as now.
    Steady,
    /// Braking as it does now, to a stop.
    Braking,
}

impl<'a> Neighbour<'a> {
    /// Its body after so many seconds.
    #[must_use]
    pub fn after(&self, seconds: f64, expected: Expected) -> Placed<'a> {
        let distance = self.distance(seconds, expected);
        let pose = match &self.way {
            _ if distance == 0.0 => self.body.pose,
            Way::Straight => Pose {
                position: self.body.pose.position + self.body.pose.forward() * distance,
                ..self.body.pose
            },
            Way::Path(path) => path.pose_at(distance),
            Way::Course(course, s) => course.pose_at(s + distance),
        };
        self.body.footprint.at(pose)
    }

    /// Metres that it is expected to drive within so many seconds.
    fn distance(&self, seconds: f64, expected: Expected) -> f64 {
        if expected == Expected::Steady || self.acceleration >= 0.0 || self.speed <= 0.0 {
            return self.speed * seconds;
        }
        let time = seconds.min(-self.speed / self.acceleration);
        time * (self.speed + self.acceleration * time / 2.0)
    }
}
