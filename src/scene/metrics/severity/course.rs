//! Courses: when two bodies would touch if each kept its speed of a moment along the way that it drove.
//!
//! The way is that of the recording, and straight on after its end: who stopped is taken to go on, which is what the
//! stop was for. Speeds are those of the moment, so the braking of the recording does not count, except that of who
//! crosses: braking as it does at the moment it may stop before the other's way.

use crate::metrics::Encounter;
use crate::metrics::plane::HORIZON;
use crate::scenario::Motion;
use nearmiss_base::geometry::{Point, Pose, Vector, angle_between};

/// Seconds until one brakes, but no more than half of the time that is left.
const REACTION: f64 = 1.0;

/// What comes of keeping on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Course {
    /// Time to contact.
    pub seconds: f64,
    /// The speed of one relative to the other, m/s.
    pub closing_speed: f64,
    /// Whether their headings are more than 10° apart at the contact, and neither drives on the other's way, as in a bend.
    pub crosses: bool,
    /// Whether it is along the paths driven, not straight on.
    pub along_paths: bool,
}

impl Course {
    /// The deceleration that avoids the contact after a reaction, m/s²: Δv / 2(t − r).
    pub fn braking(&self) -> f64 {
        // A contact now takes no more than what is in a hundredth of a second.
        let seconds = self.seconds.max(0.01);
        self.closing_speed / (2.0 * (seconds - REACTION.min(seconds / 2.0)))
    }
}

/// The way that a body drove, by arc length.
#[derive(Debug, Clone)]
pub struct DrivenPath {
    /// Steps, and the arc lengths at them, metres.
    steps: Vec<i64>,
    at_steps: Vec<f64>,
    /// Places farther apart than [`MIN_MOVEMENT`], and the arc lengths there, metres.
    poses: Vec<Pose>,
    lengths: Vec<f64>,
    /// Where it comes from, and where it goes on after its end: unit vectors.
    from: Vector,
    on: Vector,
}

/// Pieces on either side that are looked at together.
const AROUND: usize = 8;

/// Movements below this may be noise at standstill, metres: they turn no way.
const MIN_MOVEMENT: f64 = 0.1;

/// The direction of a way at its ends is that of so many metres.
const END: f64 = 0.5;

/// The heading tells that direction better, unless both are farther apart: not every recording knows it, radians.
const HEADING: f64 = 15.0 * std::f64::consts::PI / 180.0;

impl DrivenPath {
    /// The way through recorded places, in order of time.
    #[must_use]
    pub fn from_motions(motions: impl Iterator<Item = (i64, Motion)>) -> Self {
        let mut path = Self {
            steps: Vec::new(),
            at_steps: Vec::new(),
            poses: Vec::new(),
            lengths: Vec::new(),
            from: Vector::zeros(),
            on: Vector::zeros(),
        };
        let mut length = 0.0;
        // Movements since the last place of those that are too small for another.
        let mut small: Vec<Vector> = Vec::new();
        for (step, motion) in motions {
            path.steps.push(step);
            let Some(last) = path.poses.last() else {
                let forwards = motion.velocity >= 0.0;
                path.on = motion.pose.forward() * if forwards { 1.0 } else { -1.0 };
                path.add(motion.pose, length);
                path.at_steps.push(length);
                continue;
            };
            let moved = motion.pose.position - last.position;
            if moved.norm() <= MIN_MOVEMENT {
                small.push(moved);
                continue;
            }
            path.on = moved.normalize();
            path.place(&mut small, length);
            length += moved.norm();
            path.add(motion.pose, length);
            path.at_steps.push(length);
        }
        path.place(&mut small, length);
        if let [first, .., last] = path.poses[..] {
            let whole = length - END;
            let near = |p: &&Pose| (p.position - first.position).norm() >= END;
            let next = path.poses.iter().find(near).unwrap_or(&last);
            path.from = direction(&first, &(next.position - first.position));
            let before = path.lengths.partition_point(|l| *l <= whole).max(1) - 1;
            path.on = direction(&last, &(last.position - path.poses[before].position));
        } else {
            path.from = path.on;
        }
        path
    }

    fn add(&mut self, pose: Pose, length: f64) {
        self.poses.push(pose);
        self.lengths.push(length);
    }

    /// Gives small movements from an arc length on their own, along the present direction and never back.
    fn place(&mut self, small: &mut Vec<Vector>, length: f64) {
        let mut farthest = 0.0;
        for moved in small.drain(..) {
            farthest = moved.dot(&self.on).max(farthest);
            self.at_steps.push(length + farthest);
        }
    }

