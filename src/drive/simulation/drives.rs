//! Drives of a problem: all of it or a stretch, watched, controlled, or taking over what another drive has planned.

use nearmiss_base::geometry::angle_between;
use nearmiss_scene::scenario::{Motion, Scenario, Track};

use super::{
    Collision, Cycle, DriveSpan, DrivenTraffic, Driver, EndOfDriveCheck, Outcome, ResumableRollout,
    Rollout,
};
use crate::planner::{Planner, VehicleState};

/// What is wrong with a motion through a scenario.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum MotionFault {
    /// It touches an obstacle.
    #[error("touches {0}")]
    Contact(Collision),
    /// It leaves the road at a step.
    #[error("leaves the road at step {0}")]
    OffRoad(i64),
}

/// Below this way (m) in a step the heading tells nothing about the steering.
const MIN_MOVE: f64 = 0.01;

impl Driver {
    /// Drives a stretch, and shows each cycle with its planner to `watch`; where that says no, the drive is a time-out
    /// there.
    pub fn drive_watched(
        &self,
        scenario: &Scenario,
        stretch: &DriveSpan,
        watch: &mut dyn FnMut(&Planner<'_>, &Cycle) -> bool,
    ) -> Rollout {
        self.run(scenario, stretch, None, Some(watch), &mut |_| {
            Control::Follow
        })
        .drive
    }

    /// A motion of the vehicle's centre as a drive in recorded traffic, from the problem's start on: it ends as a planned
    /// one would, without a cycle.
    #[must_use]
    pub fn along(&self, scenario: &Scenario, track: &Track) -> Rollout {
        let span = self.full_span();
        let mut look = EndOfDriveCheck::new(self, scenario, span.goal_from);
        let mut drive = Rollout {
            states: Vec::new(),
            cycles: Vec::new(),
            outcome: Outcome::Timeout,
            traffic: DrivenTraffic::default(),
            limits: *self.limits(),
            dt: self.dt(),
            external: None,
        };
        let mut before: Option<Motion> = None;
        for (step, motion) in track.iter() {
            if step < span.step || step > span.last {
                continue;
            }
            let turn = before.map_or(0.0, |before| {
                let way = (motion.pose.position - before.pose.position).norm();
                let turned = angle_between(before.pose.heading, motion.pose.heading);
                if way > MIN_MOVE { turned / way } else { 0.0 }
            });
            before = Some(*motion);
            let state = VehicleState::of_centre(motion, turn, self.limits());
            drive.states.push((step, state));
            if let Some(outcome) = look.at(step, &state) {
                drive.outcome = outcome;
                break;
            }
        }
        drive
    }

    /// What is wrong with a motion of the vehicle's centre in `scenario`: the first contact with an obstacle, at a step
    /// or between two, or that it leaves the road that it was on.
    #[must_use]
    pub fn fault_of(&self, scenario: &Scenario, track: &Track) -> Option<MotionFault> {
        // A goal ends nothing here.
        let mut look = EndOfDriveCheck::new(self, scenario, i64::MAX);
        track.iter().find_map(|(step, motion)| {
            let state = VehicleState::of_centre(motion, 0.0, self.limits());
            match look.at(step, &state) {
                Some(Outcome::Collision(contact)) => Some(MotionFault::Contact(contact)),
                Some(Outcome::OffRoad) => Some(MotionFault::OffRoad(step)),
                _ => None,
            }
        })
    }

    /// Drives the whole problem under a control, which is asked at every step before it, perhaps more than once, and
    /// sees the drive until then.
    pub fn drive_controlled(
        &self,
        scenario: &Scenario,
        control: &mut dyn FnMut(&Rollout) -> Control,
        watch: &mut dyn FnMut(&Planner<'_>, &Cycle) -> bool,
    ) -> Rollout {
        self.run(scenario, &self.full_span(), None, Some(watch), control)
            .drive
    }

    /// Drives a stretch.
    #[must_use]
    pub fn drive(&self, scenario: &Scenario, stretch: &DriveSpan) -> Rollout {
        self.run(scenario, stretch, None, None, &mut |_| Control::Follow)
            .drive
    }

    /// Drives the whole problem, so that other drives can take over its first cycles.
    #[must_use]
    pub fn drive_noted(&self, scenario: &Scenario, until: i64) -> ResumableRollout {
        self.run(scenario, &self.until(until), None, None, &mut |_| {
            Control::Follow
        })
    }

    /// The same; `watch` sees each cycle with its planner; where that says no, the drive is a time-out there.
    #[must_use]
    pub fn drive_noted_watched(
        &self,
        scenario: &Scenario,
        until: i64,
        watch: &mut dyn FnMut(&Planner<'_>, &Cycle) -> bool,
    ) -> ResumableRollout {
        self.run(scenario, &self.until(until), None, Some(watch), &mut |_| {
            Control::Follow
        })
    }

    /// Drives the whole problem in traffic of which the planner is told the same as in the drive `before` in every
    /// cycle up to step `same`: those cycles are taken over instead of being planned again.
    ///
    /// The drive is exactly that of [`Self::drive_noted`], but for the times that cycles took: planning depends on
    /// the vehicle's state, on what is told of the traffic and on what the planner carries from cycle to cycle, and on
    /// nothing else. Contacts and arrivals are looked for at every step again.
    #[must_use]
    pub fn drive_again(
        &self,
        scenario: &Scenario,
        before: &ResumableRollout,
        same: i64,
        until: i64,
    ) -> ResumableRollout {
        self.run(
            scenario,
            &self.until(until),
            Some((before, same)),
            None,
            &mut |_| Control::Follow,
        )
    }

    /// The whole drive, but no farther than to step `until`.
    fn until(&self, until: i64) -> DriveSpan {
        let whole = self.full_span();
        DriveSpan {
            last: whole.last.min(until),
            ..whole
        }
    }
}

/// What the ego does in the next step of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// It follows the planner.
    Follow,
    /// It brakes fully along its path: see [`Planner::full_braking`](crate::planner::Planner::full_braking).
    Brake,
    /// The drive ends here, and is to be dropped.
    Stop,
}
