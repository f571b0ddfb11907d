//! Implausible motions: contradictions between successive states, and time steps missing, repeated or far away.
//!
//! The thresholds leave alone what recorded and simulated traffic holds: positions and speeds that are a step apart,
//! noise at standstill, vehicles that a simulation stops within a step.

use nearmiss_base::geometry::angle_between;

use super::and_more;
use crate::scenario::{LONGEST_TRACK, Sample};

/// Below this speed the direction of motion is undefined, m/s.
const MIN_SPEED: f64 = 1.0;

/// Shorter moves have no direction, metres.
const MIN_MOVE: f64 = 0.5;

/// A vehicle does not slide at a larger angle to its heading: 60°.
const SIDEWAYS: f64 = std::f64::consts::FRAC_PI_3;

/// Faster than this, m/s, it slides at less than this angle, 35°, or it is in a spin.
const FAST_SIDEWAYS: (f64, f64) = (8.0, 35.0 * std::f64::consts::PI / 180.0);

/// No vehicle turns farther within a step: 90°.
const LARGEST_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// In steps longer than this, seconds, anything may have happened.
const MAX_STEP: f64 = 1.0;

/// Changes of speed beyond this, m/s², and by more than this, m/s, are none.
const MAX_SPEED_CHANGE: (f64, f64) = (60.0, 5.0);

/// Speeds and positions that differ by this factor, and by this, metres, are in different units.
const FACTOR: (f64, f64) = (3.0, 10.0);

/// A state with its place in the file.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// The place, from 0.
    pub place: usize,
    /// What is known there.
    pub sample: Sample,
}

/// Contradictions between successive states: the index of the state and the message.
///
/// `rows` are in order of time, one a step, `dt` seconds apart. Pedestrians may turn and sidestep freely.
pub fn doubts(rows: &[Row], dt: f64, walks: bool) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let pairs = || {
        let pairs = rows
            .windows(2)
            .map(|pair| Pair::between(&pair[0], &pair[1], dt));
        pairs.filter(|pair| pair.time > 0.0)
    };
    type Doubt = fn(&Pair<'_>) -> Option<String>;
    let everyone: &[Doubt] = &[|pair| pair.speed_change(), |pair| pair.standing()];
    let vehicles: &[Doubt] = &[|pair| pair.turn(), |pair| pair.sideways()];
    let asked = everyone.iter().chain(vehicles.iter().filter(|_| !walks));
    for doubt in asked {
        let mut said = pairs().filter_map(|pair| Some((pair.place, doubt(&pair)?)));
        if let Some((place, first)) = said.next() {
            found.push((place, and_more(first, said.count())));
        }
    }
    found.extend(path_and_speed(rows, dt));
    found
}

/// Two successive states.
struct Pair<'a> {
    place: usize,
    a: &'a Sample,
    b: &'a Sample,
    /// Seconds between them.
    time: f64,
    /// Metres between them.
    moved: f64,
}

impl<'a> Pair<'a> {
    fn between(a: &'a Row, b: &'a Row, dt: f64) -> Self {
        let place = b.place;
        let (a, b) = (&a.sample, &b.sample);
        Self {
            place,
            a,
            b,
            time: b.step.saturating_sub(a.step) as f64 * dt,
            moved: (b.position - a.position).norm(),
        }
    }

    fn steps(&self) -> String {
        format!("from time step {} to {}", self.a.step, self.b.step)
    }

    fn speed_change(&self) -> Option<String> {
        let (a, b) = (self.a.velocity?, self.b.velocity?);
        let (rate, by) = MAX_SPEED_CHANGE;
        let changes = (b - a).abs() > by.max(rate * self.time);
        changes.then(|| {
            format!(
                "speed changes from {a} to {b} m/s {}, within {} s",
                self.steps(),
                self.time
            )
        })
    }

    /// It hardly moves, and says that it drives.
    fn standing(&self) -> Option<String> {
        let (a, b) = (self.a.velocity?, self.b.velocity?);
        let told = a.abs().min(b.abs()) * self.time;
        // The loss of speed under full braking, and the inexactness of records.
        let slack = 2.0 + 10.0 * self.time * self.time;
        (self.time <= MAX_STEP && told > self.moved + slack).then(|| {
            format!(
                "moves {:.1} m {}; its speed implies {told:.1} m",
                self.moved,
                self.steps()
            )
        })
    }

    fn turn(&self) -> Option<String> {
        let turn = angle_between(self.a.heading?, self.b.heading?);
        let drives = [self.a, self.b]
            .iter()
            .all(|s| s.velocity.is_some_and(|v| v.abs() > MIN_SPEED));
        (self.time <= MAX_STEP && drives && turn.abs() > LARGEST_TURN).then(|| {
            format!(
                "heading turns by {:.0}° {}",
                turn.to_degrees(),
                self.steps()
            )
        })
    }

