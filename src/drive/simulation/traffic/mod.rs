//! Traffic that reacts: obstacles follow their recording until the ego's deviation concerns them, then they drive their
//! recorded path with the Intelligent Driver Model.
//!
//! An obstacle begins to react at the step at which its recorded motion leads into the ego (or into an obstacle that
//! reacts) and comfortable braking would no longer be enough a step later, see `trigger`. From then on it stays on its
//! recorded path, and on the lane beyond its end (`course`), wants to drive as fast as was recorded at each place
//! (`desired`), and keeps its distance to whatever body is on its path or reaches a crossing first (`leader`), within
//! the limits of people ([`HumanLimits`](nearmiss_scene::scenario::HumanLimits)). Nothing is random, and nothing looks into the
//! future of another road user: where it will be is taken from its path and present speed.

mod course;
mod reacting;

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use nearmiss_base::geometry::Polyline;
use nearmiss_scene::scenario::prediction::Path;
use nearmiss_scene::scenario::{Obstacle, ObstacleRole, Scenario};
use strum::{IntoStaticStr, VariantArray};

use crate::planner::{Forecast, VehicleState};
use crate::simulation::{ContactSide, Driver, Outcome, Rollout};
use course::{Course, ExpectedPath, MAX_LENGTH, Neighbour};
pub(super) use reacting::Idm;
use reacting::Reacting;

/// What the other road users do while the ego is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum TrafficMode {
    /// What was recorded, whatever the ego does.
    #[default]
    Recorded,
    /// What was recorded until the ego's deviation concerns them; then they react.
    Reactive,
}

nearmiss_record::named!(TrafficMode, "traffic");

/// The others in one drive; what they did is in the drive.
#[derive(Debug)]
pub(super) struct World<'a> {
    reactive: Option<Reactive<'a>>,
}

/// Others that can react.
#[derive(Debug)]
struct Reactive<'a> {
    pub driver: &'a Driver,
    /// As recorded.
    pub scenario: &'a Scenario,
    /// The middle of the ego's way.
    guide: Option<Arc<Polyline>>,
    /// Recorded ways of obstacles, by place in the file's order, once they are asked for.
    courses: Vec<OnceCell<Option<Course>>>,
    /// Those that react, by place.
    pub reacting: BTreeMap<usize, Reacting>,
    /// Steps after now that forecasts are told.
    told: usize,
}

impl<'a> World<'a> {
    /// The traffic of `scenario` at the beginning of a drive.
    pub fn new(driver: &'a Driver, scenario: &'a Scenario) -> Self {
        let reactive = driver.settings().traffic == TrafficMode::Reactive;
        Self {
            reactive: reactive.then(|| Reactive::new(driver, scenario)),
        }
    }

    /// Moves the others on to the last step of a drive, from the one before.
    pub fn advance(&mut self, drive: &mut Rollout) {
        if let Some(reactive) = &mut self.reactive {
            reactive.advance(drive);
        }
    }

    /// Ends a drive.
    pub fn finish(&self, drive: &mut Rollout) {
        if let Some(reactive) = &self.reactive {
            reactive.finish(drive);
        }
    }
}

impl<'a> Reactive<'a> {
    fn new(driver: &'a Driver, scenario: &'a Scenario) -> Self {
        let settings = driver.settings();
        let path = &driver.guide().path;
        let points = (0..=path.length().min(MAX_LENGTH).ceil() as usize)
            .map(|s| path.pose_at(s as f64).position);
        Self {
            driver,
            scenario,
            guide: Polyline::new(points).map(Arc::new),
            courses: scenario.obstacles.iter().map(|_| OnceCell::new()).collect(),
            reacting: BTreeMap::new(),
            told: match settings.forecast {
                Forecast::Recorded => settings.planner.steps(driver.dt()),
                Forecast::ConstantVelocity | Forecast::Lane => 0,
            },
        }
    }

    fn advance(&mut self, drive: &mut Rollout) {
        let [.., (step, state), _] = drive.states[..] else {
            return;
        };
        let ego = self.ego(&state);
        for (place, reacting) in self.begin_at(step, &ego) {
            self.reacting.insert(place, reacting);
            drive.traffic.reactions.push(Reaction {
                obstacle: self.scenario.obstacles[place].id,
                from: step,
            });
        }
        if self.reacting.is_empty() {
            return;
        }
        let dt = self.driver.dt();
        let others = self.neighbours(step, ego);
        let decide = |(place, reacting): (&usize, &Reacting)| {
            let body = self.scenario.obstacles[*place].footprint.as_ref()?;
            let decided = reacting.decide(*place, body, &others, dt);
            (!reacting.is_gone()).then_some((*place, decided))
        };
        let decided: Vec<(usize, f64)> = self.reacting.iter().filter_map(decide).collect();
        let mut world = drive
            .traffic
            .scenario
            .take()
            .unwrap_or_else(|| Arc::new(self.scenario.clone()));
        let changed = Arc::make_mut(&mut world);
        for (place, acceleration) in decided {
            let Some(reacting) = self.reacting.get_mut(&place) else {
                continue;
            };
            reacting.go_on(acceleration, dt);
            let motions = if reacting.is_gone() {
                reacting.motions[..reacting.motions.len() - 1].to_vec()
            } else {
                reacting.foreseen(self.told, dt)
            };
            let obstacle = &self.scenario.obstacles[place];
            if let Some(departed) = obstacle.departing(&motions, dt) {
                changed.obstacles[place] = departed;
            }
        }
        drive.traffic.scenario = Some(world);
    }

