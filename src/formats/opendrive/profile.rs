//! Borders beside a reference line: how far to the left they are, by its arc length.

use super::curve::Curve;
use nearmiss_base::geometry::{Point, Polyline, Pose};

/// A function of the arc length in straight pieces: points (s, value), metres.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Profile(pub Vec<(f64, f64)>);

impl Profile {
    /// The value at an arc length; that of the nearest end beyond them.
    pub fn at(&self, s: f64) -> f64 {
        let next = self.0.partition_point(|(at, _)| *at <= s);
        match (self.0.get(next.wrapping_sub(1)), self.0.get(next)) {
            (Some((s0, v0)), Some((s1, v1))) => v0 + (v1 - v0) * (s - s0) / (s1 - s0),
            (Some((_, v)), None) | (None, Some((_, v))) => *v,
            (None, None) => 0.0,
        }
    }

    /// The same with as few points as keep every one within `tolerance`, metres.
    pub fn simplified(&self, tolerance: f64) -> Self {
        let all = &self.0;
        let mut keep = vec![false; all.len()];
        let mut spans = vec![(0, all.len().saturating_sub(1))];
        while let Some((from, to)) = spans.pop() {
            let (Some(a), Some(b)) = (all.get(from), all.get(to)) else {
                break;
            };
            keep[from] = true;
            keep[to] = true;
            let chord = |s: f64| a.1 + (b.1 - a.1) * (s - a.0) / (b.0 - a.0);
            let off = |i: &usize| (all[*i].1 - chord(all[*i].0)).abs();
            let worst = (from + 1..to).max_by(|i, j| off(i).total_cmp(&off(j)));
            if let Some(worst) = worst.filter(|i| off(i) > tolerance) {
                spans.push((from, worst));
                spans.push((worst, to));
            }
        }
        let kept = all.iter().zip(keep).filter(|(_, keep)| *keep);
        Self(kept.map(|(point, _)| *point).collect())
    }

    /// The part between two arc lengths, counted from the first.
    pub fn part(&self, from: f64, to: f64) -> Self {
        let inside = self.0.iter().filter(|(s, _)| *s > from && *s < to);
        let ends = [(from, self.at(from)), (to, self.at(to))];
        let all = ends[..1].iter().chain(inside).chain(&ends[1..]);
        Self(all.map(|(s, value)| (s - from, *value)).collect())
    }

    /// This less another one that has values at the same places.
    pub fn less(&self, other: &Self) -> Self {
        let pairs = self.0.iter().zip(&other.0);
        Self(
            pairs
                .map(|((s, a), (_, b))| (*s, (a - b).max(0.0)))
                .collect(),
        )
    }
}

/// The arc lengths at which borders are looked at: close to each other, and at both ends.
pub fn samples(curve: &Curve) -> Vec<f64> {
    let length = curve.length();
    let step = (length / 4000.0)
        .clamp(SAMPLE_SPACING, 1.0)
        .min(length / 8.0);
    let count = (length / step).ceil().max(1.0) as usize;
    let mut all: Vec<f64> = (0..=count)
        .map(|i| length * i as f64 / count as f64)
        .collect();
    // Borders have their kinks where pieces have theirs: curvature changes there.
    all.extend(curve.pieces.iter().skip(1).map(|p| p.s));
    all.sort_by(f64::total_cmp);
    all.dedup_by(|a, b| (*a - *b).abs() < 1e-4);
    all
}

/// As close as samples are, metres.
const SAMPLE_SPACING: f64 = 0.1;

/// Borders farther to the side than this are not looked for, metres.
const MAX_OFFSET: f64 = 200.0;

