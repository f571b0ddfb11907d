//! Roads: lanelets that lie beside each other in one direction, along one reference line.

use std::collections::HashSet;

use nearmiss_base::geometry::{Point, Polyline, Pose, Vector, angle_between};
use nearmiss_scene::scenario::{Adjacent, Lanelet, LaneletNetwork};

use super::curve::{Curve, Laying, Profile, deviation, lay, profile, samples};

/// A road with its lanes, from the left to the right.
#[derive(Debug, Clone)]
pub struct Road {
    /// Places of its lanelets in the network, from the left to the right.
    pub lanelets: Vec<usize>,
    /// Its reference line.
    pub curve: Curve,
    /// How far to the left of it the leftmost border is.
    pub offset: Profile,
    /// Widths of its lanes.
    pub widths: Vec<Profile>,
    /// How far its borders are at most from those of the lanelets, metres.
    pub deviation: f64,
}

/// Neighbours are one road if their borders are written as near as this, metres.
const BORDER_TOLERANCE: f64 = 0.02;

/// Near enough not to try another reference line, metres.
const GOOD: f64 = 0.01;

/// Farther off, a road is also laid through pairs of points, metres.
const FINE: f64 = 0.02;

/// Where between the right (0) and the left border (1) a road through pairs of points runs.
const PAIRED: [f64; 5] = [0.5, 0.75, 0.25, 1.0, 0.0];

/// Where one that crosses the road squarely begins; beyond a border where that one does not run back.
const SQUARE: [f64; 9] = [0.5, 1.0, 0.0, 1.5, -0.5, 2.0, -1.0, 3.0, -2.0];

/// Corners of lanes of one road are as near to those of their lanelets, metres.
const MEETING: f64 = 0.003;

/// How near widths and offsets are to the borders, metres.
const WIDTHS: f64 = 0.001;

/// The ways in which a reference line is laid until the borders fit.
const LAYINGS: [(f64, f64, f64); 7] = [
    (0.5, 0.3, 3.0),
    (0.5, 0.1, 1.5),
    (0.5, 0.5, 8.0),
    (1.0, 0.2, 2.0),
    (0.0, 0.2, 2.0),
    (0.5, 0.05, 0.7),
    (0.5, 0.02, 0.25),
];

/// All lanelets as roads; those that have no length are not among them.
pub fn roads(network: &LaneletNetwork) -> Vec<Road> {
    let mut all = Vec::new();
    for group in groups(network) {
        let fits = |r: &Road| r.deviation < BORDER_TOLERANCE && r.ends_fit(network);
        let whole = road(network, &group).filter(|r| group.len() == 1 || fits(r));
        match whole {
            Some(road) => all.push(road),
            None => all.extend(group.iter().filter_map(|place| road(network, &[*place]))),
        }
    }
    all
}

/// Lanelets beside each other in the same direction whose borders are the same, from the left to the right.
fn groups(network: &LaneletNetwork) -> Vec<Vec<usize>> {
    let lanelets = &network.lanelets;
    let place = |id: i64| lanelets.iter().position(|l| l.id == id);
    let beside = |adjacent: Option<Adjacent>| adjacent.filter(|a| a.same_direction).map(|a| a.id);
    let right_of = |lanelet: &Lanelet| {
        let to = place(beside(lanelet.adjacent_right)?)?;
        let other = &lanelets[to];
        let mutual = beside(other.adjacent_left) == Some(lanelet.id);
        (mutual && same_border(lanelet, other)).then_some(to)
    };
    let rights: Vec<Option<usize>> = lanelets.iter().map(right_of).collect();
    let has_left: HashSet<usize> = rights.iter().flatten().copied().collect();
    let mut seen = HashSet::new();
    let mut found = Vec::new();
    let leftmost = (0..lanelets.len()).filter(|i| !has_left.contains(i));
    // A ring of neighbours has no leftmost one.
    for first in leftmost.chain(0..lanelets.len()) {
        let mut group = Vec::new();
        let mut next = Some(first);
        while let Some(place) = next.filter(|place| seen.insert(*place)) {
            group.push(place);
            next = rights[place];
        }
        if !group.is_empty() {
            found.push(group);
        }
    }
    found
}

fn same_border(left: &Lanelet, right: &Lanelet) -> bool {
    let (Some(a), Some(b)) = (line(&left.right.points), line(&right.left.points)) else {
        return false;
    };
    let near = |a: &Polyline, b: &Polyline| {
        let mut all = a.points().iter();
        all.all(|p| b.project(p).d.abs() < BORDER_TOLERANCE)
    };
    near(&a, &b) && near(&b, &a)
}

fn line(points: &[Point]) -> Option<Polyline> {
    Polyline::new(points.iter().copied())
}

