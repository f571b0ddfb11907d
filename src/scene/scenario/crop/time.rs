//! Some steps of motions: states, signals, occupancies and lights in that time, and their numbers.

use std::ops::RangeInclusive;

use crate::scenario::{
    Ego, LaneletNetwork, Motion, Obstacle, ObstacleParts, ObstacleRole, Occupancy, Prediction,
    Quantity, Sample, SignalState, State, Steps, Track,
};

/// Consecutive steps that are kept.
pub(super) struct Cut {
    first: i64,
    last: i64,
    /// What is subtracted from steps.
    shift: i64,
    /// Seconds between steps.
    pub dt: f64,
}

impl Cut {
    /// `dt` are seconds between steps.
    pub fn new(steps: Option<&RangeInclusive<i64>>, from_zero: bool, dt: f64) -> Self {
        let (first, last) = steps.map_or((i64::MIN, i64::MAX), |s| (*s.start(), *s.end()));
        let shift = match steps {
            Some(_) if from_zero => first,
            _ => 0,
        };
        Self {
            first,
            last,
            shift,
            dt,
        }
    }

    /// The steps, as they were numbered.
    pub fn steps(&self) -> RangeInclusive<i64> {
        self.first..=self.last
    }

    /// What is said where steps have other numbers.
    pub fn renumbered(&self) -> Option<String> {
        (self.shift != 0).then(|| format!("; step {} became step 0", self.shift))
    }

    fn has(&self, step: i64) -> bool {
        (self.first..=self.last).contains(&step)
    }

    /// The new number of a step.
    pub fn numbered(&self, step: i64) -> i64 {
        step.saturating_sub(self.shift)
    }

    /// The part of a time that is kept.
    fn part(&self, time: Steps) -> Option<Steps> {
        let overlaps = time.from <= self.last && time.to >= self.first;
        overlaps.then(|| self.nearest(time))
    }

    /// A time moved into the one that is kept.
    fn nearest(&self, time: Steps) -> Steps {
        Steps {
            from: self.numbered(time.from.clamp(self.first, self.last)),
            to: self.numbered(time.to.clamp(self.first, self.last)),
        }
    }

    fn state(&self, state: &State) -> State {
        State {
            time: self.nearest(state.time),
            ..state.clone()
        }
    }

    /// The obstacle in this time; nothing where it is not there, or for one state of several.
    pub fn obstacle(&self, obstacle: &Obstacle) -> Option<Obstacle> {
        let stands = obstacle.role == ObstacleRole::Static;
        let all: Vec<&State> = obstacle.states().collect();
        let inside = |(i, state): &(usize, &&State)| {
            // One that stands does so at all times.
            self.has(state.time.from) || stands && *i == 0
        };
        let kept = all.iter().enumerate().filter(inside);
        let mut states: Vec<State> = kept.map(|(_, s)| self.state(s)).collect();
        if let (Some(first), Some(before)) = (states.first_mut(), all.first())
            && first.time.from != self.numbered(before.time.from)
            && let Some(motion) = obstacle
                .track()
                .at(first.time.from.saturating_add(self.shift))
        {
            say(first, motion);
        }
        let enough = all.len().min(2);
        let prediction = match &obstacle.prediction {
            Prediction::Occupancies(regions) => {
                let part = |one: &Occupancy| {
                    let time = self.part(one.time);
                    Some(Occupancy {
                        time: time.or(stands.then(|| self.nearest(one.time)))?,
                        region: one.region.clone(),
                    })
                };
                let regions: Vec<Occupancy> = regions.iter().filter_map(part).collect();
                if regions.is_empty() {
                    return None;
                }
                Prediction::Occupancies(regions)
            }
            _ if !stands && states.len() < enough => return None,
            Prediction::None => Prediction::None,
            Prediction::Trajectory(_) if stands && states.len() < 2 => Prediction::None,
            Prediction::Trajectory(_) => {
                Prediction::Trajectory(states.split_off(1.min(states.len())))
            }
        };
        let signals = obstacle.signals.iter().filter_map(|state| {
            Some(SignalState {
                time: self.part(state.time)?,
                signals: state.signals.clone(),
            })
        });
        let parts = ObstacleParts {
            id: obstacle.id,
            role: obstacle.role,
            kind: obstacle.kind,
            footprint: obstacle.footprint.clone(),
            initial: states.into_iter().next(),
            prediction,
            signals: signals.collect(),
        };
        Some(Obstacle::new(parts, self.dt))
    }

    /// The ego in this time; nothing where it is not there.
    pub fn ego(&self, ego: &Ego) -> Option<Ego> {
        let samples = ego.track.iter().filter(|(step, _)| self.has(*step));
        let samples: Vec<Sample> = samples.map(|(step, m)| self.sample(step, m)).collect();
        if samples.is_empty() {
            return None;
        }
        let mut track = Track::new(samples, self.dt, None);
        // What was filled was filled before.
        track.derived = ego.track.derived;
        let recorded = ego.recorded.iter().filter(|sample| self.has(sample.step));
        Some(Ego {
            track,
            recorded: recorded
                .map(|sample| Sample {
                    step: self.numbered(sample.step),
                    ..*sample
                })
                .collect(),
            ..ego.clone()
        })
    }

    fn sample(&self, step: i64, motion: &Motion) -> Sample {
        Sample {
            step: self.numbered(step),
            position: motion.pose.position,
            heading: Some(motion.pose.heading),
            velocity: Some(motion.velocity),
            acceleration: Some(motion.acceleration),
        }
    }

    /// The road, whose lights show the same at the new steps.
    pub fn network(&self, mut network: LaneletNetwork) -> LaneletNetwork {
        if self.shift != 0 {
            for light in &mut network.lights {
                let period: i64 = light.cycle.iter().map(|p| p.duration.max(0)).sum();
                let offset = light.offset.saturating_sub(self.shift);
                light.offset = match period {
                    1.. if offset < 0 => offset.rem_euclid(period),
                    _ => offset,
                };
            }
        }
        network
    }
}

/// Lets a first state say what was worked out from those before it, so that its motion stays what it was.
fn say(state: &mut State, motion: &Motion) {
    if state.point_mass_velocity().is_none() {
        state
            .orientation
            .get_or_insert(Quantity::Exact(motion.pose.heading));
        state
            .velocity
            .get_or_insert(Quantity::Exact(motion.velocity));
    }
    state
        .acceleration
        .get_or_insert(Quantity::Exact(motion.acceleration));
}
