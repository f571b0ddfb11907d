//! The surface of the road, lane borders by what is painted there, crossings and stop lines.

use super::Map;
use crate::display::{Picture, Stroke};
use crate::scene::{
    Border, DASH, MarkingLine, Paint, STRIPE, StopLine, Surface, SurfaceKind, offset,
};

/// Width of a painted line, metres.
const LINE: f64 = 0.15;

pub fn draw(map: &Map<'_>, picture: &mut Picture) {
    let surfaces = || map.scene.surfaces.iter();
    picture.group("road", None, |p| {
        let roads = surfaces().filter(|s| s.kind != SurfaceKind::Crossing);
        roads.for_each(|road| surface(map, p, road));
    });
    picture.group("crossings", None, |p| {
        let crossings = surfaces().filter(|s| s.kind == SurfaceKind::Crossing);
        crossings.for_each(|s| crossing(map, p, s));
    });
    picture.group("markings", None, |p| {
        map.scene.borders.iter().for_each(|b| border(map, p, b));
        let stop_lines = map.scene.stop_lines.iter();
        stop_lines.for_each(|line| stop_line(map, p, line));
    });
}

fn surface(map: &Map<'_>, picture: &mut Picture, surface: &Surface) {
    let color = match surface.kind {
        SurfaceKind::Sidewalk | SurfaceKind::Bicycle => map.palette.path,
        _ => map.palette.road,
    };
    let ring = map.view.all(&surface.ring);
    // A thin line of the same colour closes the seams between neighbours.
    picture.polygon(&ring, Some(color), Some(Stroke::new(color, 0.5).rounded()));
}

/// Stripes along the way of those who drive, as they are painted on the road.
fn crossing(map: &Map<'_>, picture: &mut Picture, crossing: &Surface) {
    let shade = map.palette.road.towards(map.palette.lane, 0.35);
    picture.polygon(&map.view.all(&crossing.ring), Some(shade), None);
    // Stripes that would be finer than a hair become a surface.
    if map.points(STRIPE) < 0.5 {
        return;
    }
    for stripe in crossing.stripes() {
        picture.polygon(&map.view.all(&stripe), Some(map.palette.crosswalk), None);
    }
}

fn border(map: &Map<'_>, picture: &mut Picture, border: &Border) {
    let width = map.points(LINE).clamp(0.35, 1.6);
    for line in border.lines {
        let stroke = stroke(map, line, width);
        let points = match line.offset {
            0.0 => map.view.all(&border.points),
            aside => map
                .view
                .all(&offset(&border.points, aside * width / map.view.scale)),
        };
        picture.line(&points, stroke);
    }
}

/// A line of a marking; `width` is that of a painted line, points.
fn stroke(map: &Map<'_>, line: &MarkingLine, width: f64) -> Stroke {
    let palette = map.palette;
    let (wide, dash) = (line.width * width, map.points(DASH));
    let faded = |by: f64| palette.lane.towards(palette.road, by);
    match line.paint {
        Paint::Solid | Paint::Curb => Stroke::new(palette.lane, wide).rounded(),
        Paint::LoweredCurb => Stroke::new(faded(0.4), wide).rounded(),
        Paint::Dashed if dash >= 1.2 => {
            Stroke::new(palette.lane_dashed, wide).dashed(&[dash, dash])
        }
        // Dashes that would run together are a lighter line.
        Paint::Dashed => Stroke::new(palette.lane_dashed.towards(palette.road, 0.5), wide),
        Paint::None => Stroke::new(faded(0.7), 0.25),
        Paint::Unknown => Stroke::new(faded(0.4), 0.35),
    }
}

fn stop_line(map: &Map<'_>, picture: &mut Picture, line: &StopLine) {
    let width = map.points(0.4).clamp(0.8, 2.4);
    let mut stroke = Stroke::new(map.palette.lane, width);
    let dash = map.points(0.6);
    if line.dashed && dash > 0.8 {
        stroke = stroke.dashed(&[dash, dash * 0.6]);
    }
    picture.line(&map.view.all(&line.ends), stroke);
}