/// The road of a group; `None` if a border of it has no length.
fn road(network: &LaneletNetwork, group: &[usize]) -> Option<Road> {
    let lanelet = |place: &usize| &network.lanelets[*place];
    let first = group.first().map(lanelet)?;
    let mut borders = vec![line(&first.left.points)?];
    for place in group {
        borders.push(line(&lanelet(place).right.points)?);
    }
    let (left, right) = (borders.first()?, borders.last()?);
    let mut best: Option<Road> = None;
    for (place, tolerance, shortest) in LAYINGS {
        let how = Laying {
            place,
            tolerance,
            shortest,
        };
        let Some(curve) = lay(left, right, how) else {
            continue;
        };
        let built = along(curve, &borders, group);
        let better = |best: &Road| built.deviation < best.deviation;
        if best.as_ref().is_none_or(better) {
            best = Some(built);
        }
        if best.as_ref().is_some_and(|best| best.deviation < GOOD) {
            break;
        }
    }
    if group.len() == 1 && best.as_ref().is_none_or(|best| best.deviation > FINE) {
        let tight = PAIRED.iter().map(|place| paired(left, right, *place));
        let square = SQUARE
            .iter()
            .map(|place| crossing_squarely(left, right, *place));
        for Paired { curve, left, right } in tight.chain(square).flatten() {
            if best.as_ref().is_some_and(|best| best.deviation < GOOD) {
                break;
            }
            let built = built(curve, &[left, right], &borders, group);
            if best
                .as_ref()
                .is_none_or(|best| built.deviation < best.deviation)
            {
                best = Some(built);
            }
        }
    }
    best
}

fn along(curve: Curve, borders: &[Polyline], group: &[usize]) -> Road {
    let at = samples(&curve);
    let places: Vec<Profile> = borders
        .iter()
        .map(|border| profile(&curve, border, &at))
        .collect();
    built(curve, &places, borders, group)
}

fn built(curve: Curve, places: &[Profile], borders: &[Polyline], group: &[usize]) -> Road {
    let offset = places
        .first()
        .map(|p| p.simplified(WIDTHS))
        .unwrap_or_default();
    let pairs = places.windows(2);
    let widths: Vec<Profile> = pairs
        .map(|pair| pair[0].less(&pair[1]).simplified(WIDTHS))
        .collect();
    let mut road = Road {
        lanelets: group.to_vec(),
        curve,
        offset,
        widths,
        deviation: 0.0,
    };
    let told = borders.iter().enumerate();
    road.deviation = told
        .map(|(i, border)| deviation(&road.curve, &road.border(i), border))
        .fold(0.0, f64::max);
    road
}

impl Road {
    /// Metres.
    pub fn length(&self) -> f64 {
        self.curve.length()
    }

    /// How far to the left the border to the right of so many lanes is, by the arc length.
    pub fn border(&self, lanes: usize) -> Profile {
        let inner = &self.widths[..lanes.min(self.widths.len())];
        let all = inner.iter().chain([&self.offset]).flat_map(|p| &p.0);
        let mut at: Vec<f64> = all.map(|(s, _)| *s).collect();
        at.sort_by(f64::total_cmp);
        at.dedup();
        let value = |s: f64| self.offset.at(s) - inner.iter().map(|w| w.at(s)).sum::<f64>();
        Profile(at.into_iter().map(|s| (s, value(s))).collect())
    }
}

impl Road {
    /// The ends of a border, to the right of so many lanes: at its beginning or its end.
    pub fn corner(&self, lanes: usize, at_end: bool) -> Point {
        let border = self.border(lanes).0;
        let place = if at_end {
            border.last()
        } else {
            border.first()
        };
        let (s, t) = place.copied().unwrap_or_default();
        self.curve.at(s).to_world(&Point::new(0.0, t))
    }

    /// Whether its lanes end where their lanelets do, so that they meet others there.
    fn ends_fit(&self, network: &LaneletNetwork) -> bool {
        let lanes = self.lanelets.iter().enumerate();
        let mut all = lanes.flat_map(|(lane, place)| {
            let lanelet = &network.lanelets[*place];
            [(&lanelet.left, lane), (&lanelet.right, lane + 1)]
        });
        all.all(|(bound, lanes)| {
            let ends = [(bound.points.first(), false), (bound.points.last(), true)];
            let off = |(p, at_end): (Option<&Point>, bool)| {
                p.map_or(0.0, |p| (self.corner(lanes, at_end) - p).norm())
            };
            ends.into_iter().all(|end| off(end) < MEETING)
        })
    }

