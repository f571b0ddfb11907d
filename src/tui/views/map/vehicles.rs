//! Bodies in their real sizes, where they have been, and how fast they are.

use ratatui::style::Color;
use ratatui::widgets::canvas::Context;

use super::{Projection, stroke};
use crate::geometry::{Bounds, Footprint, Point};
use crate::scenario::{Motion, Obstacle, ObstacleRole};
use crate::tui::loaded::Opened;
use crate::tui::model::Model;
use crate::tui::widgets::fill::Fill;

/// Seconds of the past that obstacles leave behind.
const TRAIL: f64 = 2.0;
/// Seconds ahead that the velocity line shows.
const AHEAD: f64 = 0.5;
/// Slower than this, m/s, a line inside the body shows the heading instead.
const STANDING: f64 = 0.3;
/// A body of fewer dots than this is filled, as its outline would be a blot.
const OUTLINE: f64 = 9.0;

/// An obstacle's motion at a step; what stands, stands always.
pub fn motion(obstacle: &Obstacle, step: i64) -> Option<&Motion> {
    match obstacle.role {
        ObstacleRole::Static => obstacle.track().iter().next().map(|(_, m)| m),
        _ => obstacle.track().at(step),
    }
}

pub fn trails(ctx: &mut Context<'_>, model: &Model, opened: &Opened, view: &Projection, step: i64) {
    let theme = &model.theme;
    let back = (TRAIL / opened.scenario.dt()).ceil() as i64;
    for obstacle in &opened.scenario.obstacles {
        let track = obstacle.track();
        let past: Vec<Point> = (step - back..=step)
            .filter_map(|s| track.at(s))
            .map(|m| m.pose.position)
            .collect();
        if Bounds::of(&past).is_some_and(|b| view.sees(&b)) {
            stroke(ctx, view, &past, theme.trail);
        }
        if let (Some(body), Some(motion)) = (obstacle.footprint_at(step), track.at(step)) {
            velocity(ctx, view, body, motion, theme.static_obstacle);
        }
    }
    if let Some(scene) = &opened.scene {
        let track = &scene.ego.track;
        let past: Vec<Point> = (track.steps().start..=step)
            .filter_map(|s| track.at(s))
            .map(|m| m.pose.position)
            .collect();
        stroke(ctx, view, &past, theme.ego_trail);
        // What the ego is going to do: a dot for every other step.
        let ahead = (step..track.steps().end)
            .step_by(2)
            .filter_map(|s| track.at(s));
        let coords: Vec<(f64, f64)> = ahead.map(|m| view.at(&m.pose.position)).collect();
        ctx.draw(&ratatui::widgets::canvas::Points {
            coords: &coords,
            color: theme.ego_trail,
        });
        if let Some(motion) = track.at(step) {
            velocity(ctx, view, scene.ego_footprint_at(step), motion, theme.ego);
        }
    }
}

pub fn obstacles(
    ctx: &mut Context<'_>,
    model: &Model,
    opened: &Opened,
    view: &Projection,
    step: i64,
) {
    let ego = opened.scene.as_ref().map(|s| s.ego.id);
    // The picked and the dangerous ones are drawn last, over the others.
    let mut order: Vec<_> = opened
        .scenario
        .obstacles
        .iter()
        .filter(|o| Some(o.id) != ego)
        .filter_map(|o| Some((o, o.footprint_at(step)?, motion(o, step)?)))
        .map(|(o, body, m)| (importance(model, opened, o, step), o, body, m))
        .collect();
    order.sort_by_key(|(importance, ..)| *importance);
    for (importance, obstacle, body, motion) in order {
        let theme = &model.theme;
        let color = match importance {
            3 => theme.picked,
            2 => theme.danger,
            1 => theme.warning,
            _ if obstacle.role == ObstacleRole::Static => theme.static_obstacle,
            _ => theme.obstacle,
        };
        draw_body(ctx, view, body, motion, color, importance >= 2);
    }
}

/// A line from the front, as long as the way of the next half second; under the bodies it crosses.
fn velocity(
    ctx: &mut Context<'_>,
    view: &Projection,
    body: &Footprint,
    motion: &Motion,
    color: Color,
) {
    if motion.velocity.abs() > STANDING && view.sees_point(&motion.pose.position) {
        let here = motion.pose.position;
        let (rear, front) = body.at(motion.pose).extent(&here, &motion.pose.forward());
        let reach = if motion.velocity > 0.0 { front } else { rear };
        let nose = here + motion.pose.forward() * reach;
        stroke(
            ctx,
            view,
            &[nose, nose + motion.velocity_vector() * AHEAD],
            color,
        );
    }
}

/// 3 picked, 2 in danger of collision, 1 risky, 0 any other.
fn importance(model: &Model, opened: &Opened, obstacle: &Obstacle, step: i64) -> u8 {
    let risk = opened
        .series
        .as_ref()
        .and_then(|s| s.at("risk", obstacle.id, step).value());
    match risk {
        Some(risk) if risk <= 1.0 => 2,
        _ if model.picked == Some(obstacle.id) => 3,
        Some(risk) if risk <= 2.0 => 1,
        _ => 0,
    }
}

pub fn ego(ctx: &mut Context<'_>, model: &Model, opened: &Opened, view: &Projection, step: i64) {
    let Some(scene) = &opened.scene else { return };
    if let Some(motion) = scene.ego.track.at(step) {
        draw_body(
            ctx,
            view,
            scene.ego_footprint_at(step),
            motion,
            model.theme.ego,
            true,
        );
    }
}

fn draw_body(
    ctx: &mut Context<'_>,
    view: &Projection,
    body: &Footprint,
    motion: &Motion,
    color: Color,
    filled: bool,
) {
    if !view.sees_point(&motion.pose.position) {
        return;
    }
    let (length, _) = body.shape().size();
    for ring in body.at(motion.pose).outlines() {
        let corners: Vec<(f64, f64)> = ring.iter().map(|p| view.at(p)).collect();
        if filled || length / view.dot < OUTLINE {
            ctx.draw(&Fill {
                ring: &corners,
                color,
            });
        }
        let mut closed = ring.clone();
        closed.extend(ring.first());
        stroke(ctx, view, &closed, color);
    }
    if motion.velocity.abs() <= STANDING {
        let nose = motion.pose.position + motion.pose.forward() * (length / 2.0);
        stroke(ctx, view, &[motion.pose.position, nose], color);
    }
}
