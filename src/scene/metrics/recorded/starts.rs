//! The latest start of each emergency manoeuvre that still avoids the recorded overlap.
//!
//! Source: Hillenbrand, Spieker and Kroschel 2006; Tamke, Dang and Breuel 2011. Until its start the ego does what
//! was recorded, all others do so always, and bodies are compared at the recorded steps and on the ways between them, to
//! the end of the ego's recording; starts are at steps. Who avoids it with a late start is taken to avoid it with an earlier one: the latest start is looked
//! for backwards from the overlap in doubled strides down to the first step, then by bisection. Where none of these
//! avoids it, no start is taken to.

use std::ops::Range;

use super::Manoeuvre;
use crate::metrics::{Context, NoValue};
use crate::scenario::driven_way;
use nearmiss_base::geometry::{Placed, Way};

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
                Way::new(was?, ego).first_touch(&way)
            };
            (apart || ego.distance(&other) > 0.0) && touched_on_the_way().is_none()
        })
    })
}
