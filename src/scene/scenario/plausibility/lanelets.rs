//! Checks each lanelet: its bounds, its width, its stop line, and whether lines cross each other or themselves.

use std::f64::consts::PI;

use nearmiss_base::geometry::{Bounds, Point};

use super::{ElementRef, Findings, beyond};
use crate::scenario::{Bound, Lanelet, LaneletNetwork};

/// Shorter bounds lead nowhere, metres.
const SHORTEST: f64 = 0.01;

/// No vehicle fits between bounds that are nowhere farther apart, metres.
const NARROWEST: f64 = 0.1;

/// No lane is wider, metres.
const WIDEST: f64 = 50.0;

/// No stretch of road is drawn with points farther apart, metres.
const LONGEST_SEGMENT: f64 = 2_000.0;

/// A point from which the line goes back where it came from, with legs longer than this, metres, is a mistake.
const SPIKE: f64 = 1.0;

/// Cosine of the turn at a spike: 150°.
const SPIKE_TURN: f64 = -0.866;

/// A stop line farther from its lanelet, metres, belongs to another one.
const STOP_LINE_APART: f64 = 20.0;

/// No road is higher or lower, metres.
const HIGHEST: f64 = 1e4;

pub(super) fn check(network: &LaneletNetwork, found: &mut Findings) {
    for (place, lanelet) in network.lanelets.iter().enumerate() {
        let about = ElementRef::Lanelet(place);
        let mut say = |message: String| {
            found.warn(about, format!("lanelet {}: {message}", lanelet.id));
        };
        let (left, right) = (&lanelet.left, &lanelet.right);
        let mut whole = true;
        for (side, bound, other) in [("left", left, right), ("right", right, left)] {
            whole &= self::bound(side, bound, other, &mut say);
        }
        if whole {
            between(lanelet, &mut say);
        }
        stop_line(lanelet, &network.bounds_of(place), &mut say);
    }
}

/// Cosine of a turn that is none: 10°.
const STRAIGHT: f64 = 0.985;

/// Whether a segment of a bound goes on as its neighbours do, or as the other bound where it has none: a straight line
/// needs no more points, however long it is.
fn goes_on(points: &[Point], at: usize, other: &[Point]) -> bool {
    let leg = |i: usize| Some(points.get(i + 1)? - points.get(i)?);
    let Some(own) = leg(at) else {
        return false;
    };
    let beside = [at.checked_sub(1).and_then(leg), leg(at + 1)];
    let beside: Vec<_> = beside.into_iter().flatten().collect();
    if beside.is_empty() {
        let ends = [
            (points.first(), other.first()),
            (points.last(), other.last()),
        ];
        let near = |(a, b): (Option<&Point>, Option<&Point>)| Some((a? - b?).norm() < WIDEST);
        return ends.into_iter().all(|pair| near(pair) == Some(true));
    }
    let along =
        |leg: &nearmiss_base::geometry::Vector| own.dot(leg) >= STRAIGHT * own.norm() * leg.norm();
    beside.iter().all(along)
}

/// One bound; whether it leads anywhere.
fn bound(side: &str, bound: &Bound, other: &Bound, say: &mut impl FnMut(String)) -> bool {
    let points = &bound.points;
    let (mut length, mut longest, mut spike) = (0.0, (0.0, 0), None);
    let mut before: Option<nearmiss_base::geometry::Vector> = None;
    for (i, pair) in points.windows(2).enumerate() {
        let leg = pair[1] - pair[0];
        let metres = leg.norm();
        length += metres;
        if metres > longest.0 {
            longest = (metres, i);
        }
        if metres > SPIKE {
            let turned = before.filter(|b| leg.dot(b) < SPIKE_TURN * metres * b.norm());
            if turned.is_some() {
                spike = spike.or(Some(i));
            }
        }
        before = Some(leg).filter(|_| metres > SPIKE);
    }
    if length < SHORTEST {
        say(format!("{side} bound is only {length:.3} m long"));
        return false;
    }
    let (metres, at) = longest;
    if metres > LONGEST_SEGMENT && !goes_on(points, at, &other.points) {
        say(format!(
            "{side} bound jumps {metres:.0} m from point {} to {}; is a coordinate wrong?",
            at + 1,
            at + 2
        ));
    }
    if let Some(at) = spike {
        say(format!(
            "{side} bound turns back on itself at point {}",
            at + 1
        ));
    }
    if let Some((a, b)) = self_crossing(points, false) {
        say(format!(
            "{side} bound crosses itself after points {} and {}",
            a + 1,
            b + 1
        ));
    }
    if let Some(z) = bound.heights.iter().find(|z| z.abs() > HIGHEST) {
        say(format!("{side} bound is at a height of {z} m"));
    }
    true
}

