//! What one does over some steps, each with its own times: turns, brakes, slows down, speeds up, changes lanes.

use std::f64::consts::FRAC_PI_2;

use serde::Serialize;

use super::{STANDING, TURN};
use crate::scenario::{Lane, LaneRelation, LaneletNetwork, Motion, Track};
use nearmiss_base::geometry::{Vector, angle_between};

/// Who slows down with less does not brake, m/s².
const BRAKING: f64 = 1.0;

/// Decelerations are those over so many seconds: single steps are noise.
const OVER: f64 = 0.4;

/// Headings of who moves less than this in all are noise, metres.
const LEAST_WAY: f64 = 2.0;

/// Who gains or loses less keeps on, m/s.
pub(super) const NOTABLE: f64 = 0.5;

/// The share by which speeds by places are off recorded ones, beside [`NOTABLE`].
const AS_RECORDED: f64 = 0.06;

/// Speeds that are off those by places by less are as recordings are, m/s.
const FAR_OFF: f64 = 2.0;

/// Headings that change by more between two steps are those of a reversal or of noise, where the way does not turn as they
/// do, radians: 30°.
const JUMP: f64 = 0.524;

/// Who turns by more between two steps goes back, radians: 135°.
const BACK: f64 = 2.356;

/// A turn to one side ends where the heading goes back by more, radians: 5°.
const SWAY: f64 = 0.087;

/// Who turns more slowly for a second follows a bend, rad/s: 5°/s.
const BEND: f64 = 0.087;

/// A rise or fall of the speed ends with a pause of so many seconds.
const PAUSE: f64 = 2.0;

/// Who gets faster by more in between brakes anew, m/s.
const FASTER: f64 = 0.3;

/// A braking goes on after a break of so many seconds.
const BREAK: f64 = 1.0;

/// What one does.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "action", rename_all = "snake_case")]
pub enum Action {
    /// Its speed falls with at least 1 m/s² over 0.4 s, with breaks of at most 1 s.
    Brake {
        /// Speed at the beginning, m/s.
        from_speed: f64,
        /// Speed at the end, m/s.
        to_speed: f64,
        /// The most over 0.4 s, or the mean where that is more, m/s².
        most: f64,
    },
    /// Its speed falls more slowly.
    SlowDown {
        /// Speed at the beginning, m/s.
        from_speed: f64,
        /// Speed at the end, m/s.
        to_speed: f64,
    },
    /// Its speed rises.
    SpeedUp {
        /// Speed at the beginning, m/s.
        from_speed: f64,
        /// Speed at the end, m/s.
        to_speed: f64,
    },
    /// Its heading changes by 15° or more, with 5°/s or more.
    Turn {
        /// To the left; negative to the right.
        degrees: f64,
    },
    /// Its middle comes into a lane beside its own.
    ChangeLanes {
        /// Which one that is.
        lane: Beside,
    },
    /// Its speed falls by less than 0.5 m/s.
    NotBrake,
    /// Its speed stays between these.
    KeepOn {
        /// The lowest, m/s.
        low: f64,
        /// The highest, m/s.
        high: f64,
    },
}

impl Action {
    /// How much there is to tell of it: m/s of a speed, 20° of a turn; braking tells most.
    fn weight(&self) -> f64 {
        match *self {
            Self::Brake {
                from_speed,
                to_speed,
                ..
            } => 2.0 * (from_speed - to_speed),
            Self::SlowDown {
                from_speed,
                to_speed,
            }
            | Self::SpeedUp {
                from_speed,
                to_speed,
            } => (from_speed - to_speed).abs(),
            Self::Turn { degrees } => degrees.abs() / 20.0,
            Self::ChangeLanes { .. } => 5.0,
            Self::NotBrake | Self::KeepOn { .. } => 0.0,
        }
    }

    /// Whether one gets slower.
    pub fn is_slowing(&self) -> bool {
        matches!(self, Self::Brake { .. } | Self::SlowDown { .. })
    }
}

