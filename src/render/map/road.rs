//! The surface of the road, lane borders by what is painted there, crossings and stop lines.

use std::collections::HashSet;

use super::Map;
use crate::geometry::{Point, Polyline};
use crate::render::display::{Picture, Spot, Stroke};
use crate::scenario::{Bound, Lanelet, LaneletType, LineMarking};

/// Dash and gap of a dashed line, metres.
const DASH: f64 = 3.0;
/// Width of a painted line, metres.
const LINE: f64 = 0.15;
/// Width of a stripe of a crossing and of the gap beside it, metres.
const STRIPE: f64 = 0.5;

pub fn draw(map: &Map<'_>, picture: &mut Picture) {
    let network = &map.subject.scenario.network;
    let places = 0..network.lanelets.len();
    let seen: Vec<&Lanelet> = places
        .filter(|&i| map.view.sees(&network.bounds_of(i)))
        .map(|i| &network.lanelets[i])
        .collect();
    let crossings = || seen.iter().filter(|l| is_crossing(l));
    picture.group("road", None, |p| {
        for lanelet in seen.iter().filter(|l| !is_crossing(l)) {
            surface(map, p, lanelet);
        }
    });
    picture.group("crossings", None, |p| {
        crossings().for_each(|l| crossing(map, p, l));
    });
    picture.group("markings", None, |p| {
        // Neighbours share their border: it is drawn once, and what is painted beats what is not said.
        let mut drawn = HashSet::new();
        let borders = || {
            let driven = seen.iter().filter(|l| !is_crossing(l));
            driven.flat_map(|l| [&l.left, &l.right])
        };
        let silent = |m: LineMarking| matches!(m, LineMarking::NoMarking | LineMarking::Unknown);
        for wanted in [false, true] {
            for bound in borders().filter(|b| silent(b.marking) == wanted) {
                if drawn.insert(key(bound)) {
                    border(map, p, bound);
                }
            }
        }
        for lanelet in &seen {
            stop_line(map, p, lanelet);
        }
    });
}

fn is_crossing(lanelet: &Lanelet) -> bool {
    lanelet.types.contains(&LaneletType::Crosswalk)
}

/// The same for a border and for its neighbour's, whichever way it is drawn.
fn key(bound: &Bound) -> [[i64; 2]; 3] {
    let rounded = |p: &Point| [(p.x * 50.0).round() as i64, (p.y * 50.0).round() as i64];
    let points = &bound.points;
    let ends = [points.first(), points.last()].map(|p| p.map_or([0, 0], rounded));
    let count = points.len() as i64;
    let middle = match points
        .get(points.len() / 2)
        .zip(points.get(points.len().saturating_sub(1) / 2))
    {
        // The middle of both middles is the same from both ends.
        Some((a, b)) => rounded(&nalgebra::center(a, b)),
        None => [count, 0],
    };
    let (first, last) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    [first, middle, last]
}

fn surface(map: &Map<'_>, picture: &mut Picture, lanelet: &Lanelet) {
    let light = [LaneletType::Sidewalk, LaneletType::BicycleLane];
    let color = match lanelet.types.iter().any(|t| light.contains(t)) {
        true => map.palette.path,
        false => map.palette.road,
    };
    let ring = map.view.all(&lanelet.ring());
    // A thin line of the same colour closes the seams between neighbours.
    picture.polygon(&ring, Some(color), Some(Stroke::new(color, 0.5).rounded()));
}

/// Stripes along the way of those who drive, as they are painted on the road.
fn crossing(map: &Map<'_>, picture: &mut Picture, lanelet: &Lanelet) {
    let ring = map.view.all(&lanelet.ring());
    let color = map.palette.crosswalk;
    let shade = map.palette.road.towards(map.palette.lane, 0.35);
    picture.polygon(&ring, Some(shade), None);
    let line = |points: &[Point]| Polyline::new(points.iter().copied());
    let (Some(left), Some(right)) = (line(&lanelet.left.points), line(&lanelet.right.points))
    else {
        return;
    };
    let length = left.length().max(right.length());
    // Stripes that would be finer than a hair become a surface.
    if map.points(STRIPE) < 0.5 {
        return;
    }
    let count = (length / (2.0 * STRIPE)).round().clamp(1.0, 500.0) as usize;
    for i in 0..count {
        let part = |quarter: f64| (i as f64 + quarter) / count as f64;
        let spot = |line: &Polyline, quarter: f64| {
            map.view
                .at(&line.pose_at(part(quarter) * line.length()).position)
        };
        let ring = [
            spot(&left, 0.25),
            spot(&left, 0.75),
            spot(&right, 0.75),
            spot(&right, 0.25),
        ];
        picture.polygon(&ring, Some(color), None);
    }
}

