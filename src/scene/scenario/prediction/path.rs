//! The line an obstacle follows: straight, an arc, or the middle of a lane that it may follow.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

use nearmiss_base::geometry::{Point, Polyline, Pose, Vector, angle_between};

use super::Observed;
use crate::scenario::{DirectedLanelet, Direction, Lane, LaneletNetwork, Motion};

/// Poses by the distance driven.
#[derive(Debug, Clone)]
pub enum Path {
    /// Straight ahead.
    Straight(Pose),
    /// A circle; positive curvature (1/m) turns left.
    Arc {
        /// The beginning.
        start: Pose,
        /// 1/m.
        curvature: f64,
    },
    /// Along a line, back to it from beside it.
    Lane {
        /// The middle of the lane.
        line: Arc<Polyline>,
        /// Arc length beside which it begins, metres.
        s: f64,
        /// Offset there, metres; positive on the left.
        offset: f64,
        /// Change of the offset per metre there.
        slope: f64,
        /// Heading there that the offset's slope does not explain, radians.
        skew: f64,
    },
}

/// Metres in which an offset from the middle of a lane fades to 1/e, after a start without slope.
const RETURN: f64 = 10.0;

/// The heading of a body on a line is that of the chord between its axles, this long, metres.
const CHORD: f64 = 3.0;

/// Steeper than this no obstacle crosses a lane.
const STEEPEST: f64 = 1.0;

impl Path {
    /// Along `line` from `start`.
    #[must_use]
    pub fn along(line: Arc<Polyline>, start: &Pose) -> Self {
        let at = line.project(&start.position);
        let chord = chord(&line, at.s);
        let offset = (start.position - chord.position).dot(&chord.left());
        let turn = angle_between(chord.heading, start.heading);
        let slope = turn.tan().clamp(-STEEPEST, STEEPEST);
        Self::Lane {
            line,
            s: at.s,
            offset,
            slope,
            skew: turn - slope.atan(),
        }
    }

    /// The pose after `distance` metres.
    #[must_use]
    pub fn pose_at(&self, distance: f64) -> Pose {
        match self {
            Self::Straight(start) => Pose {
                position: start.position + start.forward() * distance,
                heading: start.heading,
            },
            Self::Arc { start, curvature } => {
                let turn = curvature * distance;
                // The chord of the arc, without the division where it is straight.
                let half = turn / 2.0;
                let chord = if half.abs() < 1e-6 {
                    distance
                } else {
                    distance * half.sin() / half
                };
                let heading = start.heading + half;
                Pose {
                    position: start.position + Vector::new(heading.cos(), heading.sin()) * chord,
                    heading: start.heading + turn,
                }
            }
            Self::Lane {
                line,
                s,
                offset,
                slope,
                skew,
            } => {
                let on = chord(line, s + distance);
                let fade = (-distance / RETURN).exp();
                let rate = slope + offset / RETURN;
                let d = (offset + rate * distance) * fade;
                let slope = (rate - (offset + rate * distance) / RETURN) * fade;
                Pose {
                    position: on.position + on.left() * d,
                    heading: on.heading + slope.atan() + skew * fade,
                }
            }
        }
    }
}

/// The middle of the chord whose axles are on the line around `s`.
fn chord(line: &Polyline, s: f64) -> Pose {
    let (rear, front) = (line.pose_at(s - CHORD / 2.0), line.pose_at(s + CHORD / 2.0));
    let between = front.position - rear.position;
    Pose {
        position: rear.position + between / 2.0,
        heading: between.y.atan2(between.x),
    }
}

/// A way along lanelets.
#[derive(Debug, Clone)]
pub(super) struct LaneWay {
    /// One after the other.
    pub lanelets: Vec<i64>,
    /// Their middle.
    pub line: Arc<Polyline>,
    /// The unnormalised likelihood of this route.
    pub weight: f64,
}

/// The lanes of one network; each is worked out once, and only where an obstacle is near it. (A
/// [`crate::scenario::LaneGraph`] works out all of them, which is too slow for something that is asked at every step.)
#[derive(Debug)]
pub(super) struct Lanes<'a> {
    network: &'a LaneletNetwork,
    middles: HashMap<DirectedLanelet, Option<Arc<Polyline>>>,
}

/// No obstacle that points this much away from a lane follows it, radians.
const MOST_TURN: f64 = FRAC_PI_4;

/// The spread of headings against the lane that is followed, radians, and of offsets from its middle, metres.
const TURN: f64 = 0.2;
const OFFSET: f64 = 1.0;