/// The places of a border at arc lengths of the curve: where the lines across the curve meet it.
pub fn profile(curve: &Curve, border: &Polyline, at: &[f64]) -> Profile {
    let points = border.points();
    let mut values = Vec::with_capacity(at.len());
    let across = |pose: &Pose, p: &Point| (p - pose.position).dot(&pose.left());
    let mut near = points.first().map_or(0.0, |p| across(&curve.at(0.0), p));
    let mut segment = 0;
    for (i, s) in at.iter().enumerate() {
        let pose = curve.at(*s);
        let end = match i {
            0 => points.first(),
            _ if i + 1 == at.len() => points.last(),
            _ => None,
        };
        if let Some(p) = end {
            near = across(&pose, p);
            segment = if i == 0 { 0 } else { points.len() - 2 };
        } else if let Some((t, place)) = crossing(&pose, points, near, segment) {
            (near, segment) = (t, place);
        }
        values.push((*s, near));
    }
    Profile(values)
}

/// Segments around the last one that are looked at first.
const SEARCH_WINDOW: usize = 12;

/// Where the line across a pose meets a border: the crossing nearest to the one before.
fn crossing(pose: &Pose, points: &[Point], near: f64, segment: usize) -> Option<(f64, usize)> {
    let within = |from: usize, to: usize| {
        let pairs = points[from..=to].windows(2).enumerate();
        let found = pairs.filter_map(|(i, pair)| {
            let (a, b) = (pose.to_local(&pair[0]), pose.to_local(&pair[1]));
            if a.x * b.x > 0.0 || a.x == b.x {
                return None;
            }
            let t = a.y + (b.y - a.y) * a.x / (a.x - b.x);
            (t.abs() < MAX_OFFSET).then_some((t, from + i))
        });
        found.min_by(|a, b| (a.0 - near).abs().total_cmp(&(b.0 - near).abs()))
    };
    let last = points.len() - 1;
    let from = segment.saturating_sub(SEARCH_WINDOW);
    within(from, (segment + SEARCH_WINDOW).min(last)).or_else(|| within(0, last))
}

/// How far the border that a profile tells is from a border, either way, metres.
pub fn deviation(curve: &Curve, told: &Profile, border: &Polyline) -> f64 {
    let mut at: Vec<f64> = told.0.iter().map(|(s, _)| *s).collect();
    let length = curve.length();
    let count = (length / 0.25).ceil().clamp(8.0, 8000.0);
    at.extend((0..=count as usize).map(|i| length * i as f64 / count));
    at.sort_by(f64::total_cmp);
    let place = |s: &f64| {
        let pose = curve.at(*s);
        pose.position + pose.left() * told.at(*s)
    };
    let points: Vec<Point> = at.iter().map(place).collect();
    let away = |line: &Polyline, p: &Point| line.project(p).d.abs();
    let off = points.iter().map(|p| away(border, p)).fold(0.0, f64::max);
    // What is missing at the ends, or cut off at a corner.
    let Some(line) = Polyline::new(points) else {
        return off;
    };
    let missing = border.points().iter().map(|p| away(&line, p));
    missing.fold(off, f64::max)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_border_beside_a_line_keeps_its_corners() {
        let mut curve = Curve::default();
        curve.biarc_to(Pose::new(0.0, 0.0, 0.0), Pose::new(20.0, 0.0, 0.0));
        let border = [(0.0, 3.0), (10.0, 3.0), (20.0, 5.0)];
        let border = Polyline::new(border.map(|(x, y)| Point::new(x, y))).unwrap();
        let full = profile(&curve, &border, &samples(&curve));
        let few = full.simplified(1e-3);
        assert!(few.0.len() <= 4, "{few:?}");
        for (s, t) in [(0.0, 3.0), (5.0, 3.0), (15.0, 4.0), (20.0, 5.0)] {
            assert!((few.at(s) - t).abs() < 2e-3, "{s}");
        }
        assert!(deviation(&curve, &few, &border) < 2e-3);
    }

    #[test]
    fn widths_are_not_negative() {
        let a = Profile(vec![(0.0, 1.0), (5.0, 2.0)]);
        let b = Profile(vec![(0.0, 3.0), (5.0, 1.5)]);
        assert_eq!(a.less(&b).0, [(0.0, 0.0), (5.0, 0.5)]);
    }
}