/// A lane beside another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Beside {
    /// On the left, in the same direction.
    Left,
    /// On the right, in the same direction.
    Right,
    /// One of the opposite direction.
    Oncoming,
    /// One of its own direction, beside one of the opposite.
    Own,
}

/// An action from a step to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Doing {
    pub steps: (i64, i64),
    pub action: Action,
}

impl Doing {
    /// How much there is to tell of it, three times what goes on between these steps.
    pub fn weight(&self, (since, until): (i64, i64)) -> f64 {
        let is_late = self.steps.1 > since && self.steps.0 < until;
        let late = if is_late { 3.0 } else { 1.0 };
        late * self.action.weight()
    }
}

/// Motions at consecutive steps.
pub(super) struct Drive {
    all: Vec<(i64, Motion)>,
    dt: f64,
    /// All that it does, by their beginnings.
    pub doings: Vec<Doing>,
}

/// First and last place.
type Part = (usize, usize);

/// A braking, as [`Action::Brake`] says what one is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Braking {
    /// First and last step.
    pub steps: (i64, i64),
    /// From the first to the last step, m/s².
    pub mean: f64,
    /// The most over 0.4 s, m/s².
    pub most: f64,
}

/// The brakings of a track, in order.
pub(crate) fn brakings(track: &Track, dt: f64) -> Vec<Braking> {
    let all: Vec<(i64, Motion)> = track.iter().map(|(step, motion)| (step, *motion)).collect();
    let runs = all.chunk_by(|a, b| a.0 + 1 == b.0);
    let drives = runs.map(|run| Drive {
        all: run.to_vec(),
        dt,
        doings: Vec::new(),
    });
    let changes = drives.flat_map(|drive| drive.speed_changes());
    let braked = changes.filter_map(|Doing { steps, action }| match action {
        Action::Brake {
            from_speed,
            to_speed,
            most,
        } => Some(Braking {
            steps,
            mean: (from_speed - to_speed) / ((steps.1 - steps.0) as f64 * dt),
            most,
        }),
        _ => None,
    });
    braked.collect()
}

impl Drive {
    /// Those before and after a step without a gap.
    pub fn new(
        motion: impl Fn(i64) -> Option<Motion>,
        step: i64,
        dt: f64,
        network: &LaneletNetwork,
    ) -> Self {
        let there = |step: i64| motion(step).map(|motion| (step, motion));
        let mut all: Vec<_> = (i64::MIN..step).rev().map_while(there).collect();
        all.reverse();
        all.extend((step..).map_while(there));
        let mut drive = Self {
            all,
            dt,
            doings: Vec::new(),
        };
        let mut found = drive.speed_changes();
        found.extend(drive.turns());
        found.extend(drive.lane_changes(network));
        found.sort_by_key(|doing| doing.steps);
        drive.doings = found;
        drive
    }

    fn speed(&self, place: usize) -> f64 {
        self.all[place].1.velocity.abs()
    }

    fn places(&self, seconds: f64) -> usize {
        ((seconds / self.dt).round() as usize).max(1)
    }

    fn doing(&self, (from, to): Part, action: Action) -> Doing {
        Doing {
            steps: (self.all[from].0, self.all[to].0),
            action,
        }
    }

    /// The mean of the recorded speeds around a place and the speed by places there, m/s.
    fn speeds_around(&self, place: usize) -> (f64, f64) {
        let half = self.places(OVER / 2.0);
        let around = place.saturating_sub(half)..=(place + half).min(self.all.len() - 1);
        let (mut told, mut way, mut seconds) = (0.0, 0.0, 0.0);
        for pair in self.all[around].windows(2) {
            let time = (pair[1].0 - pair[0].0) as f64 * self.dt;
            told += (pair[0].1.velocity.abs() + pair[1].1.velocity.abs()) / 2.0 * time;
            way += (pair[1].1.pose.position - pair[0].1.pose.position).norm();
            seconds += time;
        }
        if seconds > 0.0 {
            (told / seconds, way / seconds)
        } else {
            (self.speed(place), self.speed(place))
        }
    }

