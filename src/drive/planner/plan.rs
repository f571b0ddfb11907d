//! One planning cycle: sample, evaluate, select; the fallback when no candidate is left; what the cycle looked at.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::evaluate::{Allowed, CLEAR, Candidate, Cost, Judge, Rejection};
use super::lower_bound::LateralChanges;
use super::pace::{Hold, Pace, StopMemory};
use super::profile::{Lateral, Profile, Start};
use super::settings::{Level, MAX_SPEED_GAIN, Sampler};
use super::state::{Moved, Station, place, state};
use super::traffic::CloseTraffic;
use super::{Emergency, Limits, ReferenceTrack, Road, Settings, Traffic, VehicleState};

/// Decision of a planning cycle.
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
    /// A rule that asks for a stop ahead.
    pub hold: Option<Hold>,
}

/// State carried from one cycle to the next: with it, planning continues as if it had never stopped.
#[derive(Debug, Clone, Copy)]
pub struct Memory {
    last: Option<(i64, Profile, Lateral)>,
    hint: Option<f64>,
    stops: StopMemory,
}

/// Plans cycle by cycle along one guide.
#[derive(Debug)]
pub struct Planner<'a> {
    pub(super) settings: Settings,
    pub(super) limits: Limits,
    pub(super) guide: &'a ReferenceTrack,
    road: &'a Road,
    pub(super) dt: f64,
    /// What was chosen last, and at which step.
    pub(super) last: Option<(i64, Profile, Lateral)>,
    pub(super) hint: Option<f64>,
    /// Stop signs that were obeyed.
    pub(super) stops: StopMemory,
    /// What the rules asked for in the last cycle.
    pub(super) hold: Option<Hold>,
    pub(super) profiles: Vec<Profile>,
    pub(super) stations: Vec<Station>,
    pub(super) candidates: Vec<Candidate>,
    /// Costs and indices of the feasible candidates.
    order: Vec<(f64, usize)>,
    /// Those of the traffic that any candidate could get near to.
    near: Traffic,
    /// Those of them that the candidates of one profile can meet.
    close: CloseTraffic,
    /// What it was told last.
    told: Option<Traffic>,
    pub(super) now: Option<VehicleState>,
    pub(super) cancel: Cancel,
    only_best: bool,
    /// Of only the best: the cheapest candidate so far that stays on the road, with its cost.
    pub(super) best: Option<(f64, usize)>,
    /// Changes of the offset of a level: over time, and over arc length.
    pub(super) ways: [LateralChanges; 2],
    /// Of only the best: what each profile costs at least after each of its steps.
    pub(super) rest: Vec<f64>,
    /// Of only the best: the least that each candidate costs, its index and its way.
    pub(super) least: Vec<(f64, usize, usize)>,
}

impl<'a> Planner<'a> {
    /// A planner along `guide` on `road`, for steps of `dt` seconds.
    #[must_use]
    pub fn new(settings: Settings, guide: &'a ReferenceTrack, road: &'a Road, dt: f64) -> Self {
        Self {
            settings,
            limits: settings.limits(),
            guide,
            road,
            dt,
            last: None,
            hint: None,
            stops: StopMemory::default(),
            hold: None,
            profiles: Vec::new(),
            stations: Vec::new(),
            candidates: Vec::new(),
            order: Vec::new(),
            near: Traffic::default(),
            close: CloseTraffic::default(),
            told: None,
            now: None,
            cancel: Cancel::default(),
            only_best: false,
            best: None,
            ways: Default::default(),
            rest: Vec::new(),
            least: Vec::new(),
        }
    }

    /// The same planner, whose cycles end early when `cancel` asks for it.
    #[must_use]
    pub fn cancelled_by(mut self, cancel: &Cancel) -> Self {
        self.cancel = cancel.clone();
        self
    }

    /// The same planner, which gives up candidates as soon as another one is cheaper. It plans the same, sooner; its
    /// plans do not say how many candidates could be driven.
    #[must_use]
    pub fn only_best(self) -> Self {
        Self {
            only_best: true,
            ..self
        }
    }