/// Both bounds.
fn between(lanelet: &Lanelet, say: &mut impl FnMut(String)) {
    let (left, right) = (&lanelet.left.points, &lanelet.right.points);
    if left.len() != right.len() {
        say(format!(
            "left bound has {} points, right bound {}; points should pair up, so they are matched by length",
            left.len(),
            right.len()
        ));
    }
    if let Some((a, b)) = crossing(left, right) {
        say(format!(
            "bounds cross after point {} of the left and {} of the right one",
            a + 1,
            b + 1
        ));
    } else if lanelet.borders_disagree() {
        say("bounds run in opposite directions; one is reversed".into());
    } else if twice_area(left, right) > 0.0 {
        say("left bound is right of the right one; are they swapped?".into());
    }
    width(left, right, say);
}

fn width(left: &[Point], right: &[Point], say: &mut impl FnMut(String)) {
    let ends = || {
        [
            left.first().zip(right.first()),
            left.last().zip(right.last()),
        ]
    };
    let widths: Vec<f64> = if left.len() == right.len() {
        let pairs = left.iter().zip(right);
        pairs.map(|(l, r)| (l - r).norm()).collect()
    } else {
        let pairs = ends().into_iter().flatten();
        pairs.map(|(l, r)| (l - r).norm()).collect()
    };
    let most = widths.iter().copied().fold(0.0, f64::max);
    if most < NARROWEST {
        say(format!("at most {most:.2} m wide; no vehicle fits"));
    } else if most > WIDEST {
        let at = widths.iter().position(|w| *w == most).unwrap_or_default();
        say(format!(
            "{most:.0} m wide at point {}; is a coordinate wrong?",
            at + 1
        ));
    }
}

/// Twice the area that is on the left of the way along the left bound and back along the right one: negative where
/// the left one lies on the left.
fn twice_area(left: &[Point], right: &[Point]) -> f64 {
    let Some(origin) = left.first() else {
        return 0.0;
    };
    let ring = || left.iter().chain(right.iter().rev());
    let next = ring().skip(1).chain([origin]);
    ring()
        .zip(next)
        .map(|(a, b)| (a - origin).perp(&(b - origin)))
        .sum()
}

fn stop_line(lanelet: &Lanelet, around: &Bounds, say: &mut impl FnMut(String)) {
    let ends = lanelet.stop_line.as_ref().and_then(|line| line.points);
    let Some((from, to)) = ends else {
        return;
    };
    let length = (to - from).norm();
    if length < SHORTEST {
        say("stop line has no length".into());
    } else if length > WIDEST {
        say(format!("stop line is {length:.0} m long"));
    }
    let off = beyond(around, &from).min(beyond(around, &to));
    if off > STOP_LINE_APART {
        say(format!("stop line is {off:.0} m away from the lanelet"));
    }
}

/// A segment of one of two lines, and how far it reaches along the axis that is swept.
struct Segment<'a> {
    line: usize,
    place: usize,
    ends: [&'a Point; 2],
    from: f64,
    to: f64,
}

/// The indices of the first segments of two lines that cross, not merely touch.
pub fn crossing(a: &[Point], b: &[Point]) -> Option<(usize, usize)> {
    swept(&[a, b], |one, other| one.line != other.line)
}

/// The places of two segments of a line that cross; the last point of a `ring` is joined to the first.
pub fn self_crossing(line: &[Point], ring: bool) -> Option<(usize, usize)> {
    if !ring && !turns_back(line) {
        return None;
    }
    let last = line.len();
    let apart = |one: &Segment<'_>, other: &Segment<'_>| {
        let between = one.place.abs_diff(other.place);
        between > 1 && (!ring || between + 1 < last)
    };
    if !ring {
        return swept(&[line], apart);
    }
    let closed: Vec<Point> = line.iter().chain(line.first()).copied().collect();
    swept(&[&closed], apart)
}

