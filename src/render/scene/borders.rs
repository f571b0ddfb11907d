//! Borders of lanes, each once though neighbours share it, and their markings as lines to be painted.

use std::collections::HashSet;

use nearmiss_base::geometry::{Bounds, Point, Rings, Vector};
use nearmiss_scene::scenario::{Bound, Lanelet, LaneletType, LineMarking};

use super::road::{Surface, SurfaceKind};

/// What has more than one part in so many within other surfaces is crossed by them.
const MOST_CROSSED: usize = 5;

/// What lies nearer to the edge of a surface than this, metres, does not cross it.
const EDGE: f64 = 0.6;

/// Beside a border is so far from it, metres.
const BESIDE: f64 = 0.4;

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
    /// Whether the surfaces of lanes end there.
    pub is_edge: bool,
}

/// Every border once; what is painted beats what is not said.
pub(super) fn borders(lanelets: &[Lanelet], driven: &DrivenSurfaces<'_>) -> Vec<Border> {
    let silent = |m: LineMarking| matches!(m, LineMarking::NoMarking | LineMarking::Unknown);
    let mut drawn = HashSet::new();
    let mut found = Vec::new();
    for wanted in [false, true] {
        let lanes = lanelets
            .iter()
            .filter(|l| !l.types.contains(&LaneletType::Crosswalk));
        let bounds = lanes.flat_map(|l| [&l.left, &l.right]);
        for bound in bounds.filter(|b| silent(b.marking) == wanted) {
            if let Some(bounds) = Bounds::from_points(&bound.points)
                && drawn.insert(key(bound))
            {
                let middles = middles(&bound.points);
                found.push(Border {
                    points: bound.points.clone(),
                    lines: lines_of(bound.marking),
                    bounds,
                    is_crossed: driven.are_crossed_by(&middles, None),
                    is_edge: driven.end_at(&bound.points),
                });
            }
        }
    }
    found
}

/// The middles of the pieces of a border.
fn middles(points: &[Point]) -> Vec<Point> {
    let pieces = points.windows(2);
    pieces
        .map(|pair| nalgebra::center(&pair[0], &pair[1]))
        .collect()
}

/// The surfaces on which traffic drives.
pub(super) struct DrivenSurfaces<'a> {
    surfaces: Vec<&'a Surface>,
    rings: Rings<'a>,
}

impl<'a> DrivenSurfaces<'a> {
    pub fn new(surfaces: &'a [Surface]) -> Self {
        let driven = surfaces.iter().filter(|s| s.kind != SurfaceKind::Crossing);
        let surfaces: Vec<&Surface> = driven.collect();
        let rings = surfaces.iter().map(|s| (&s.ring[..], s.left_points));
        Self {
            rings: Rings::new(rings),
            surfaces,
        }
    }

    /// Whether enough of these points lie inside them; not inside that of the lanelet `own`.
    pub fn are_crossed_by(&self, points: &[Point], own: Option<i64>) -> bool {
        let is_inside = |p: &&Point| {
            let mut near = self.rings.near(p);
            near.any(|place| {
                own != Some(self.surfaces[place].lanelet) && self.rings.has_inside(place, p, EDGE)
            })
        };
        let mut inside = points.iter().filter(is_inside);
        inside.nth(points.len() / MOST_CROSSED).is_some()
    }

    /// Whether most of a border has them on one side alone.
    fn end_at(&self, border: &[Point]) -> bool {
        let sides = [-BESIDE, BESIDE].map(|aside| middles(&offset(border, aside)));
        let [left, right] = sides.map(|points| points.into_iter().map(|p| self.has(&p)));
        let open = left.zip(right).filter(|(left, right)| !(left & right));
        2 * open.count() > border.len().saturating_sub(1)
    }

    fn has(&self, p: &Point) -> bool {
        let mut near = self.rings.near(p);
        near.any(|place| self.rings.has_inside(place, p, 0.0))
    }
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

/// Dash and gap of a dashed line, metres.
pub const DASH: f64 = 3.0;

/// What a line along a border shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Paint {
    /// A solid line.
    Solid,
    /// Dashes and gaps of [`DASH`].
    Dashed,
    /// A kerb.
    Curb,
    /// A kerb that vehicles can cross.
    LoweredCurb,
    /// Nothing is painted there.
    None,
    /// The file does not say.
    Unknown,
}

/// One line of a marking. Lengths are in widths of a painted line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarkingLine {
    /// What it shows.
    pub paint: Paint,
    /// How far to the right of the border it lies; to the left where negative.
    pub offset: f64,
    /// How broad it is.
    pub width: f64,
}

const fn line(paint: Paint, offset: f64, width: f64) -> MarkingLine {
    MarkingLine {
        paint,
        offset,
        width,
    }
}

