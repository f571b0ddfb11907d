//! Checks which obstacles may be changed, how a change begins, that it stays on the road and overlaps no other.

use nearmiss_base::geometry::{Footprint, Placed, angle_between};
use nearmiss_scene::scenario::{Motion, Obstacle, ObstacleRole, Scenario};

use super::run::{Findings, Flow, MOST_DIFFERENT, Run, overlapped, touch};
use crate::generation::{AttackStyle, Capability, Change, ChangeError, Reason, Refusal};

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

/// How far two motions are apart in place (m), heading (rad) and speed (m/s).
pub(super) fn differences(a: &Motion, b: &Motion) -> impl Iterator<Item = (&'static str, f64)> {
    let turned = angle_between(a.pose.heading, b.pose.heading).abs();
    [
        ("position", (a.pose.position - b.pose.position).norm()),
        ("heading", turned),
        ("velocity", (a.velocity - b.velocity).abs()),
    ]
    .into_iter()
}

impl Run<'_> {
    /// It begins at the recorded state.
    pub fn start(&self, found: &mut Findings) -> Flow {
        let (step, first) = &self.motions[0];
        let Some(recorded) = self.obstacle.track().at(*step) else {
            return Flow::Continue(());
        };
        for (what, value) in differences(recorded, first) {
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
