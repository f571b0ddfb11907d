//! What the last cycle looked at: states of candidates, and the cycle's summary.

use super::candidate::{Candidate, Cost};
use super::motion::{Moved, state};
use super::{Emergency, Plan, Planner, VehicleState};

impl Planner<'_> {
    pub(super) fn moments<'b>(
        &'b self,
        candidate: &'b Candidate,
    ) -> impl Iterator<Item = Moved> + 'b {
        let steps = self.steps();
        let stations = &self.stations[candidate.profile * (steps + 1)..][..=steps];
        let (now, dt) = (self.now, self.dt);
        let now = now.as_ref().map(Moved::from_state);
        stations
            .iter()
            .enumerate()
            .map_while(move |(i, at)| match now {
                // The present is given, and not to be rounded.
                Some(now) if i == 0 => Some(now),
                _ => state(at, candidate.lateral.at(i as f64 * dt, at.s)),
            })
    }

    /// Arc length of a candidate at a step from now, metres.
    pub(super) fn arc_length_at(&self, candidate: &Candidate, step: usize) -> Option<f64> {
        let place = candidate.profile * (self.steps() + 1) + step;
        self.stations.get(place).map(|at| at.s[0])
    }

    /// The states of one of [`Self::candidates`], one a step, up to where the path's coordinates end.
    #[must_use]
    pub fn states_of(&self, candidate: &Candidate) -> Vec<VehicleState> {
        let mut states: Vec<VehicleState> = self.moments(candidate).map(|m| m.whole()).collect();
        if let (Some(first), Some(now)) = (states.first_mut(), self.now) {
            *first = now;
        }
        states
    }

    /// The candidates of the last cycle.
    #[must_use]
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    pub(super) fn summary(
        &self,
        wanted: f64,
        refinements: usize,
        emergency: Option<Emergency>,
    ) -> Plan {
        let mut rejected: Vec<(&'static str, usize)> = Vec::new();
        for (_, why) in self.candidates.iter().filter_map(|c| c.rejected) {
            let name = why.name();
            match rejected.iter_mut().find(|(n, _)| *n == name) {
                Some((_, count)) => *count += 1,
                None => rejected.push((name, 1)),
            }
        }
        let out: usize = rejected.iter().map(|(_, n)| n).sum();
        Plan {
            states: Vec::new(),
            candidates: self.candidates.len(),
            feasible: self.candidates.len() - out,
            rejected,
            refinements,
            wanted,
            cost: Cost::default(),
            emergency,
            hold: self.hold,
        }
    }
}
