//! Windows around one track of a long recording: how they are named, and which of them are worth looking at.
//!
//! A window is worth looking at if two bodies in it would soon meet, were each to keep its velocity. That is a quick
//! look over the whole recording, not one of the measures: these are taken once a window is open.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::report::Report;
use crate::formats::commonroad::ReadError;
use crate::geometry::{Point, Vector};

/// Length of a window, seconds.
pub const LENGTH: f64 = 10.0;

/// So much of a window lies after its worst moment, seconds.
const AFTER: f64 = 3.0;

/// Recordings up to this long are one scenario, seconds.
pub const SHORT: f64 = 30.0;

/// Windows of a recording that are listed.
const MOST: usize = 50;

/// Meetings later than this are not foreseen, seconds.
const FORESIGHT: f64 = 8.0;

/// Bodies farther apart are not compared, metres.
const NEAR: f64 = 60.0;

/// A track shorter than this is no ego, seconds.
const SHORTEST: f64 = 2.0;

/// What is slower stands, m/s.
const STANDING: f64 = 0.5;

/// Bodies that are looked at in one recording.
const MOST_LOOKS: usize = 40_000_000;

/// Which part of a recording: a track, and when its window begins; without a time, as long as the track is there.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// The track's name in the recording.
    pub track: String,
    /// Seconds.
    pub start: Option<f64>,
}

impl Wanted {
    /// Reads `track=NAME` or `track=NAME@34.0s`.
    ///
    /// # Errors
    /// It is something else.
    pub fn parse(part: &str, report: &Report) -> Result<Self, ReadError> {
        let wrong = || {
            report.fail(format!(
                "`{part}` is no window; name one as `track=12@34.0s`, or a whole track as `track=12`"
            ))
        };
        let rest = part.strip_prefix("track=").ok_or_else(wrong)?;
        // Names of tracks may have an `@`, times have none.
        let timed = rest.rsplit_once('@').and_then(|(track, time)| {
            let seconds: f64 = time.strip_suffix('s').unwrap_or(time).parse().ok()?;
            (seconds.is_finite() && seconds.abs() < 1e7).then_some((track, Some(seconds)))
        });
        let (track, start) = timed.unwrap_or((rest, None));
        if track.is_empty() {
            return Err(wrong());
        }
        Ok(Self {
            track: track.to_string(),
            start,
        })
    }
}

/// A body at one of the moments that are looked at.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// Place of its track.
    pub track: u32,
    /// Seconds.
    pub time: f64,
    pub position: Point,
    pub velocity: Vector,
    pub heading: f64,
    /// Half its length and width, metres.
    pub half: (f64, f64),
}

impl Look {
    fn moves(&self) -> bool {
        self.velocity.norm() >= STANDING
    }
}

/// What is seen of a recording at a few moments a second.
#[derive(Default)]
pub struct Looks {
    /// By the number of the moment.
    moments: BTreeMap<i64, Vec<Look>>,
    count: usize,
}

/// A moment of a track: how soon it would meet another, and whom.
type Worst = (f64, f64, u32);

impl Looks {
    /// Adds a body; of more than can be kept, nothing.
    ///
    /// # Errors
    /// There are too many.
    pub fn add(&mut self, moment: i64, look: Look, report: &Report) -> Result<(), ReadError> {
        self.count += 1;
        if self.count > MOST_LOOKS {
            return Err(
                report.fail("too long to look for windows in it; name one as FILE#track=12@34.0s")
            );
        }
        self.moments.entry(moment).or_default().push(look);
        Ok(())
    }

    /// From when to when it is, seconds.
    pub fn span(&self) -> (f64, f64) {
        let time = |moment: Option<(&i64, &Vec<Look>)>| {
            moment
                .and_then(|(_, looks)| looks.first())
                .map_or(0.0, |l| l.time)
        };
        (
            time(self.moments.first_key_value()),
            time(self.moments.last_key_value()),
        )
    }

    /// The windows worth looking at, the most dangerous first; `name` is that of a track.
    pub fn windows(self, name: impl Fn(u32) -> String) -> Vec<String> {
        let mut present: HashMap<u32, (f64, f64)> = HashMap::new();
        let mut moving: HashSet<u32> = HashSet::new();
        let mut worst: HashMap<u32, Worst> = HashMap::new();
        for looks in self.moments.into_values() {
            for look in &looks {
                let span = present.entry(look.track).or_insert((look.time, look.time));
                span.1 = look.time;
                if look.moves() {
                    moving.insert(look.track);
                }
            }
            self::meetings(looks, &mut worst);
        }
        let mut ranked: Vec<(f64, u32, f64, Option<u32>)> = present
            .iter()
            .filter(|(track, (from, to))| to - from >= SHORTEST && moving.contains(*track))
            .map(|(track, (from, _))| match worst.get(track) {
                Some((soon, time, other)) => (*soon, *track, *time, Some(*other)),
                None => (f64::MAX, *track, from + LENGTH - AFTER, None),
            })
            .collect();
        // Where nothing is dangerous, any stretch is as good as another.
        if ranked.iter().any(|(soon, ..)| *soon < f64::MAX) {
            ranked.retain(|(soon, ..)| *soon < f64::MAX);
        }
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut taken: Vec<(u32, u32, f64)> = Vec::new();
        let mut names = Vec::new();
        for (_, track, time, other) in ranked {
            // The same two at the same time, seen by the other one.
            if let Some(other) = other {
                if taken
                    .iter()
                    .any(|t| (t.0, t.1) == (other, track) && (t.2 - time).abs() < LENGTH)
                {
                    continue;
                }
                taken.push((track, other, time));
            }
            let (from, to) = present[&track];
            let start = (time + AFTER - LENGTH).clamp(from, (to - LENGTH).max(from));
            names.push(format!("track={}@{start:.1}s", name(track)));
            if names.len() == MOST {
                break;
            }
        }
        names
    }
}

