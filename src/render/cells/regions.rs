//! Regions: environment obstacles, occupancy sets, goals.

use ratatui::style::Color;

use super::canvas::Canvas;
use super::color::mix;
use super::lines::outlines;
use super::{Appearance, CellView};
use crate::scene::{GoalArea, MapScene, RegionKind};
use nearmiss_base::geometry::Point;

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
