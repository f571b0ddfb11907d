//! One cycle of planning: sample, follow, choose; and what is done when nothing is left.

use super::brake::brake;
use super::candidate::{Candidate, Cost, Rejection};
use super::evaluate::{CLEAR, Judge};
use super::lateral::{Lateral, Start};
use super::motion::{Moved, Station, state};
use super::profile::Profile;
use super::samples::{FASTER, Level, Sampler, start};
use super::{Guide, Limits, Road, Settings, Traffic, VehicleState};
use crate::geometry::Frenet;

/// What a cycle decided.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The states from now to the horizon, one a step.
    pub states: Vec<VehicleState>,
    /// Candidates that were followed, those of all refinements together.
    pub candidates: usize,
    /// How many of them could be driven (the road is asked only of those that are cheaper than the chosen one).
    pub feasible: usize,
    /// Why the others could not, by name.
    pub rejected: Vec<(&'static str, usize)>,
    /// Times that the samples were refined.
    pub refinements: usize,
    /// The speed that was wanted, m/s.
    pub wanted: f64,
    /// What the chosen one costs.
    pub cost: Cost,
    /// Nothing could be driven, and this was done about it.
    pub emergency: Option<Emergency>,
}

/// What is done when no candidate can be driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Emergency {
    /// The candidate that touches somebody's prediction last.
    LatestContact,
    /// As hard a braking as the friction circle allows, along the path.
    Braking,
}

/// Plans cycle by cycle along one guide.
#[derive(Debug)]
pub struct Planner<'a> {
    settings: Settings,
    limits: Limits,
    guide: &'a Guide,
    road: &'a Road,
    dt: f64,
    /// What was chosen last, and at which step.
    last: Option<(i64, Profile, Lateral)>,
    hint: Option<f64>,
    profiles: Vec<Profile>,
    stations: Vec<Station>,
    candidates: Vec<Candidate>,
    order: Vec<usize>,
    /// Those of the traffic that any candidate could get near to.
    near: Traffic,
    now: Option<VehicleState>,
}

/// From one cycle to the next the place on the path moves less than this, metres.
const HINT: f64 = 15.0;

impl<'a> Planner<'a> {
    /// A planner along `guide` on `road`, for steps of `dt` seconds.
    #[must_use]
    pub fn new(settings: Settings, guide: &'a Guide, road: &'a Road, dt: f64) -> Self {
        Self {
            settings,
            limits: settings.limits(),
            guide,
            road,
            dt,
            last: None,
            hint: None,
            profiles: Vec::new(),
            stations: Vec::new(),
            candidates: Vec::new(),
            order: Vec::new(),
            near: Traffic::default(),
            now: None,
        }
    }