/// The offset is extrapolated by this time, seconds: it reveals lane changes.
const DRIFT: f64 = 1.0;

/// Ways that are less likely than this share of the likeliest are not followed.
const MIN_LIKELIHOOD: f64 = 0.01;

/// Older motion does not indicate the lane followed, seconds.
const MEMORY: f64 = 1.0;

/// More ways are not followed: roads fork into few.
const MOST_WAYS: usize = 6;

/// More lanelets are not followed one after the other.
const MOST_LANELETS: usize = 64;

impl<'a> Lanes<'a> {
    pub fn new(network: &'a LaneletNetwork) -> Self {
        Self {
            network,
            middles: HashMap::new(),
        }
    }

    /// The ways on from where an obstacle is that drives `speed` m/s, `reach` metres long where the road goes on; the
    /// likeliest first.
    pub fn ways(&mut self, seen: &Observed<'_>, speed: f64, reach: f64) -> Vec<LaneWay> {
        let pose = &seen.motion.pose;
        let mut starts: Vec<(f64, DirectedLanelet, f64)> = Vec::new();
        for lanelet in self.here_and_beside(&pose.position) {
            for direction in [Direction::Along, Direction::Against] {
                let from = DirectedLanelet { lanelet, direction };
                let Some(middle) = self.middle(from) else {
                    continue;
                };
                let at = middle.project(&pose.position);
                let turn = angle_between(middle.pose_at(at.s).heading, pose.heading);
                if turn.abs() <= MOST_TURN {
                    starts.push((drift(at.d, turn, speed).abs(), from, at.s));
                }
            }
        }
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        starts.truncate(MOST_WAYS);
        let mut found: Vec<LaneWay> = Vec::new();
        for (_, from, s) in starts {
            let ways = self.ways_from(from, s + reach);
            let share = 1.0 / ways.len() as f64;
            for way in ways {
                let Some(line) = self.line(&way) else {
                    continue;
                };
                found.push(LaneWay {
                    lanelets: way.iter().map(|d| d.lanelet).collect(),
                    weight: share * fit(&line, seen, speed),
                    line,
                });
            }
        }
        found.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        let least = found.first().map_or(0.0, |way| way.weight * MIN_LIKELIHOOD);
        found.truncate(MOST_WAYS);
        // All weights may be 0 if no lane fits.
        found.retain(|way| way.weight > 0.0 && way.weight >= least);
        found
    }

    /// The lanelets under a point, then their neighbours in the same direction.
    fn here_and_beside(&self, p: &Point) -> Vec<i64> {
        let mut ids = self.network.lanelets_at(p);
        for place in 0..ids.len() {
            let here = self.network.lanelet(ids[place]);
            let beside = here.map(|l| [l.adjacent_left, l.adjacent_right]);
            for beside in beside.into_iter().flatten().flatten() {
                if beside.same_direction && !ids.contains(&beside.id) {
                    ids.push(beside.id);
                }
            }
        }
        ids
    }

    /// The centre line of a lanelet in the direction driven; `None` if that direction is not allowed.
    fn middle(&mut self, driven: DirectedLanelet) -> Option<Arc<Polyline>> {
        let network = self.network;
        let middle = || {
            let lanelet = network.lanelet(driven.lanelet)?;
            let lane = Lane::from_lanelet(lanelet)?;
            match driven.direction {
                Direction::Along => Some(Arc::new(lane.centre().clone())),
                Direction::Against if lanelet.users_bidirectional.is_empty() => None,
                Direction::Against => Some(Arc::new(lane.reversed().centre().clone())),
            }
        };
        self.middles.entry(driven).or_insert_with(middle).clone()
    }

    /// Every way on from a lanelet, until `length` metres are there.
    fn ways_from(&mut self, from: DirectedLanelet, length: f64) -> Vec<Vec<DirectedLanelet>> {
        let mut open = vec![(vec![from], 0.0)];
        let mut whole = Vec::new();
        while let Some((way, before)) = open.pop() {
            let last = way[way.len() - 1];
            let here = before + self.middle(last).map_or(0.0, |m| m.length());
            let room = MOST_WAYS.saturating_sub(whole.len() + open.len());
            let next = if here < length && way.len() < MOST_LANELETS {
                self.following(last, &way, room)
            } else {
                Vec::new()
            };
            if next.is_empty() {
                whole.push(way);
                continue;
            }
            // The last one opened is the first one followed.
            for next in next.into_iter().rev() {
                open.push(([way.as_slice(), &[next]].concat(), here));
            }
        }
        whole
    }

