//! Turns an attacker's targets into a drivable motion.

use std::ops::RangeInclusive;

use super::manoeuvre::{self, Plan};
use super::{AttackContext, Capability, Change, Joint, Refusal, TrackingTarget, track};
use crate::planner::{Limits, VehicleState};
use nearmiss_scene::scenario::{Motion, Obstacle};
use nearmiss_scene::verdict::Manoeuvre;

/// Acceleration limit of attackers by friction, m/s²: a dry road gives little more.
const GRIP: f64 = 8.0;

/// How fast attackers change their acceleration, m/s³.
const JERK: f64 = 15.0;

/// The motion of an obstacle that does a manoeuvre; `way` as in [`manoeuvre::plan`].
///
/// # Errors
/// It cannot be done: the one reason.
pub fn of_manoeuvre(
    stage: &AttackContext<'_>,
    obstacle: &Obstacle,
    manoeuvre: &Manoeuvre,
    way: usize,
) -> Result<Change, Refusal> {
    let plan = manoeuvre::plan(stage, obstacle, manoeuvre, way).map_err(|why| Refusal {
        step: Some(stage.step_at(manoeuvre.start)),
        ..Refusal::answer(why)
    })?;
    follow(stage, obstacle, plan.from, &plan)
}

/// The motion that comes as near to a plan as an attacker can drive.
///
/// # Errors
/// The obstacle does not move by itself, is not there, or nothing is wanted of it.
pub fn follow(
    stage: &AttackContext<'_>,
    obstacle: &Obstacle,
    from: i64,
    plan: &Plan,
) -> Result<Change, Refusal> {
    let id = obstacle.id;
    let able = Capability::for_obstacle(obstacle, stage.style)
        .ok_or_else(|| Refusal::answer(format!("obstacle {id} does not move by itself")))?;
    let now = *obstacle
        .track()
        .at(from)
        .ok_or_else(|| Refusal::answer(format!("obstacle {id} is absent at step {from}")))?;
    if plan.wanted.iter().all(Option::is_none) {
        return Err(Refusal::answer(format!(
            "obstacle {id}: no motion left to change"
        )));
    }
    let able = moderate(able);
    let start = start(stage, obstacle, from, &now, &able);
    let states = track(&start, &plan.wanted, &able, stage.dt());
    let motions = (from + 1..)
        .zip(states.iter().skip(1))
        .map(|(step, state)| (step, state.centre(&able.limits)));
    Ok(Change {
        obstacle: id,
        motions: std::iter::once((from, now)).chain(motions).collect(),
    })
}

fn moderate(able: Capability) -> Capability {
    Capability {
        limits: Limits {
            acceleration: able.limits.acceleration.min(GRIP),
            ..able.limits
        },
        jerk: able.jerk.min(JERK),
        ..able
    }
}

/// The recorded state, as that of a vehicle whose wheels and acceleration are in the middle of what the recording says.
fn start(
    stage: &AttackContext<'_>,
    obstacle: &Obstacle,
    step: i64,
    now: &Motion,
    able: &Capability,
) -> VehicleState {
    let limits = &able.limits;
    let joint = Joint::at(obstacle.track(), step, able, stage.dt());
    let steering = joint.as_ref().and_then(|j| j.steering.clone());
    let angle = steering
        .map_or(0.0, |range| middle(&range))
        .clamp(-limits.steering, limits.steering);
    let acceleration = joint.map_or(now.acceleration, |j| middle(&j.acceleration));
    VehicleState {
        acceleration: acceleration.clamp(-limits.acceleration, limits.acceleration),
        ..VehicleState::of_centre(now, angle.tan() / limits.wheelbase, limits)
    }
}

fn middle(range: &RangeInclusive<f64>) -> f64 {
    f64::midpoint(*range.start(), *range.end())
}

/// What is wanted of a motion that keeps to nothing but its own places: those of a given motion.
#[must_use]
pub fn as_given(motions: &[(i64, Motion)]) -> Vec<Option<TrackingTarget>> {
    let wanted = motions.iter().skip(1).map(|(_, motion)| {
        Some(TrackingTarget {
            position: motion.pose.position,
            velocity: Some(motion.velocity),
            heading: Some(motion.pose.heading),
            weight: 1.0,
        })
    });
    wanted.collect()
}
