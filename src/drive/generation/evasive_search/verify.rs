//! Verifies an evasive trajectory: it touches no obstacle, and the vehicle can drive it.

use super::super::certificate::{EvasiveTrajectory, Finder};
use super::Search;
use crate::planner::{Feasibility, VehicleState};
use crate::simulation::{Collision, Look, Outcome, Rollout};
use nearmiss_base::geometry::Pose;

/// After the evasive trajectory the ego must be able to drive on this long (s) at one of these accelerations (m/s²).
const GOING_ON: f64 = 2.0;
const GOING_ON_WITH: [f64; 4] = [-8.0, -3.0, 0.0, 3.0];

impl Search<'_> {
    /// Whether a finished trajectory touches no obstacle, stays on the road, gets to its end, and can be driven from
    /// step `reaction` on.
    pub fn verify(&self, avoidance: &EvasiveTrajectory, reaction: i64) -> bool {
        let driver = self.closed.driver();
        let drive = &avoidance.drive;
        let mut look = Look::new(driver, self.scenario, self.goal_from);
        let mut goal = None;
        for (step, state) in &drive.states {
            match look.at(*step, state) {
                Some(Outcome::Goal(_)) => goal = Some(*step),
                Some(_) => return false,
                None => {}
            }
        }
        let end = drive.states.last().map(|(step, _)| *step);
        let arrived = end.is_some_and(|end| end >= self.last) || goal == end;
        // The unchanged drive may be over before: then there is nothing to avoid.
        let over = avoidance.found == Finder::Unchanged;
        let changed = drive.states.iter().filter(|(step, _)| *step >= reaction);
        let changed: Vec<VehicleState> = changed.map(|(_, state)| *state).collect();
        let check = Feasibility::new(*driver.limits(), driver.dt());
        (arrived || over)
            && check.states(reaction, &changed).is_ok()
            && (over || self.can_go_on(drive))
    }

    /// Whether an ego that ends here does not end right before a bumper: straight on, with one of a few accelerations,
    /// no obstacle is touched for a while.
    fn can_go_on(&self, drive: &Rollout) -> bool {
        let Some((end, state)) = drive.states.last() else {
            return false;
        };
        let driver = self.closed.driver();
        let (dt, limits, without) = (driver.dt(), driver.limits(), driver.settings().without);
        let later = (GOING_ON / dt).round() as i64;
        let start = state.centre(limits);
        GOING_ON_WITH.iter().any(|acceleration| {
            let (mut s, mut v, mut before) = (0.0, start.velocity, start.pose);
            (1..=later).all(|k| {
                let next = (v + acceleration * dt).clamp(0.0, limits.speed);
                s += f64::midpoint(v, next) * dt;
                v = next;
                let pose = Pose {
                    position: start.pose.position + start.pose.forward() * s,
                    ..start.pose
                };
                let body = driver.road().body().at(pose);
                let was = Some(std::mem::replace(&mut before, pose));
                Collision::first(self.scenario, &body, was, end + k, without).is_none()
            })
        })
    }
}