    /// Its length, metres.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or_default()
    }

    /// The arc length (m) at a step; of who stands still at every step, as that of a static obstacle.
    #[must_use]
    pub fn length_at(&self, step: i64) -> Option<f64> {
        match self.steps.binary_search(&step) {
            Ok(place) => Some(self.at_steps[place]),
            Err(_) if self.steps.len() == 1 => Some(0.0),
            Err(_) => None,
        }
    }

    /// Arc length and offset to the left (m) of the place nearest to a point, straight on at both ends: nearest around
    /// the piece `hint`, or of all, which becomes that of the place found.
    #[must_use]
    pub fn project_near(&self, point: &Point, hint: &mut Option<usize>) -> Option<(f64, f64)> {
        let first = self.poses.first()?;
        let pieces = self.poses.len() - 1;
        let (mut low, mut high) = match *hint {
            Some(piece) => {
                let middle = piece.min(pieces.saturating_sub(1));
                (middle, (middle + 1).min(pieces))
            }
            None => (0, pieces),
        };
        let best = loop {
            let found = (low..high).map(|piece| {
                let (apart, at) = self.foot(point, piece);
                (apart, piece, at)
            });
            let best = found.min_by(|a, b| a.0.total_cmp(&b.0));
            // Farther on either side while the nearest is at the edge.
            let inside = best.is_some_and(|(_, piece, _)| {
                (piece > low || low == 0) && (piece + 1 < high || high == pieces)
            });
            if inside || (low, high) == (0, pieces) {
                break best;
            }
            (low, high) = (low.saturating_sub(AROUND), (high + AROUND).min(pieces));
        };
        match best {
            Some((_, piece, at)) => {
                *hint = Some(piece);
                Some(at)
            }
            // It never moved.
            None => {
                let away = point - first.position;
                Some((away.dot(&self.on), self.on.perp(&away)))
            }
        }
    }

    /// How far a point is from a piece, and its foot there: arc length and offset to the left; straight on before the first
    /// and behind the last.
    fn foot(&self, point: &Point, piece: usize) -> (f64, (f64, f64)) {
        let (from, to) = (self.poses[piece].position, self.poses[piece + 1].position);
        let (begin, end) = (self.lengths[piece], self.lengths[piece + 1]);
        let (unit, away) = ((to - from) / (end - begin), point - from);
        let (s, d) = (away.dot(&unit), unit.perp(&away));
        let on = s.clamp(0.0, end - begin);
        let apart = (s - on).hypot(d);
        let mut best = (apart, (begin + on, apart.copysign(d)));
        let mut straight = |place: Point, along: Vector, length: f64| {
            let away = point - place;
            let (beyond, aside) = (away.dot(&along), along.perp(&away));
            let is_beyond = if length == 0.0 {
                beyond < 0.0
            } else {
                beyond > 0.0
            };
            if is_beyond && aside.abs() < best.0 {
                best = (aside.abs(), (length + beyond, aside));
            }
        };
        if piece == 0 {
            straight(from, self.from, 0.0);
        }
        if piece + 2 == self.poses.len() {
            straight(to, self.on, end);
        }
        best
    }

    /// How far a point is beside the way, straight on at its end, metres; nothing of one that lies before its begin: the
    /// recording does not tell where it came from.
    pub(super) fn aside(&self, point: &Point) -> Option<f64> {
        let nearest = self.nearest(point);
        let before = self.poses.first().map(|first| {
            let away = point - first.position;
            let beyond = -away.dot(&self.from);
            (beyond, (away + self.from * beyond).norm())
        });
        let is_before = before.is_some_and(|(beyond, aside)| beyond > 0.0 && aside < nearest);
        (!is_before).then_some(nearest)
    }

    /// How far a point is from the way, straight on at its end, metres.
    fn nearest(&self, point: &Point) -> f64 {
        let mut nearest = f64::INFINITY;
        for ends in self.poses.windows(2) {
            let (from, to) = (ends[0].position, ends[1].position);
            let along = to - from;
            let share = (point - from).dot(&along) / along.norm_squared();
            nearest = nearest.min((from + along * share.clamp(0.0, 1.0) - point).norm());
        }
        if let Some(end) = self.poses.last() {
            let away = point - end.position;
            let beyond = away.dot(&self.on);
            if beyond >= 0.0 {
                nearest = nearest.min((away - self.on * beyond).norm());
            }
        }
        nearest
    }

    /// Whether a body is on the way and looks along it.
    fn leads_to(&self, pose: &Pose) -> bool {
        let end = self.poses.last().zip(self.lengths.last());
        let beyond = end.map(|(end, length)| length + (pose.position - end.position).dot(&self.on));
        let places = self
            .poses
            .iter()
            .copied()
            .chain(beyond.and_then(|length| self.at(length)));
        let apart = |place: &Pose| (place.position - pose.position).norm();
        let nearest = places.min_by(|a, b| apart(a).total_cmp(&apart(b)));
        self.nearest(&pose.position) <= ON_THE_WAY
            && nearest
                .is_some_and(|place| angle_between(place.heading, pose.heading).abs() <= CROSSING)
    }

    /// Where the body is at an arc length (m), straight on at both ends, and the direction of the way there.
    #[must_use]
    pub fn at(&self, length: f64) -> Option<Pose> {
        let last = *self.poses.last()?;
        let end = *self.lengths.last()?;
        if length >= end {
            return Some(Pose {
                position: last.position + self.on * (length - end),
                ..last
            });
        }
        if length < 0.0 {
            let first = self.poses[0];
            return Some(Pose {
                position: first.position + self.from * length,
                ..first
            });
        }
        let next = self.lengths.partition_point(|&l| l <= length).max(1);
        let (from, to) = (&self.poses[next - 1], &self.poses[next]);
        let (a, b) = (self.lengths[next - 1], self.lengths[next]);
        let share = if b > a { (length - a) / (b - a) } else { 0.0 };
        Some(Pose {
            position: from.position + (to.position - from.position) * share,
            heading: from.heading + angle_between(from.heading, to.heading) * share,
        })
    }
}

