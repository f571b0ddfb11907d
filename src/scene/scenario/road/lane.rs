//! Lanes: borders that run the same way, the centre line between them, the width, and their numbers on a route.

use std::collections::{HashMap, VecDeque};

use nearmiss_base::geometry::{Point, Polyline, contains};

use super::{DirectedLanelet, LaneGraph, Route, Side};
use crate::scenario::Lanelet;

/// A lanelet, or several one after the other, as one lane.
#[derive(Debug, Clone, PartialEq)]
pub struct Lane {
    /// The lanelets, in driving direction.
    pub lanelets: Vec<i64>,
    /// Border on the left, metres.
    pub left: Vec<Point>,
    /// Border on the right, metres.
    pub right: Vec<Point>,
    centre: Polyline,
}

/// Points of two borders nearer than this are one point where lanelets are joined, metres.
const JOINT: f64 = 1e-3;

impl Lane {
    /// The lane that one lanelet is; `None` if all its points lie on one spot.
    #[must_use]
    pub fn from_lanelet(lanelet: &Lanelet) -> Option<Self> {
        let (left, right) = lanelet.borders();
        Self::new(vec![lanelet.id], left, right)
    }

    fn new(lanelets: Vec<i64>, left: Vec<Point>, right: Vec<Point>) -> Option<Self> {
        let centre = Polyline::new(centre_line(&left, &right))?;
        Some(Self {
            lanelets,
            left,
            right,
            centre,
        })
    }

    /// `lanelets`, one after the other, as one lane; `None` for none.
    ///
    /// The common border has each joint once. Where lanelets do not quite meet, both points stay.
    #[must_use]
    pub fn merged<'a>(lanelets: impl IntoIterator<Item = &'a Lanelet>) -> Option<Self> {
        let (mut ids, mut left, mut right) = (Vec::new(), Vec::new(), Vec::new());
        let mut centre = Vec::new();
        for lanelet in lanelets {
            ids.push(lanelet.id);
            let (l, r) = lanelet.borders();
            centre.extend(centre_line(&l, &r));
            // A joint counts where both borders meet, so that they keep the same number of points.
            let meet = |a: &[Point], b: &[Point]| {
                a.last()
                    .zip(b.first())
                    .is_some_and(|(a, b)| (a - b).norm() < JOINT)
            };
            let skip = usize::from(meet(&left, &l) && meet(&right, &r));
            left.extend(l.into_iter().skip(skip));
            right.extend(r.into_iter().skip(skip));
        }
        Some(Self {
            lanelets: ids,
            left,
            right,
            centre: Polyline::new(centre)?,
        })
    }

    /// The same lane driven the other way.
    #[must_use]
    pub fn reversed(&self) -> Self {
        let back = |points: &[Point]| points.iter().rev().copied().collect::<Vec<_>>();
        let centre = Polyline::new(self.centre.points().iter().rev().copied());
        Self {
            lanelets: self.lanelets.iter().rev().copied().collect(),
            left: back(&self.right),
            right: back(&self.left),
            centre: centre.unwrap_or_else(|| self.centre.clone()),
        }
    }

    /// The middle between the borders: of their points in pairs where both have as many, else of the
    /// points at the same share of the arc length.
    #[must_use]
    pub fn centre(&self) -> &Polyline {
        &self.centre
    }

    /// Length of the centre line, metres.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.centre.length()
    }

    /// Width at arc length `s` of the centre line: the distances from there to both borders, metres.
    #[must_use]
    pub fn width_at(&self, s: f64) -> f64 {
        let here = self.centre.pose_at(s.clamp(0.0, self.length())).position;
        [&self.left, &self.right]
            .map(|border| distance_to(border, &here))
            .iter()
            .sum()
    }
}

impl Lanelet {
    /// Both borders in driving direction: the one that was drawn the other way is turned around.
    ///
    /// Borders agree where points at equal shares of their lengths are nearer to each other than to
    /// those of the border turned around. The right one is turned if the left has it on its right.
    #[must_use]
    pub fn borders(&self) -> (Vec<Point>, Vec<Point>) {
        let (mut left, mut right) = (self.left.points.clone(), self.right.points.clone());
        if self.borders_disagree() {
            if self.right_is_right_of_left() {
                right.reverse();
            } else {
                left.reverse();
            }
        }
        (left, right)
    }