    /// The part between the first and the last place around which recorded speeds are those by places, where two fifths of the
    /// change or more is by places, too: simulators tell speeds along a lane, and the body cuts its curve.
    fn driven(&self, (from, to): Part) -> Option<Part> {
        let is_driven = |place: &usize| {
            let (told, driven) = self.speeds_around(*place);
            (told - driven).abs() <= NOTABLE + AS_RECORDED * told
        };
        let first = (from..=to).find(is_driven)?;
        let last = (first..=to).rev().find(is_driven)?;
        let (before, after) = (self.speeds_around(first), self.speeds_around(last));
        let share = (after.1 - before.1) / (after.0 - before.0);
        (first < last && share >= 0.4).then_some((first, last))
    }

    /// By how much recorded speeds between two steps are off those by places, where that is much, m/s.
    pub fn off(&self, (from, to): (i64, i64)) -> Option<f64> {
        let places = (0..self.all.len()).filter(|place| (from..=to).contains(&self.all[*place].0));
        let off = places.filter_map(|place| {
            let (told, driven) = self.speeds_around(place);
            let off = (told - driven).abs();
            (off >= FAR_OFF.max(0.3 * told)).then_some(off)
        });
        off.max_by(f64::total_cmp)
    }

    /// From a step to the next within a second that is at least a metre away.
    pub fn next_way(&self, step: i64) -> Option<Vector> {
        let place = self.all.iter().position(|(own, _)| *own == step)?;
        self.way(place, place..place + self.places(1.0) + 1)
    }

    /// From a place to the next of others that is at least a metre away.
    fn way(&self, from: usize, others: impl Iterator<Item = usize>) -> Option<Vector> {
        let position = |place: usize| self.all.get(place).map(|(_, motion)| motion.pose.position);
        let from = position(from)?;
        let mut ways = others.filter_map(|place| Some(position(place)? - from));
        ways.find(|way| way.norm() >= 1.0)
    }

    /// Whether the way turns by about so much between a place and the next.
    fn way_turns(&self, place: usize, by: f64) -> bool {
        let before = self.way(place, (0..place).rev());
        let after = self.way(place + 1, place + 2..self.all.len());
        before.zip(after).is_some_and(|(before, after)| {
            let turned = angle_between((-before.y).atan2(-before.x), after.y.atan2(after.x));
            by.abs() < BACK && (turned - by).abs() < JUMP
        })
    }

    /// Turns of who moves.
    fn turns(&self) -> Vec<Doing> {
        let mut headings = vec![0.0; self.all.len().min(1)];
        let mut ways = headings.clone();
        for (place, pair) in self.all.windows(2).enumerate() {
            let (from, to) = (pair[0].1.pose, pair[1].1.pose);
            let by = angle_between(from.heading, to.heading);
            let is_turned = by.abs() <= JUMP || self.way_turns(place, by);
            headings.push(headings[place] + if is_turned { by } else { 0.0 });
            ways.push(ways[place] + (to.position - from.position).norm());
        }
        let legs = self.legs(&headings, SWAY, (1.0, BEND));
        let turned = |(from, to): Part| headings[to] - headings[from];
        let second = self.places(1.0);
        let turns = legs.into_iter().filter_map(|leg| {
            let part @ (from, to) = trimmed(&headings, leg)?;
            let around = (
                from.saturating_sub(second),
                (to + second).min(ways.len() - 1),
            );
            let is_turn = turned(leg).abs() >= TURN && ways[around.1] - ways[around.0] >= LEAST_WAY;
            let degrees = turned(part).to_degrees();
            is_turn.then(|| self.doing(part, Action::Turn { degrees }))
        });
        turns.collect()
    }

