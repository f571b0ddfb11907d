//! Borders of lanes, each once though neighbours share it.

use std::collections::HashSet;

use super::marking::{MarkingLine, lines_of};
use super::road::{Surface, SurfaceKind};
use crate::geometry::{Bounds, Point};
use crate::scenario::{Bound, Lanelet, LaneletType, LineMarking};

/// What has more than one part in so many within another surface is crossed by it.
const MOST_CROSSED: usize = 5;

/// A border between lanes, or of the road.
#[derive(Debug, Clone, PartialEq)]
pub struct Border {
    /// Its points in driving direction of the lanelet that it was taken from.
    pub points: Vec<Point>,
    /// What is painted along it.
    pub lines: &'static [MarkingLine],
    /// The box around it.
    pub bounds: Bounds,
    /// Whether it runs across the surface of another lane, as within a junction.
    pub is_crossed: bool,
}

/// Every border once; what is painted beats what is not said.
pub(super) fn borders(lanelets: &[Lanelet], surfaces: &[Surface]) -> Vec<Border> {
    let silent = |m: LineMarking| matches!(m, LineMarking::NoMarking | LineMarking::Unknown);
    let mut drawn = HashSet::new();
    let mut found = Vec::new();
    for wanted in [false, true] {
        let driven = lanelets
            .iter()
            .filter(|l| !l.types.contains(&LaneletType::Crosswalk));
        let bounds = driven.flat_map(|l| [&l.left, &l.right]);
        for bound in bounds.filter(|b| silent(b.marking) == wanted) {
            if let Some(bounds) = Bounds::from_points(&bound.points)
                && drawn.insert(key(bound))
            {
                found.push(Border {
                    points: bound.points.clone(),
                    lines: lines_of(bound.marking),
                    bounds,
                    is_crossed: is_crossed(&bound.points, &bounds, surfaces),
                });
            }
        }
    }
    found
}

/// Whether a border runs through the inside of some surface on which traffic drives.
fn is_crossed(points: &[Point], bounds: &Bounds, surfaces: &[Surface]) -> bool {
    let middles = points.windows(2);
    let middles = middles.map(|pair| nalgebra::center(&pair[0], &pair[1]));
    runs_through(&middles.collect::<Vec<_>>(), bounds, surfaces.iter())
}

/// Whether enough of these points within `bounds` lie inside one of the surfaces on which traffic drives.
pub(super) fn runs_through<'a>(
    points: &[Point],
    bounds: &Bounds,
    surfaces: impl Iterator<Item = &'a Surface>,
) -> bool {
    let driven = surfaces.filter(|s| s.kind != SurfaceKind::Crossing);
    let mut near = driven.filter(|s| s.bounds.overlaps(bounds));
    near.any(|surface| {
        let within = points.iter().filter(|p| surface.has_inside(p));
        within.count() * MOST_CROSSED > points.len()
    })
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
    fn what_is_painted_beats_what_a_neighbour_does_not_say() {
        let bound = |y: f64, marking| Bound {
            points: [0.0, 5.0, 10.0].map(|x| Point::new(x, y)).to_vec(),
            heights: Vec::new(),
            marking,
        };
        let lanelet = |id, left, right| Lanelet {
            id,
            left,
            right,
            ..Lanelet::default()
        };
        let lanelets = [
            lanelet(
                1,
                bound(3.0, LineMarking::Solid),
                bound(0.0, LineMarking::Unknown),
            ),
            lanelet(
                2,
                bound(0.0, LineMarking::Dashed),
                bound(-3.0, LineMarking::Unknown),
            ),
        ];
        let found = borders(&lanelets, &[]);
        let lines: Vec<_> = found.iter().map(|b| (b.points[0].y, b.lines)).collect();
        assert_eq!(
            lines,
            [
                (3.0, lines_of(LineMarking::Solid)),
                (0.0, lines_of(LineMarking::Dashed)),
                (-3.0, lines_of(LineMarking::Unknown)),
            ]
        );
    }
}
