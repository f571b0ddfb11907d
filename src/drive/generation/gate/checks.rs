//! Checks of a change: who is changed and where, and the motion against itself, the single-track model and its departure.
//!
//! Independent of the single-track check: nothing is integrated here. While the rear axle rolls along the heading, the
//! centre, `b` metres before it, also swings to the side: over a step in which the heading turns by `t`, it moves
//! `b · 2 sin(t/2)` across the mean heading. Recordings move it along the heading. Both are allowed, and all between.

use std::ops::RangeInclusive;

use nearmiss_base::geometry::{Footprint, Placed, Vector, angle_between};
use nearmiss_scene::scenario::{Motion, Obstacle, ObstacleRole, Sample, Scenario, Track};

use super::run::{Findings, Flow, MOST_DIFFERENT, Run, SHARE, Transition, overlapped, touch};
use crate::generation::{AttackStyle, Capability, Change, ChangeError, Reason, Refusal};
use crate::planner::{Bound, Feasibility, Limits, Tolerance};

/// How well a place has to be where heading and speed lead, metres.
const POSITION_TOLERANCE: f64 = 0.01;

/// How well a direction has to fit, radians: wheels turn within a step.
const DIRECTION: f64 = 0.02;

/// A shorter displacement has no direction, metres.
const STANDING: f64 = 0.01;

