//! Which obstacles begin to react at a step, and the way that they have before them.

use super::course::Course;
use super::idm::Idm;
use super::neighbour::Neighbour;
use super::reacting::Reacting;
use super::trigger::{Follower, HORIZON, touch};
use super::world::Reactive;
use nearmiss_base::geometry::Placed;
use nearmiss_scene::scenario::prediction::{Model, ObservedHistory, Path, Predictor};
use nearmiss_scene::scenario::{Motion, Obstacle, ObstacleRole};

/// A body that is no farther than this from where it was recorded, metres, and no faster or slower by more than this,
/// m/s, moves as it was recorded.
const AS_RECORDED: f64 = 0.5;

/// The lane beyond the recording is followed so far, metres; beside all lanes one goes straight on.
const BEYOND: f64 = 300.0;
const STRAIGHT_ON: f64 = 100.0;

/// Seconds of a recording whose last part says which lane is followed.
const MEMORY: f64 = 1.0;

impl Reactive<'_> {
    /// The obstacles that begin to react at a step, by place: those that the ego concerns, or one that reacts already.
    pub fn begin_at(&self, step: i64, ego: &Neighbour<'_>) -> Vec<(usize, Reacting)> {
        let reacting = self.reacting.keys();
        let reacting: Vec<Neighbour<'_>> = reacting
            .filter_map(|place| self.neighbour(*place, step))
            .collect();
        let places = (0..self.scenario.obstacles.len()).filter(|p| !self.reacting.contains_key(p));
        let begins = places.filter(|place| {
            let others = std::iter::once(ego).chain(&reacting);
            self.follower(*place, step).is_some_and(|follower| {
                { others }.any(|other| {
                    follower.is_concerned(other) && !self.is_as_recorded(&follower, other)
                })
            })
        });
        begins
            .filter_map(|place| Some((place, self.begin(place, step)?)))
            .collect()
    }

    /// An obstacle that follows its recording on from a step.
    fn follower(&self, place: usize, step: i64) -> Option<Follower<'_>> {
        let obstacle = self.body(place)?;
        let moves = obstacle.role == ObstacleRole::Dynamic;
        obstacle.track().at(step + 1).filter(|_| moves)?;
        Some(Follower {
            obstacle,
            course: self.course(place)?,
            step,
            dt: self.driver.dt(),
            idm: Idm::of(obstacle.kind),
        })
    }

    /// Whether another body moves as it was recorded, and the recording goes well: then what is expected of it is wrong,
    /// and the recording is right.
    fn is_as_recorded(&self, follower: &Follower<'_>, other: &Neighbour<'_>) -> bool {
        let steps = (HORIZON / follower.dt).round() as i64;
        let recorded = |step| self.recorded(other, step);
        let Some((motion, _)) = recorded(follower.step) else {
            return false;
        };
        let apart = (motion.pose.position - other.body.pose.position).norm();
        if apart > AS_RECORDED || (motion.velocity - other.speed).abs() > AS_RECORDED {
            return false;
        }
        (follower.step..=follower.step + steps).all(|step| {
            let own = follower.obstacle.placed_at(step);
            let (Some(own), Some((_, there))) = (own, recorded(step)) else {
                return true;
            };
            !touch(&own, &there)
        })
    }

    /// The recorded motion and body of the ego or an obstacle.
    fn recorded(&self, who: &Neighbour<'_>, step: i64) -> Option<(Motion, Placed<'_>)> {
        match who.place {
            Some(place) => {
                let obstacle: &Obstacle = &self.scenario.obstacles[place];
                Some((*obstacle.motion_at(step)?, obstacle.placed_at(step)?))
            }
            None => {
                let scene = self.driver.recorded()?;
                Some((*scene.ego.track.at(step)?, scene.ego_at(step)?))
            }
        }
    }

    fn begin(&self, place: usize, step: i64) -> Option<Reacting> {
        let course = self.onward(place, self.course(place)?.clone());
        let obstacle = &self.scenario.obstacles[place];
        Reacting::new(obstacle, course, step, self.driver.dt())
    }

    /// A recorded way with what comes after it: the lane that it leads to, or straight on beside all lanes.
    fn onward(&self, place: usize, course: Course) -> Course {
        let obstacle = &self.scenario.obstacles[place];
        let last = obstacle.track().steps().end - 1;
        let memory = (MEMORY / self.driver.dt()).round() as i64;
        let past = ObservedHistory::of_traffic(self.scenario, last - memory..=last, None);
        let seen = past.others().iter().find(|seen| seen.who.id == obstacle.id);
        let lane = seen.and_then(|seen| {
            let mut predictor = Predictor::new(&past, Model::AlongLanes);
            predictor.likeliest_lane(seen, BEYOND)
        });
        let Some(end) = course.last().copied() else {
            return course;
        };
        match lane {
            Some(line) => {
                let left = line.length() - line.project(&end.position).s;
                course.continued(Path::along(line, &end), left.min(BEYOND))
            }
            None => course.continued(Path::Straight(end), STRAIGHT_ON),
        }
    }
}
