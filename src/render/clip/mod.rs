//! Cuts off what reaches far beyond the page before it is painted.
//!
//! Painters have numbers with few digits, fail on very large ones, and spend time on each dash that cannot be seen.

use super::display::{Area, Item, Picture, Segment, Spot, Stroke};
use nearmiss_base::geometry::{Bounds, Point, part_within, ring_within, within_at};

/// What stays within this distance of the page is painted as it is, points.
const UNCLIPPED_DISTANCE: f64 = 20_000.0;

/// Dashed lines longer than this are cut off in any case, points.
const MAX_DASHED_LENGTH: f64 = 100_000.0;

/// No line of a picture is so wide, points: what is wider is not drawn.
const MOST_WIDTH: f64 = 1000.0;

/// What is cut off is kept up to this distance from the page, and the width of its line, points: its ends are not seen.
const CLIP_DISTANCE: f64 = 200.0;

/// Hands every item of a picture to `paint`; where one reaches too far, what can be seen of it.
pub fn each(picture: &Picture, mut paint: impl FnMut(&Item)) {
    let page = Area {
        x: 0.0,
        y: 0.0,
        width: picture.size.0,
        height: picture.size.1,
    };
    for item in &picture.items {
        match cut(item, &page, UNCLIPPED_DISTANCE) {
            None => paint(item),
            Some(items) => items.iter().for_each(&mut paint),
        }
    }
}

/// What can be seen of an item that reaches farther than `near` points from the page; `None` for one that does not.
fn cut(item: &Item, page: &Area, near: f64) -> Option<Vec<Item>> {
    let near = page.grown(near);
    let holds =
        |(x, y): &Spot| (near.x..=near.right()).contains(x) && (near.y..=near.bottom()).contains(y);
    match item {
        Item::Path { path, fill, stroke } => {
            let dashed = stroke.as_ref().is_some_and(|s| !s.dashes.is_empty());
            let width = stroke.as_ref().map_or(0.0, |s| s.width);
            let usual = width <= MOST_WIDTH;
            let fits = path.iter().flat_map(spots).all(|spot| holds(&spot));
            if fits && usual && !(dashed && length(path) > MAX_DASHED_LENGTH) {
                return None;
            }
            let bounds =
                bounds(&page.grown(CLIP_DISTANCE + if usual { 4.0 * width.max(0.0) } else { 0.0 }));
            let rings = rings(path);
            let mut items = Vec::new();
            if let Some(color) = fill {
                let inside: Vec<Segment> = rings
                    .iter()
                    .map(|ring| ring_within(&ring.points, &bounds))
                    .filter(|ring| ring.len() > 2)
                    .flat_map(|ring| segments(&ring, true))
                    .collect();
                items.extend((!inside.is_empty()).then_some(Item::Path {
                    path: inside,
                    fill: Some(*color),
                    stroke: None,
                }));
            }
            if let Some(stroke) = stroke.as_ref().filter(|_| usual) {
                let pieces = rings.iter().flat_map(|ring| ring.cut(stroke, &bounds));
                items.extend(strokes(pieces.collect(), stroke));
            }
            Some(items)
        }
        Item::Text(text) => (!holds(&text.at)).then(Vec::new),
        Item::Begin { .. } | Item::End => None,
    }
}

fn bounds(area: &Area) -> Bounds {
    Bounds {
        min: Point::new(area.x, area.y),
        max: Point::new(area.right(), area.bottom()),
    }
}

fn spots(segment: &Segment) -> impl Iterator<Item = Spot> + use<> {
    let all = match *segment {
        Segment::Move(p) | Segment::Line(p) => [Some(p), None, None],
        Segment::Curve(a, b, c) => [Some(a), Some(b), Some(c)],
        Segment::Close => [None; 3],
    };
    all.into_iter().flatten()
}

/// The length of the polygon through the points of a path.
fn length(path: &[Segment]) -> f64 {
    let spots: Vec<Spot> = path.iter().flat_map(spots).collect();
    let pairs = spots.windows(2);
    pairs
        .map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1))
        .sum()
}

/// A piece of an outline as a polygon.
struct Ring {
    points: Vec<Point>,
    closed: bool,
}