    /// When its middle comes into the lane beside its own, and is there a second later, too.
    fn lane_changes(&self, network: &LaneletNetwork) -> Vec<Doing> {
        let lanes = |place: usize| network.lanelets_driven(&self.all[place].1.pose);
        let mut found = Vec::new();
        let mut before: Vec<i64> = Vec::new();
        for place in 0..self.all.len() {
            let here = lanes(place);
            if here.is_empty() {
                continue;
            }
            let left = std::mem::replace(&mut before, here);
            if left.is_empty() || left.iter().any(|id| before.contains(id)) {
                continue;
            }
            let relations = network.lane_relations(&left);
            let closest = |all: &[i64]| all.iter().map(|id| relations.relation_to(*id)).min();
            let later = place + self.places(1.0);
            if later >= self.all.len() {
                break;
            }
            let side = closest(&before).filter(|side| closest(&lanes(later)) == Some(*side));
            let lane = match side {
                Some(LaneRelation::Left) => Beside::Left,
                Some(LaneRelation::Right) => Beside::Right,
                Some(LaneRelation::Oncoming) if self.is_against(network, &before, place) => {
                    Beside::Oncoming
                }
                Some(LaneRelation::Oncoming) => Beside::Own,
                _ => continue,
            };
            found.push(self.doing((place, place), Action::ChangeLanes { lane }));
        }
        found
    }

    /// Whether these lanelets lead against the heading at a place.
    fn is_against(&self, network: &LaneletNetwork, lanelets: &[i64], place: usize) -> bool {
        let pose = &self.all[place].1.pose;
        let mut lanes =
            { lanelets.iter() }.filter_map(|id| Lane::from_lanelet(network.lanelet(*id)?));
        lanes.any(|lane| {
            let along = lane.centre().project(&pose.position);
            let leads = lane.centre().pose_at(along.s).heading;
            angle_between(leads, pose.heading).abs() > FRAC_PI_2
        })
    }

    /// The speeds between two steps, m/s.
    fn between(&self, (from, to): (i64, i64)) -> impl Iterator<Item = f64> {
        let within = { self.all.iter() }.filter(move |(step, _)| (from..=to).contains(step));
        within.map(|(_, motion)| motion.velocity.abs())
    }

    /// Lowest and highest speed between two steps, m/s.
    pub fn speeds(&self, steps: (i64, i64)) -> (f64, f64) {
        let speeds = self.between(steps);
        speeds.fold((f64::INFINITY, 0.0), |(low, high), speed| {
            (low.min(speed), high.max(speed))
        })
    }

    /// The most by which the speed falls between two steps, m/s.
    pub fn loss(&self, steps: (i64, i64)) -> f64 {
        let (mut high, mut loss) = (0.0_f64, 0.0_f64);
        for speed in self.between(steps) {
            high = high.max(speed);
            loss = loss.max(high - speed);
        }
        loss
    }

    /// The deceleration around a place, m/s²: over [`OVER`], or as much of it as is recorded.
    fn slowing(&self, place: usize) -> f64 {
        let half = self.places(OVER / 2.0);
        let to = (place + half).min(self.all.len() - 1);
        self.mean((place.saturating_sub(half), to))
    }

    /// The mean deceleration from one place to another, m/s².
    fn mean(&self, (from, to): Part) -> f64 {
        let seconds = (self.all[to].0 - self.all[from].0) as f64 * self.dt;
        if seconds > 0.0 {
            (self.speed(from) - self.speed(to)) / seconds
        } else {
            0.0
        }
    }

    /// Brakings, and what else the speed falls and rises.
    fn speed_changes(&self) -> Vec<Doing> {
        let speeds: Vec<f64> = (0..self.all.len()).map(|place| self.speed(place)).collect();
        let legs = self.legs(&speeds, NOTABLE, (PAUSE, NOTABLE / 2.0));
        let brakings = self.brakings(&speeds, &legs);
        let mut found: Vec<Doing> = { brakings.iter() }
            .map(|&(first, last)| {
                let most = (first..=last).map(|place| self.slowing(place));
                let action = Action::Brake {
                    from_speed: speeds[first],
                    to_speed: speeds[last],
                    // What lasts less than that for which it is measured is more than it.
                    most: most.fold(self.mean((first, last)), f64::max),
                };
                self.doing((first, last), action)
            })
            .collect();
        for (from, to) in legs {
            // What is left of a fall before, between and after brakings.
            let mut start = from;
            let mut parts = Vec::new();
            for &(first, last) in brakings.iter().filter(|b| b.0 < to && b.1 > from) {
                parts.push((start, first.max(start)));
                start = last.min(to);
            }
            parts.push((start, to));
            let parts = parts.into_iter();
            found.extend(parts.filter_map(|part| self.speed_change(&speeds, part)));
        }
        found
    }

