//! Lane borders by their marking, crosswalks, goals, stop lines and lights.

use ratatui::style::Color;
use ratatui::widgets::canvas::{Context, Points};

use super::{Projection, stroke};
use crate::geometry::{Point, Polyline};
use crate::scenario::{Bound, LaneletType, LineMarking};
use crate::tui::loaded::Opened;
use crate::tui::model::Model;

/// Dash and gap of a dashed line, metres.
const DASH: f64 = 3.0;

pub fn draw(ctx: &mut Context<'_>, model: &Model, opened: &Opened, view: &Projection) {
    let theme = &model.theme;
    let network = &opened.scenario.network;
    let goals: Vec<i64> = opened
        .scenario
        .planning_problems
        .iter()
        .flat_map(|p| p.goals.iter().flat_map(|g| g.lanelets()))
        .collect();
    let seen = network
        .lanelets
        .iter()
        .enumerate()
        .filter(|(i, _)| view.sees(&network.bounds_of(*i)));
    // What is drawn later colours the cell, so the markings come last.
    let mut later = Vec::new();
    for (_, lanelet) in seen {
        if lanelet.types.contains(&LaneletType::Crosswalk) {
            hatch(
                ctx,
                view,
                &lanelet.left.points,
                &lanelet.right.points,
                theme.crosswalk,
            );
            continue;
        }
        if goals.contains(&lanelet.id) {
            dots(
                ctx,
                view,
                &lanelet.left.points,
                &lanelet.right.points,
                theme.goal,
            );
        }
        later.push(lanelet);
    }
    for lanelet in &later {
        for border in [&lanelet.left, &lanelet.right] {
            bound(ctx, view, border, theme.lane, theme.lane_dashed);
        }
    }
    let lines = later.iter().filter_map(|l| l.stop_line.as_ref()?.points);
    for (from, to) in lines {
        stroke(ctx, view, &[from, to], theme.text);
    }
}

fn bound(ctx: &mut Context<'_>, view: &Projection, bound: &Bound, solid: Color, dashed: Color) {
    match bound.marking {
        LineMarking::Dashed | LineMarking::BroadDashed | LineMarking::DashedDashed
            if view.dot < DASH / 2.0 =>
        {
            let Some(line) = Polyline::new(bound.points.iter().copied()) else {
                return;
            };
            let mut s = 0.0;
            while s < line.length() {
                let end = (s + DASH).min(line.length());
                stroke(
                    ctx,
                    view,
                    &[line.pose_at(s).position, line.pose_at(end).position],
                    dashed,
                );
                s += 2.0 * DASH;
            }
        }
        LineMarking::Dashed
        | LineMarking::BroadDashed
        | LineMarking::DashedDashed
        | LineMarking::NoMarking => stroke(ctx, view, &bound.points, dashed),
        _ => stroke(ctx, view, &bound.points, solid),
    }
}

/// Stripes across, as painted on a crossing.
fn hatch(ctx: &mut Context<'_>, view: &Projection, left: &[Point], right: &[Point], color: Color) {
    across(view, left, right, 1.0, |from, to| {
        stroke(ctx, view, &[from, to], color)
    });
}

/// Scattered dots, so that what is above stays readable.
fn dots(ctx: &mut Context<'_>, view: &Projection, left: &[Point], right: &[Point], color: Color) {
    let mut coords = Vec::new();
    across(view, left, right, 2.0, |from, to| {
        for t in [0.25, 0.5, 0.75] {
            coords.push(view.at(&(from + (to - from) * t)));
        }
    });
    ctx.draw(&Points {
        coords: &coords,
        color,
    });
}

/// Calls `with` for lines from border to border, about `every` metres, at least three dots apart.
fn across(
    view: &Projection,
    left: &[Point],
    right: &[Point],
    every: f64,
    mut with: impl FnMut(Point, Point),
) {
    let lines = Polyline::new(left.iter().copied()).zip(Polyline::new(right.iter().copied()));
    let Some((left, right)) = lines else { return };
    let every = every.max(3.0 * view.dot);
    let count = (left.length().max(right.length()) / every)
        .ceil()
        .clamp(1.0, 2000.0) as usize;
    for i in 0..=count {
        let part = i as f64 / count as f64;
        let from = left.pose_at(part * left.length()).position;
        let to = right.pose_at(part * right.length()).position;
        if view.sees_point(&from) || view.sees_point(&to) {
            with(from, to);
        }
    }
}
