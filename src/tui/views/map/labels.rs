//! Names beside the vehicles that matter now: few, and never one over another.

use ratatui::style::{Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::canvas::Context;

use super::Projection;
use super::vehicles::motion;
use crate::geometry::Footprint;
use crate::scenario::Motion;
use crate::tui::loaded::Opened;
use crate::tui::model::Model;

/// Obstacles named at once, beside the picked one.
const MOST: usize = 7;

struct Label {
    text: String,
    style: Style,
    /// Around the vehicle.
    body: Area,
}

pub fn draw(ctx: &mut Context<'_>, model: &Model, opened: &Opened, view: &Projection, step: i64) {
    let theme = &model.theme;
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    let mut labels = Vec::new();
    if let Some(scene) = &opened.scene
        && let Some(motion) = scene.ego.track.at(step)
        && let Some(body) = Area::of(view, scene.ego_footprint_at(step), motion)
    {
        labels.push(Label {
            text: "ego".into(),
            style: bold(theme.ego),
            body,
        });
    }
    for id in wanted(model, opened, step) {
        let Some(obstacle) = opened.scenario.obstacle(id) else {
            continue;
        };
        let Some(m) = motion(obstacle, step) else {
            continue;
        };
        if !view.sees_point(&m.pose.position) {
            continue;
        }
        let value = |measure| {
            opened
                .series
                .as_ref()
                .and_then(|s| s.at(measure, id, step).value())
        };
        let outline = obstacle.footprint_at(step);
        let Some(body) = outline.and_then(|outline| Area::of(view, outline, m)) else {
            continue;
        };
        let (text, style) = match (value("distance"), value("risk")) {
            (Some(0.0), _) => (format!("X {id} contact"), bold(theme.danger)),
            (_, Some(risk)) if risk <= 1.0 => (format!("! {id}"), bold(theme.danger)),
            _ if model.picked == Some(id) => (id.to_string(), bold(theme.picked)),
            (_, Some(risk)) if risk <= 2.0 => (id.to_string(), Style::new().fg(theme.warning)),
            _ => (id.to_string(), Style::new().fg(theme.dim)),
        };
        labels.push(Label { text, style, body });
    }
    place(ctx, view, labels);
}

/// The picked obstacle, then those nearest to the ego at this step.
fn wanted(model: &Model, opened: &Opened, step: i64) -> Vec<i64> {
    let mut near: Vec<(f64, i64)> = match &opened.series {
        Some(series) => series
            .obstacles()
            .iter()
            .filter_map(|&id| Some((series.at("distance", id, step).value()?, id)))
            .collect(),
        None => opened
            .scenario
            .obstacles
            .iter()
            .map(|o| (0.0, o.id))
            .collect(),
    };
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let picked = model.picked.into_iter();
    let others = near
        .into_iter()
        .map(|(_, id)| id)
        .filter(|id| Some(*id) != model.picked);
    picked.chain(others.take(MOST)).collect()
}

/// Writes the labels beside their vehicles, where they cover neither each other nor the vehicles they name.
fn place(ctx: &mut Context<'_>, view: &Projection, labels: Vec<Label>) {
    let (column, row) = (2.0 * view.dot, 4.0 * view.dot);
    let mut taken: Vec<Area> = labels.iter().map(|label| label.body).collect();
    for label in labels {
        let width = label.text.chars().count() as f64 * column;
        let (right, left) = (label.body.x.1 + column, label.body.x.0 - column - width);
        let (middle, over, under) = (
            f64::midpoint(label.body.y.0, label.body.y.1),
            label.body.y.1 + 0.6 * row,
            label.body.y.0 - 0.6 * row,
        );
        let centered = f64::midpoint(label.body.x.0, label.body.x.1) - width / 2.0;
        let spots = [
            (right, middle),
            (left, middle),
            (centered, over),
            (centered, under),
            (right, over),
            (right, under),
            (left, over),
            (left, under),
        ];
        let areas = spots.map(|(x, y)| Area {
            x: (x, x + width),
            y: (y - 0.45 * row, y + 0.45 * row),
        });
        let free = areas.into_iter().find(|area| {
            let inside = area.x.0 > -view.half.0
                && area.x.1 < view.half.0
                && area.y.0 > -view.half.1 + 2.0 * row
                && area.y.1 < view.half.1;
            inside && !taken.iter().any(|other| other.meets(area))
        });
        if let Some(area) = free {
            ctx.print(
                area.x.0,
                f64::midpoint(area.y.0, area.y.1),
                Line::styled(label.text, label.style),
            );
            taken.push(area);
        }
    }
}

/// A box on the canvas.
#[derive(Clone, Copy)]
struct Area {
    x: (f64, f64),
    y: (f64, f64),
}

impl Area {
    fn meets(&self, other: &Self) -> bool {
        self.x.0 < other.x.1 && other.x.0 < self.x.1 && self.y.0 < other.y.1 && other.y.0 < self.y.1
    }

    /// Around a body.
    fn of(view: &Projection, body: &Footprint, motion: &Motion) -> Option<Self> {
        let corners = body.at(motion.pose).outlines().concat();
        let seen: Vec<(f64, f64)> = corners.iter().map(|p| view.at(p)).collect();
        let range = |values: Vec<f64>| {
            let low = values.iter().copied().reduce(f64::min)?;
            Some((low, values.into_iter().reduce(f64::max)?))
        };
        Some(Self {
            x: range(seen.iter().map(|p| p.0).collect())?,
            y: range(seen.iter().map(|p| p.1).collect())?,
        })
    }
}