/// Whether a line turns so much in all that it could come back to itself.
fn turns_back(line: &[Point]) -> bool {
    let mut turned = 0.0;
    let mut before = None;
    for pair in line.windows(2) {
        let along = pair[1] - pair[0];
        if along.norm_squared() == 0.0 {
            continue;
        }
        if let Some(before) = before {
            turned += along.angle(&before);
        }
        before = Some(along);
    }
    turned >= PI
}

/// The first two segments that cross among those that `may`.
fn swept(
    lines: &[&[Point]],
    may: impl Fn(&Segment<'_>, &Segment<'_>) -> bool,
) -> Option<(usize, usize)> {
    let all = lines.iter().copied().flatten();
    let extent = nearmiss_base::geometry::Bounds::from_points(all)?;
    let size = extent.max - extent.min;
    let along = |p: &Point| if size.x >= size.y { p.x } else { p.y };
    let mut segments = Vec::with_capacity(lines.iter().map(|l| l.len()).sum());
    for (line, points) in lines.iter().enumerate() {
        for (place, pair) in points.windows(2).enumerate() {
            let (a, b) = (along(&pair[0]), along(&pair[1]));
            segments.push(Segment {
                line,
                place,
                ends: [&pair[0], &pair[1]],
                from: a.min(b),
                to: a.max(b),
            });
        }
    }
    segments.sort_by(|a, b| a.from.total_cmp(&b.from));
    let mut open: Vec<&Segment<'_>> = Vec::new();
    for segment in &segments {
        open.retain(|other| other.to >= segment.from);
        let hit = open
            .iter()
            .find(|other| may(other, segment) && cross(other.ends, segment.ends));
        if let Some(other) = hit {
            let (first, second) = if (other.line, other.place) < (segment.line, segment.place) {
                (*other, segment)
            } else {
                (segment, *other)
            };
            return Some((first.place, second.place));
        }
        open.push(segment);
    }
    None
}

/// Whether two segments cross between their ends.
fn cross([a, b]: [&Point; 2], [c, d]: [&Point; 2]) -> bool {
    let side = |p: &Point, q: &Point, r: &Point| (q - p).perp(&(r - p));
    let parted = |x: f64, y: f64| (x > 0.0 && y < 0.0) || (x < 0.0 && y > 0.0);
    parted(side(a, b, c), side(a, b, d)) && parted(side(c, d, a), side(c, d, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: &[(f64, f64)]) -> Vec<Point> {
        points.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    #[test]
    fn two_lines() {
        let low = line(&[(0., 0.), (5., 0.), (9., 0.)]);
        assert_eq!(crossing(&low, &line(&[(0., 3.), (9., 1.)])), None);
        // A shared end point is not a crossing.
        assert_eq!(crossing(&low, &line(&[(0., 3.), (9., 0.)])), None);
        let through = line(&[(0., 3.), (4., 2.), (7., -2.)]);
        assert_eq!(crossing(&low, &through), Some((1, 1)));
        let upright = |points: &[(f64, f64)]| -> Vec<Point> {
            points.iter().map(|&(x, y)| Point::new(y, x)).collect()
        };
        assert_eq!(
            crossing(
                &upright(&[(0., 0.), (5., 0.), (9., 0.)]),
                &upright(&[(0., 3.), (4., 2.), (7., -2.)])
            ),
            Some((1, 1))
        );
    }

    #[test]
    fn one_line_and_a_ring() {
        let winding = line(&[(0., 0.), (4., 0.), (8., 3.), (12., 3.)]);
        assert_eq!(self_crossing(&winding, false), None);
        let knot = line(&[(0., 0.), (8., 0.), (8., 4.), (4., 4.), (4., -4.)]);
        assert_eq!(self_crossing(&knot, false), Some((0, 3)));
        let square = line(&[(0., 0.), (4., 0.), (4., 4.), (0., 4.)]);
        assert_eq!(self_crossing(&square, true), None);
        let bow = line(&[(0., 0.), (4., 4.), (4., 0.), (0., 4.)]);
        assert_eq!(self_crossing(&bow, true), Some((0, 2)));
        assert_eq!(self_crossing(&[], true), None);
    }
}
