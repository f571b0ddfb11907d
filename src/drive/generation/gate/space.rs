//! Checks that the body stays on the road and overlaps no other obstacle.

use super::others::{overlapped, touch};
use super::run::{Findings, Flow, Run};
use crate::generation::{Reason, Refusal};
use nearmiss_base::geometry::Placed;

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
