//! The map from above: lanes, then trails and paths, obstacles, the ego, and signs and labels on top.

mod goals;
mod hollow;
mod image;
mod label_placer;
mod labels;
mod legend;
mod paths;
mod planner;
mod signs;
mod tape;
mod vehicles;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use unicode_width::UnicodeWidthStr;

use self::label_placer::LabelPlacer;
use crate::render::Subject;
use crate::render::cells::{self, Appearance, CellView, MapStyle};
use crate::render::scene::{MapRequest, MapScene, RegionKind, TrailSpan, Viewport};
use crate::tui::loaded::Opened;
use crate::tui::model::{MapDrawn, Model, On, Pane};
use crate::tui::widgets::frame;
use crate::tui::widgets::words::hundredths;

/// What is shown of the motion of obstacles, and of the picked one.
const TRAILS: [TrailSpan; 2] = [
    TrailSpan {
        past: Some(2.0),
        future: Some(2.0),
    },
    TrailSpan {
        past: Some(2.0),
        future: None,
    },
];

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
    let view = CellView::new(camera.frame(ego), half, (cell, row));
    model.drawn.map(MapDrawn {
        area: inner,
        frame: view.frame,
        cell,
        row,
    });
    if let Some(encoder) = image::encoder(model) {
        image::request(model, opened, encoder, (inner, &view), step);
        if let Some(shown) = image::shown(model, inner) {
            shown.draw(f, inner);
            bottom_line(f, inner, model, opened, step, None);
            return legend::draw(f, area, model, signs::Placed::default());
        }
    }
    let scene = MapScene::new(&request(model, opened, view.seen, step));
    let scene = with_layers(scene, model, step);
    cells::draw(f.buffer_mut(), inner, &scene, &view, &look(model));
    let shown = write(f, inner, model, opened, (&scene, &view));
    bottom_line(f, inner, model, opened, step, Some(cell));
    legend::draw(f, area, model, shown);
}

/// How the map is drawn in this terminal.
pub fn look(model: &Model) -> Appearance<'_> {
    let theme = &model.theme;
    let style = match model.look.map_style() {
        // A theme without colours for the road.
        MapStyle::Cells(_) if theme.map_road == theme.map_ground => MapStyle::Braille,
        style => style,
    };
    Appearance {
        style,
        theme,
        markings: model.map.layers.lanes,
    }
}

/// What is to be seen at a step.
fn request<'a>(
    model: &'a Model,
    opened: &'a Opened,
    viewport: Viewport,
    step: i64,
) -> MapRequest<'a> {
    MapRequest {
        subject: Subject {
            scenario: &opened.scenario,
            scene: opened.scene.as_deref(),
        },
        basemap: &opened.basemap,
        step,
        viewport,
        highlighted: model.picked.as_slice(),
        series: opened.series.as_ref(),
        variation: model.variant().and_then(|shown| shown.variation()),
        trails: TRAILS,
    }
}

/// The scene with the layers that are on, and with what only the workbench shows.
fn with_layers<'a>(mut scene: MapScene<'a>, model: &'a Model, step: i64) -> MapScene<'a> {
    let layers = &model.map.layers;
    if !layers.variant {
        scene.variation.clear();
    }
    if !layers.goal {
        scene.goals.clear();
    }
    if !layers.lights {
        scene.lights.clear();
        scene.stop_lines.clear();
    }
    if !layers.signs {
        scene.signs.clear();
    }
    if !layers.trails {
        scene.trails.clear();
    }
    if !layers.occupancy {
        scene.regions.retain(|r| r.kind != RegionKind::Occupancy);
    }
    scene.underlays.extend(planner::fan(model));
    scene.overlays.extend(paths::predictions(model));
    scene.overlays.extend(planner::overlays(model, step));
    scene.top.extend(tape::line(model));
    scene
}

/// Signs and words on top; what has to be where it is comes first.
fn write(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    opened: &Opened,
    (scene, view): (&MapScene<'_>, &CellView),
) -> signs::Placed {
    let mut board = LabelPlacer::new(f.buffer_mut(), area, view);
    let look = &look(model);
    vehicles::arrows(&mut board, look, scene, view);
    vehicles::contacts(&mut board, look, scene, view);
    let lights = signs::lights(&mut board, model, scene, view);
    tape::ends(&mut board, model, view);
    labels::draw(&mut board, model, scene, view);
    tape::label(&mut board, model, view);
    hollow::names(&mut board, look, scene, view);
    planner::seconds(&mut board, model, view);
    vehicles::keep_clear(&mut board, scene, view);
    paths::ends(&mut board, model, view);
    goals::labels(&mut board, model, opened, view);
    let posts = signs::signs(&mut board, model, scene, view);
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

/// A round length at the lower left, unless an image has its own; the picked obstacle in words at the lower right.
fn bottom_line(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    opened: &Opened,
    step: i64,
    cell: Option<f64>,
) {
    let row = Rect {
        y: area.bottom() - 1,
        height: 1,
        ..area
    };
    let mut left = usize::from(area.width);
    if let Some(bar) = cell.and_then(|cell| scale_bar(area, cell)) {
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