    /// It up to an arc length, and the rest.
    pub fn split(&self, s: f64) -> (Self, Self) {
        let (head, tail) = self.curve.split(s);
        let part = |curve: Curve, from: f64, to: f64| Self {
            curve,
            offset: self.offset.part(from, to),
            widths: self.widths.iter().map(|w| w.part(from, to)).collect(),
            lanelets: self.lanelets.clone(),
            deviation: self.deviation,
        };
        (part(head, 0.0, s), part(tail, s, self.length()))
    }

    /// A road of some of its lanes, counted from the left.
    pub fn lanes(&self, range: std::ops::Range<usize>) -> Self {
        Self {
            offset: self.border(range.start),
            widths: self.widths[range.clone()].to_vec(),
            lanelets: self.lanelets[range].to_vec(),
            ..self.clone()
        }
    }
}

/// A reference line with the profiles of both borders.
pub struct Paired {
    /// The reference line.
    pub curve: Curve,
    /// The left border.
    pub left: Profile,
    /// The right border.
    pub right: Profile,
}

/// Samples between two pairs are so close, metres.
const SAMPLE_SPACING: f64 = 0.1;

/// A border is looked for so far beside where it is expected, metres.
const BORDER_SEARCH_DISTANCE: f64 = 0.5;

/// A line across the road: where the reference line crosses it, squarely, and where both borders are.
struct Rung {
    pose: Pose,
    left: Point,
    right: Point,
}

/// The road through pairs of points, `place` of the way from the right to the left; `None` where they are not paired.
pub fn paired(left: &Polyline, right: &Polyline, place: f64) -> Option<Paired> {
    let (l, r) = (left.points(), right.points());
    if l.len() != r.len() {
        return None;
    }
    let middles: Vec<Point> = l.iter().zip(r).map(|(l, r)| r + (l - r) * place).collect();
    let rungs = (0..l.len()).map(|i| {
        let before = middles[i.saturating_sub(1)];
        let driven = middles[(i + 1).min(l.len() - 1)] - before;
        Rung {
            pose: Pose {
                position: middles[i],
                heading: square(&(l[i] - r[i]), driven),
            },
            left: l[i],
            right: r[i],
        }
    });
    through(&rungs.collect::<Vec<_>>())
}

/// The road square to every line across it, from a pair of points to the next: the reference line is the curve that
/// crosses all of them at a right angle, and begins `place` of the way from the right to the left.
///
/// Where a border runs back, lines across meet beyond it: on their other side there are such curves that only run
/// forwards, and both borders are exact. `None` where points are not paired, a line across has no length, or the curve
/// runs back.
pub fn crossing_squarely(left: &Polyline, right: &Polyline, place: f64) -> Option<Paired> {
    let (l, r) = (left.points(), right.points());
    if l.len() != r.len() {
        return None;
    }
    let unit = |left: &Point, right: &Point| {
        let across = left - right;
        (across.norm() > NARROW).then(|| across.normalize())
    };
    let mut across = unit(&l[0], &r[0])?;
    // How far to the left of the right border the curve is.
    let mut beside = (l[0] - r[0]).norm() * place;
    let pose = |right: &Point, across: &Vector, beside: f64| Pose {
        position: right + across * beside,
        heading: (-across.x).atan2(across.y),
    };
    let mut rungs = vec![Rung {
        pose: pose(&r[0], &across, beside),
        left: l[0],
        right: r[0],
    }];
    let mut before = r[0];
    for i in 1..l.len() {
        let (a, b) = (l[i] - l[i - 1], r[i] - r[i - 1]);
        let end = unit(&l[i], &r[i])?;
        let turn = across.dot(&end).clamp(-1.0, 1.0).acos();
        let count = (a.norm().max(b.norm()) / RUNGS.0)
            .max(turn / RUNGS.1)
            .ceil()
            .clamp(1.0, MOST_RUNGS);
        for k in 1..=count as usize * FINER {
            let share = k as f64 / (count * FINER as f64);
            let (left, right) = (l[i - 1] + a * share, r[i - 1] + b * share);
            let next = unit(&left, &right)?;
            // Square to the line across: what the border gains along it, the curve loses.
            beside -= (right - before).dot(&((across + next) / 2.0));
            (across, before) = (next, right);
            let pose = pose(&right, &across, beside);
            let last = rungs.last()?;
            let ahead = last.pose.to_local(&pose.position).x;
            if ahead < -MIN_RUNG_SPACING {
                return None;
            }
            if k % FINER == 0 && (ahead > MIN_RUNG_SPACING || i + 1 == l.len()) {
                rungs.push(Rung { pose, left, right });
            }
        }
    }
    through(&rungs)
}

/// Lines across narrower than this have no direction, metres.
const NARROW: f64 = 0.05;

