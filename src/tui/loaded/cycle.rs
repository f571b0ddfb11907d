//! One planning cycle, reduced to what a screen can show: about 20 kB.

use std::time::Duration;

use nearmiss_base::geometry::{Point, Vector};
use nearmiss_drive::planner::{
    Candidate, Cost, Emergency, Hold, Limits, Planner, Traffic, VehicleState,
};
use nearmiss_drive::simulation::Cycle;

/// Lines of the fan at most: of candidates that can be driven, and of those that cannot.
const LINES: (usize, usize) = (90, 80);

/// Points of a line at most.
const POINTS: usize = 14;

/// Seconds from one drawn moment of a predicted body to the next.
const MOMENT: f64 = 1.0;

/// A predicted body farther from the ego than this is left out, metres.
const FAR: f64 = 80.0;

/// A body predicted to stay within this distance of its position gets no separate outline, metres.
const STAYS: f64 = 0.5;

/// A cycle of the planner.
#[derive(Debug, Clone, PartialEq)]
pub struct CycleShown {
    /// The time step at which it was planned.
    pub step: i64,
    /// Candidates that were looked at.
    pub candidates: usize,
    /// How many of them could be driven.
    pub feasible: usize,
    /// Why the others could not, the most frequent reason first.
    pub rejected: Vec<(&'static str, usize)>,
    /// Times that the samples were refined.
    pub refinements: usize,
    /// The speed that was wanted, m/s.
    pub wanted: f64,
    /// The speed at the beginning and at the end of what was chosen, m/s.
    pub speeds: (f64, f64),
    /// Cost of the chosen candidate.
    pub cost: Cost,
    /// The fallback, if nothing could be driven.
    pub emergency: Option<Emergency>,
    /// A rule that asks for a stop ahead.
    pub hold: Option<Hold>,
    /// How long planning took, the forecast not counted.
    pub took: Duration,
    /// Where what was chosen leads, the body's centre, a point a step.
    pub chosen: Vec<Point>,
    /// Steps from one full second of what was chosen to the next.
    pub second: usize,
    /// Some of the candidates.
    pub fan: Fan,
    /// Bodies that the planner was told of, at full seconds from now.
    pub foreseen: Vec<PredictedBody>,
}

/// Lines of candidates, in little memory: metres from `origin`, in single precision.
#[derive(Debug, Clone, PartialEq)]
pub struct Fan {
    origin: Point,
    points: Vec<[f32; 2]>,
    /// Where each line ends, and whether it can be driven.
    ends: Vec<(usize, bool)>,
}

/// A body where it is predicted to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedBody {
    /// Its corners, one after another.
    pub corners: [Point; 4],
    /// Whether contact with it is ruled out; else it only costs.
    pub avoided: bool,
}

impl CycleShown {
    /// The displayed data of a cycle that has just ended, for steps of `dt` seconds.
    #[must_use]
    pub fn new(
        planner: &Planner<'_>,
        limits: &Limits,
        cycle: &Cycle,
        traffic: &Traffic,
        dt: f64,
    ) -> Self {
        let plan = &cycle.plan;
        let centre = |s: &VehicleState| s.centre(limits).pose.position;
        let chosen: Vec<Point> = plan.states.iter().map(centre).collect();
        let origin = chosen.first().copied().unwrap_or(Point::origin());
        let speed = |state: Option<&VehicleState>| state.map_or(0.0, |s| s.velocity);
        let mut rejected = plan.rejected.clone();
        rejected.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        let second = ((MOMENT / dt).round() as usize).max(1);
        Self {
            step: cycle.step,
            candidates: plan.candidates,
            feasible: plan.feasible,
            rejected,
            refinements: plan.refinements,
            wanted: plan.wanted,
            speeds: (speed(plan.states.first()), speed(plan.states.last())),
            cost: plan.cost,
            emergency: plan.emergency,
            hold: plan.hold,
            took: cycle.took,
            second,
            fan: Fan::of(planner, limits, origin),
            foreseen: foreseen(traffic, &origin, second),
            chosen,
        }
    }
}

