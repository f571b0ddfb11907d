//! Lines of dots: strokes, dashes, thick lines, rows of crosses.

use ratatui::style::Color;

use super::CellView;
use super::canvas::Canvas;
use crate::scene::LineStyle;
use nearmiss_base::geometry::Point;

/// Dots of a dash and of the gap behind it.
const DASH: (f64, f64) = (5.0, 4.0);
/// Dots from one dot to the next of a dotted line.
const SPARSE: f64 = 5.0;
/// Dots from one cross to the next.
pub const CROSSES: f64 = 9.0;
/// Pieces of a line that are longer than this are no pieces of a road, metres.
const FARTHEST: f64 = 1e100;
/// Dashes that fit on the largest map, at a period of a dot.
const MOST_DASHES: f64 = 10_000.0;

/// Draws an open line of the world in a style.
pub fn styled(
    canvas: &mut Canvas<'_>,
    view: &CellView,
    line: &[Point],
    style: LineStyle,
    color: Color,
) {
    match style {
        LineStyle::Solid => stroke(canvas, view, line, color),
        LineStyle::Thick => {
            for pair in line.windows(2) {
                canvas.thick(view.at(&pair[0]), view.at(&pair[1]), color);
            }
        }
        LineStyle::Dashed => {
            let (on, off) = DASH;
            dashes(canvas, view, line, (on * view.dot, off * view.dot), color);
        }
        LineStyle::Dotted => {
            walk(view, line, 0.0, SPARSE * view.dot, |at, _| {
                canvas.point(at, color)
            });
        }
        LineStyle::Crossed => walk(view, line, 0.0, CROSSES * view.dot, |at, _| {
            cross(canvas, view, at, color);
        }),
    }
}

/// Draws an unbroken open line.
pub fn stroke(canvas: &mut Canvas<'_>, view: &CellView, points: &[Point], color: Color) {
    for pair in points.windows(2) {
        canvas.line(view.at(&pair[0]), view.at(&pair[1]), color);
    }
}

/// Draws the outlines of a region.
pub fn outlines(canvas: &mut Canvas<'_>, view: &CellView, rings: &[Vec<Point>], color: Color) {
    for ring in rings {
        stroke(canvas, view, ring, color);
        if let [first, .., last] = ring.as_slice() {
            stroke(canvas, view, &[*last, *first], color);
        }
    }
}

/// Draws dashes along a line; lengths of dash and gap in metres.
pub fn dashes(
    canvas: &mut Canvas<'_>,
    view: &CellView,
    line: &[Point],
    (on, off): (f64, f64),
    color: Color,
) {
    walk(view, line, on, off, |from, to| {
        canvas.line(from, to, color);
    });
}

/// A cross of three dots by three.
fn cross(canvas: &mut Canvas<'_>, view: &CellView, (x, y): (f64, f64), color: Color) {
    let d = view.dot;
    for side in [d, -d] {
        canvas.line((x - d, y - side), (x + d, y + side), color);
    }
}

type Dot = (f64, f64);