impl Run<'_> {
    /// No jumps, heading along motion, speed equal to displacement, jerk, and the said accelerations.
    pub fn rolling(&self, found: &mut Findings) -> Flow {
        let dt = self.dt();
        let mut before: Option<Transition<'_>> = None;
        for way in self.ways() {
            self.jump(&way, found)?;
            self.direction(&way, found)?;
            self.speed(&way, found)?;
            self.forces(&way, found)?;
            let joined = before.filter(|b| b.place + 1 == way.place);
            let change = match joined {
                Some(before) => {
                    let exempt = self.is_exempt(before.place) && self.is_exempt(way.place);
                    let a = before.acceleration(dt);
                    Some((a..=a, exempt))
                }
                None if way.place == 0 => {
                    let joint = self.joint();
                    joint.map(|joint| (joint.acceleration, self.is_exempt(0)))
                }
                None => None,
            };
            let a = way.acceleration(dt);
            if let Some((before, exempt)) = change {
                let jerk = beyond(&before, a) / dt;
                let most = self.can.jerk * (1.0 + SHARE) + 4.0 * self.gate.rounding / (dt * dt);
                if jerk > most {
                    let refusal = Refusal::at(way.step, Reason::Jerk).with(jerk, most);
                    found.say(exempt, refusal)?;
                }
            }
            self.check_stated_acceleration(joined.as_ref(), &way, found)?;
            before = Some(way);
        }
        Flow::Continue(())
    }

    /// The displacement is none that the greater of its speeds, all of the grip and turning about the rear axle
    /// explain.
    fn jump(&self, way: &Transition<'_>, found: &mut Findings) -> Flow {
        let (dt, limits) = (self.dt(), &self.can.limits);
        let moved = (way.to.pose.position - way.from.pose.position).norm();
        let fastest = way.from.velocity.abs().max(way.to.velocity.abs());
        let swing = limits.rear_to_centre * way.turned().abs();
        let explained = fastest * dt + limits.acceleration * dt * dt / 2.0 + swing;
        let most = explained + POSITION_TOLERANCE + 2.0 * self.gate.rounding;
        if moved > most {
            let refusal = Refusal::at(way.step, Reason::Jump).with(moved, most);
            found.say(self.is_exempt(way.place), refusal)?;
        }
        Flow::Continue(())
    }

    /// The displacement points where the heading does, or where the centre of a turning body moves.
    fn direction(&self, way: &Transition<'_>, found: &mut Findings) -> Flow {
        let moved = way.to.pose.position - way.from.pose.position;
        let length = moved.norm();
        if length < STANDING {
            return Flow::Continue(());
        }
        let turned = way.turned();
        let mean = way.from.pose.heading + turned / 2.0;
        let backwards = way.from.velocity + way.to.velocity < 0.0;
        let moved = if backwards { -moved } else { moved };
        let angle = angle_between(mean, moved.y.atan2(moved.x));
        let swing = 2.0 * (turned / 2.0).sin() * self.can.limits.rear_to_centre;
        let swing = (swing / length).clamp(-1.0, 1.0).asin();
        let swing = if backwards { -swing } else { swing };
        let off = beyond(&(swing.min(0.0)..=swing.max(0.0)), angle);
        let most =
            DIRECTION + ((POSITION_TOLERANCE / 2.0 + 2.0 * self.gate.rounding) / length).atan();
        if off > most {
            let refusal = Refusal::at(way.step, Reason::Heading).with(off, most);
            found.say(self.is_exempt(way.place), refusal)?;
        }
        Flow::Continue(())
    }

    /// The displacement is as long as the speeds at its ends say. The speed is the rear axle's, or that of the centre.
    fn speed(&self, way: &Transition<'_>, found: &mut Findings) -> Flow {
        let dt = self.dt();
        let moved = way.to.pose.position - way.from.pose.position;
        let turned = way.turned();
        let (sin, cos) = (way.from.pose.heading + turned / 2.0).sin_cos();
        let along = moved.x * cos + moved.y * sin;
        let whole = moved.norm().copysign(along);
        // An arc is longer than its chord.
        let half = turned / 2.0;
        let arc = if half.abs() > 1e-6 {
            half / half.sin()
        } else {
            1.0
        };
        let (a, b) = (along * arc / dt, whole * arc / dt);
        let said = f64::midpoint(way.from.velocity, way.to.velocity);
        let off = beyond(&(a.min(b)..=a.max(b)), said);
        // With the acceleration changing as fast as it may within the step, the mean speed is not that of the ends.
        let bent = self.can.jerk * dt * dt / 12.0;
        let most = (POSITION_TOLERANCE + 2.0 * self.gate.rounding) / dt + bent;
        if off > most {
            let refusal = Refusal::at(way.step, Reason::Velocity).with(off, most);
            found.say(self.is_exempt(way.place), refusal)?;
        }
        Flow::Continue(())
    }

    /// It speeds up and turns no harder than its style allows; braking is part of the friction circle.
    fn forces(&self, way: &Transition<'_>, found: &mut Findings) -> Flow {
        let (dt, rounding) = (self.dt(), self.gate.rounding);
        let speed = f64::midpoint(way.from.velocity, way.to.velocity).abs();
        let across = speed * way.turned().abs() / dt;
        let bounds = [
            (
                Reason::SpeedingUp,
                way.acceleration(dt),
                self.can.speeding_up,
                1.0,
            ),
            (Reason::Lateral, across, self.can.lateral, speed),
        ];
        for (reason, value, limit, per) in bounds {
            let most = limit * (1.0 + SHARE) + 2.0 * rounding * per / dt;
            if value > most {
                let refusal = Refusal::at(way.step, reason).with(value, most);
                found.say(self.is_exempt(way.place), refusal)?;
            }
        }
        Flow::Continue(())
    }

    /// The acceleration that a changed state says is that of the step to it or from it, or between them; it may be as
    /// much off as it may change in a step.
    fn check_stated_acceleration(
        &self,
        before: Option<&Transition<'_>>,
        way: &Transition<'_>,
        found: &mut Findings,
    ) -> Flow {
        // The first state is the recorded one.
        let Some(before) = before else {
            return Flow::Continue(());
        };
        let dt = self.dt();
        let (a, b) = (before.acceleration(dt), way.acceleration(dt));
        let off = beyond(&(a.min(b)..=a.max(b)), way.from.acceleration);
        let most = self.can.jerk * dt * (1.0 + SHARE) + 2.0 * self.gate.rounding / dt;
        if off > most {
            let refusal = Refusal::at(way.step, Reason::Acceleration).with(off, most);
            found.say(self.is_kept(way.place), refusal)?;
        }
        Flow::Continue(())
    }
}