    /// Steps of the horizon.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.settings.steps(self.dt)
    }

    /// What to do from `now` at `step`, while the others do as `traffic` says.
    pub fn plan(&mut self, now: &VehicleState, step: i64, traffic: &Traffic) -> Plan {
        self.candidates.clear();
        self.profiles.clear();
        self.stations.clear();
        self.now = Some(*now);
        let Some((along, lateral)) = self.place(now) else {
            return self.stop(now, traffic, 0.0, 0);
        };
        // The goal asks for the centre of the body.
        let centre = along[0] + self.limits.rear_to_centre;
        let wanted = self.guide.wanted(centre, now.velocity, step, self.dt);
        let wanted = wanted.min(self.guide.bends.speed(along[0] + now.velocity));
        let moved = Moved::of(now);
        let settings = self.settings;
        let (limits, guide) = (self.limits, self.guide);
        let mut near = std::mem::take(&mut self.near);
        near.keep_near(traffic, moved.x, moved.y, |step| {
            let fastest = now.velocity.max(wanted) + FASTER;
            let body = limits.rear_to_centre + limits.length.hypot(limits.width) / 2.0;
            fastest * step as f64 * self.dt + settings.stopping(fastest) + body + CLEAR
        });
        let sampler = Sampler {
            settings: &settings,
            limits: &limits,
            guide,
            traffic,
            wanted,
            dt: self.dt,
        };
        let judge = Judge {
            settings: &settings,
            limits,
            traffic: &near,
            wanted,
            bends: &guide.bends,
            dt: self.dt,
            steps: self.steps(),
        };
        let mut found = None;
        for refinement in 0..=settings.sampling.refinements {
            let level = Level::new(&settings.sampling, refinement);
            if refinement == 0 {
                self.go_on(&judge, &moved, step);
            }
            self.sample(level, &sampler, &judge, &moved, along, &lateral);
            found = self.choose().map(|chosen| (refinement, chosen));
            if found.is_some() {
                break;
            }
        }
        self.near = near;
        if let Some((refinement, chosen)) = found {
            let candidate = self.candidates[chosen];
            let profile = self.profiles[candidate.profile];
            self.last = Some((step, profile, candidate.lateral));
            return Plan {
                states: self.states_of(&candidate),
                cost: candidate.cost,
                ..self.summary(wanted, refinement, None)
            };
        }
        self.stop(now, traffic, wanted, settings.sampling.refinements)
    }

    /// Where the state is along the path and across it.
    fn place(&mut self, now: &VehicleState) -> Option<([f64; 3], Start)> {
        let path = &self.guide.path;
        let near = self
            .hint
            .and_then(|hint| path.project_near(&now.rear.position, hint, HINT).ok());
        let at: Frenet = match near {
            Some(at) => at,
            None => path
                .project_near(&now.rear.position, self.guide.start, FIRST)
                .ok()
                .or_else(|| path.project(&now.rear.position).ok())?,
        };
        self.hint = Some(at.s);
        let profile = path.profile_at(at, now.rear.heading, now.curvature).ok()?;
        let point = path.at(at.s);
        let stretch = point.stretch(at).ok()?;
        let (sin, cos) = (now.rear.heading - point.heading).sin_cos();
        if cos <= 0.1 {
            return None;
        }
        let tan = sin / cos;
        let s1 = now.velocity * cos / stretch;
        let drift = point.curvature_rate * at.d + point.curvature * profile.d_s;
        let turn = now.curvature * stretch / cos - point.curvature;
        let s2 = (now.acceleration * cos - s1 * s1 * (stretch * tan * turn - drift)) / stretch;
        let along = [at.s, s1, s2];
        Some((along, start([profile.d, profile.d_s, profile.d_ss], along)))
    }

    /// What was chosen before, from here on.
    fn go_on(&mut self, judge: &Judge<'_>, now: &Moved, step: i64) {
        let Some((before, profile, lateral)) = self.last.take() else {
            return;
        };
        let later = (step - before) as f64 * self.dt;
        let profile = Profile {
            elapsed: profile.elapsed + later,
            ..profile
        };
        let first = self.stations.len();
        let laid = profile.lay(&self.guide.path, judge.steps, self.dt, &mut self.stations);
        let Some(profile) = laid else { return };
        let place = self.profiles.len();
        self.profiles.push(profile);
        let lateral = lateral.later(later);
        self.candidates
            .push(judge.follow(now, place, &profile, &self.stations[first..], lateral));
    }

    fn sample(
        &mut self,
        level: Level,
        sampler: &Sampler<'_>,
        judge: &Judge<'_>,
        now: &Moved,
        along: [f64; 3],
        start: &Start,
    ) {
        let first = self.profiles.len();
        sampler.profiles(level, along, &mut self.profiles);
        let steps = judge.steps;
        // Those that cannot be laid out make room for those that can.
        let mut kept = first;
        for place in first..self.profiles.len() {
            let profile = self.profiles[place];
            let laid = profile.lay(&self.guide.path, steps, self.dt, &mut self.stations);
            if let Some(profile) = laid {
                self.profiles[kept] = profile;
                kept += 1;
            }
        }
        self.profiles.truncate(kept);
        for place in first..kept {
            let profile = self.profiles[place];
            let stations = &self.stations[place * (steps + 1)..][..=steps];
            for target in level.offsets(self.settings.sampling.widest, start.by_length[0]) {
                for change in level.changes(self.settings.horizon) {
                    let lateral = if profile.slowest < self.settings.low_speed {
                        // As long as it would be at the present speed: whoever brakes does not turn sharper.
                        Lateral::over_length(start, target, along[0], along[1] * change)
                    } else {
                        Lateral::over_time(start, target, change)
                    };
                    self.candidates
                        .push(judge.follow(now, place, &profile, stations, lateral));
                }
            }
        }
    }

    /// The cheapest candidate that stays on the road.
    fn choose(&mut self) -> Option<usize> {
        let candidates = &self.candidates;
        self.order.clear();
        self.order
            .extend((0..candidates.len()).filter(|&i| candidates[i].rejected.is_none()));
        let cost = |i: usize| candidates[i].cost.total();
        // Of equal ones the first, so that nothing depends on the order of sorting.
        self.order
            .sort_unstable_by(|&a, &b| cost(a).total_cmp(&cost(b)).then(a.cmp(&b)));
        for n in 0..self.order.len() {
            let place = self.order[n];
            match self.leaves_road(&self.candidates[place]) {
                None => return Some(place),
                Some(step) => self.candidates[place].rejected = Some((step, Rejection::OffRoad)),
            }
        }
        None
    }

    /// The step at which a candidate leaves the road. Whoever starts off the road may first get onto it.
    fn leaves_road(&self, candidate: &Candidate) -> Option<usize> {
        let states = self.moments(candidate).map(|m| m.whole());
        self.road.left_at(states, &self.limits)
    }

    fn moments<'b>(&'b self, candidate: &'b Candidate) -> impl Iterator<Item = Moved> + 'b {
        let steps = self.steps();
        let stations = &self.stations[candidate.profile * (steps + 1)..][..=steps];
        let (now, dt) = (self.now, self.dt);
        let now = now.as_ref().map(Moved::of);
        stations
            .iter()
            .enumerate()
            .map_while(move |(i, at)| match now {
                // The present is given, and not to be rounded.
                Some(now) if i == 0 => Some(now),
                _ => state(at, candidate.lateral.at(i as f64 * dt, at.s)),
            })
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

    fn stop(
        &mut self,
        now: &VehicleState,
        traffic: &Traffic,
        wanted: f64,
        refinements: usize,
    ) -> Plan {
        self.last = None;
        let latest = self.candidates.iter().filter_map(|c| match c.rejected {
            Some((step, Rejection::Contact(_))) => Some((step, c)),
            _ => None,
        });
        let latest = latest.max_by(|a, b| {
            let dearer = b.1.cost.total().total_cmp(&a.1.cost.total());
            a.0.cmp(&b.0).then(dearer)
        });
        let latest = latest.map(|(step, candidate)| (step, *candidate));
        // The mildest braking that touches nobody; if all do, the one that does so last.
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
        match latest.filter(|(step, c)| touched < *step && self.leaves_road(c).is_none()) {
            Some((_, candidate)) => Plan {
                states: self.states_of(&candidate),
                cost: candidate.cost,
                ..self.summary(wanted, refinements, Some(Emergency::LatestContact))
            },
            None => Plan {
                states: braking,
                ..self.summary(wanted, refinements, Some(Emergency::Braking))
            },
        }
    }

    fn summary(&self, wanted: f64, refinements: usize, emergency: Option<Emergency>) -> Plan {
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
        }
    }
}

/// Shares of the full braking that are tried in an emergency.
const BRAKING: [f64; 3] = [0.4, 0.7, 1.0];

/// The start may lie this far from where the route has it, metres.
const FIRST: f64 = 20.0;

/// The first step at which somebody's predicted body is touched.
fn first_contact(states: &[VehicleState], traffic: &Traffic, limits: &Limits) -> Option<usize> {
    states.iter().enumerate().skip(1).find_map(|(step, state)| {
        let centre = state.centre(limits).pose;
        let (sin, cos) = centre.heading.sin_cos();
        let own = super::traffic::Own {
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