/// Walks along a line on the canvas: `on` metres that are handed over by their two ends, `off` metres that are not, and
/// so on.
fn walk(view: &CellView, line: &[Point], on: f64, off: f64, mut with: impl FnMut(Dot, Dot)) {
    let period = on + off;
    let mut done = 0.0;
    // The number of the next dash; where one began that goes on behind a corner, and how far along the line it ends.
    let mut next = 0.0_f64;
    let mut open: Option<(Dot, f64)> = None;
    let mut here = None;
    for pair in line.windows(2) {
        let (from, to) = (view.at(&pair[0]), view.at(&pair[1]));
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        // Too far away to be drawn.
        if length <= 0.0 || length.is_nan() || length > FARTHEST {
            continue;
        }
        here = Some(to);
        // Only the visible part is sampled: coordinates may be of any size.
        let Some((enters, leaves)) = view.part_seen(from, to) else {
            if let Some((start, _)) = open.take() {
                with(start, from);
            }
            done += length;
            continue;
        };
        let at = |s: f64| {
            let part = ((s - done) / length).clamp(0.0, 1.0);
            (
                from.0 + (to.0 - from.0) * part,
                from.1 + (to.1 - from.1) * part,
            )
        };
        if let Some((start, end)) = open.take_if(|(_, end)| *end <= done + length) {
            with(start, at(end));
        }
        // The first dash that reaches into this piece, or into what is seen of it.
        let first = ((done + enters * length - on) / period).ceil().max(next);
        let last = (done + leaves * length) / period;
        // Counted: a number that is large enough does not change by adding to it.
        let count = (last - first).floor().clamp(-1.0, MOST_DASHES);
        for dash in (0_u32..).map(f64::from).take_while(|dash| *dash <= count) {
            let (start, end) = ((first + dash) * period, (first + dash) * period + on);
            if start >= done + length {
                break;
            }
            next = first + dash + 1.0;
            if end <= done + length {
                with(at(start), at(end))
            } else {
                open = Some((at(start), end))
            }
        }
        done += length;
    }
    if let Some(((start, _), end)) = open.zip(here) {
        with(start, end);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_base::geometry::Pose;

    #[test]
    fn lines_of_any_length_have_as_many_dashes_as_are_seen() {
        let view = CellView::new(Pose::new(0.0, 0.0, 0.0), (50.0, 50.0), (2.0, 4.0));
        for far in [1e3, 1e9, 1e15, 1e100, f64::MAX, f64::INFINITY, f64::NAN] {
            for from in [(-far, 0.0), (0.0, 0.0), (far, far)] {
                let line =
                    [from, (far, 0.0), (far, -far), (3.0, 4.0)].map(|(x, y)| Point::new(x, y));
                let mut count = 0;
                walk(&view, &line, 5.0, 4.0, |_, _| count += 1);
                assert!(count < 200, "{count} dashes of {line:?}");
            }
        }
        let mut seen = 0;
        let line = [Point::new(-1e9, 0.0), Point::new(1e9, 0.0)];
        walk(&view, &line, 5.0, 5.0, |_, _| seen += 1);
        assert!((10..=14).contains(&seen), "{seen}");
    }

    #[test]
    fn of_dashes_those_that_are_seen_are_drawn() {
        let view = CellView::new(Pose::new(0.0, 0.0, 0.0), (40.0, 40.0), (1.0, 2.0));
        let starts = |points: &[(f64, f64)]| {
            let line: Vec<Point> = points.iter().map(|(x, y)| Point::new(*x, *y)).collect();
            let mut starts = Vec::new();
            walk(&view, &line, 3.0, 3.0, |from, _| starts.push(from.1));
            starts
        };
        // Along the way 0, 6, 12, 18, 24 and 30 m: the third one begins on the slope.
        let whole = starts(&[(0.0, 0.0), (10.0, 0.0), (20.0, 3.0), (32.5, 3.0)]);
        assert_eq!(whole.len(), 6, "{whole:?}");
        assert!(whole[..2] == [0.0, 6.0] && (11.9..11.92).contains(&whole[2]));
        for far in [1e4, 1e9, 1e15, 1e100] {
            let found = starts(&[(-far, 0.0), (far, 0.0), (0.0, 10.0)]);
            assert!(found.len() < 40, "{}", found.len());
        }
        let crossing = starts(&[(-6000.0, 0.0), (6000.0, 0.0)]);
        let seen = crossing.iter().filter(|at| (-40.0..40.0).contains(*at));
        assert_eq!(seen.count(), 13);
    }

    #[test]
    fn dashes_go_on_across_corners() {
        let north = Pose::new(0.0, 0.0, std::f64::consts::FRAC_PI_2);
        let view = CellView::new(north, (50.0, 50.0), (2.0, 4.0));
        let line = [(0.0, 0.0), (4.0, 0.0), (4.0, 6.0)].map(|(x, y)| Point::new(x, y));
        let mut dashes = Vec::new();
        walk(&view, &line, 3.0, 2.0, |from, to| dashes.push((from, to)));
        let round = |(x, y): (f64, f64)| ((x * 1e6).round() / 1e6, (y * 1e6).round() / 1e6);
        let dashes: Vec<_> = dashes
            .into_iter()
            .map(|(a, b)| (round(a), round(b)))
            .collect();
        assert_eq!(dashes, [((0.0, 0.0), (3.0, 0.0)), ((4.0, 1.0), (4.0, 4.0))]);
        let mut dots = Vec::new();
        walk(&view, &line, 0.0, 4.0, |at, _| dots.push(round(at)));
        assert_eq!(dots, [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0)]);
    }
}
