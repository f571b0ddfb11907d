//! Names beside the vehicles that matter now: few, and never one over another.

use ratatui::style::{Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::canvas::Context;
use unicode_width::UnicodeWidthStr;

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
    body: Body,
}

pub fn draw(ctx: &mut Context<'_>, model: &Model, opened: &Opened, view: &Projection, step: i64) {
    let theme = &model.theme;
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    let mut labels = Vec::new();
    if let Some(scene) = &opened.scene
        && let Some(motion) = scene.ego.track.at(step)
        && let Some(body) = Body::of(view, scene.ego_footprint_at(step), motion)
    {
        labels.push(Label {
            text: "ego".into(),
            style: bold(theme.ego),
            body,
        });
    }
    for id in wanted(model, opened, view, step) {
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
        let Some(body) = outline.and_then(|outline| Body::of(view, outline, m)) else {
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

/// The picked obstacle, then those nearest to the ego at this step, or without an ego to the middle of the map.
fn wanted(model: &Model, opened: &Opened, view: &Projection, step: i64) -> Vec<i64> {
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
            .filter_map(|o| {
                let (x, y) = view.at(&motion(o, step)?.pose.position);
                Some((x.hypot(y), o.id))
            })
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

/// Writes the labels beside their vehicles, where they cover neither each other nor the vehicles they name. What comes
/// first has its place first.
fn place(ctx: &mut Context<'_>, view: &Projection, labels: Vec<Label>) {
    let cells = Cells::of(view);
    let mut taken: Vec<Area> = labels.iter().map(|l| cells.around(&l.body)).collect();
    for label in labels {
        let width = i32::try_from(label.text.width()).unwrap_or(FAR);
        let body = cells.around(&label.body);
        let (right, left) = (body.x.1 + 1, body.x.0 - 1 - width);
        let (middle, over, under) = ((body.y.0 + body.y.1 - 1) / 2, body.y.0 - 1, body.y.1);
        let centered = (body.x.0 + body.x.1 - width) / 2;
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
            y: (y, y + 1),
        });
        let free = areas.into_iter().find(|area| {
            // The lowest row says who is picked.
            let inside = area.x.0 >= 0
                && area.x.1 <= cells.columns
                && area.y.0 >= 0
                && area.y.1 < cells.rows;
            // A column stays free between two labels, so that they do not read as one.
            let wider = Area {
                x: (area.x.0 - 1, area.x.1 + 1),
                ..*area
            };
            inside && !taken.iter().any(|other| other.meets(&wider))
        });
        if let Some(area) = free {
            let (x, y) = cells.point(view, area.x.0, area.y.0);
            ctx.print(x, y, Line::styled(label.text, label.style));
            taken.push(area);
        }
    }
}

/// Cells that no screen has.
const FAR: i32 = 1_000_000;

/// The cells that the canvas is drawn in.
struct Cells {
    columns: i32,
    rows: i32,
    /// Metres of a column and of a row.
    size: (f64, f64),
    half: (f64, f64),
}

/// A box of cells, the ends not in it.
#[derive(Clone, Copy)]
struct Area {
    x: (i32, i32),
    y: (i32, i32),
}

impl Area {
    fn meets(&self, other: &Self) -> bool {
        self.x.0 < other.x.1 && other.x.0 < self.x.1 && self.y.0 < other.y.1 && other.y.0 < self.y.1
    }
}

impl Cells {
    fn of(view: &Projection) -> Self {
        let size = (2.0 * view.dot, 4.0 * view.dot);
        let count = |half: f64, size: f64| (2.0 * half / size).round() as i32;
        Self {
            columns: count(view.half.0, size.0),
            rows: count(view.half.1, size.1),
            size,
            half: view.half,
        }
    }

    /// The cells of a body.
    fn around(&self, body: &Body) -> Area {
        let cell = |metres: f64, size: f64| {
            let far = f64::from(FAR);
            (metres / size).floor().clamp(-far, far) as i32
        };
        let column = |x: f64| cell(x + self.half.0, self.size.0);
        let row = |y: f64| cell(self.half.1 - y, self.size.1);
        Area {
            x: (column(body.x.0), column(body.x.1) + 1),
            y: (row(body.y.1), row(body.y.0) + 1),
        }
    }

    /// Where the canvas has to write to begin in a cell: it spreads its points over one cell less.
    fn point(&self, view: &Projection, column: i32, row: i32) -> (f64, f64) {
        let part = |cell: i32, cells: i32| {
            let part = (f64::from(cell) + 0.5) / f64::from((cells - 1).max(1));
            part.min(1.0)
        };
        (
            (part(column, self.columns) * 2.0 - 1.0) * view.half.0,
            (1.0 - part(row, self.rows) * 2.0) * view.half.1,
        )
    }
}

/// What a body covers on the canvas, metres.
#[derive(Clone, Copy)]
struct Body {
    x: (f64, f64),
    y: (f64, f64),
}

impl Body {
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