impl Run<'_> {
    /// A single-track vehicle of its kind can drive it.
    ///
    /// Steering angles are estimated from the changed motion alone: the steering rate of its first step is asked at
    /// the joint.
    pub fn kinematics(&self, found: &mut Findings) -> Flow {
        let dt = self.dt();
        let samples = self.motions.iter().map(|(step, motion)| Sample {
            step: *step,
            position: motion.pose.position,
            heading: Some(motion.pose.heading),
            velocity: Some(motion.velocity),
            acceleration: Some(motion.acceleration),
        });
        let track = Track::new(samples.collect(), dt, None);
        let tolerance = Tolerance {
            rounding: self.gate.rounding,
            ..Tolerance::default()
        };
        let check = Feasibility::new(self.can.limits, dt).within(tolerance);
        let Err(error) = check.track(&track) else {
            return Flow::Continue(());
        };
        for broken in error.0 {
            let place = self.motions.iter().position(|(s, _)| *s == broken.step);
            let exempt = place.is_some_and(|place| match broken.bound {
                Bound::Speed | Bound::Backwards => self.is_kept(place),
                // It says how the wheels were turned since the step before.
                Bound::SteeringRate => {
                    self.is_exempt(place) && (place == 0 || self.is_exempt(place - 1))
                }
                _ => self.is_exempt(place),
            });
            // Gaps have been reported.
            if broken.bound != Bound::Gap {
                found.say(exempt, broken.into())?;
            }
        }
        Flow::Continue(())
    }
}

/// Steering angles and accelerations of a recorded state, implied by its surroundings.
///
/// Recordings determine them badly: headings and speeds scatter, and many move the centre along the heading, where a
/// vehicle's rear axle would. So each is a range of all values that the recording implies around the state, before and
/// after. A change must reach its first step from some value in the range within its limits; limits that the recording
/// itself breaks there do not count against it.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Steering angles, radians; `None` if the body hardly moves, and the wheels may stand anyhow.
    pub steering: Option<RangeInclusive<f64>>,
    /// Accelerations along the heading, m/s²: the said one, and those of the steps before and after.
    pub acceleration: RangeInclusive<f64>,
}

/// Steering angles are looked for this long before and after the state, seconds.
const STEERING_WINDOW: f64 = 0.3;

impl Joint {
    /// The joint at a recorded step of a track with `dt` seconds between two steps; `None` if none is recorded.
    #[must_use]
    pub fn at(track: &Track, step: i64, can: &Capability, dt: f64) -> Option<Self> {
        let here = track.at(step)?;
        let next = |from: i64| {
            let to = from.checked_add(1)?;
            Some((track.at(from)?, track.at(to)?))
        };
        let around = (STEERING_WINDOW / dt).ceil().clamp(1.0, 100.0) as i64;
        let ways = step.saturating_sub(around)..step.saturating_add(around);
        let angles = ways
            .filter_map(next)
            .filter_map(|(a, b)| steering(a, b, &can.limits));
        let steering = angles.fold(None, |range, (angle, _)| Some(widened(range, angle)));
        let beside = [step.saturating_sub(1), step].into_iter().filter_map(next);
        let accelerations = beside.map(|(a, b)| (b.velocity - a.velocity) / dt);
        let said = here.acceleration..=here.acceleration;
        Some(Self {
            steering,
            acceleration: accelerations.fold(said, |range, a| widened(Some(range), a)),
        })
    }
}

/// The mean steering angle from one motion to the next (rad), and the length of the rear axle's way (m).
fn steering(from: &Motion, to: &Motion, limits: &Limits) -> Option<(f64, f64)> {
    let rear = |m: &Motion| -> Vector {
        m.pose.position.coords - m.pose.forward() * limits.rear_to_centre
    };
    let chord = (rear(to) - rear(from)).norm();
    if chord < STANDING {
        return None;
    }
    let turned = angle_between(from.pose.heading, to.pose.heading);
    let half = turned / 2.0;
    let length = if half.abs() > 1e-6 {
        chord * half / half.sin()
    } else {
        chord
    };
    Some((limits.steering_of(turned / length), length))
}