/// The lines of a marking, from left to right.
#[must_use]
pub fn lines_of(marking: LineMarking) -> &'static [MarkingLine] {
    use LineMarking as M;
    use Paint::{Dashed, Solid};
    const BROAD: f64 = 2.0;
    match marking {
        M::Solid => const { &[line(Solid, 0.0, 1.0)] },
        M::BroadSolid => const { &[line(Solid, 0.0, BROAD)] },
        M::Dashed => const { &[line(Dashed, 0.0, 1.0)] },
        M::BroadDashed => const { &[line(Dashed, 0.0, BROAD)] },
        M::SolidSolid => const { &[line(Solid, -1.0, 1.0), line(Solid, 1.0, 1.0)] },
        M::DashedDashed => const { &[line(Dashed, -1.0, 1.0), line(Dashed, 1.0, 1.0)] },
        M::SolidDashed => const { &[line(Solid, -1.0, 1.0), line(Dashed, 1.0, 1.0)] },
        M::DashedSolid => const { &[line(Dashed, -1.0, 1.0), line(Solid, 1.0, 1.0)] },
        M::Curb => const { &[line(Paint::Curb, 0.0, 1.3)] },
        M::LoweredCurb => const { &[line(Paint::LoweredCurb, 0.0, 1.3)] },
        M::NoMarking => const { &[line(Paint::None, 0.0, 1.0)] },
        M::Unknown => const { &[line(Paint::Unknown, 0.0, 1.0)] },
    }
}

/// The same line so many metres to its right; to its left where that is negative.
#[must_use]
pub fn offset(points: &[Point], metres: f64) -> Vec<Point> {
    let shifted = |i: usize| {
        let last = points.len() - 1;
        let along = points[(i + 1).min(last)] - points[i.saturating_sub(1)];
        let norm = along.norm();
        let scale = if norm > 0.0 { metres / norm } else { 0.0 };
        points[i] + Vector::new(along.y, -along.x) * scale
    };
    (0..points.len()).map(shifted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_scene::scenario::LaneletNetwork;

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
        let network = LaneletNetwork::new(lanelets.to_vec(), Vec::new(), Vec::new(), Vec::new());
        let surfaces: Vec<Surface> = { network.lanelets.iter().enumerate() }
            .map(|(place, lanelet)| Surface::new(lanelet, network.bounds_of(place)))
            .collect();
        let found = borders(&lanelets, &DrivenSurfaces::new(&surfaces));
        // The road ends at the outer ones alone.
        let edges: Vec<bool> = found.iter().map(|border| border.is_edge).collect();
        assert_eq!(edges, [true, false, true]);
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

    /// With each middle looked at against each edge, or each border against each surface, these take minutes.
    #[test]
    fn long_borders_and_many_lanelets_in_one_place_take_no_longer_than_they_are() {
        let lanelet = |id: i64, points: u32, turn: f64| {
            let (sin, cos) = turn.sin_cos();
            let bound = |y: f64| Bound {
                points: (0..points)
                    .map(|i| f64::from(i) / f64::from(points - 1) * 100.0 - 50.0)
                    .map(|x| Point::new(x * cos - y * sin, x * sin + y * cos))
                    .collect(),
                heights: Vec::new(),
                marking: LineMarking::Solid,
            };
            Lanelet {
                id,
                left: bound(2.0),
                right: bound(-2.0),
                ..Lanelet::default()
            }
        };
        let long = vec![lanelet(1, 10_000, 0.3), lanelet(2, 10_000, 1.2)];
        let alike = (0..300).map(|id| lanelet(id, 10, 0.3)).collect();
        let star = (0..100).map(|id| lanelet(id, 10, f64::from(id as i32) * 0.06));
        let begun = std::time::Instant::now();
        for (lanelets, crossed) in [(long, false), (alike, true), (star.collect(), true)] {
            let network = LaneletNetwork::new(lanelets, Vec::new(), Vec::new(), Vec::new());
            let surfaces: Vec<Surface> = { network.lanelets.iter().enumerate() }
                .map(|(place, lanelet)| Surface::new(lanelet, network.bounds_of(place)))
                .collect();
            let driven = DrivenSurfaces::new(&surfaces);
            assert!(surfaces.iter().all(|s| s.is_crossed_by(&driven) == crossed));
            borders(&network.lanelets, &driven);
        }
        let took = begun.elapsed();
        assert!(took < std::time::Duration::from_secs(60), "{took:?}");
    }

    #[test]
    fn double_lines_lie_on_both_sides() {
        let line = [0.0, 10.0, 20.0].map(|x| Point::new(x, 0.0));
        // y is up: driving to the right, the right side is below.
        assert_eq!(offset(&line, 2.0)[1], Point::new(10.0, -2.0));
        assert_eq!(offset(&line, -2.0)[2], Point::new(20.0, 2.0));
        for marking in LineMarking::ALL {
            let lines = lines_of(marking);
            assert!(lines.is_sorted_by_key(|line| line.offset), "{marking}");
            let middle: f64 = lines.iter().map(|line| line.offset).sum();
            assert!(middle == 0.0 && lines.len() <= 2, "{marking}");
        }
    }

    #[test]
    fn a_line_beside_a_bend_follows_it() {
        let line = [(0.0, 0.0), (10.0, 0.0), (10.0, -5.0)].map(|(x, y)| Point::new(x, y));
        let moved = offset(&line, 0.5);
        assert_eq!(moved[0], Point::new(0.0, -0.5));
        assert_eq!(moved[2], Point::new(9.5, -5.0));
    }
}