fn border(map: &Map<'_>, picture: &mut Picture, bound: &Bound) {
    use LineMarking::{
        BroadDashed, BroadSolid, Curb, Dashed, DashedDashed, DashedSolid, LoweredCurb, NoMarking,
        Solid, SolidDashed, SolidSolid, Unknown,
    };
    let palette = map.palette;
    let points = map.view.all(&bound.points);
    let width = map.points(LINE).clamp(0.35, 1.6);
    let solid = Stroke::new(palette.lane, width).rounded();
    let dash = map.points(DASH);
    // Dashes that would run together are a lighter line.
    let dashed = match dash >= 1.2 {
        true => Stroke::new(palette.lane_dashed, width).dashed(&[dash, dash]),
        false => Stroke::new(palette.lane_dashed.towards(palette.road, 0.5), width),
    };
    let broad = |stroke: Stroke| Stroke {
        width: 2.0 * width,
        ..stroke
    };
    match bound.marking {
        Solid => picture.line(&points, solid),
        BroadSolid => picture.line(&points, broad(solid)),
        Dashed => picture.line(&points, dashed),
        BroadDashed => picture.line(&points, broad(dashed)),
        Curb => picture.line(&points, Stroke::new(palette.lane, 1.3 * width).rounded()),
        LoweredCurb => {
            let color = palette.lane.towards(palette.road, 0.4);
            picture.line(&points, Stroke::new(color, 1.3 * width).rounded());
        }
        NoMarking => {
            let color = palette.lane.towards(palette.road, 0.7);
            picture.line(&points, Stroke::new(color, 0.25));
        }
        Unknown => {
            let color = palette.lane.towards(palette.road, 0.4);
            picture.line(&points, Stroke::new(color, 0.35));
        }
        SolidSolid | DashedDashed | SolidDashed | DashedSolid => {
            let (left, right) = match bound.marking {
                SolidSolid => (solid.clone(), solid),
                DashedDashed => (dashed.clone(), dashed),
                SolidDashed => (solid, dashed),
                _ => (dashed, solid),
            };
            picture.line(&beside(&points, -width), left);
            picture.line(&beside(&points, width), right);
        }
    }
}

/// The same line as far to its right; to its left where that is negative.
fn beside(points: &[Spot], by: f64) -> Vec<Spot> {
    let shifted = |i: usize| {
        let (from, to) = (
            points[i.saturating_sub(1)],
            points[(i + 1).min(points.len() - 1)],
        );
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let length = dx.hypot(dy).max(1e-9);
        let (x, y) = points[i];
        (x - dy / length * by, y + dx / length * by)
    };
    (0..points.len()).map(shifted).collect()
}

fn stop_line(map: &Map<'_>, picture: &mut Picture, lanelet: &Lanelet) {
    let Some(line) = &lanelet.stop_line else {
        return;
    };
    // Without its own ends it lies at the end of the lanelet.
    let ends = line.points.or(lanelet
        .left
        .points
        .last()
        .copied()
        .zip(lanelet.right.points.last().copied()));
    let Some((from, to)) = ends else { return };
    let width = map.points(0.4).clamp(0.8, 2.4);
    let mut stroke = Stroke::new(map.palette.lane, width);
    let dash = map.points(0.6);
    if matches!(line.marking, LineMarking::Dashed | LineMarking::BroadDashed) && dash > 0.8 {
        stroke = stroke.dashed(&[dash, dash * 0.6]);
    }
    picture.line(&map.view.all([&from, &to]), stroke);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_border_and_its_neighbours_are_one() {
        let bound = |xs: &[f64]| Bound {
            points: xs.iter().map(|&x| Point::new(x, 1.0)).collect(),
            heights: Vec::new(),
            marking: LineMarking::Solid,
        };
        let there = key(&bound(&[0.0, 3.0, 7.0, 9.0]));
        assert_eq!(there, key(&bound(&[9.0, 7.0, 3.0, 0.0])));
        assert_ne!(there, key(&bound(&[0.0, 3.0, 7.0, 9.5])));
    }

    #[test]
    fn double_lines_lie_on_both_sides() {
        let line = [(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)];
        // y is down: driving to the right, the right side is below.
        assert_eq!(beside(&line, 2.0)[1], (10.0, 2.0));
        assert_eq!(beside(&line, -2.0)[2], (20.0, -2.0));
    }
}