    /// A rise or fall of the speed. Who stands does so until it moves, and from when it stands on.
    fn speed_change(&self, speeds: &[f64], part: Part) -> Option<Doing> {
        let (mut from, mut to) = trimmed(speeds, part)?;
        let stands = |place: &usize| speeds[*place] < STANDING;
        let is_rise = speeds[to] > speeds[from];
        if is_rise {
            from = (part.0..to).take_while(stands).last().unwrap_or(from);
        } else {
            to = (from..=part.1).find(stands).unwrap_or(to);
        }
        let (from, to) = self.driven((from, to))?;
        let (from_speed, to_speed) = (speeds[from], speeds[to]);
        let by = (to_speed - from_speed).abs();
        let is_told = is_change(by, from_speed.max(to_speed));
        let action = if is_rise {
            Action::SpeedUp {
                from_speed,
                to_speed,
            }
        } else {
            Action::SlowDown {
                from_speed,
                to_speed,
            }
        };
        is_told.then(|| self.doing((from, to), action))
    }

    /// The times in which one brakes; with short breaks, in which it does not get faster, and to a stand where it rolls there.
    fn brakings(&self, speeds: &[f64], legs: &[Part]) -> Vec<Part> {
        let mut found: Vec<Part> = Vec::new();
        for place in (0..speeds.len()).filter(|place| self.slowing(*place) >= BRAKING) {
            match found.last_mut() {
                Some((first, last)) if self.goes_on(*first, *last, place) => *last = place,
                _ => found.push((place, place)),
            }
        }
        for i in 0..found.len() {
            let (first, last) = found[i];
            let next = found.get(i + 1).map(|next| next.0);
            let leg = legs.iter().find(|leg| (leg.0..leg.1).contains(&last));
            let to = leg.map_or(last, |leg| leg.1.max(last));
            let stand = (first..=to).find(|place| speeds[*place] < STANDING);
            let rolls = |stand: &usize| {
                self.mean((first, *stand)) >= BRAKING && next.is_none_or(|next| *stand <= next)
            };
            found[i].1 = stand.filter(rolls).unwrap_or(last);
        }
        let driven = found.into_iter().filter_map(|part| self.driven(part));
        let is_told = |(first, last): &Part| speeds[*first] - speeds[*last] >= NOTABLE;
        driven.filter(is_told).collect()
    }

    /// Whether a braking goes on at a place where one brakes again.
    fn goes_on(&self, first: usize, last: usize, again: usize) -> bool {
        let seconds = (self.all[again].0 - self.all[last].0) as f64 * self.dt;
        let faster = (last..=again).any(|place| self.speed(place) > self.speed(last) + FASTER);
        again == last + 1 || !faster && seconds <= BREAK && self.mean((first, again)) >= BRAKING
    }

    /// The rises and falls of values: none has a change back by `least` in it, nor a pause of so many seconds with a change
    /// of less than so much.
    fn legs(&self, values: &[f64], least: f64, pause: (f64, f64)) -> Vec<Part> {
        let mut ends: Vec<usize> = Vec::new();
        let (mut low, mut high) = (0, 0);
        let mut is_up = None;
        for (place, value) in values.iter().enumerate() {
            if *value <= values[low] {
                low = place;
            }
            if *value > values[high] {
                high = place;
            }
            if is_up != Some(true) && value - values[low] >= least {
                ends.push(low);
                (is_up, high) = (Some(true), place);
            } else if is_up != Some(false) && values[high] - value >= least {
                ends.push(high);
                (is_up, low) = (Some(false), place);
            }
        }
        ends.extend(is_up.map(|is_up| if is_up { high } else { low }));
        let legs = ends.windows(2).map(|ends| (ends[0], ends[1]));
        legs.flat_map(|leg| self.without_pauses(values, leg, pause))
            .collect()
    }