    pub(crate) fn borders_disagree(&self) -> bool {
        let (left, right) = (&self.left.points, &self.right.points);
        let (Some(l), Some(r)) = (
            left.first().zip(left.last()),
            right.first().zip(right.last()),
        ) else {
            return false;
        };
        let apart = |a: &Point, b: &Point| (a - b).norm();
        if apart(l.0, r.0) + apart(l.1, r.1) < apart(l.0, r.1) + apart(l.1, r.0) {
            return false;
        }
        // A ring's ends lie together, so its whole course decides.
        let lines = [left, right].map(|b| Polyline::new(b.iter().copied()));
        let [Some(l), Some(r)] = lines else {
            return false;
        };
        let (mut same, mut turned) = (0.0, 0.0);
        for share in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let at = |line: &Polyline, share: f64| line.pose_at(share * line.length()).position;
            same += apart(&at(&l, share), &at(&r, share));
            turned += apart(&at(&l, share), &at(&r, 1.0 - share));
        }
        turned < same
    }

    fn right_is_right_of_left(&self) -> bool {
        let left = Polyline::new(self.left.points.iter().copied());
        let right = Polyline::new(self.right.points.iter().copied());
        left.zip(right).is_none_or(|(left, right)| {
            let middle = right.pose_at(right.length() / 2.0).position;
            left.project(&middle).d <= 0.0
        })
    }

    /// Distance from `p` to the lanelet, metres; 0 on it.
    pub(crate) fn distance(&self, p: &Point) -> f64 {
        let ring = self.ring();
        if contains(&ring, p) {
            return 0.0;
        }
        distance_to(&ring, p).min(
            ring.last()
                .map_or(f64::MAX, |end| distance_to(&[*end, ring[0]], p)),
        )
    }
}

/// Distance from `p` to a chain of points, metres.
fn distance_to(points: &[Point], p: &Point) -> f64 {
    match Polyline::new(points.iter().copied()) {
        Some(line) => line.project(p).d.abs(),
        None => points.first().map_or(f64::MAX, |only| (only - p).norm()),
    }
}

fn centre_line(left: &[Point], right: &[Point]) -> Vec<Point> {
    if left.len() == right.len() {
        let pairs = left.iter().zip(right);
        return pairs.map(|(l, r)| nalgebra::center(l, r)).collect();
    }
    let lines = [left, right].map(|b| Polyline::new(b.iter().copied()));
    let shares = |line: &Option<Polyline>| -> Vec<f64> {
        let line = line.as_ref();
        line.map_or(vec![0.0, 1.0], |l| {
            l.arc_lengths().iter().map(|s| s / l.length()).collect()
        })
    };
    let mut all = [shares(&lines[0]), shares(&lines[1])].concat();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| *a - *b < 1e-9);
    // A border without length is one point all along.
    let at = |line: &Option<Polyline>, spot: &[Point], share: f64| match line {
        Some(line) => Some(line.pose_at(share * line.length()).position),
        None => spot.first().copied(),
    };
    all.into_iter()
        .filter_map(|share| {
            let l = at(&lines[0], left, share)?;
            Some(nalgebra::center(&l, &at(&lines[1], right, share)?))
        })
        .collect()
}

/// Neighbours farther away than this are not counted, lanes.
const MAX_LANES_ASIDE: i32 = 16;

impl LaneGraph<'_> {
    /// The number of the lane of every lanelet along `route` and beside it: 0 for the lane where the route
    /// starts, one more for each lane to the left, one less for each to the right, whichever way they are driven.
    ///
    /// A lane keeps its number along the route, and a lane change does not move the count. Lanelets that lead
    /// elsewhere have none. What the path follows before and after the route is counted too.
    #[must_use]
    pub fn lane_numbers(&self, route: &Route) -> HashMap<i64, i32> {
        let mut numbers: HashMap<i64, i32> = HashMap::new();
        let mut here = 0;
        let before = route.before.iter().map(|d| (*d, None));
        let legs = route.legs.iter().map(|leg| (leg.driven, leg.change));
        let after = route.after.iter().map(|d| (*d, None));
        let mut seeds: VecDeque<(DirectedLanelet, i32)> = VecDeque::new();
        for (driven, change) in before.chain(legs).chain(after) {
            here += match change {
                Some(Side::Left) => 1,
                Some(Side::Right) => -1,
                None => 0,
            };
            // The lanes of the route come first: neighbours never take their numbers.
            if let std::collections::hash_map::Entry::Vacant(free) = numbers.entry(driven.lanelet) {
                free.insert(here);
                seeds.push_back((driven, here));
            }
        }
        while let Some((driven, number)) = seeds.pop_front() {
            for (side, step) in [(Side::Left, 1), (Side::Right, -1)] {
                let next = number + step;
                let Some(beside) = self.adjacent(driven, side) else {
                    continue;
                };
                if next.abs() <= MAX_LANES_ASIDE && !numbers.contains_key(&beside.lanelet) {
                    numbers.insert(beside.lanelet, next);
                    seeds.push_back((beside, next));
                }
            }
        }
        numbers
    }

    /// The lanelet on a side of a lane, seen the way that the lane is driven, whatever users it allows.
    fn adjacent(&self, driven: DirectedLanelet, side: Side) -> Option<DirectedLanelet> {
        let place = self.network.place(driven.lanelet)?;
        let lanelet = &self.network.lanelets[place];
        let along = driven.direction == super::Direction::Along;
        let adjacent = if (side == Side::Left) == along {
            lanelet.adjacent_left
        } else {
            lanelet.adjacent_right
        }?;
        self.network.place(adjacent.id)?;
        Some(DirectedLanelet {
            lanelet: adjacent.id,
            direction: if adjacent.same_direction {
                driven.direction
            } else {
                driven.direction.other()
            },
        })
    }
}
