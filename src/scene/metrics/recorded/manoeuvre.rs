//! Emergency manoeuvres of the ego: their latest start that still avoids the recorded overlap, and the time until then.
//!
//! The latest start of each emergency manoeuvre that still avoids the recorded overlap.
//!
//! Source: Hillenbrand, Spieker and Kroschel 2006; Tamke, Dang and Breuel 2011. Until its start the ego does what
//! was recorded, all others do so always, and bodies are compared at the recorded steps and on the ways between them, to
//! the end of the ego's recording; starts are at steps. Who avoids it with a late start is taken to avoid it with an earlier one: the latest start is looked
//! for backwards from the overlap in doubled strides down to the first step, then by bisection. Where none of these
//! avoids it, no start is taken to.
//!
//! Times to brake, kick down, steer and react: how long the ego can wait until only another manoeuvre helps.
//!
//! TTB, TTK and TTS are the times from now to the latest start of full braking, full acceleration and
//! evasive steering to the better side (the limits `full_braking`, `kick_down`, `evasion` and `tightest`) that avoids
//! the overlap recorded with this obstacle; TTR is the largest of them. Source: Hillenbrand, Spieker and Kroschel
//! 2006; Tamke, Dang and Breuel 2011.

use std::ops::Range;

use nearmiss_base::geometry::{Placed, Point, Pose, Sweep};

use super::super::{Danger, Encounter, Measure, Reading};
use crate::metrics::limits::Limits;
use crate::metrics::{Context, NoValue};
use crate::scenario::{Motion, driven_way};

/// The ego's manoeuvre to avoid a collision. Only the acceleration given here changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::metrics) enum Manoeuvre {
    /// Full braking straight ahead, until it stands.
    Brake,
    /// Full acceleration straight ahead.
    KickDown,
    /// Full lateral acceleration to the left.
    Left,
    /// Full lateral acceleration to the right.
    Right,
}

impl Manoeuvre {
    /// The pose after `time` seconds, from `start` on.
    ///
    /// A point mass with constant acceleration along or across its first heading; while it steers, the
    /// body turns into the direction of its motion (Jansson 2005, 5.3).
    pub fn pose(self, start: &Motion, time: f64, limits: &Limits) -> Pose {
        let (v, sign) = (start.velocity.abs(), 1.0_f64.copysign(start.velocity));
        let (along, across, turn) = match self {
            Self::Brake => {
                let time = time.min(v / limits.full_braking);
                (v * time - limits.full_braking * time * time / 2.0, 0.0, 0.0)
            }
            Self::KickDown => (v * time + limits.kick_down * time * time / 2.0, 0.0, 0.0),
            Self::Left | Self::Right => {
                let side = if self == Self::Left { 1.0 } else { -1.0 };
                let most = limits.evasion.min(v * v * limits.tightest);
                let turn = if v > 0.0 {
                    (most * time / v).atan()
                } else {
                    0.0
                };
                (
                    v * time,
                    side * most * time * time / 2.0,
                    side * sign * turn,
                )
            }
        };
        Pose {
            position: start.pose.to_world(&Point::new(sign * along, across)),
            heading: start.pose.heading + turn,
        }
    }
}

/// Latest starts, as places of steps.
#[derive(Debug, Clone)]
pub(in crate::metrics) struct Starts {
    /// The first step of a recorded contact, or after one between two steps.
    overlap: Option<usize>,
    /// The last step that a recorded contact is at or after.
    last: usize,
    brake: Option<usize>,
    kick_down: Option<usize>,
    steer: Option<usize>,
}

impl Starts {
    /// For the overlap with any of some participants; the manoeuvres avoid them all.
    pub fn new(context: &Context<'_>, participants: Range<usize>) -> Self {
        let (mut first, mut last): (Option<usize>, usize) = (None, 0);
        for participant in participants.clone() {
            for contact in context.contacts(participant) {
                let Some(index) = context.index(contact.step) else {
                    continue;
                };
                first = Some(first.map_or(index, |f| f.min(index)));
                last = last.max(index - usize::from(!contact.overlaps));
            }
        }
        let latest =
            |manoeuvre| first.and_then(|f| latest(context, participants.clone(), manoeuvre, f));
        Self {
            overlap: first,
            last,
            brake: latest(Manoeuvre::Brake),
            kick_down: latest(Manoeuvre::KickDown),
            steer: latest(Manoeuvre::Left).max(latest(Manoeuvre::Right)),
        }
    }

    /// Places of steps until the latest start of braking.
    pub fn brake(&self, now: usize) -> Result<usize, NoValue> {
        self.until(self.brake, now)
    }

    /// Places of steps until the latest start of accelerating.
    pub fn kick_down(&self, now: usize) -> Result<usize, NoValue> {
        self.until(self.kick_down, now)
    }

    /// Places of steps until the latest start of steering to either side.
    pub fn steer(&self, now: usize) -> Result<usize, NoValue> {
        self.until(self.steer, now)
    }