    /// What the others did in a drive that is over: what forecasts were told beyond its end is no part of it.
    fn finish(&self, drive: &mut Rollout) {
        if self.told == 0 {
            return;
        }
        let Some(mut world) = drive.traffic.scenario.take() else {
            return;
        };
        let changed = Arc::make_mut(&mut world);
        for (place, reacting) in self.reacting.iter().filter(|(_, r)| !r.is_gone()) {
            let obstacle = &self.scenario.obstacles[*place];
            if let Some(departed) = obstacle.departing(&reacting.motions, self.driver.dt()) {
                changed.obstacles[*place] = departed;
            }
        }
        drive.traffic.scenario = Some(world);
    }

    /// The ego as the others see it: on its way to the goal.
    fn ego(&self, state: &VehicleState) -> Neighbour<'a> {
        let motion = state.centre(self.driver.limits());
        let way =
            |line: &Arc<Polyline>| ExpectedPath::Path(Path::along(Arc::clone(line), &motion.pose));
        Neighbour {
            place: None,
            body: self.driver.road().body().at(motion.pose),
            speed: motion.velocity,
            acceleration: motion.acceleration,
            way: self.guide.as_ref().map_or(ExpectedPath::Straight, way),
        }
    }

    /// All bodies at a step.
    fn neighbours<'b>(&'b self, step: i64, ego: Neighbour<'b>) -> Vec<Neighbour<'b>> {
        let places = 0..self.scenario.obstacles.len();
        let others = places.filter_map(|place| self.neighbour(place, step));
        std::iter::once(ego).chain(others).collect()
    }

    /// An obstacle at a step, where it has a body there.
    pub fn neighbour(&self, place: usize, step: i64) -> Option<Neighbour<'_>> {
        let obstacle = self.body(place)?;
        if let Some(reacting) = self.reacting.get(&place) {
            let (_, motion) = reacting.motions.last()?;
            let body = obstacle.footprint.as_ref()?.at(motion.pose);
            return (!reacting.is_gone()).then_some(Neighbour {
                place: Some(place),
                body,
                speed: reacting.v,
                acceleration: reacting.a,
                way: ExpectedPath::Course(&reacting.course, reacting.s),
            });
        }
        let motion = obstacle.motion_at(step)?;
        let moves = obstacle.role == ObstacleRole::Dynamic;
        let course = self
            .course(place)
            .filter(|_| moves)
            .and_then(|course| Some((course, course.at_step(step)?)));
        Some(Neighbour {
            place: Some(place),
            body: obstacle.placed_at(step)?,
            speed: if moves { motion.velocity } else { 0.0 },
            acceleration: if moves { motion.acceleration } else { 0.0 },
            way: course.map_or(ExpectedPath::Straight, |(course, s)| {
                ExpectedPath::Course(course, s)
            }),
        })
    }

    /// An obstacle that has a body and is not the ego itself.
    pub fn body(&self, place: usize) -> Option<&'a Obstacle> {
        let obstacle = &self.scenario.obstacles[place];
        let solid = matches!(obstacle.role, ObstacleRole::Static | ObstacleRole::Dynamic);
        (solid && Some(obstacle.id) != self.driver.settings().without).then_some(obstacle)
    }

    /// The recorded way of an obstacle.
    pub fn course(&self, place: usize) -> Option<&Course> {
        let made = || Course::recorded(self.scenario.obstacles[place].track());
        self.courses[place].get_or_init(made).as_ref()
    }
}

/// The others during a drive.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DrivenTraffic {
    /// The scenario as it was driven, where an obstacle reacted; else all drove as recorded. Obstacles that reacted have
    /// no motion after the last step of the drive.
    pub scenario: Option<Arc<Scenario>>,
    /// Which obstacles reacted, in order of time.
    pub reactions: Vec<Reaction>,
}

/// An obstacle that reacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reaction {
    /// Its id.
    pub obstacle: i64,
    /// The step of its last recorded state; it reacts from the next one on.
    pub from: i64,
}

/// Traffic that drove into the ego's rear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum HitFromBehind {
    /// It followed its recording, and knew nothing of the ego: such a contact says little about the ego.
    Unaware,
    /// It reacted, too late.
    Reacting,
}

nearmiss_record::named!(HitFromBehind);

impl Rollout {
    /// The scenario as it was driven, of a drive through `recorded`.
    #[must_use]
    pub fn scenario_in<'a>(&'a self, recorded: &'a Scenario) -> &'a Scenario {
        self.traffic.scenario.as_deref().unwrap_or(recorded)
    }

    /// Whether an obstacle drove into the ego's rear with its front, and whether it reacted to the ego.
    #[must_use]
    pub fn hit_from_behind(&self) -> Option<HitFromBehind> {
        let Outcome::Collision(collision) = self.outcome else {
            return None;
        };
        if collision.ego != ContactSide::Rear || collision.other != ContactSide::Front {
            return None;
        }
        let mut reactions = self.traffic.reactions.iter();
        Some(if reactions.any(|r| r.obstacle == collision.with) {
            HitFromBehind::Reacting
        } else {
            HitFromBehind::Unaware
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
