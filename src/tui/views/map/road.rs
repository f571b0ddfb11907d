//! Lane borders by marking, crosswalks, driving directions, goal lanelets and stop lines.

use ratatui::style::Color;
use ratatui::widgets::canvas::{Context, Points};

use super::{Projection, stroke};
use crate::geometry::{Point, Polyline, Vector};
use crate::scenario::{Bound, Lanelet, LaneletType, LineMarking};
use crate::tui::loaded::Opened;
use crate::tui::model::Model;

/// Dash and gap of a dashed line, metres.
const DASH: f64 = 3.0;

/// Dashes of a straight piece of a line that are drawn at most.
const MOST_DASHES: f64 = 10_000.0;

/// Where a dot is at most this large, metres, there is room for a second line and for driving directions.
const CLOSE: f64 = 0.4;

/// Metres from one sign of the driving direction to the next, and the size of such a sign.
const APART: f64 = 18.0;
const CHEVRON: f64 = 0.8;

pub fn draw(ctx: &mut Context<'_>, model: &Model, opened: &Opened, view: &Projection) {
    let theme = &model.theme;
    let layers = &model.map.layers;
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
    // Later strokes colour the cell, so the markings come last.
    let mut later = Vec::new();
    for (_, lanelet) in seen {
        if lanelet.types.contains(&LaneletType::Crosswalk) {
            if layers.lanes {
                hatch(
                    ctx,
                    view,
                    &lanelet.left.points,
                    &lanelet.right.points,
                    theme.crosswalk,
                );
            }
            continue;
        }
        if layers.goal && goals.contains(&lanelet.id) {
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
        if view.dot <= CLOSE && layers.lanes {
            direction(ctx, view, lanelet, theme.lane_dashed);
        }
        for border in [&lanelet.left, &lanelet.right] {
            if layers.lanes {
                bound(ctx, view, border, theme.lane, theme.lane_dashed);
            } else {
                stroke(ctx, view, &border.points, theme.lane_dashed);
            }
        }
    }
    if layers.lights {
        for (from, to) in later.iter().filter_map(|l| l.stop_line_ends()) {
            stroke(ctx, view, &[from, to], theme.text);
            beside(ctx, view, &[from, to], 1.0, theme.text);
        }
    }
}

/// How a marking is drawn: the line itself, and the second one beside it.
fn kinds(marking: LineMarking) -> (Kind, Option<Kind>) {
    use Kind::{Dashed, Plain, Solid};
    use LineMarking as M;
    match marking {
        M::Dashed => (Dashed, None),
        M::BroadDashed | M::DashedDashed => (Dashed, Some(Dashed)),
        M::BroadSolid | M::SolidSolid => (Solid, Some(Solid)),
        // The first is on the left.
        M::SolidDashed => (Solid, Some(Dashed)),
        M::DashedSolid => (Dashed, Some(Solid)),
        M::NoMarking => (Plain, None),
        M::Solid | M::Curb | M::LoweredCurb | M::Unknown => (Solid, None),
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Solid,
    Dashed,
    /// Where nothing is painted.
    Plain,
}

fn bound(ctx: &mut Context<'_>, view: &Projection, bound: &Bound, solid: Color, dashed: Color) {
    let (first, second) = kinds(bound.marking);
    line(ctx, view, &bound.points, first, (solid, dashed));
    let Some(second) = second.filter(|_| view.dot <= CLOSE) else {
        return;
    };
    // Two dots to the right: broad lines grow together, double ones leave one free.
    let double = matches!(
        bound.marking,
        LineMarking::SolidSolid
            | LineMarking::DashedDashed
            | LineMarking::SolidDashed
            | LineMarking::DashedSolid
    );
    let aside = if double { 2.0 } else { 1.0 };
    let points = shifted(&bound.points, aside * view.dot);
    line(ctx, view, &points, second, (solid, dashed));
}

fn line(
    ctx: &mut Context<'_>,
    view: &Projection,
    points: &[Point],
    kind: Kind,
    (solid, dashed): (Color, Color),
) {
    match kind {
        Kind::Solid => stroke(ctx, view, points, solid),
        Kind::Dashed if view.dot < DASH / 2.0 => dashes(ctx, view, points, dashed),
        Kind::Dashed | Kind::Plain => stroke(ctx, view, points, dashed),
    }
}

fn dashes(ctx: &mut Context<'_>, view: &Projection, points: &[Point], color: Color) {
    let Some(line) = Polyline::new(points.iter().copied()) else {
        return;
    };
    for start in dash_starts(&line, view) {
        let end = (start + DASH).min(line.length());
        let ends = [line.pose_at(start).position, line.pose_at(end).position];
        if view.sees_around(&ends[0], DASH) {
            stroke(ctx, view, &ends, color);
        }
    }
}

/// Where along a line the dashes begin that may be seen, metres: of a line of any length no more than there is room for.
fn dash_starts(line: &Polyline, view: &Projection) -> Vec<f64> {
    let period = 2.0 * DASH;
    let mut starts = Vec::new();
    // The number of the next dash.
    let mut next = 0.0_f64;
    for (pair, from) in line.points().windows(2).zip(line.arc_lengths()) {
        let Some((enters, leaves)) = view.part_seen(view.at(&pair[0]), view.at(&pair[1])) else {
            continue;
        };
        let length = (pair[1] - pair[0]).norm();
        // One that begins before a corner may be seen behind it.
        let first = ((from + enters * length) / period - 1.0).floor();
        let last = ((from + leaves * length) / period).min(line.length() / period);
        let first = next.max(first);
        // Counted: a number that is large enough does not change by adding to it.
        let count = (last - first).floor().clamp(-1.0, MOST_DASHES) + 1.0;
        let dashes = (0_u32..).map(f64::from).take_while(|dash| *dash < count);
        let found = dashes.map(|dash| (first + dash) * period);
        starts.extend(found.filter(|start| *start < line.length()));
        next = first + count;
    }
    starts
}

/// A second line, this many dots to the right of a line.
fn beside(ctx: &mut Context<'_>, view: &Projection, points: &[Point], aside: f64, color: Color) {
    stroke(ctx, view, &shifted(points, aside * view.dot), color);
}

/// The points, moved to the right of the line.
fn shifted(points: &[Point], aside: f64) -> Vec<Point> {
    let right = |from: &Point, to: &Point| {
        let along = to - from;
        let norm = along.norm();
        let scale = if norm > 0.0 { aside / norm } else { 0.0 };
        Vector::new(along.y, -along.x) * scale
    };
    let mut last = Vector::zeros();
    let place = |i: usize| {
        if let Some(next) = points.get(i + 1) {
            last = right(&points[i], next);
        }
        points[i] + last
    };
    (0..points.len()).map(place).collect()
}

/// Chevrons along a lanelet that is driven in one direction.
fn direction(ctx: &mut Context<'_>, view: &Projection, lanelet: &Lanelet, color: Color) {
    let walked = [LaneletType::Sidewalk, LaneletType::Border];
    let driven = lanelet.users_bidirectional.is_empty();
    if !driven || lanelet.types.iter().any(|t| walked.contains(t)) {
        return;
    }
    let (left, right) = (&lanelet.left.points, &lanelet.right.points);
    across(view, left, right, APART, 0.5, |from, to| {
        let width = (to - from).norm();
        if width < 2.0 * CHEVRON {
            return;
        }
        let aside = (to - from) / width;
        let forward = Vector::new(-aside.y, aside.x);
        let tip = nalgebra::center(&from, &to) + forward * CHEVRON;
        for side in [1.0, -1.0] {
            let tail = tip - forward * CHEVRON + aside * (side * CHEVRON);
            stroke(ctx, view, &[tail, tip], color);
        }
    });
}

/// Stripes across, as painted on a crossing.
fn hatch(ctx: &mut Context<'_>, view: &Projection, left: &[Point], right: &[Point], color: Color) {
    across(view, left, right, 1.0, 0.0, |from, to| {
        stroke(ctx, view, &[from, to], color)
    });
}

/// Scattered dots, so that what is above stays readable.
fn dots(ctx: &mut Context<'_>, view: &Projection, left: &[Point], right: &[Point], color: Color) {
    let mut coords = Vec::new();
    across(view, left, right, 2.0, 0.0, |from, to| {
        for t in [0.25, 0.5, 0.75] {
            coords.push(view.at(&(from + (to - from) * t)));
        }
    });
    ctx.draw(&Points {
        coords: &coords,
        color,
    });
}

/// Calls `with` for lines from border to border, about `every` metres, at least three dots apart; the first one after
/// a part of that.
fn across(
    view: &Projection,
    left: &[Point],
    right: &[Point],
    every: f64,
    first: f64,
    mut with: impl FnMut(Point, Point),
) {
    let lines = Polyline::new(left.iter().copied()).zip(Polyline::new(right.iter().copied()));
    let Some((left, right)) = lines else { return };
    let every = every.max(3.0 * view.dot);
    let length = left.length().max(right.length());
    let count = (length / every).ceil().clamp(1.0, 2000.0);
    for i in 0..=count as usize {
        let part = (i as f64 + first) / count;
        if part > 1.0 {
            break;
        }
        let from = left.pose_at(part * left.length()).position;
        let to = right.pose_at(part * right.length()).position;
        if view.sees_point(&from) || view.sees_point(&to) {
            with(from, to);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::geometry::Pose;

    #[test]
    fn of_dashes_those_that_are_seen_are_drawn() {
        let view = Projection::new(Pose::new(0.0, 0.0, 0.0), (40.0, 40.0), (1.0, 2.0));
        let line = |points: &[(f64, f64)]| {
            let points = points.iter().map(|(x, y)| Point::new(*x, *y));
            Polyline::new(points).unwrap()
        };
        let whole = line(&[(0.0, 0.0), (10.0, 0.0), (20.0, 3.0), (32.5, 3.0)]);
        assert_eq!(
            dash_starts(&whole, &view),
            [0.0, 6.0, 12.0, 18.0, 24.0, 30.0]
        );
        for far in [1e4, 1e9, 1e15, 1e100] {
            let starts = dash_starts(&line(&[(-far, 0.0), (far, 0.0), (0.0, 10.0)]), &view);
            assert!(starts.len() < 40, "{}", starts.len());
        }
        let crossing = dash_starts(&line(&[(-6000.0, 0.0), (6000.0, 0.0)]), &view);
        let seen = crossing.iter().filter(|s| (5960.0..6040.0).contains(*s));
        assert_eq!(seen.count(), 13);
    }

    #[test]
    fn a_second_line_lies_to_the_right() {
        let line = [(0.0, 0.0), (10.0, 0.0), (10.0, -5.0)].map(|(x, y)| Point::new(x, y));
        let moved = shifted(&line, 0.5);
        assert_eq!(moved[0], Point::new(0.0, -0.5));
        assert_eq!(moved[2], Point::new(9.5, -5.0));
    }
}
