//! Lanes: borders that run the same way, the line between them, their numbers on a route, and the line that a route follows.

use std::collections::{HashMap, VecDeque};

use nearmiss_base::geometry::{Point, Polyline, contains};
use petgraph::graph::NodeIndex;

use super::route::LegLane;
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

/// The points of a route's middle.
pub(super) struct Line {
    pub points: Vec<Point>,
    /// Arc length of the line where the first lane of the route begins, metres.
    pub first: f64,
    /// Length of the first row of lanes, metres.
    pub first_length: f64,
    /// Arc length of the line where the last row of lanes begins, metres.
    pub last: f64,
    /// Length of the last row of lanes, metres.
    pub last_length: f64,
    /// The lanes that lead to the first one, in driving direction.
    pub before: Vec<NodeIndex>,
    /// The lanes that go on from the last one.
    pub after: Vec<NodeIndex>,
}

/// How far the line goes on before and after the route where the road does, metres.
const LEAD: f64 = 100.0;

/// Distance between points in a lane change, metres.
const STEP: f64 = 1.0;

/// Parts of a step that rounding may add to a lane.
const ROUNDING_SHARE: f64 = 1e-6;

impl LaneGraph<'_> {
    /// The middle of the lanes of a route.
    pub(super) fn line(&self, parts: &[LegLane]) -> Line {
        let used: Vec<NodeIndex> = parts.iter().map(|p| p.node).collect();
        let lead = |end: Option<&LegLane>, forward| {
            end.map_or(Vec::new(), |p| self.lead(p.node, forward, &used))
        };
        let mut points = Vec::new();
        let mut before = lead(parts.first(), false);
        before.reverse();
        for &node in &before {
            points.extend(self.middle(node));
        }
        let mut marks = Vec::new();
        let mut rows: Vec<&[LegLane]> = Vec::new();
        let mut rest = parts;
        while !rest.is_empty() {
            let changes = rest[1..].iter().take_while(|p| p.change.is_some()).count();
            let (row, more) = rest.split_at(changes + 1);
            rows.push(row);
            rest = more;
        }
        for row in rows {
            let from = points.len();
            points.extend(self.row(row));
            marks.push((from, points.len()));
        }
        let after = lead(parts.last(), true);
        for &node in &after {
            points.extend(self.middle(node));
        }
        let mut arcs = vec![0.0];
        for pair in points.windows(2) {
            arcs.push(arcs[arcs.len() - 1] + (pair[1] - pair[0]).norm());
        }
        let span = |mark: Option<&(usize, usize)>| {
            mark.map_or((0.0, 0.0), |&(from, to)| {
                let from = arcs[from.min(arcs.len() - 1)];
                (from, arcs[(to.max(1) - 1).min(arcs.len() - 1)] - from)
            })
        };
        let ((first, first_length), (last, last_length)) =
            (span(marks.first()), span(marks.last()));
        Line {
            points,
            first,
            first_length,
            last,
            last_length,
            before,
            after,
        }
    }

    fn middle(&self, node: NodeIndex) -> Vec<Point> {
        let lane = self.lane_of(self.graph[node]);
        lane.map_or(Vec::new(), |l| l.centre().points().to_vec())
    }

    /// The lanelets straight on from an end of the route, none twice.
    fn lead(&self, end: NodeIndex, forward: bool, used: &[NodeIndex]) -> Vec<NodeIndex> {
        let (mut found, mut left) = (Vec::new(), LEAD);
        let mut here = end;
        while left > 0.0 {
            let next = self.straightest(here, forward).into_iter();
            let fresh = |n: &NodeIndex| !used.contains(n) && !found.contains(n);
            let Some(next) = { next }.find(fresh) else {
                break;
            };
            left -= self.length(self.graph[next]);
            found.push(next);
            here = next;
        }
        found
    }

    /// The points of neighbouring lanes that are changed from one to the next.
    fn row(&self, row: &[LegLane]) -> Vec<Point> {
        if let [only] = row {
            return self.middle(only.node);
        }
        let lanes: Vec<Polyline> = row
            .iter()
            .filter_map(|p| self.lane_of(self.graph[p.node]))
            .map(|lane| lane.centre().clone())
            .collect();
        let longest = lanes.iter().map(Polyline::length).fold(0.0, f64::max);
        let steps = (longest / STEP - ROUNDING_SHARE)
            .ceil()
            .clamp(8.0, 100_000.0) as usize;
        let at = |line: &Polyline, share: f64| line.pose_at(share * line.length()).position;
        let point = |i: usize| {
            let share = i as f64 / steps as f64;
            let mut here = lanes.first().map(|l| at(l, share))?;
            for (part, lane) in row.iter().zip(&lanes).skip(1) {
                let (from, to) = part.change.map_or((0.0, 0.0), |(_, from, to)| (from, to));
                here += (at(lane, share) - here) * ramp((share - from) / (to - from));
            }
            Some(here)
        };
        (0..=steps).filter_map(point).collect()
    }
}

/// From 0 to 1 with no slope and no curvature at both ends: the quintic of least jerk.
fn ramp(share: f64) -> f64 {
    // A change without length is a step.
    let t = if share.is_nan() {
        1.0
    } else {
        share.clamp(0.0, 1.0)
    };
    t * t * t * (10.0 - 15.0 * t + 6.0 * t * t)
}
