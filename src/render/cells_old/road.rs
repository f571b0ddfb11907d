//! What is not a body: road surfaces, markings, stop lines, regions, and lines over the traffic.

use nearmiss_base::geometry::Point;
use ratatui::style::Color;

use super::canvas::{Canvas, dashes, outlines, stroke, styled};
use super::compose::mix;
use super::{Appearance, CellView};
use crate::scene::{
    Border, DASH, DirectionArrow, GoalArea, LineStyle, MapScene, Outline, Overlay, Paint,
    RegionKind, STRIPE, Surface, SurfaceKind, offset,
};

/// Where a dot is at most this large, metres, there is room for a second line.
const MAX_DOT_OF_SECOND_LINE: f64 = 0.4;
/// Where a dot is at most this large, metres, there is room for driving directions: elsewhere they look like dashes.
const DIRECTIONS: f64 = 0.15;
/// Where a dot is larger than this, metres, the surface alone shows the road: lines within it would run together.
const MAX_DOT_OF_LINES: f64 = 1.3;
/// Dots from one line across a surface to the next at least.
const MIN_LINE_SPACING: f64 = 3.0;

/// Surfaces, crossings and lanelets to reach.
pub fn surfaces(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    if look.style.has_backgrounds() {
        let is_crossing = |s: &Surface| s.kind == SurfaceKind::Crossing;
        for surface in scene.surfaces.iter().filter(|s| !is_crossing(s)) {
            fill(canvas, view, &surface.ring, ground(look, surface.kind));
        }
        for surface in scene.surfaces.iter().filter(|s| s.is_crossed) {
            fill(canvas, view, &surface.ring, look.theme.map_junction);
        }
        for surface in scene.surfaces.iter().filter(|s| is_crossing(s)) {
            crossing(canvas, look, view, surface);
        }
        // Once more: where lanes cross, what is to be reached lies above.
        for goal in &scene.goals {
            if let GoalArea::Lanelet(place) = goal {
                let ring = &scene.basemap.surfaces[*place].ring;
                tinted(
                    canvas,
                    look,
                    view,
                    std::slice::from_ref(ring),
                    look.theme.goal,
                );
            }
        }
        return;
    }
    if look.markings {
        let crossings = scene
            .surfaces
            .iter()
            .filter(|s| s.kind == SurfaceKind::Crossing);
        for (from, to) in crossings.flat_map(|s| across(view, s, 1.0)) {
            stroke(canvas, view, &[from, to], look.theme.crosswalk);
        }
    }
    for goal in &scene.goals {
        if let GoalArea::Lanelet(place) = goal {
            dots(
                canvas,
                view,
                &scene.basemap.surfaces[*place],
                look.theme.goal,
            );
        }
    }
}

fn ground(look: &Appearance<'_>, kind: SurfaceKind) -> Color {
    let theme = look.theme;
    match kind {
        SurfaceKind::Driving | SurfaceKind::Bus | SurfaceKind::Crossing => theme.map_road,
        SurfaceKind::Shoulder | SurfaceKind::Parking => mix(theme.map_road, theme.map_ground, 0.3),
        SurfaceKind::Sidewalk | SurfaceKind::Bicycle => theme.map_path,
        SurfaceKind::Verge => mix(theme.map_road, theme.map_ground, 0.55),
    }
}

/// Stripes where they are wide enough, else a lighter surface.
fn crossing(canvas: &mut Canvas<'_>, look: &Appearance<'_>, view: &CellView, surface: &Surface) {
    let theme = look.theme;
    let striped = view.cell.0 / 2.0 <= STRIPE;
    let shade = if striped { 0.12 } else { 0.3 };
    fill(
        canvas,
        view,
        &surface.ring,
        mix(theme.map_road, theme.crosswalk, shade),
    );
    if striped && look.markings {
        let stripe = mix(theme.map_road, theme.crosswalk, 0.6);
        surface
            .stripes()
            .iter()
            .for_each(|ring| fill(canvas, view, ring, stripe));
    }
}

fn fill(canvas: &mut Canvas<'_>, view: &CellView, ring: &[Point], color: Color) {
    let corners: Vec<(f64, f64)> = ring.iter().map(|p| view.at(p)).collect();
    canvas.area(&corners, color);
}

/// Borders with what is painted there, driving directions and stop lines.
pub fn markings(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    canvas.faint(true);
    if look.markings && view.dot <= DIRECTIONS {
        let color = if look.style.has_backgrounds() {
            mix(look.theme.map_road, look.theme.map_marking, 0.3)
        } else {
            look.theme.lane_dashed
        };
        for arrow in scene.surfaces.iter().flat_map(|s| &s.arrows) {
            direction(canvas, view, arrow, color);
        }
    }
    // Later strokes colour the cell: what is painted comes last of all.
    for border in scene.borders.iter().rev() {
        if look.markings {
            marking(canvas, view, border, look)
        } else {
            stroke(canvas, view, &border.points, look.theme.lane_dashed)
        }
    }
    canvas.faint(false);
    for line in &scene.stop_lines {
        stroke(canvas, view, &line.ends, look.theme.text);
        stroke(canvas, view, &offset(&line.ends, view.dot), look.theme.text);
    }
}

/// The lines of a marking: the first one on the border itself, a second one two dots to the right of it, so that one
/// stays free. Broad lines are two dots across.
fn marking(canvas: &mut Canvas<'_>, view: &CellView, border: &Border, look: &Appearance<'_>) {
    let first = border.lines.first().map_or(0.0, |line| line.offset);
    for line in border.lines {
        if look.style.has_backgrounds() && is_left_out(view, border, line.paint) {
            continue;
        }
        let broad = line.width >= 2.0;
        for more in 0..=u8::from(broad) {
            let aside = line.offset - first + f64::from(more);
            if aside == 0.0 {
                painted(canvas, view, &border.points, line.paint, look);
            } else if view.dot <= MAX_DOT_OF_SECOND_LINE {
                let points = offset(&border.points, aside * view.dot);
                painted(canvas, view, &points, line.paint, look);
            }
        }
    }
}

