//! The map from above: lanes, then trails and paths, obstacles, the ego, and signs and labels on top.

mod attack;
mod label_placer;
mod labels;
mod legend;
mod paths;
mod planner;
mod regions;
mod road;
mod signs;
mod tape;
mod vehicles;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{Canvas, Context, Line as Stroke};
use ratatui::widgets::{Paragraph, Wrap};

use unicode_width::UnicodeWidthStr;

use self::label_placer::LabelPlacer;
use crate::geometry::{Bounds, Point, Pose, Vector, part_within};
use crate::tui::loaded::Opened;
use crate::tui::model::{MapDrawn, Model, On, Pane};
use crate::tui::widgets::frame;
use crate::tui::widgets::words::hundredths;

/// From the world to the canvas: x to the right, y up, in metres from the middle.
struct Projection {
    frame: Pose,
    /// Up and left on the screen, as directions of the world.
    axes: (Vector, Vector),
    /// Half of what is seen, metres.
    half: (f64, f64),
    /// Metres of a column and of a row.
    cell: (f64, f64),
    /// Metres from one dot to the next, where they are farther apart.
    dot: f64,
}

impl Projection {
    fn new(frame: Pose, half: (f64, f64), cell: (f64, f64)) -> Self {
        Self {
            frame,
            axes: (frame.forward(), frame.left()),
            half,
            cell,
            dot: (cell.0 / 2.0).max(cell.1 / 4.0),
        }
    }

    fn at(&self, p: &Point) -> (f64, f64) {
        let turned = self.turned(&(p - self.frame.position));
        (turned.x, turned.y)
    }

    /// A direction of the world on the canvas.
    fn turned(&self, v: &Vector) -> Vector {
        Vector::new(-v.dot(&self.axes.1), v.dot(&self.axes.0))
    }

    /// Whether something within `bounds` may be seen.
    fn sees(&self, bounds: &Bounds) -> bool {
        self.sees_around(&bounds.center(), (bounds.max - bounds.min).norm() / 2.0)
    }

    /// Whether something within `reach` metres of a point may be seen.
    fn sees_around(&self, p: &Point, reach: f64) -> bool {
        let (x, y) = self.at(p);
        x.abs() <= self.half.0 + reach && y.abs() <= self.half.1 + reach
    }

    fn sees_point(&self, p: &Point) -> bool {
        self.sees_around(p, 0.0)
    }

    /// The part of a line on the canvas that may be seen, from 0 (its beginning) to 1; with some dots around the map.
    fn part_seen(&self, from: (f64, f64), to: (f64, f64)) -> Option<(f64, f64)> {
        let half = Vector::new(self.half.0 + 2.0 * self.dot, self.half.1 + 2.0 * self.dot);
        let bounds = Bounds {
            min: Point::from(-half),
            max: Point::from(half),
        };
        part_within(
            &Point::new(from.0, from.1),
            &Point::new(to.0, to.1),
            &bounds,
        )
    }
}

/// Draws an open line.
fn stroke(
    ctx: &mut Context<'_>,
    view: &Projection,
    points: &[Point],
    color: ratatui::style::Color,
) {
    for pair in points.windows(2) {
        let ((x1, y1), (x2, y2)) = (view.at(&pair[0]), view.at(&pair[1]));
        ctx.draw(&Stroke {
            x1,
            y1,
            x2,
            y2,
            color,
        });
    }
}

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let camera = &model.camera;
    let across = camera.cell * f64::from(area.width.saturating_sub(2));
    let mut title = Line::from(format!("map · {across:.0} m"));
    let mode = match (camera.follow, camera.ego_up) {
        (true, true) => " · follows ego, ego up",
        (true, false) => " · follows ego",
        (false, true) => " · ego up",
        (false, false) => "",
    };
    title.push_span(Span::styled(mode, Style::new().fg(model.theme.dim)));
    let inner = frame::pane(f, area, model, Pane::Map, title);
    let Some(opened) = &model.opened else {
        let frame = camera.frame(None);
        model.drawn.map(MapDrawn {
            area: inner,
            frame,
            cell: camera.cell,
            row: camera.row(),
        });
        return nothing(f, inner, model);
    };
    if inner.width < 4 || inner.height < 2 {
        return;
    }
    let step = model.clock.step();
    let ego = opened.motion_of(On::Ego, step).map(|m| m.pose);
    let (cell, row) = (camera.cell, camera.row());
    let half = (
        cell * f64::from(inner.width) / 2.0,
        row * f64::from(inner.height) / 2.0,
    );
    let view = Projection::new(camera.frame(ego), half, (cell, row));
    model.drawn.map(MapDrawn {
        area: inner,
        frame: view.frame,
        cell,
        row,
    });
    let canvas = Canvas::default()
        .marker(Marker::Braille)
        .x_bounds([-half.0, half.0])
        .y_bounds([-half.1, half.1])
        .paint(|ctx| paint(ctx, model, opened, &view, step));
    f.render_widget(canvas, inner);
    let shown = write(f, inner, model, opened, &view, step);
    bottom_line(f, inner, model, opened, step, cell);
    legend::draw(f, area, model, shown);
}

