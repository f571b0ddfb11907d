//! The line that a route's smooth path follows: along the middle of lanes, over lane changes, and a while before and
//! after.

use petgraph::graph::NodeIndex;

use super::LaneGraph;
use super::route::LegLane;
use nearmiss_base::geometry::{Point, Polyline};

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