    /// The parts of a rise or fall around its pauses, in which it hardly changes.
    fn without_pauses(
        &self,
        values: &[f64],
        (from, to): Part,
        (seconds, least): (f64, f64),
    ) -> Vec<Part> {
        let pause = self.places(seconds);
        let (mut start, mut parts) = (from, Vec::new());
        let mut place = from;
        while place + pause <= to {
            if (values[place + pause] - values[place]).abs() >= least {
                place += 1;
                continue;
            }
            if start < place {
                // What little changes in the pause ends the part before it.
                parts.push((start, place + pause));
            }
            place += 1;
            start = place;
        }
        parts.push((start, to));
        parts
    }
}

/// The part in which values change: from where a twentieth of it is done to where a twentieth is left.
fn trimmed(values: &[f64], (from, to): Part) -> Option<Part> {
    let all = values[to] - values[from];
    let done = |place: usize| (values[place] - values[from]) / all;
    let first = (from..to).take_while(|place| done(*place) <= 0.05).last()?;
    let last = (first..=to).find(|place| done(*place) >= 0.95)?;
    (first < last).then_some((first, last))
}

/// Whether who has up to such a speed does more than keep on where it changes by so much, m/s.
pub(super) fn is_change(by: f64, high: f64) -> bool {
    by >= NOTABLE.max(0.08 * high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_base::geometry::Pose;

    /// One that drives along x with these speeds, a tenth of a second each.
    fn drive(speeds: &[f64]) -> Drive {
        let mut x = 0.0;
        let motions: Vec<Motion> = { speeds.iter() }
            .map(|velocity| {
                x += velocity * 0.1;
                Motion {
                    pose: Pose::new(x, 0.0, 0.0),
                    velocity: *velocity,
                    acceleration: 0.0,
                }
            })
            .collect();
        let at = |step: i64| motions.get(usize::try_from(step).ok()?).copied();
        Drive::new(at, 0, 0.1, &LaneletNetwork::default())
    }

    /// Steps, speeds and the most of each braking.
    fn brakings(drive: &Drive) -> Vec<((i64, i64), f64, f64, f64)> {
        let all = drive.doings.iter().filter_map(|doing| match doing.action {
            Action::Brake {
                from_speed,
                to_speed,
                most,
            } => Some((doing.steps, from_speed, to_speed, most)),
            _ => None,
        });
        all.collect()
    }

    fn rises(drive: &Drive) -> Vec<(i64, i64)> {
        let is_rise = |doing: &&Doing| matches!(doing.action, Action::SpeedUp { .. });
        let rises = drive.doings.iter().filter(is_rise);
        rises.map(|doing| doing.steps).collect()
    }

    #[test]
    fn the_most_of_a_braking_is_that_of_all_of_it() {
        // 8 m/s² for a second, then 2.
        let hard = (0..10).map(|i| 20.0 - 0.8 * f64::from(i));
        let soft = (0..10).map(|i| 12.0 - 0.2 * f64::from(i));
        let speeds: Vec<f64> = hard.chain(soft).collect();
        let [(_, from, to, most)] = brakings(&drive(&speeds))[..] else {
            panic!("one braking");
        };
        assert!(from > 18.0 && to < 11.0);
        assert!((most - 8.0).abs() < 0.1, "{most}");
    }

    #[test]
    fn the_most_of_a_short_braking_is_not_below_its_mean() {
        let mut speeds = vec![2.0; 10];
        speeds.extend([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let [((first, last), from, to, most)] = brakings(&drive(&speeds))[..] else {
            panic!("one braking");
        };
        assert!(most >= (from - to) / ((last - first) as f64 * 0.1) - 1e-9);
        assert_eq!(last, 11, "it stands from there on");
    }

    #[test]
    fn a_braking_goes_on_after_a_break_and_not_after_speeding_up() {
        let mut speeds: Vec<f64> = (0..10).map(|i| 20.0 - 0.3 * f64::from(i)).collect();
        speeds.extend([17.3; 6]);
        speeds.extend((0..10).map(|i| 17.3 - 0.3 * f64::from(i)));
        assert_eq!(brakings(&drive(&speeds)).len(), 1);
        for speed in &mut speeds[16..] {
            *speed += 1.0;
        }
        assert_eq!(brakings(&drive(&speeds)).len(), 2);
    }

    #[test]
    fn who_rolls_to_a_stand_brakes_to_a_stand_and_starts_when_it_moves() {
        let brake = (0..10).map(|i| 6.0 - 0.5 * f64::from(i));
        let roll = (0..10).map(|i| 1.0 - 0.08 * f64::from(i));
        let stand = [0.1; 20];
        let start = (0..20).map(|i| 0.1 + 0.15 * f64::from(i));
        let speeds: Vec<f64> = brake.chain(roll).chain(stand).chain(start).collect();
        let drive = drive(&speeds);
        let [((_, last), _, to, _)] = brakings(&drive)[..] else {
            panic!("one braking");
        };
        assert!(to < STANDING && last < 20, "{last}");
        let [(first, _)] = rises(&drive)[..] else {
            panic!("one rise");
        };
        assert!(speeds[first as usize] < STANDING && speeds[first as usize + 1] >= STANDING);
    }

    #[test]
    fn a_rise_ends_where_the_speed_falls_and_where_it_pauses() {
        let rising = (0..15).map(|i| 9.0 + 0.2 * f64::from(i));
        let again = (0..15).map(|i| 10.8 + 0.2 * f64::from(i));
        let speeds: Vec<f64> = rising.chain(again).collect();
        let [(0, end), (begin, 28..=29)] = rises(&drive(&speeds))[..] else {
            panic!("two rises");
        };
        assert!(end <= 14 && begin >= 14);
        let pause = [12.0; 25];
        let rising = (0..15).map(|i| 9.0 + 0.2 * f64::from(i));
        let again = (0..15).map(|i| 12.0 + 0.2 * f64::from(i));
        let speeds: Vec<f64> = rising.chain(pause).chain(again).collect();
        let [(0, 14..=16), (begin, _)] = rises(&drive(&speeds))[..] else {
            panic!("two rises");
        };
        assert!(begin >= 34, "{begin}");
    }

    #[test]
    fn a_turn_has_its_own_times() {
        let mut turning = drive(&[10.0; 60]);
        let mut at = Pose::new(0.0, 0.0, 0.0);
        for (step, motion) in &mut turning.all {
            let turned = (*step - 20).clamp(0, 20) as f64 / 20.0;
            at = Pose::new(
                at.position.x + at.heading.cos(),
                at.position.y + at.heading.sin(),
                turned * std::f64::consts::FRAC_PI_2,
            );
            motion.pose = at;
        }
        let turns = turning.turns();
        let [
            Doing {
                steps: (20..=22, 38..=40),
                action: Action::Turn { degrees },
            },
        ] = turns[..]
        else {
            panic!("{turns:?}");
        };
        assert!((80.0..=90.0).contains(&degrees), "{degrees}");
    }

    #[test]
    fn a_corner_within_a_step_is_a_turn_and_a_reversal_is_none() {
        let mut corner = drive(&[10.0; 30]);
        for (step, motion) in corner.all.iter_mut().skip(15) {
            motion.pose = Pose::new(15.0, (*step - 14) as f64, std::f64::consts::FRAC_PI_2);
        }
        assert_eq!(corner.turns().len(), 1);
        for (step, motion) in corner.all.iter_mut().skip(15) {
            motion.pose = Pose::new(29.0 - *step as f64, 0.0, std::f64::consts::PI);
        }
        assert!(corner.turns().is_empty());
    }

    #[test]
    fn a_rise_that_the_places_do_not_have_is_not_told() {
        let rising: Vec<f64> = (0..20).map(|i| 4.0 + 0.2 * f64::from(i)).collect();
        let mut lies = drive(&rising);
        assert_eq!(rises(&lies).len(), 1);
        for (step, motion) in &mut lies.all {
            motion.pose.position.x = 0.4 * *step as f64;
        }
        assert!(lies.speed_changes().is_empty());
    }
}