/// Rungs are no farther apart than this: metres along a border, and radians.
const RUNGS: (f64, f64) = (0.5, 0.06);

/// Rungs between two pairs at most.
const MOST_RUNGS: f64 = 200.0;

/// Steps of the integration between two rungs.
const FINER: usize = 16;

/// Rungs nearer than this along the curve are one, metres.
const MIN_RUNG_SPACING: f64 = 0.01;

/// The road whose reference line crosses these rungs.
fn through(rungs: &[Rung]) -> Option<Paired> {
    let mut curve = Curve::default();
    let mut knots = vec![(0.0, 0)];
    for (i, pair) in rungs.windows(2).enumerate() {
        curve.biarc_to(pair[0].pose, pair[1].pose);
        if curve.length() > knots.last().map_or(0.0, |(s, _)| *s) + 1e-6 {
            knots.push((curve.length(), i + 1));
        }
    }
    let side = |of: fn(&Rung) -> Point| -> Profile {
        let mut all = Vec::new();
        let at = |s: f64, p: &Point| curve.at(s).to_local(p).y;
        for pair in knots.windows(2) {
            let ((from, i), (to, j)) = (pair[0], pair[1]);
            let (a, b) = (of(&rungs[i]), of(&rungs[j]));
            let (first, then) = (at(from, &a), at(to, &b));
            all.push((from, first));
            let count = ((to - from) / SAMPLE_SPACING).ceil().clamp(1.0, 200.0);
            for k in 1..count as usize {
                let share = k as f64 / count;
                let s = from + (to - from) * share;
                let expected = first + (then - first) * share;
                all.push((s, crossing(&curve.at(s), &a, &b, expected)));
            }
        }
        let end = knots.last().map(|(s, i)| (*s, at(*s, &of(&rungs[*i]))));
        all.extend(end);
        Profile(all)
    };
    let (left, right) = (side(|r| r.left), side(|r| r.right));
    (knots.len() > 1).then_some(Paired { curve, left, right })
}

/// The direction square to a line across the road, as it is driven.
fn square(across: &Vector, driven: Vector) -> f64 {
    let driving = driven.y.atan2(driven.x);
    if across.norm() < NARROW {
        return driving;
    }
    let square = (-across.x).atan2(across.y);
    if angle_between(driving, square).abs() < 1.4 {
        square
    } else {
        driving
    }
}

/// Where the line across a pose meets that through two points, near where it is expected.
fn crossing(pose: &Pose, a: &Point, b: &Point, expected: f64) -> f64 {
    let (a, b) = (pose.to_local(a), pose.to_local(b));
    let along = b.x - a.x;
    if along.abs() < 1e-9 {
        return expected;
    }
    let t = a.y - (b.y - a.y) * a.x / along;
    if (t - expected).abs() < BORDER_SEARCH_DISTANCE {
        t
    } else {
        expected
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::curve::deviation;
    use super::*;

    fn line(points: &[(f64, f64)]) -> Polyline {
        Polyline::new(points.iter().map(|(x, y)| Point::new(*x, *y))).unwrap()
    }

    #[test]
    fn pairs_across_a_tight_bend_keep_both_borders() {
        // A quarter of a turn about (0, 0): the inner border has a radius of 0.5 m, the outer one of 4 m.
        let around = |radius: f64| {
            let at = |i: i32| f64::from(i) * std::f64::consts::PI / 32.0;
            let all: Vec<(f64, f64)> = (0..=16)
                .map(|i| (radius * at(i).sin(), -radius * at(i).cos()))
                .collect();
            line(&all)
        };
        let (left, right) = (around(0.5), around(4.0));
        let laid = paired(&left, &right, 0.5).unwrap();
        assert!(deviation(&laid.curve, &laid.left, &left) < 0.01);
        assert!(deviation(&laid.curve, &laid.right, &right) < 0.01);
    }

    #[test]
    fn a_border_that_runs_back_is_kept() {
        // A turn about (0, 0) by a lane wider than its radius: its inner border is beyond the centre.
        let around = |radius: f64| {
            let at = |i: i32| f64::from(i) * std::f64::consts::PI / 24.0;
            let all: Vec<(f64, f64)> = (0..=12)
                .map(|i| (radius * at(i).sin(), -radius * at(i).cos()))
                .collect();
            line(&all)
        };
        let (left, right) = (around(-1.0), around(2.5));
        // From the inner border the curve would run back.
        assert!(crossing_squarely(&left, &right, 1.0).is_none());
        let laid = crossing_squarely(&left, &right, 0.0).unwrap();
        assert!(deviation(&laid.curve, &laid.left, &left) < 0.01);
        assert!(deviation(&laid.curve, &laid.right, &right) < 0.01);
    }
}