    /// Places of steps until the latest start of any of them.
    pub fn react(&self, now: usize) -> Result<usize, NoValue> {
        self.until(self.brake.max(self.kick_down).max(self.steer), now)
    }

    fn until(&self, start: Option<usize>, now: usize) -> Result<usize, NoValue> {
        match (self.overlap, start) {
            (None, _) => Err(NoValue::NoRecordedOverlap),
            _ if now > self.last => Err(NoValue::NoRecordedOverlap),
            (_, Some(start)) if start >= now => Ok(start - now),
            (_, Some(_)) => Err(NoValue::TooLate),
            (_, None) => Err(NoValue::NeverAvoided),
        }
    }
}

/// The latest place before `overlap` at which the manoeuvre can start and avoids it.
fn latest(
    context: &Context<'_>,
    participants: Range<usize>,
    manoeuvre: Manoeuvre,
    overlap: usize,
) -> Option<usize> {
    let avoids = |start| avoids(context, participants.clone(), manoeuvre, start);
    let (mut late, mut stride) = (overlap, 1);
    let mut early = loop {
        // The first step is tried before giving up.
        let start = overlap.saturating_sub(stride);
        if late == 0 {
            return None;
        }
        if avoids(start) {
            break start;
        }
        late = start;
        stride *= 2;
    };
    while late - early > 1 {
        let middle = usize::midpoint(early, late);
        if avoids(middle) {
            early = middle;
        } else {
            late = middle;
        }
    }
    Some(early)
}

/// Whether the ego touches none of the participants if it starts at a place.
fn avoids(
    context: &Context<'_>,
    participants: Range<usize>,
    manoeuvre: Manoeuvre,
    start: usize,
) -> bool {
    let Some((motion, body)) = context.ego[start] else {
        return false;
    };
    let placed = |index: usize| {
        let time = context.time(start, index as f64);
        body.at(manoeuvre.pose(motion, time, context.limits()))
    };
    let mut before = None;
    (start..context.length()).all(|index| {
        let ego = placed(index);
        let was: Option<Placed<'_>> = before.replace(ego);
        participants.clone().all(|participant| {
            let there = |index| {
                let (other, other_body) = context.other(participant, index)?;
                Some(other_body.at(other.pose))
            };
            let Some(other) = there(index) else {
                return true;
            };
            let reach = body.reach() + other.footprint.reach();
            let apart = (other.pose.position - ego.pose.position).norm() > reach;
            let touched_on_the_way = || {
                let way = driven_way(there(index.checked_sub(1)?)?, other, context.dt())?;
                Sweep::new(was?, ego).first_touch(&way)
            };
            (apart || ego.distance(&other) > 0.0) && touched_on_the_way().is_none()
        })
    })
}

const fn measure(
    id: &'static str,
    name: &'static str,
    source: &'static str,
    compute: fn(&Encounter<'_>) -> Reading,
) -> Measure {
    Measure::new(id, name, "s", Danger::Low, source, compute).reading_ahead()
}

pub(in crate::metrics) const BRAKE: Measure = measure(
    "ttb",
    "time to brake",
    "latest full braking that avoids the recorded overlap (Hillenbrand 2006)",
    |e| time(e, Starts::brake),
);

pub(in crate::metrics) const KICK_DOWN: Measure = measure(
    "ttk",
    "time to kick down",
    "latest full acceleration that avoids the recorded overlap (Tamke 2011)",
    |e| time(e, Starts::kick_down),
);

pub(in crate::metrics) const STEER: Measure = measure(
    "tts",
    "time to steer",
    "latest evasive steering that avoids the recorded overlap (Hillenbrand 2006)",
    |e| time(e, Starts::steer),
);

pub(in crate::metrics) const REACT: Measure = measure(
    "ttr",
    "time to react",
    "largest of ttb, ttk and tts (Hillenbrand 2006)",
    |e| time(e, Starts::react),
);

fn time(encounter: &Encounter<'_>, until: fn(&Starts, usize) -> Result<usize, NoValue>) -> Reading {
    let time =
        encounter.ask(|c, other, now| Ok(until(c.starts_before(other), now)? as f64 * c.dt()));
    time.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: &Limits = &Limits::SHIPPED;

    #[test]
    fn braking_stops_and_steering_goes_aside() {
        let start = Motion {
            pose: Pose::new(0.0, 0.0, 0.0),
            velocity: 8.0,
            acceleration: 0.0,
        };
        let stood = Manoeuvre::Brake.pose(&start, 9.0, LIMITS);
        assert!((stood.position.x - 64.0 / (2.0 * LIMITS.full_braking)).abs() < 1e-12);
        let aside = Manoeuvre::Right.pose(&start, 0.5, LIMITS);
        assert!((aside.position.y + LIMITS.evasion / 8.0).abs() < 1e-12 && aside.heading < 0.0);
        assert!(
            (Manoeuvre::KickDown.pose(&start, 2.0, LIMITS).position.x
                - 16.0
                - 2.0 * LIMITS.kick_down)
                .abs()
                < 1e-12
        );
    }
}