    /// It moves neither the way it looks nor backwards from there.
    fn sideways(&self) -> Option<String> {
        let moves = self.moved >= MIN_MOVE && self.moved >= MIN_SPEED * self.time;
        if !moves || self.time > MAX_STEP {
            return None;
        }
        let between = self.b.position - self.a.position;
        let way = between.y.atan2(between.x);
        let off = |s: &Sample| Some((angle_between(s.heading?, way), s.velocity?));
        let (a, b) = (off(self.a)?, off(self.b)?);
        let (fast, less) = FAST_SIDEWAYS;
        let most = if self.moved > fast * self.time {
            less
        } else {
            SIDEWAYS
        };
        let agrees = |(off, velocity): (f64, f64)| {
            let off = off.abs();
            let off = if velocity < 0.0 {
                std::f64::consts::PI - off
            } else {
                off
            };
            off <= most
        };
        if agrees(a) || agrees(b) {
            return None;
        }
        let (steps, (off, velocity)) = (self.steps(), b);
        Some(if off.abs() < SIDEWAYS {
            format!("moves forwards {steps}, but its speed of {velocity} m/s implies backwards")
        } else if velocity >= 0.0 && off.abs() > std::f64::consts::PI - SIDEWAYS {
            format!("moves backwards {steps}, but its speed of {velocity} m/s implies forwards")
        } else {
            format!(
                "moves at {:.0}° to its heading {steps}; is the heading in degrees, or of another vehicle?",
                off.to_degrees()
            )
        })
    }
}

/// The way that the positions tell against the way that the speeds tell.
fn path_and_speed(rows: &[Row], dt: f64) -> Option<(usize, String)> {
    let (mut path, mut told) = (0.0, 0.0);
    for pair in rows.windows(2) {
        let pair = Pair::between(&pair[0], &pair[1], dt);
        if pair.time > MAX_STEP {
            continue;
        }
        let (a, b) = (pair.a.velocity?, pair.b.velocity?);
        told += f64::midpoint(a.abs(), b.abs()) * pair.time;
        path += pair.moved;
    }
    let (factor, least) = FACTOR;
    let (less, more) = (path.min(told), path.max(told));
    (more > factor * less && more - less > least).then(|| {
        let message =
            format!("positions cover {path:.1} m, but speeds {told:.1} m; both are used as is");
        (rows[0].place, message)
    })
}

/// What is wrong with the time steps of a row of states, in the order of the file: the place of the state at which it
/// shows, and the words.
pub(crate) fn check(steps: &[i64]) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut order: Vec<usize> = (0..steps.len()).collect();
    order.sort_by_key(|i| steps[*i]);
    let pairs = || order.windows(2).map(|pair| (pair[0], pair[1]));
    let twice = pairs().find(|(a, b)| steps[*a] == steps[*b]);
    let back = steps.windows(2).position(|pair| pair[1] < pair[0]);
    if let Some((_, second)) = twice {
        let message = format!(
            "time step {} has two states; the first is used",
            steps[second]
        );
        found.push((second, message));
    }
    if let Some(place) = back.filter(|_| twice.is_none()) {
        let falling = steps.windows(2).all(|pair| pair[1] < pair[0]);
        let message = if falling && steps.len() > 2 {
            "the states run backwards in time and were sorted"
        } else {
            "the states are not in time order and were sorted"
        };
        found.push((place + 1, message.into()));
    }
    found.extend(gaps(steps, pairs()));
    let (Some(first), Some(last)) = (order.first(), order.last()) else {
        return found;
    };
    if steps[*first] < 0 {
        let message = format!("starts at time step {}, before the scenario", steps[*first]);
        found.push((*first, message));
    }
    if steps[*first] > LONGEST_TRACK {
        let message = format!("starts only at time step {}", steps[*first]);
        found.push((*first, message));
    }
    if steps[*last].saturating_sub(steps[*first]) > LONGEST_TRACK {
        let late = order
            .iter()
            .find(|i| steps[**i].saturating_sub(steps[*first]) > LONGEST_TRACK);
        let message =
            format!("states more than {LONGEST_TRACK} steps after the first were left out");
        found.push((*late.unwrap_or(last), message));
    }
    found
}

/// The diagnostic for gaps between steps in order of time.
pub fn missing(steps: &[i64]) -> Option<(usize, String)> {
    gaps(steps, (1..steps.len()).map(|i| (i - 1, i)))
}

