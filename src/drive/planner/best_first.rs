//! Candidates in the order of what they cost at least: once the next one costs more than the best so far, all do.

use std::ops::Range;

use super::Planner;
use super::candidate::{Candidate, Cost, Rejection};
use super::close_traffic::CloseTraffic;
use super::evaluate::Judge;
use super::motion::Moved;

impl Planner<'_> {
    /// Follows the candidates of these profiles, those that may cost least first, until all others cost more than the
    /// best one.
    pub(super) fn follow_best(&mut self, profiles: Range<usize>, judge: &Judge<'_>, now: &Moved) {
        let steps = judge.steps;
        let first = profiles.start;
        self.rest.clear();
        self.least.clear();
        for place in profiles {
            let profile = &self.profiles[place];
            let stations = &self.stations[place * (steps + 1)..][..=steps];
            let ways = &self.ways[usize::from(profile.slowest < self.settings.low_speed)];
            let start = self.rest.len();
            judge.least(stations, ways, &mut self.rest);
            let jerk = judge.along_jerk(profile);
            for (i, way) in ways.list.iter().enumerate() {
                let left = [self.rest[start], ways.rest(i, steps)[0]];
                let least = judge.least_cost(jerk, way, left);
                self.least.push((least, self.candidates.len(), i));
                // Where it is not followed, it is because of what it costs.
                self.candidates.push(Candidate {
                    profile: place,
                    lateral: way.lateral,
                    cost: Cost::default(),
                    rejected: Some((0, Rejection::Costlier)),
                });
            }
        }
        self.least
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // The next candidate is of any profile: lists of each would not pay.
        let close = CloseTraffic::default();
        for n in 0..self.least.len() {
            let (least, index, way) = self.least[n];
            let most = self.best.map(|(cost, _)| cost);
            if self.cancel.is_asked() || most.is_some_and(|most| least > most) {
                return;
            }
            let Candidate {
                profile: place,
                lateral,
                ..
            } = self.candidates[index];
            let profile = &self.profiles[place];
            let stations = &self.stations[place * (steps + 1)..][..=steps];
            let ways = &self.ways[usize::from(profile.slowest < self.settings.low_speed)];
            let rest = [
                &self.rest[(place - first) * (steps + 1)..][..=steps],
                ways.rest(way, steps),
            ];
            let lateral = (lateral, ways.offsets(way, steps));
            self.candidates[index] =
                judge.follow(now, place, profile, (stations, &close), lateral, rest, most);
            self.ask_road(index);
        }
    }

    /// Asks the road of a candidate that would be the best one so far whether it is that; of equal ones the first is.
    pub(super) fn ask_road(&mut self, index: usize) {
        let candidate = self.candidates[index];
        let cost = candidate.cost.total();
        let is_best = self
            .best
            .is_none_or(|(least, at)| cost < least || cost == least && index < at);
        if candidate.rejected.is_none() && is_best {
            match self.leaves_road(&candidate) {
                Some(step) => self.candidates[index].rejected = Some((step, Rejection::OffRoad)),
                None => self.best = Some((cost, index)),
            }
        }
    }
}
