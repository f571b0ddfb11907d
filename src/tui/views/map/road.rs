//! Lane borders by marking, crosswalks, driving directions, goal lanelets and stop lines.

use ratatui::style::Color;
use ratatui::widgets::canvas::{Context, Points};

use super::lines::{dashes, stroke};
use super::{CellView, Layers, Theme};
use crate::geometry::Point;
use crate::render::scene::{
    Border, DASH, DirectionArrow, GoalArea, MapScene, Paint, Surface, SurfaceKind, offset,
};

/// Where a dot is at most this large, metres, there is room for a second line and for driving directions.
const CLOSE: f64 = 0.4;

/// Dots from one line across a surface to the next at least.
const APART: f64 = 3.0;

pub fn draw(
    ctx: &mut Context<'_>,
    theme: &Theme,
    layers: &Layers,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    // Later strokes colour the cell, so the markings come last.
    if layers.lanes {
        let crossings = scene.surfaces.iter();
        let crossings = crossings.filter(|s| s.kind == SurfaceKind::Crossing);
        for (from, to) in crossings.flat_map(|s| across(view, s, 1.0)) {
            stroke(ctx, view, &[from, to], theme.crosswalk);
        }
    }
    if layers.goal {
        for goal in &scene.goals {
            if let GoalArea::Lanelet(place) = goal {
                dots(ctx, view, &scene.basemap.surfaces[*place], theme.goal);
            }
        }
    }
    if layers.lanes && view.dot <= CLOSE {
        for arrow in scene.surfaces.iter().flat_map(|s| &s.arrows) {
            direction(ctx, view, arrow, theme.lane_dashed);
        }
    }
    // What is painted comes last of all.
    for border in scene.borders.iter().rev() {
        match layers.lanes {
            true => marking(ctx, view, border, theme),
            false => stroke(ctx, view, &border.points, theme.lane_dashed),
        }
    }
    if layers.lights {
        for line in &scene.stop_lines {
            stroke(ctx, view, &line.ends, theme.text);
            stroke(ctx, view, &offset(&line.ends, view.dot), theme.text);
        }
    }
}

/// The lines of a marking: the first one on the border itself, a second one two dots to the right of it, so that one
/// stays free. Broad lines are two dots across.
fn marking(ctx: &mut Context<'_>, view: &CellView, border: &Border, theme: &Theme) {
    let first = border.lines.first().map_or(0.0, |line| line.offset);
    for line in border.lines {
        let broad = line.width >= 2.0;
        for more in 0..=u8::from(broad) {
            let aside = line.offset - first + f64::from(more);
            if aside == 0.0 {
                painted(ctx, view, &border.points, line.paint, theme);
            } else if view.dot <= CLOSE {
                let points = offset(&border.points, aside * view.dot);
                painted(ctx, view, &points, line.paint, theme);
            }
        }
    }
}

fn painted(ctx: &mut Context<'_>, view: &CellView, points: &[Point], paint: Paint, theme: &Theme) {
    match paint {
        Paint::Dashed if view.dot < DASH / 2.0 => {
            dashes(ctx, view, points, (DASH, DASH), theme.lane_dashed);
        }
        Paint::Dashed | Paint::None => stroke(ctx, view, points, theme.lane_dashed),
        Paint::Solid | Paint::Curb | Paint::LoweredCurb | Paint::Unknown => {
            stroke(ctx, view, points, theme.lane);
        }
    }
}

/// A chevron in the driving direction.
fn direction(ctx: &mut Context<'_>, view: &CellView, arrow: &DirectionArrow, color: Color) {
    if view.sees_point(&arrow.tip) {
        for tail in arrow.tails {
            stroke(ctx, view, &[tail, arrow.tip], color);
        }
    }
}

/// Scattered dots, so that what is above stays readable.
fn dots(ctx: &mut Context<'_>, view: &CellView, surface: &Surface, color: Color) {
    let parts = |(from, to): (Point, Point)| {
        [0.25, 0.5, 0.75].map(|part| view.at(&(from + (to - from) * part)))
    };
    let coords: Vec<(f64, f64)> = across(view, surface, 2.0).flat_map(parts).collect();
    ctx.draw(&Points {
        coords: &coords,
        color,
    });
}

/// Lines across a surface that are seen, about `every` metres, at least some dots apart.
fn across<'a>(
    view: &'a CellView,
    surface: &'a Surface,
    every: f64,
) -> impl Iterator<Item = (Point, Point)> + 'a {
    let lines = surface.across(every.max(APART * view.dot), 0.0);
    lines.filter(|(from, to)| view.sees_point(from) || view.sees_point(to))
}