/// Where surfaces are filled, borders of which nothing is known are not drawn across the lanes of a junction, and from
/// far away only painted ones are.
fn is_left_out(view: &CellView, border: &Border, paint: Paint) -> bool {
    match paint {
        Paint::None | Paint::Unknown => border.is_crossed || view.dot > MAX_DOT_OF_LINES,
        Paint::Dashed => view.dot > MAX_DOT_OF_LINES,
        Paint::Solid | Paint::Curb | Paint::LoweredCurb => view.dot > 2.0 * MAX_DOT_OF_LINES,
    }
}

fn painted(
    canvas: &mut Canvas<'_>,
    view: &CellView,
    points: &[Point],
    paint: Paint,
    look: &Appearance<'_>,
) {
    let theme = look.theme;
    let (solid, broken) = if look.style.has_backgrounds() {
        (theme.map_marking, theme.map_marking)
    } else {
        (theme.lane, theme.lane_dashed)
    };
    // Dashes that would run together are a lighter line.
    let merged = mix(theme.map_road, theme.map_marking, 0.45);
    match paint {
        Paint::Dashed if view.dot < DASH / 2.0 => {
            dashes(canvas, view, points, (DASH, DASH), broken);
        }
        Paint::Dashed if look.style.has_backgrounds() => stroke(canvas, view, points, merged),
        Paint::Dashed => stroke(canvas, view, points, broken),
        Paint::None if look.style.has_backgrounds() => {
            stroke(
                canvas,
                view,
                points,
                mix(theme.map_road, theme.map_marking, 0.2),
            );
        }
        Paint::None => stroke(canvas, view, points, broken),
        Paint::Solid | Paint::Unknown | Paint::Curb | Paint::LoweredCurb => {
            stroke(canvas, view, points, solid)
        }
    }
}

/// A chevron in the driving direction.
fn direction(canvas: &mut Canvas<'_>, view: &CellView, arrow: &DirectionArrow, color: Color) {
    if view.sees_point(&arrow.tip) {
        for tail in arrow.tails {
            stroke(canvas, view, &[tail, arrow.tip], color);
        }
    }
}

/// Scattered dots, so that what is above stays readable.
fn dots(canvas: &mut Canvas<'_>, view: &CellView, surface: &Surface, color: Color) {
    for (from, to) in across(view, surface, 2.0) {
        for part in [0.25, 0.5, 0.75] {
            canvas.point(view.at(&(from + (to - from) * part)), color);
        }
    }
}

/// Lines across a surface that are seen, about `every` metres, at least some dots apart.
fn across<'a>(
    view: &'a CellView,
    surface: &'a Surface,
    every: f64,
) -> impl Iterator<Item = (Point, Point)> + 'a {
    let lines = surface.across(every.max(MIN_LINE_SPACING * view.dot), 0.0);
    lines.filter(|(from, to)| view.sees_point(from) || view.sees_point(to))
}

/// How much of its own colour an area has over the road.
const TINT: f64 = 0.22;

/// Static regions and goals.
pub fn fixed(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    for goal in &scene.goals {
        if let GoalArea::Region(rings) = goal {
            area(canvas, look, view, rings, look.theme.goal);
        }
    }
    for region in &scene.regions {
        if region.kind == RegionKind::Environment {
            let color = look.theme.static_obstacle;
            tinted(canvas, look, view, &region.rings, color);
            outlines(canvas, view, &region.rings, color);
        }
    }
}

/// Where phantom obstacles and those with occupancy sets may be at the step, as areas.
pub fn occupancies(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    for region in &scene.regions {
        if region.kind == RegionKind::Occupancy {
            let color = match region.highlighted {
                Some(_) => look.theme.picked,
                None => look.theme.occupancy,
            };
            area(canvas, look, view, &region.rings, color);
        }
    }
}

/// A tinted area with an outline.
fn area(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    view: &CellView,
    rings: &[Vec<Point>],
    color: Color,
) {
    tinted(canvas, look, view, rings, color);
    outlines(canvas, view, rings, color);
}

/// The road in a tint; scattered dots where there are no backgrounds.
pub fn tinted(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    view: &CellView,
    rings: &[Vec<Point>],
    color: Color,
) {
    for ring in rings {
        let corners: Vec<(f64, f64)> = ring.iter().map(|p| view.at(p)).collect();
        if look.style.has_backgrounds() {
            canvas.area(&corners, mix(look.theme.map_road, color, TINT));
        } else {
            canvas.scatter(&corners, color)
        }
    }
}

/// Draws them; thick lines cover what was drawn before.
pub fn draw_overlays(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    overlays: &[Overlay],
    view: &CellView,
) {
    for overlay in overlays {
        match overlay {
            Overlay::Path(path) => {
                if path.style == LineStyle::Thick {
                    canvas.layer();
                }
                if view.sees_any(&path.points) {
                    styled(
                        canvas,
                        view,
                        &path.points,
                        path.style,
                        look.color(path.role),
                    );
                }
            }
            Overlay::Outline(Outline {
                role, faint, rings, ..
            }) => {
                let color = look.color(*role);
                if !view.sees_any(rings.iter().flatten()) {
                    continue;
                }
                if *faint {
                    for corner in rings.iter().flatten() {
                        canvas.point(view.at(corner), color);
                    }
                } else {
                    outlines(canvas, view, rings, color)
                }
            }
        }
    }
}