fn widened(range: Option<RangeInclusive<f64>>, value: f64) -> RangeInclusive<f64> {
    match range {
        Some(range) => range.start().min(value)..=range.end().max(value),
        None => value..=value,
    }
}

/// How far a value is from a range.
fn beyond(range: &RangeInclusive<f64>, value: f64) -> f64 {
    (range.start() - value).max(value - range.end()).max(0.0)
}

impl Run<'_> {
    pub fn joint(&self) -> Option<Joint> {
        let track = self.obstacle.track();
        Joint::at(track, self.motions[0].0, &self.can, self.dt())
    }

    /// The wheels can be turned from where they stood to where the first changed step needs them.
    pub fn joint_steering(&self, found: &mut Findings) -> Flow {
        let joint = self.joint().and_then(|joint| joint.steering);
        let (Some(range), Some(way)) = (joint, self.ways().next()) else {
            return Flow::Continue(());
        };
        let limits = &self.can.limits;
        let Some((angle, length)) = steering(way.from, way.to, limits) else {
            return Flow::Continue(());
        };
        let dt = self.dt();
        // The mean of a tangent is not the tangent of the mean; and headings and places are rounded.
        let slack = 2.0 * self.gate.rounding * (limits.wheelbase + 1.0) / length / dt;
        let most = limits.steering_rate * (1.0 + SHARE + ESTIMATE) + slack;
        let rate = beyond(&range, angle) / dt;
        if way.place == 0 && !self.is_exempt(0) && rate > most {
            let reason = Reason::Kinematics(Bound::SteeringRate);
            found.say(false, Refusal::at(way.step, reason).with(rate, most))?;
        }
        Flow::Continue(())
    }
}

/// The share of the steering rate that estimated angles may exceed it by, as in the single-track check.
const ESTIMATE: f64 = 0.02;

/// Tolerance for rounding when a body sticks out, metres.
const SLACK: f64 = 1e-3;

impl Run<'_> {
    /// No other obstacle is where the body is, until it has touched the ego; and it touches the ego only where it
    /// moves in its new way.
    pub fn overlaps(&self, found: &mut Findings) -> Flow {
        self.ego_before(found)?;
        for (place, (step, _)) in self.motions.iter().enumerate() {
            if self.contact.is_some_and(|contact| *step > contact) {
                break;
            }
            if !found.asks(self.is_kept(place)) {
                continue;
            }
            let body = self.body(place);
            let before = place
                .checked_sub(1)
                .filter(|before| self.motions[*before].0 + 1 == *step)
                .map(|before| self.body(before));
            let (scenario, regions) = (self.around, &self.gate.regions);
            for id in overlapped(scenario, regions, before, &body, self.obstacle.id, *step) {
                let refusal = Refusal::at(*step, Reason::Overlap(id));
                found.say(self.is_kept(place), refusal)?;
            }
        }
        Flow::Continue(())
    }

    /// The ego is not touched where the motion is the recorded one: up to the state that the change departs from, or
    /// further on to the first changed one.
    fn ego_before(&self, found: &mut Findings) -> Flow {
        let Some(ego) = self.gate.ego else {
            return Flow::Continue(());
        };
        let changed = self.first_changed().filter(|place| *place > 0);
        let first = match changed {
            Some(place) => self.motions[place].0,
            None => self.motions[0].0.saturating_add(1),
        };
        for (step, motion) in self.obstacle.track().iter() {
            if step >= first {
                break;
            }
            let Some(there) = ego.track.at(step) else {
                continue;
            };
            let Some(body) = self.obstacle.footprint_at(step) else {
                continue;
            };
            if touch(&body.at(motion.pose), &ego.footprint.at(there.pose)) {
                found.say(false, Refusal::at(step, Reason::OverlapsEgo))?;
            }
        }
        Flow::Continue(())
    }

    /// Who has to stay on the road does: nothing of the body is off it, or while it has not been wholly on it yet, no
    /// more than at the beginning.
    pub fn road(&self, found: &mut Findings) -> Flow {
        if !self.can.on_road {
            return Flow::Continue(());
        }
        let road = &self.gate.road;
        let outside = |place| road.outside(&self.body(place)).map_or(0.0, |o| o.distance);
        // How far is only worked out where it has to be known: it takes long.
        let mut beginning = None;
        let mut on = false;
        for (place, (step, _)) in self.motions.iter().enumerate() {
            let kept = self.is_kept(place);
            if road.covers(&self.body(place)) {
                on = true;
            } else if found.asks(kept) {
                let metres = outside(place);
                let most = if on {
                    0.0
                } else {
                    *beginning.get_or_insert_with(|| outside(0))
                };
                if metres > most + SLACK {
                    let refusal = Refusal::at(*step, Reason::OffRoad);
                    found.say(kept, refusal.with(metres, most))?;
                }
            }
        }
        Flow::Continue(())
    }

    /// The body at a place of the motion.
    fn body(&self, place: usize) -> Placed<'_> {
        let (step, motion) = &self.motions[place];
        let recorded = self
            .obstacle
            .footprint_at(*step)
            .filter(|_| self.is_kept(place));
        recorded.unwrap_or(self.footprint).at(motion.pose)
    }
}