    /// Keeps what it was told of the traffic in the cycle that has just ended, to be shown.
    pub fn keep_told(&mut self, traffic: Traffic) {
        self.told = Some(traffic);
    }

    /// What it was told of the traffic in its last cycle, if that was kept.
    #[must_use]
    pub fn traffic(&self) -> Option<&Traffic> {
        self.told.as_ref()
    }

    /// Steps of the horizon.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.settings.steps(self.dt)
    }

    /// What it carries to its next cycle.
    #[must_use]
    pub fn memory(&self) -> Memory {
        Memory {
            last: self.last,
            hint: self.hint,
            stops: self.stops,
        }
    }

    /// Plans on from where another planner, along the same guide and with the same settings, had this memory.
    pub fn recall(&mut self, memory: &Memory) {
        (self.last, self.hint, self.stops) = (memory.last, memory.hint, memory.stops);
    }

    /// What to do from `now` at `step`, while the others do as `traffic` says. A cycle that is cancelled looks at no
    /// further candidate: its plan is to be dropped.
    pub fn plan(&mut self, now: &VehicleState, step: i64, traffic: &Traffic) -> Plan {
        self.candidates.clear();
        self.profiles.clear();
        self.stations.clear();
        self.best = None;
        self.hold = None;
        self.now = Some(*now);
        let Some((along, lateral)) = place(self.guide, now, self.hint) else {
            return self.stop(now, traffic, 0.0, 0);
        };
        self.hint = Some(along[0]);
        // The goal asks for the centre of the body.
        let centre = along[0] + self.limits.rear_to_centre;
        let wanted = self
            .guide
            .wanted(centre, now.velocity, step, self.dt)
            .min(self.guide.bends.speed(along[0] + now.velocity));
        let (wanted, legal) = self.legal(wanted, centre, now.velocity);
        let stop = self.stop_ahead(now, along[0], step, traffic, wanted);
        let moved = Moved::from_state(now);
        let settings = self.settings;
        let (limits, guide) = (self.limits, self.guide);
        let mut near = std::mem::take(&mut self.near);
        near.keep_near(traffic, moved.x, moved.y, |step| {
            let fastest = now.velocity.max(wanted) + MAX_SPEED_GAIN;
            let body = limits.rear_to_centre + limits.length.hypot(limits.width) / 2.0;
            fastest * step as f64 * self.dt + settings.stopping(fastest) + body + CLEAR
        });
        let sampler = Sampler {
            settings: &settings,
            limits: &limits,
            guide,
            traffic,
            wanted,
            stop,
            dt: self.dt,
        };
        let pace = Pace {
            wanted,
            bends: &guide.bends,
            legal,
            stop,
            centre: limits.rear_to_centre,
            now: now.velocity,
        };
        let judge = Judge {
            settings: &settings,
            allowed: Allowed::new(limits, self.dt),
            traffic: &near,
            dt: self.dt,
            steps: self.steps(),
        };
        let mut found = None;
        for refinement in 0..=settings.sampling.refinements {
            let level = Level::new(&settings.sampling, refinement);
            if refinement == 0 {
                self.go_on(&judge, &pace, &moved, step);
            }
            self.sample(level, &sampler, (&judge, &pace), &moved, along, &lateral);
            found = self.choose().map(|chosen| (refinement, chosen));
            if found.is_some() || self.cancel.is_asked() {
                break;
            }
        }
        self.near = near;
        if self.cancel.is_asked() {
            return self.summary(wanted, 0, None);
        }
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

    /// What was chosen before, from here on.
    fn go_on(&mut self, judge: &Judge<'_>, pace: &Pace<'_>, now: &Moved, step: i64) {
        let Some((before, profile, lateral)) = self.last.take() else {
            return;
        };
        let later = (step - before) as f64 * self.dt;
        let profile = Profile {
            elapsed: profile.elapsed + later,
            ..profile
        };
        let first = self.stations.len();
        let path = &self.guide.path;
        let laid = profile.lay(path, pace, judge.steps, self.dt, &mut self.stations);
        let Some(profile) = laid else { return };
        let place = self.profiles.len();
        self.profiles.push(profile);
        let lateral = lateral.later(later);
        let stations = &self.stations[first..];
        let (settings, limits) = (judge.settings, &judge.allowed.limits);
        self.close.take(judge.traffic, stations, settings, limits);
        let along = (stations, &self.close);
        let candidate = judge.follow(now, place, &profile, along, (lateral, &[]), [&[]; 2], None);
        self.candidates.push(candidate);
        if self.only_best {
            self.ask_road(self.candidates.len() - 1);
        }
    }

    fn sample(
        &mut self,
        level: Level,
        sampler: &Sampler<'_>,
        (judge, pace): (&Judge<'_>, &Pace<'_>),
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
            if self.cancel.is_asked() {
                break;
            }
            let profile = self.profiles[place];
            let path = &self.guide.path;
            let laid = profile.lay(path, pace, steps, self.dt, &mut self.stations);
            if let Some(profile) = laid {
                self.profiles[kept] = profile;
                kept += 1;
            }
        }
        self.profiles.truncate(kept);
        for (ways, by_length) in self.ways.iter_mut().zip([false, true]) {
            ways.lay(judge, level, start, along, by_length);
        }
        if self.only_best {
            return self.follow_best(first..kept, judge, now);
        }
        for place in first..kept {
            let profile = self.profiles[place];
            let stations = &self.stations[place * (steps + 1)..][..=steps];
            let (settings, limits) = (judge.settings, &judge.allowed.limits);
            self.close.take(judge.traffic, stations, settings, limits);
            let along = (stations, &self.close);
            let slow = usize::from(profile.slowest < self.settings.low_speed);
            let ways = &self.ways[slow];
            for (i, way) in ways.list.iter().enumerate() {
                if self.cancel.is_asked() {
                    return;
                }
                let lateral = (way.lateral, ways.offsets(i, steps));
                let followed = judge.follow(now, place, &profile, along, lateral, [&[]; 2], None);
                self.candidates.push(followed);
            }
        }
    }

    /// The cheapest candidate that stays on the road.
    fn choose(&mut self) -> Option<usize> {
        if self.only_best {
            return self.best.map(|(_, place)| place);
        }
        let candidates = &self.candidates;
        self.order.clear();
        let drivable = candidates
            .iter()
            .enumerate()
            .filter(|(_, c)| c.rejected.is_none());
        self.order
            .extend(drivable.map(|(place, c)| (c.cost.total(), place)));
        // Of equal ones the first, so that nothing depends on the order of sorting.
        self.order
            .sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for n in 0..self.order.len() {
            if self.cancel.is_asked() {
                return None;
            }
            let (_, place) = self.order[n];
            match self.leaves_road(&self.candidates[place]) {
                None => return Some(place),
                Some(step) => self.candidates[place].rejected = Some((step, Rejection::OffRoad)),
            }
        }
        None
    }

    /// The step at which a candidate leaves the road. An ego that starts off the road may first get onto it.
    pub(super) fn leaves_road(&self, candidate: &Candidate) -> Option<usize> {
        let states = self.moments(candidate).map(|m| m.state());
        self.road.left_at(states, &self.limits)
    }
}

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
        let mut states: Vec<VehicleState> = self.moments(candidate).map(|m| m.state()).collect();
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

/// A wish that planning ends early, shared between the planner and the code that waits for it.
#[derive(Debug, Clone, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// The wish that `flag` stands for.
    #[must_use]
    pub fn from_flag(flag: &Arc<AtomicBool>) -> Self {
        Self(Arc::clone(flag))
    }

    /// Asks for it.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether planning is to end: what comes out of it then is not whole, and is to be dropped.
    #[must_use]
    #[inline]
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
