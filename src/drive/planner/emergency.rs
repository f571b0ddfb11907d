//! The fallback without a feasible candidate: the latest contact, or braking.

use super::brake::brake;
use super::candidate::{Candidate, Rejection};
use super::place::place;
use super::traffic::EgoBox;
use super::{Limits, Plan, Planner, Traffic, VehicleState};

/// Fallback when no candidate is feasible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Emergency {
    /// The candidate that touches an obstacle's prediction last.
    LatestContact,
    /// Braking along the path: the mildest that touches no obstacle's prediction, or that which does so last.
    Braking,
}

/// Shares of the full braking that are tried in an emergency.
const BRAKING: [f64; 3] = [0.4, 0.7, 1.0];

impl Planner<'_> {
    /// The mildest braking without a predicted contact; if there is none, the one with the latest contact.
    pub(super) fn stop(
        &mut self,
        now: &VehicleState,
        traffic: &Traffic,
        wanted: f64,
        refinements: usize,
    ) -> Plan {
        self.last = None;
        let latest = self
            .candidates
            .iter()
            .filter_map(|c| match c.rejected {
                Some((step, Rejection::Contact(_))) => Some((step, c)),
                _ => None,
            })
            .max_by(|a, b| {
                let dearer = b.1.cost.total().total_cmp(&a.1.cost.total());
                a.0.cmp(&b.0).then(dearer)
            })
            .map(|(step, candidate)| (step, *candidate));
        // The mildest braking that touches no obstacle; if all do, the one that does so last.
        let mut braked: Option<(usize, Vec<VehicleState>)> = None;
        for share in BRAKING {
            let states = brake(
                now,
                self.guide,
                self.hint,
                &self.limits,
                share,
                self.dt,
                self.steps(),
            );
            let touched = first_contact(&states, traffic, &self.limits).unwrap_or(usize::MAX);
            if braked.as_ref().is_none_or(|(before, _)| touched > *before) {
                braked = Some((touched, states));
            }
            if touched == usize::MAX {
                break;
            }
        }
        let (touched, braking) = braked.unwrap_or_default();
        // A candidate is not driven beyond its contact: what it would do there does not count.
        let stays = |(step, candidate): &(usize, Candidate)| {
            let left = self.leaves_road(candidate);
            left.is_none_or(|left| left > *step)
        };
        match latest.filter(|l| touched < l.0 && stays(l)) {
            Some((step, candidate)) => Plan {
                states: self.braked_from(&candidate, step),
                cost: candidate.cost,
                ..self.summary(wanted, refinements, Some(Emergency::LatestContact))
            },
            None => Plan {
                states: braking,
                ..self.summary(wanted, refinements, Some(Emergency::Braking))
            },
        }
    }

    /// The state after one step of full braking along the path: what the friction circle leaves beside steering,
    /// 98 % of the vehicle's largest acceleration where it drives straight. The next cycle plans afresh from there.
    #[must_use]
    pub fn full_braking(&mut self, now: &VehicleState) -> VehicleState {
        self.last = None;
        // Before the first cycle the place on the path is not known yet.
        let place = place(self.guide, now, self.hint);
        self.hint = place.map(|(along, _)| along[0]).or(self.hint);
        let states = brake(now, self.guide, self.hint, &self.limits, 1.0, self.dt, 1);
        states.last().copied().unwrap_or(*now)
    }

    /// The states of a candidate up to `step`, beyond which it was not looked at, and full braking from there on.
    fn braked_from(&self, candidate: &Candidate, step: usize) -> Vec<VehicleState> {
        let mut states = self.states_of(candidate);
        states.truncate(step + 1);
        let left = self.steps().saturating_sub(step);
        if let Some(last) = states.last().copied() {
            let hint = self.arc_length_at(candidate, step);
            let stop = brake(&last, self.guide, hint, &self.limits, 1.0, self.dt, left);
            states.extend(stop.into_iter().skip(1));
        }
        states
    }
}

/// The first step at which an obstacle's predicted body is touched.
fn first_contact(states: &[VehicleState], traffic: &Traffic, limits: &Limits) -> Option<usize> {
    states.iter().enumerate().skip(1).find_map(|(step, state)| {
        let centre = state.centre(limits).pose;
        let (sin, cos) = centre.heading.sin_cos();
        let own = EgoBox {
            x: centre.position.x,
            y: centre.position.y,
            cos,
            sin,
            half_length: limits.length / 2.0,
            half_width: limits.width / 2.0,
        };
        let others = traffic.at(step).iter();
        let mut avoided = others.filter(|o| traffic.bodies[o.body].avoided);
        avoided.any(|o| o.separation(&own) < 0.0).then_some(step)
    })
}