impl CycleShown {
    /// Bytes that it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let lists = size_of_val(&self.fan.points[..])
            + size_of_val(&self.fan.ends[..])
            + size_of_val(&self.chosen[..])
            + size_of_val(&self.foreseen[..]);
        size_of::<Self>() + lists
    }
}

impl Fan {
    fn of(planner: &Planner<'_>, limits: &Limits, origin: Point) -> Self {
        let mut fan = Self {
            origin,
            points: Vec::new(),
            ends: Vec::new(),
        };
        let all = planner.candidates();
        let (can, cannot): (Vec<&Candidate>, Vec<&Candidate>) =
            all.iter().partition(|c| c.rejected.is_none());
        for candidate in spread(&cannot, LINES.1).chain(spread(&can, LINES.0)) {
            let mut states = planner.states_of(candidate);
            if let Some((step, _)) = candidate.rejected {
                // The candidate was not evaluated past the step of its rejection.
                states.truncate(step + 1);
            }
            let centres: Vec<Point> = states
                .iter()
                .map(|s| s.centre(limits).pose.position)
                .collect();
            fan.add(&centres, candidate.rejected.is_none());
        }
        fan.points.shrink_to_fit();
        fan.ends.shrink_to_fit();
        fan
    }

    fn add(&mut self, line: &[Point], drivable: bool) {
        let Some(last) = line.len().checked_sub(1).filter(|last| *last > 0) else {
            return;
        };
        let stride = last.div_ceil(POINTS - 1).max(1);
        let steps = (0..last).step_by(stride).chain([last]);
        for step in steps {
            let from = line[step] - self.origin;
            self.points.push([from.x as f32, from.y as f32]);
        }
        self.ends.push((self.points.len(), drivable));
    }

    /// How many lines there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// Each line, and whether it can be driven; those that can come last.
    pub fn lines(&self) -> impl Iterator<Item = (Vec<Point>, bool)> + '_ {
        let mut from = 0;
        self.ends.iter().map(move |&(to, drivable)| {
            let line = &self.points[from..to];
            from = to;
            let at = |p: &[f32; 2]| self.origin + Vector::new(f64::from(p[0]), f64::from(p[1]));
            (line.iter().map(at).collect(), drivable)
        })
    }
}

/// At most `most` of them, evenly spaced.
fn spread<'a, T>(all: &'a [&'a T], most: usize) -> impl Iterator<Item = &'a T> {
    let count = all.len().min(most);
    (0..count).map(move |i| all[i * all.len() / count])
}

/// The bodies at full seconds from now that are near and do not just stay.
fn foreseen(traffic: &Traffic, ego: &Point, second: usize) -> Vec<PredictedBody> {
    let now = traffic.at(0);
    let mut found = Vec::new();
    for step in (second..=traffic.horizon()).step_by(second) {
        for body in traffic.at(step) {
            let at = Point::new(body.x, body.y);
            let before = now.iter().find(|b| b.body == body.body);
            let stays = before.is_some_and(|b| (at - Point::new(b.x, b.y)).norm() < STAYS);
            if stays || (at - ego).norm() > FAR {
                continue;
            }
            let forward = Vector::new(body.cos, body.sin) * body.half_length;
            let left = Vector::new(-body.sin, body.cos) * body.half_width;
            found.push(PredictedBody {
                corners: [
                    at + forward + left,
                    at - forward + left,
                    at - forward - left,
                    at + forward - left,
                ],
                avoided: traffic.bodies[body.body].avoided,
            });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_much_is_thinned_evenly() {
        let all: Vec<usize> = (0..10).collect();
        let all: Vec<&usize> = all.iter().collect();
        assert_eq!(spread(&all, 3).copied().collect::<Vec<_>>(), [0, 3, 6]);
        assert_eq!(spread(&all, 20).count(), 10);
        assert_eq!(spread(&all[..0], 20).count(), 0);
    }
}
