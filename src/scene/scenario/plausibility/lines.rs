//! Checks whether lines cross each other or themselves.

use std::f64::consts::PI;

use nearmiss_base::geometry::Point;

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