/// The obstacle whose motion is changed, its body and its limits.
pub(super) fn who<'a>(
    scenario: &'a Scenario,
    style: AttackStyle,
    change: &Change,
) -> Result<(&'a Obstacle, &'a Footprint, Capability), Refusal> {
    let id = change.obstacle;
    let no = |why| Refusal::whole_motion(Reason::Obstacle(why));
    let obstacle = scenario
        .obstacle(id)
        .ok_or_else(|| no(ChangeError::NoSuchObstacle(id)))?;
    if obstacle.role != ObstacleRole::Dynamic || obstacle.initial.is_none() {
        return Err(no(ChangeError::DoesNotMove(id)));
    }
    let unable = || Refusal::whole_motion(Reason::Unable(id));
    let footprint = obstacle.footprint.as_ref().ok_or_else(unable)?;
    let can = Capability::for_obstacle(obstacle, style).ok_or_else(unable)?;
    let from = change
        .from()
        .ok_or_else(|| Refusal::whole_motion(Reason::Gap))?;
    if obstacle.track().at(from).is_none() {
        return Err(Refusal {
            step: Some(from),
            ..no(ChangeError::NotThere(id))
        });
    }
    Ok((obstacle, footprint, can))
}

/// Refuses what is no motion at all: of no length, or with what is no number. Nothing else can be asked of that.
pub(super) fn is_no_motion(motions: &[(i64, Motion)], found: &mut Findings) -> Flow {
    if let [(step, _)] = motions {
        found.say(false, Refusal::at(*step, Reason::Gap).with(0.0, 1.0))?;
    }
    for (step, motion) in motions {
        let numbers = [
            motion.pose.position.x,
            motion.pose.position.y,
            motion.pose.heading,
            motion.velocity,
            motion.acceleration,
        ];
        if !numbers.iter().all(|n| n.is_finite()) {
            found.say(false, Refusal::at(*step, Reason::NotANumber))?;
        }
    }
    Flow::Continue(())
}

impl Run<'_> {
    /// It begins at the recorded state.
    pub fn start(&self, found: &mut Findings) -> Flow {
        let (step, first) = &self.motions[0];
        let Some(recorded) = self.obstacle.track().at(*step) else {
            return Flow::Continue(());
        };
        for (what, value) in recorded.differences(first) {
            if value > MOST_DIFFERENT {
                let refusal = Refusal::at(*step, Reason::Start(what));
                found.say(false, refusal.with(value, MOST_DIFFERENT))?;
            }
        }
        Flow::Continue(())
    }

    /// Checks that each step has a state.
    pub fn gaps(&self, found: &mut Findings) -> Flow {
        for pair in self.motions.windows(2) {
            let (step, next) = (pair[0].0, pair[1].0);
            let steps = next.saturating_sub(step);
            if steps != 1 {
                let refusal = Refusal::at(step, Reason::Gap);
                found.say(false, refusal.with(steps as f64, 1.0))?;
            }
        }
        Flow::Continue(())
    }
}