/// The soonest meeting of each body at a moment.
fn meetings(mut looks: Vec<Look>, worst: &mut HashMap<u32, Worst>) {
    looks.sort_by(|a, b| a.position.x.total_cmp(&b.position.x));
    for (i, a) in looks.iter().enumerate() {
        let near = looks[i + 1..]
            .iter()
            .take_while(|b| b.position.x - a.position.x <= NEAR);
        for b in near {
            let Some(soon) = meet(a, b) else { continue };
            // Of one behind the other, the ego is the one behind; what stands is met.
            for (one, other) in [(a, b), (b, a)] {
                let ahead = (other.position - one.position).dot(&one.velocity) >= 0.0;
                if !ahead || !one.moves() {
                    continue;
                }
                let known = worst.entry(one.track).or_insert((f64::MAX, 0.0, 0));
                if soon < known.0 {
                    *known = (soon, one.time, other.track);
                }
            }
        }
    }
}

/// How soon two bodies would meet with the velocities that they have, seconds; `None` if they would not.
fn meet(a: &Look, b: &Look) -> Option<f64> {
    let (apart, closing) = (b.position - a.position, a.velocity - b.velocity);
    let distance = apart.norm();
    if distance > NEAR {
        return None;
    }
    let reach = |axis: &Vector| half_along(a, axis) + half_along(b, axis);
    let axis = apart
        .try_normalize(1e-9)
        .unwrap_or_else(|| Vector::new(1.0, 0.0));
    let speed = closing.dot(&axis);
    if speed <= 0.1 {
        return None;
    }
    let time = ((distance - reach(&axis)) / speed).max(0.0);
    // Whether they miss each other then, to the side.
    let way = closing.try_normalize(1e-9)?;
    let aside = Vector::new(-way.y, way.x);
    let misses = apart.dot(&aside).abs() > reach(&aside);
    (!misses && time <= FORESIGHT).then_some(time)
}

/// How far a body reaches along an axis from its middle, metres.
fn half_along(look: &Look, axis: &Vector) -> f64 {
    let (sin, cos) = look.heading.sin_cos();
    let along = (axis.x * cos + axis.y * sin).abs();
    let across = (axis.y * cos - axis.x * sin).abs();
    look.half.0 * along + look.half.1 * across
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_window_is_a_track_and_perhaps_a_time() {
        let report = Report::about("x.csv");
        let parse = |part: &str| {
            let wanted = Wanted::parse(part, &report).ok()?;
            Some((wanted.track, wanted.start))
        };
        assert_eq!(parse("track=12"), Some(("12".into(), None)));
        assert_eq!(parse("track=12@34.0s"), Some(("12".into(), Some(34.0))));
        assert_eq!(parse("track=a@b"), Some(("a@b".into(), None)));
        assert_eq!(parse("track=@1s"), None);
        assert_eq!(parse("12"), None);
        let error = Wanted::parse("12", &report).unwrap_err().to_string();
        assert!(error.contains("track=12@34.0s"), "{error}");
    }

    #[test]
    fn the_most_dangerous_window_comes_first_and_once() {
        let report = Report::about("x.csv");
        let mut looks = Looks::default();
        for moment in 0..200 {
            let time = f64::from(moment) * 0.2;
            let mut add = |track, x: f64, y, v: f64| {
                let look = Look {
                    track,
                    time,
                    position: Point::new(x, y),
                    velocity: Vector::new(v, 0.0),
                    heading: 0.0,
                    half: (2.0, 1.0),
                };
                looks.add(i64::from(moment), look, &report).unwrap();
            };
            // 0 comes up behind 1 until 20 s, and brakes; 2 is alone in its lane.
            let gap = if time < 20.0 { 55.0 - 2.0 * time } else { 15.0 };
            add(
                0,
                10.0 * time - gap,
                0.0,
                if time < 20.0 { 12.0 } else { 10.0 },
            );
            add(1, 10.0 * time, 0.0, 10.0);
            add(2, 11.0 * time, 7.0, 11.0);
        }
        assert_eq!(looks.span().0, 0.0);
        let names = looks.windows(|track| (track + 7).to_string());
        assert_eq!(names, ["track=7@12.8s"]);
    }
}