/// The pieces of an outline, its curves as short lines. Points that are no numbers part a line.
fn rings(path: &[Segment]) -> Vec<Ring> {
    let mut rings: Vec<Ring> = Vec::new();
    let begin = |rings: &mut Vec<Ring>| {
        rings.push(Ring {
            points: Vec::new(),
            closed: false,
        });
    };
    for segment in path {
        let finite = spots(segment).all(|(x, y)| x.is_finite() && y.is_finite());
        if rings.is_empty() || matches!(segment, Segment::Move(_)) || !finite {
            begin(&mut rings);
        }
        let Some(ring) = rings.last_mut().filter(|_| finite) else {
            continue;
        };
        match *segment {
            Segment::Move((x, y)) | Segment::Line((x, y)) => ring.points.push(Point::new(x, y)),
            Segment::Curve(a, b, c) => {
                let [a, b, c] = [a, b, c].map(|(x, y)| Point::new(x, y));
                let from = ring.points.last().copied().unwrap_or(a);
                ring.points.extend(curve(from, a, b, c));
            }
            Segment::Close => ring.closed = true,
        }
    }
    rings
}

/// Points along a cubic Bézier curve, without its beginning; as many as it takes to look smooth.
fn curve(from: Point, a: Point, b: Point, to: Point) -> impl Iterator<Item = Point> {
    let length = (a - from).norm() + (b - a).norm() + (to - b).norm();
    let count = (2.0 * length).sqrt().clamp(8.0, 4096.0).ceil() as u32;
    (1..=count).map(move |i| {
        let t = f64::from(i) / f64::from(count);
        let u = 1.0 - t;
        let curved = from.coords * (u * u * u)
            + a.coords * (3.0 * u * u * t)
            + b.coords * (3.0 * u * t * t)
            + to.coords * (t * t * t);
        Point::from(curved)
    })
}

fn segments(points: &[Point], closed: bool) -> Vec<Segment> {
    let mut path: Vec<Segment> = points.iter().map(|p| Segment::Line((p.x, p.y))).collect();
    if let Some(first) = points.first() {
        path[0] = Segment::Move((first.x, first.y));
    }
    path.extend(closed.then_some(Segment::Close));
    path
}

/// A part of a line.
struct Piece {
    points: Vec<Point>,
    /// How far along the whole line its first point is, points.
    start: f64,
}

impl Ring {
    /// The pieces of its line within `bounds`.
    fn cut(&self, stroke: &Stroke, bounds: &Bounds) -> Vec<Piece> {
        let inside = |p: &Point| *p == within_at(p, p, 0.0, bounds);
        let mut points = self.points.clone();
        if self.closed {
            // From a corner that is not seen, so that no corner that is has two ends.
            let hidden = points.iter().position(|p| !inside(p));
            points.rotate_left(hidden.filter(|_| stroke.dashes.is_empty()).unwrap_or(0));
            points.extend(points.first().copied());
        }
        let mut done = 0.0;
        let mut pieces: Vec<Piece> = Vec::new();
        let mut goes_on = false;
        for pair in points.windows(2) {
            let (from, to) = (&pair[0], &pair[1]);
            let length = (to - from).norm();
            match part_within(from, to, bounds) {
                Some((enters, leaves)) => {
                    if !(goes_on && enters == 0.0) {
                        let first = within_at(from, to, enters, bounds);
                        pieces.push(Piece {
                            points: vec![first],
                            start: done + enters * length,
                        });
                    }
                    if let Some(piece) = pieces.last_mut() {
                        piece.points.push(within_at(from, to, leaves, bounds));
                    }
                    goes_on = leaves == 1.0;
                }
                None => goes_on = false,
            }
            done += length;
        }
        pieces
    }
}

/// Paints pieces of a line. Without dashes they are one path: where pieces cover each other, separate ones would be
/// painted twice, which shows at soft edges and through transparent colours.
fn strokes(pieces: Vec<Piece>, stroke: &Stroke) -> Vec<Item> {
    let item = |path: Vec<Segment>, phase: f64| Item::Path {
        path,
        fill: None,
        stroke: Some(Stroke {
            phase,
            ..stroke.clone()
        }),
    };
    if stroke.dashes.is_empty() {
        let paths = pieces.iter().flat_map(|p| segments(&p.points, false));
        let path: Vec<Segment> = paths.collect();
        return if path.is_empty() {
            Vec::new()
        } else {
            vec![item(path, stroke.phase)]
        };
    }
    let period: f64 = stroke.dashes.iter().sum();
    let phase = |start: f64| {
        let phase = (start + stroke.phase).rem_euclid(period);
        if phase.is_finite() { phase } else { 0.0 }
    };
    pieces
        .iter()
        .map(|p| item(segments(&p.points, false), phase(p.start)))
        .collect()
}

#[cfg(test)]
mod tests;