fn paint(ctx: &mut Context<'_>, model: &Model, opened: &Opened, view: &Projection, step: i64) {
    road::draw(ctx, model, opened, view);
    regions::fixed(ctx, model, opened, view);
    planner::fan(ctx, model, view);
    ctx.layer();
    regions::occupancies(ctx, model, opened, view, step);
    paths::trails(ctx, model, opened, view, step);
    paths::futures(ctx, model, view);
    planner::recorded(ctx, model, view, step);
    planner::chosen(ctx, model, view);
    attack::motions(ctx, model, view, step);
    ctx.layer();
    vehicles::obstacles(ctx, model, opened, view, step);
    ctx.layer();
    vehicles::ego(ctx, model, opened, view, step);
    tape::line(ctx, model, view);
}

/// Signs and words on top; what has to be where it is comes first.
fn write(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    opened: &Opened,
    view: &Projection,
    step: i64,
) -> signs::Placed {
    let mut board = LabelPlacer::new(f.buffer_mut(), area, view);
    vehicles::arrows(&mut board, model, opened, view, step);
    let lights = signs::lights(&mut board, model, opened, view, step);
    tape::ends(&mut board, model, view);
    labels::draw(&mut board, model, opened, view, step);
    tape::label(&mut board, model, view);
    planner::name(&mut board, model, view, step);
    attack::name(&mut board, model, view, step);
    planner::seconds(&mut board, model, view);
    vehicles::keep_clear(&mut board, model, opened, view, step);
    paths::ends(&mut board, model, view);
    regions::goal_labels(&mut board, model, opened, view);
    let posts = signs::signs(&mut board, model, opened, view);
    signs::Placed { lights, posts }
}

fn nothing(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let words = match (&model.open_error, model.opening.is_some()) {
        (Some(error), _) => crate::description::visible(error).into_owned(),
        (None, true) => "opening…".into(),
        (None, false) => "no scenario is open".into(),
    };
    let color = if model.open_error.is_some() {
        model.theme.danger
    } else {
        model.theme.dim
    };
    let words = Paragraph::new(words)
        .wrap(Wrap { trim: true })
        .style(Style::new().fg(color));
    f.render_widget(words, area);
}

/// A round length at the lower left, the picked obstacle in words at the lower right.
fn bottom_line(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    opened: &Opened,
    step: i64,
    cell: f64,
) {
    let row = Rect {
        y: area.bottom() - 1,
        height: 1,
        ..area
    };
    let mut left = usize::from(area.width);
    if let Some(bar) = scale_bar(area, cell) {
        let width = bar.width();
        left = left.saturating_sub(width + 2);
        let style = Style::new().fg(model.theme.dim);
        f.render_widget(Span::styled(bar, style), row);
    }
    let words = picked_in_words(model, opened, step, left);
    let width = u16::try_from(words.width()).unwrap_or(0).min(row.width);
    let at = Rect {
        x: row.right() - width,
        width,
        ..row
    };
    f.render_widget(Span::styled(words, Style::new().fg(model.theme.picked)), at);
}

fn scale_bar(area: Rect, cell: f64) -> Option<String> {
    let most = f64::from(area.width) * 0.25;
    let lengths = [
        1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 5000.0,
    ];
    let length = lengths.into_iter().rev().find(|l| l / cell <= most)?;
    let columns = (length / cell).round().max(2.0) as usize;
    Some(format!(
        "├{}┤ {length:.0} m",
        "─".repeat(columns.saturating_sub(2))
    ))
}

/// As much as there is room for, the most telling first.
fn picked_in_words(model: &Model, opened: &Opened, step: i64, room: usize) -> String {
    let picked = model.picked.and_then(|id| opened.scenario.obstacle(id));
    let Some(obstacle) = picked else {
        return String::new();
    };
    let value = |measure| {
        let series = opened.series.as_ref()?;
        series.at(measure, obstacle.id, step).value()
    };
    let parts = [
        Some(format!("{} {}", obstacle.kind, obstacle.id)),
        value("distance").map(|d| format!("{} m away", hundredths(d))),
        value("ttc").map(|t| format!("TTC {} s", hundredths(t))),
        obstacle
            .track()
            .at(step)
            .map(|m| format!("{:.1} m/s", m.velocity)),
    ];
    let mut text = String::new();
    for part in parts.into_iter().flatten() {
        let separator = if text.is_empty() { "" } else { " · " };
        if text.width() + separator.width() + part.width() > room {
            break;
        }
        text.push_str(separator);
        text.push_str(&part);
    }
    text
}
