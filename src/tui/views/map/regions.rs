//! Regions of the world: environment obstacles, regions that somebody may cover, goals.

use ratatui::style::Color;
use ratatui::widgets::canvas::Context;

use super::{Projection, stroke};
use crate::geometry::{Bounds, Shape};
use crate::scenario::{ObstacleRole, Position, Prediction};
use crate::tui::loaded::Opened;
use crate::tui::model::Model;

/// What stands for ever, and goal regions.
pub fn fixed(ctx: &mut Context<'_>, model: &Model, opened: &Opened, view: &Projection) {
    let problems = opened.scenario.planning_problems.iter();
    for goal in problems.flat_map(|p| &p.goals) {
        for position in &goal.positions {
            if let Position::Region(region) = position {
                outline(ctx, view, region, model.theme.goal);
            }
        }
    }
    for obstacle in &opened.scenario.obstacles {
        if obstacle.role == ObstacleRole::Environment
            && let Some(body) = &obstacle.footprint
        {
            outline(ctx, view, body.shape(), model.theme.static_obstacle);
        }
    }
}

/// Where phantom obstacles and those with occupancy sets may be at a step.
pub fn occupancies(
    ctx: &mut Context<'_>,
    model: &Model,
    opened: &Opened,
    view: &Projection,
    step: i64,
) {
    for obstacle in &opened.scenario.obstacles {
        let Prediction::Occupancies(occupancies) = &obstacle.prediction else {
            continue;
        };
        let color = match model.picked == Some(obstacle.id) {
            true => model.theme.picked,
            false => model.theme.obstacle,
        };
        for occupancy in occupancies {
            if (occupancy.time.from..=occupancy.time.to).contains(&step) {
                outline(ctx, view, &occupancy.region, color);
            }
        }
    }
}

fn outline(ctx: &mut Context<'_>, view: &Projection, region: &Shape, color: Color) {
    for mut ring in region.outlines() {
        if Bounds::of(&ring).is_some_and(|bounds| view.sees(&bounds)) {
            ring.extend(ring.first().copied());
            stroke(ctx, view, &ring, color);
        }
    }
}
