//! An attacker's motion: a drivable one from targets, or one through waypoints exactly as given.

use std::ops::RangeInclusive;

use nearmiss_base::geometry::{Point, Pose, Vector, angle_between};
use nearmiss_scene::scenario::{Motion, Obstacle};
use nearmiss_scene::verdict::{Manoeuvre, Moment, Waypoint};

use super::manoeuvre::{self, Plan};
use super::{
    AttackContext, Capability, Change, ChangeError, Joint, Reason, Refusal, TrackingTarget, track,
};
use crate::planner::{Bound, Limits, VehicleState};

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
pub fn targets_of(motions: &[(i64, Motion)]) -> Vec<Option<TrackingTarget>> {
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

/// Answers round: a first waypoint that is this near to the recorded state is that state, metres, radians and m/s.
const ROUNDED: f64 = 0.01;

/// A part of a step by which times may miss it.
const PART: f64 = 1e-6;

/// What is slower has no direction, m/s.
const STANDING: f64 = 0.1;

/// The first waypoint is not looked at any further where it is so far from the recorded place, metres.
const ELSEWHERE: f64 = 1000.0;

/// A waypoint with its time in seconds, and the velocity there.
#[derive(Debug, Clone, Copy)]
struct Knot {
    time: f64,
    position: Point,
    heading: Option<f64>,
    speed: Option<f64>,
    velocity: Vector,
}

/// The motion through waypoints: cubic Hermite curves in time, with the said speeds and headings at their ends, or with
/// those of parabolas through the neighbours. There is a state for each step between the first waypoint and the last.
///
/// A first waypoint that is the recorded state but for rounding is that state; any other one is kept as it is given.
///
/// # Errors
/// Waypoints that no motion leads through: all that is wrong with them.
pub(super) fn through_waypoints(
    stage: &AttackContext<'_>,
    obstacle: &Obstacle,
    points: &[Waypoint],
) -> Result<Change, Vec<Refusal>> {
    let id = obstacle.id;
    let able = Capability::for_obstacle(obstacle, stage.style)
        .ok_or_else(|| vec![Refusal::whole_motion(Reason::Unable(id))])?;
    let dt = stage.dt();
    let mut knots: Vec<Knot> = points.iter().map(|p| knot(p, dt)).collect();
    let wrong = wrong(stage, obstacle, &knots, able.limits.speed);
    if !wrong.is_empty() {
        return Err(wrong);
    }
    let (Some(first), Some(last)) = (knots.first(), knots.last()) else {
        return Err(vec![Refusal::answer("no waypoints")]);
    };
    let from = (first.time / dt - PART).ceil() as i64;
    let until = (last.time / dt + PART).floor() as i64;
    let recorded = obstacle.track().at(from).copied().ok_or_else(|| {
        let reason = Reason::Obstacle(ChangeError::NotThere(id));
        vec![Refusal::at(from, reason)]
    })?;
    let off = (first.position - recorded.pose.position).norm();
    if off > ELSEWHERE {
        let refusal = Refusal::at(from, Reason::Start("position"));
        return Err(vec![refusal.with(off, 0.0)]);
    }
    let begins = is_recorded(first, &recorded, from as f64 * dt);
    if begins {
        knots[0].position = recorded.pose.position;
        knots[0].heading = Some(recorded.pose.heading);
        knots[0].speed = Some(recorded.velocity);
    }
    aim(&mut knots);
    let mut heading = knots[0].heading.unwrap_or(recorded.pose.heading);
    let mut motions: Vec<(i64, Motion)> = (from..=until)
        .map(|step| {
            let (position, velocity) = at(&knots, step as f64 * dt);
            let speed = velocity.norm();
            if speed > STANDING {
                heading = velocity.y.atan2(velocity.x);
            }
            let motion = Motion {
                pose: Pose { position, heading },
                velocity: speed,
                acceleration: 0.0,
            };
            (step, motion)
        })
        .collect();
    for place in 0..motions.len() {
        let next = (place + 1).min(motions.len() - 1);
        let before = next.saturating_sub(1);
        let gained = motions[next].1.velocity - motions[before].1.velocity;
        motions[place].1.acceleration = gained / dt;
    }
    if begins {
        motions[0].1 = recorded;
    }
    Ok(Change {
        obstacle: id,
        motions,
    })
}

fn knot(point: &Waypoint, dt: f64) -> Knot {
    Knot {
        time: match point.at {
            Moment::Step(step) => step as f64 * dt,
            Moment::Seconds(time) => time,
        },
        position: Point::new(point.x, point.y),
        heading: point.heading,
        speed: point.velocity,
        velocity: Vector::zeros(),
    }
}

/// What is wrong with the waypoints before any motion is made of them.
fn wrong(
    stage: &AttackContext<'_>,
    obstacle: &Obstacle,
    knots: &[Knot],
    fastest: f64,
) -> Vec<Refusal> {
    let dt = stage.dt();
    let last = (obstacle.track().steps().end - 1).max(*stage.steps.end());
    let mut found = Vec::new();
    for (place, knot) in knots.iter().enumerate() {
        let number = place + 1;
        let numbers = [knot.time, knot.position.x, knot.position.y];
        let said = [knot.heading, knot.speed].into_iter().flatten();
        if !numbers.into_iter().chain(said).all(f64::is_finite) {
            found.push(Refusal::answer(format!(
                "waypoint {number} has an invalid number"
            )));
            continue;
        }
        let step = (knot.time / dt).round();
        if step < 0.0 || step > last as f64 {
            found.push(Refusal::answer(format!(
                "waypoint {number} is at step {step:.0}, but the scenario has steps 0 to {last}"
            )));
            continue;
        }
        let step = step as i64;
        if let Some(speed) = knot.speed.filter(|speed| *speed < 0.0) {
            let reason = Reason::Kinematics(Bound::Backwards);
            found.push(Refusal::at(step, reason).with(-speed, 0.0));
        }
        let Some(before) = place.checked_sub(1).and_then(|place| knots.get(place)) else {
            continue;
        };
        let moved = (knot.position - before.position).norm();
        let most = fastest * (knot.time - before.time);
        if moved > most {
            found.push(Refusal::at(step, Reason::Jump).with(moved, most));
        }
    }
    if found.is_empty() && steps_between(knots, dt) < 1 {
        found.push(Refusal::answer("all waypoints are within one step"));
    }
    found
}

fn steps_between(knots: &[Knot], dt: f64) -> i64 {
    let (Some(first), Some(last)) = (knots.first(), knots.last()) else {
        return 0;
    };
    (last.time / dt + PART).floor() as i64 - (first.time / dt - PART).ceil() as i64
}

/// Whether a waypoint is the recorded state of a step at `time`, but for rounding.
fn is_recorded(first: &Knot, recorded: &Motion, time: f64) -> bool {
    let turned = |heading| angle_between(recorded.pose.heading, heading).abs();
    (first.time - time).abs() <= PART
        && (first.position - recorded.pose.position).norm() <= ROUNDED
        && first.heading.is_none_or(|h| turned(h) <= ROUNDED)
        && first
            .speed
            .is_none_or(|v| (v - recorded.velocity).abs() <= ROUNDED)
}

/// Gives each waypoint its velocity.
fn aim(knots: &mut [Knot]) {
    let pairs = knots.windows(2);
    let chords: Vec<(f64, Vector)> = pairs
        .map(|pair| {
            let time = pair[1].time - pair[0].time;
            (time, (pair[1].position - pair[0].position) / time)
        })
        .collect();
    let Some((last, one_sided)) = chords.len().checked_sub(1).zip(chords.first()) else {
        return;
    };
    let only = one_sided.1;
    for (place, knot) in knots.iter_mut().enumerate() {
        let across = match place {
            _ if last == 0 => only,
            0 => beyond(chords[0], chords[1]),
            place if place > last => beyond(chords[last], chords[last - 1]),
            place => {
                let ((h, a), (k, b)) = (chords[place - 1], chords[place]);
                (a * k + b * h) / (h + k)
            }
        };
        knot.velocity = match (knot.speed, knot.heading) {
            (Some(speed), Some(heading)) => forward(heading) * speed,
            (None, Some(heading)) => {
                let forward = forward(heading);
                forward * across.dot(&forward).max(0.0)
            }
            (Some(speed), None) if across.norm() > STANDING => across.normalize() * speed,
            (Some(_), None) => Vector::zeros(),
            (None, None) => across,
        };
    }
}

fn forward(heading: f64) -> Vector {
    Vector::new(heading.cos(), heading.sin())
}

/// The velocity at the outer end of the first of two chords, on the parabola through them.
fn beyond((h, a): (f64, Vector), (k, b): (f64, Vector)) -> Vector {
    a + (a - b) * (h / (h + k))
}

/// Place and velocity on the curve at a time, which is between the first waypoint and the last but for rounding.
fn at(knots: &[Knot], time: f64) -> (Point, Vector) {
    let place = knots
        .partition_point(|knot| knot.time <= time)
        .clamp(1, knots.len() - 1);
    let (a, b) = (&knots[place - 1], &knots[place]);
    let h = b.time - a.time;
    let x = ((time - a.time) / h).clamp(0.0, 1.0);
    let (xx, xxx) = (x * x, x * x * x);
    let (p, q) = (a.position.coords, b.position.coords);
    let position = p * (2.0 * xxx - 3.0 * xx + 1.0)
        + a.velocity * (h * (xxx - 2.0 * xx + x))
        + q * (3.0 * xx - 2.0 * xxx)
        + b.velocity * (h * (xxx - xx));
    let velocity = (q - p) * ((6.0 * x - 6.0 * xx) / h)
        + a.velocity * (3.0 * xx - 4.0 * x + 1.0)
        + b.velocity * (3.0 * xx - 2.0 * x);
    (Point::from(position), velocity)
}