/// The direction of a way at a pose, of what it moved there: that of the body, forwards or backwards, where it moves along
/// its heading.
fn direction(pose: &Pose, moved: &Vector) -> Vector {
    let (moved, forward) = (moved.normalize(), pose.forward());
    let along = if moved.dot(&forward) < 0.0 {
        -forward
    } else {
        forward
    };
    if moved.dot(&along) >= HEADING.cos() {
        along
    } else {
        moved
    }
}

/// Headings nearer to each other than this are of two who go the same way, radians: more than in a change of lanes.
const CROSSING: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// Who is no further beside a way than this drives on it, metres.
const ON_THE_WAY: f64 = 1.0;

/// Bodies nearer than this touch, metres.
const TOUCHING: f64 = 0.02;

/// Between two looks at least and at most this passes, seconds: ways bend.
const SAMPLING_INTERVAL: (f64, f64) = (0.05, 0.5);

/// When the two touch if both keep their speeds along the ways that they drove; within [`HORIZON`]. Who crosses and brakes
/// goes no further than to where it stands then.
pub(super) fn meet(
    ego: &DrivenPath,
    other: &DrivenPath,
    encounter: &Encounter<'_>,
    step: i64,
) -> Option<Course> {
    let course = meet_within(ego, other, encounter, step, f64::INFINITY)?;
    let Motion {
        velocity,
        acceleration,
        ..
    } = *encounter.other;
    let stop = velocity * velocity / (2.0 * acceleration.abs());
    if course.crosses && velocity * acceleration < 0.0 {
        meet_within(ego, other, encounter, step, stop)
    } else {
        Some(course)
    }
}

/// The same if the other goes no further than so many metres.
fn meet_within(
    ego: &DrivenPath,
    other: &DrivenPath,
    encounter: &Encounter<'_>,
    step: i64,
    most: f64,
) -> Option<Course> {
    let from = [ego.length_at(step)?, other.length_at(step)?];
    let speeds = [encounter.ego, encounter.other].map(|motion| motion.velocity.abs());
    let fastest = speeds[0] + speeds[1];
    if fastest <= 0.0 {
        return None;
    }
    let (ego_body, other_body) = (encounter.ego_body, encounter.other_body);
    let reach = ego_body.reach() + other_body.reach();
    let places = |t: f64| {
        Some((
            ego.at(from[0] + speeds[0] * t)?,
            other.at(from[1] + (speeds[1] * t).min(most))?,
        ))
    };
    let mut t = 0.0;
    let mut before: Option<(f64, f64)> = None;
    while t <= HORIZON {
        let (a, b) = places(t)?;
        let apart = (b.position - a.position).norm();
        if apart > reach {
            t += ((apart - reach) / fastest).max(SAMPLING_INTERVAL.0);
            before = None;
            continue;
        }
        let gap = ego_body.at(a).distance(&other_body.at(b));
        if gap <= TOUCHING {
            let (was, is) = (places((t - SAMPLING_INTERVAL.0).max(0.0))?, (a, b));
            let moved = (is.1.position - was.1.position) - (is.0.position - was.0.position);
            let passed = t - (t - SAMPLING_INTERVAL.0).max(0.0);
            let closing_speed = if passed > 0.0 {
                moved.norm() / passed
            } else {
                (encounter.other.velocity_vector() - encounter.ego.velocity_vector()).norm()
            };
            return Some(Course {
                seconds: t,
                closing_speed,
                crosses: angle_between(a.heading, b.heading).abs() > CROSSING
                    && !ego.leads_to(&b)
                    && !other.leads_to(&a),
                along_paths: true,
            });
        }
        // As fast as it closed since the last look, and carefully so.
        let rate = before.map_or(fastest, |(then, gap_then)| {
            ((gap_then - gap) / (t - then)).max(1.0)
        });
        before = Some((t, gap));
        t += (gap / rate * 0.8).clamp(SAMPLING_INTERVAL.0, SAMPLING_INTERVAL.1);
    }
    None
}
