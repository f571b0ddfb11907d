//! Checks the motion of the body's centre against its own headings, speeds and accelerations.
//!
//! Independent of the single-track check: nothing is integrated here. While the rear axle rolls along the heading, the
//! centre, `b` metres before it, also swings to the side: over a step in which the heading turns by `t`, it moves
//! `b · 2 sin(t/2)` across the mean heading. Recordings move it along the heading. Both are allowed, and all between.

use super::departure::beyond;
use super::run::{Findings, Flow, Run, SHARE, Transition};
use crate::generation::{Reason, Refusal};
use nearmiss_base::geometry::angle_between;

/// How well a place has to be where heading and speed lead, metres.
const PLACE: f64 = 0.01;

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
            self.said(joined.as_ref(), &way, found)?;
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
        let most = explained + PLACE + 2.0 * self.gate.rounding;
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
        let most = DIRECTION + ((PLACE / 2.0 + 2.0 * self.gate.rounding) / length).atan();
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
        let most = (PLACE + 2.0 * self.gate.rounding) / dt + bent;
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
    fn said(
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