    /// The successors of a lanelet that are not on the route yet, at most `room`.
    fn following(
        &mut self,
        driven: DirectedLanelet,
        way: &[DirectedLanelet],
        room: usize,
    ) -> Vec<DirectedLanelet> {
        let Some(lanelet) = self.network.lanelet(driven.lanelet) else {
            return Vec::new();
        };
        let ids = match driven.direction {
            Direction::Along => &lanelet.successors,
            Direction::Against => &lanelet.predecessors,
        };
        let next = ids
            .iter()
            .map(|&lanelet| DirectedLanelet { lanelet, ..driven });
        next.filter(|next| !way.contains(next) && self.middle(*next).is_some())
            .take(room)
            .collect()
    }

    fn line(&mut self, way: &[DirectedLanelet]) -> Option<Arc<Polyline>> {
        if let [only] = way {
            return self.middle(*only);
        }
        let middles: Vec<_> = way.iter().filter_map(|d| self.middle(*d)).collect();
        let points = middles.iter().flat_map(|m| m.points().iter().copied());
        Polyline::new(points).map(Arc::new)
    }
}

/// How well a line explains what was seen, 0 to 1: the headings of the last second, and where it drifts.
fn fit(line: &Polyline, seen: &Observed<'_>, speed: f64) -> f64 {
    let turn_at = |motion: &Motion| {
        let at = line.project(&motion.pose.position);
        let along = line.pose_at(at.s).heading;
        (at, angle_between(along, motion.pose.heading))
    };
    let (now, turn) = turn_at(seen.motion);
    let drifted = drift(now.d, turn, speed);
    let (mut turns, mut n) = (0.0, 0.0);
    for (step, motion) in seen.motions.iter().rev() {
        let (at, turn) = turn_at(motion);
        if n > 0.0 && (at.s <= 0.0 || seen.ago(*step) > MEMORY) {
            break;
        }
        turns += (turn / TURN).powi(2);
        n += 1.0;
    }
    (-(turns / n + (drifted / OFFSET).powi(2)) / 2.0).exp()
}

/// Where an obstacle at offset `d` gets to that points `turn` away from the lane and drives `speed` m/s, metres.
fn drift(d: f64, turn: f64, speed: f64) -> f64 {
    d + speed * turn.sin() * DRIFT
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use nearmiss_base::geometry::Point;

    fn apart(a: &Pose, b: &Pose) -> f64 {
        (a.position - b.position).norm() + angle_between(a.heading, b.heading).abs()
    }

    #[test]
    fn a_quarter_of_a_circle() {
        let arc = |curvature| Path::Arc {
            start: Pose::new(1.0, 2.0, 0.0),
            curvature,
        };
        let quarter = 10.0 * std::f64::consts::FRAC_PI_2;
        let left = arc(0.1).pose_at(quarter);
        assert!(apart(&left, &Pose::new(11.0, 12.0, std::f64::consts::FRAC_PI_2)) < 1e-9);
        let straight = Path::Straight(Pose::new(1.0, 2.0, 0.0));
        assert!(apart(&arc(0.0).pose_at(7.0), &straight.pose_at(7.0)) < 1e-12);
        assert!(apart(&arc(1e-8).pose_at(7.0), &arc(2e-6).pose_at(7.0)) < 1e-3);
    }

    #[test]
    fn a_lane_is_joined_where_one_stands_and_followed_afterwards() {
        let points = [(0., 0.), (50., 0.), (50., 80.)].map(|(x, y)| Point::new(x, y));
        let line = Arc::new(Polyline::new(points).unwrap());
        for (x, y, heading) in [(5.0, 1.2, -0.2), (20.0, -0.7, 0.3), (10.0, 0.0, 1.2)] {
            let start = Pose::new(x, y, heading);
            let path = Path::along(line.clone(), &start);
            assert!(apart(&path.pose_at(0.0), &start) < 1e-9, "{x} {y}");
            // It begins into the direction of the heading, as far as lanes are crossed at all.
            let moved = path.pose_at(0.01).position - start.position;
            let steep = heading.abs() > std::f64::consts::FRAC_PI_4;
            assert!(steep || (moved.y.atan2(moved.x) - heading).abs() < 0.01);
            let far = path.pose_at(110.0);
            assert!((far.position.x - 50.0).abs() < 0.01, "{far:?}");
            assert!((far.heading - std::f64::consts::FRAC_PI_2).abs() < 0.01);
        }
    }
}
