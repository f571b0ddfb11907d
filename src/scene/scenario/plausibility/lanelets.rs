//! Checks each lanelet: its bounds, its width, its stop line.

use super::lines::{crossing, self_crossing};
use super::{ElementRef, Findings, beyond};
use crate::scenario::{Bound, Lanelet, LaneletNetwork};
use nearmiss_base::geometry::{Bounds, Point};

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