/// Steps between the first and the last without a state.
fn gaps(steps: &[i64], pairs: impl Iterator<Item = (usize, usize)>) -> Option<(usize, String)> {
    let apart: Vec<(usize, i64, i64)> = pairs
        .map(|(a, b)| (b, steps[a], steps[b]))
        .filter(|(_, a, b)| a != b)
        .collect();
    let stride = apart.first().map_or(1, |(_, a, b)| b - a);
    let gaps = apart.iter().filter(|(_, a, b)| b - a > 1);
    let (place, a, b) = *gaps.clone().next()?;
    let even = apart.len() > 2 && apart.iter().all(|(_, a, b)| b - a == stride);
    let message = if even {
        format!("only one state every {stride} time steps; are its times in another unit?")
    } else {
        let missing = match b - a {
            2 => format!("no state at time step {}", a + 1),
            _ => format!("no states from time step {} to {}", a + 1, b - 1),
        };
        and_more(format!("{missing}; assumed absent"), gaps.count() - 1)
    };
    Some((place, message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_base::geometry::Point;

    /// A drive along x: positions, heading and velocity of each step.
    fn drive(states: &[(f64, f64, f64)]) -> Vec<Row> {
        let row = |(place, &(x, heading, velocity)): (usize, &(f64, f64, f64))| Row {
            place,
            sample: Sample {
                step: place as i64,
                position: Point::new(x, 0.0),
                heading: Some(heading),
                velocity: Some(velocity),
                acceleration: None,
            },
        };
        states.iter().enumerate().map(row).collect()
    }

    fn even(heading: f64, velocity: f64, stride: f64) -> Vec<(f64, f64, f64)> {
        (0..20)
            .map(|i| (f64::from(i) * stride, heading, velocity))
            .collect()
    }

    #[test]
    fn driving_forwards_and_backwards_is_possible() {
        for states in [
            even(0.0, 10.0, 1.0),
            even(std::f64::consts::PI, -10.0, 1.0),
            even(0.0, 0.0, 0.0),
            even(9.0 * std::f64::consts::TAU, 10.0, 1.0),
        ] {
            assert_eq!(doubts(&drive(&states), 0.1, false), []);
        }
        assert_eq!(doubts(&[], 0.1, false), []);
    }

    #[test]
    fn what_states_say_against_each_other() {
        let changed = |at: usize, state: (f64, f64, f64)| {
            let mut states = even(0.0, 10.0, 1.0);
            states[at] = state;
            states
        };
        for (states, place, words) in [
            (even(1.6, 10.0, 1.0), 1, "-92° to its heading"),
            (
                even(0.0, -10.0, 1.0),
                1,
                "forwards from time step 0 to 1, but its speed of -10",
            ),
            (
                even(3.1, 10.0, 1.0),
                1,
                "backwards from time step 0 to 1, but its speed of 10",
            ),
            (
                changed(7, (7.0, 3.0, 10.0)),
                7,
                "turns by 172° from time step 6 to 7 (and 1 more)",
            ),
            (changed(7, (7.0, 0.0, 99.0)), 7, "from 10 to 99 m/s"),
            (even(0.0, 60.0, 0.0), 1, "moves 0.0 m"),
            (even(0.0, 36.0, 1.0), 0, "cover 19.0 m, but speeds 68.4 m"),
            (even(0.0, 0.0, 1.0), 0, "cover 19.0 m, but speeds 0.0 m"),
        ] {
            let found = doubts(&drive(&states), 0.1, false);
            let hit = found
                .iter()
                .any(|(at, said)| *at == place && said.contains(words));
            assert!(hit, "{words}: {found:?}");
        }
        let beside = doubts(&drive(&even(1.6, 10.0, 1.0)), 0.1, true);
        assert_eq!(beside, [], "pedestrians may step aside");
    }

    #[test]
    fn times_that_are_wrong_are_told_where_they_show() {
        let all = |steps: &[i64]| check(steps);
        assert_eq!(all(&[]), []);
        assert_eq!(all(&[0, 1, 2, 3]), []);
        assert_eq!(all(&[7]), []);
        for (steps, place, words) in [
            (&[0, 1, 1, 2][..], 2, "time step 1 has two states"),
            (&[0, 2, 1, 3], 2, "not in time order"),
            (&[3, 2, 1, 0], 1, "run backwards"),
            (&[0, 1, 3, 4], 2, "no state at time step 2;"),
            (&[0, 1, 12, 13], 2, "no states from time step 2 to 11;"),
            (&[0, 2, 3, 9, 10], 1, "(and 1 more)"),
            (
                &[0, 100, 200, 300],
                1,
                "only one state every 100 time steps",
            ),
            (&[-3, -2, -1, 0], 0, "starts at time step -3"),
            (&[0, 1_000_000], 1, "were left out"),
            (&[900_000, 900_001], 0, "starts only at time step 900000"),
        ] {
            let found = all(steps);
            let hit = found
                .iter()
                .any(|(at, said)| *at == place && said.contains(words));
            assert!(hit, "{steps:?}: {found:?}");
        }
    }
}
