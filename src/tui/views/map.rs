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
mod status;
mod tape;
mod titles;
mod vehicles;

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Margin, Rect};
use ratatui::style::Style;
use ratatui::widgets::{Paragraph, Wrap};

use self::label_placer::LabelPlacer;
use crate::model::{Halves, MapDrawn, Model, Moment, Pane, Trails};
use crate::widgets::frame;
use nearmiss_base::geometry::Pose;
use nearmiss_render::Subject;
use nearmiss_render::cells::{self, Appearance, CellView, MapStyle};
use nearmiss_render::scene::{MapRequest, MapScene, Owner, RegionKind, TrailSpan, Viewport};

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
    // Answers side by side leave room for one map.
    let second = model.second_moment().filter(|_| !model.compare.open);
    let inside = area.inner(Margin::new(1, 1));
    let halves = second.and_then(|_| Halves::of(inside, camera.aspect));
    let both = second.zip(halves);
    let title = titles::first(model, both.map(|(_, halves)| halves.first), inside);
    let inner = frame::pane(f, area, model, Pane::Map, title);
    let Some(now) = model.moment() else {
        let cell = (camera.cell, camera.row());
        register(model, inner, camera.frame(None), cell, false);
        return nothing(f, inner, model);
    };
    if inner.width < 4 || inner.height < 2 {
        return;
    }
    let shown = match both {
        Some((then, halves)) => {
            let title = titles::second(&then, halves.second);
            frame::divide(f, area, model, Pane::Map, halves.line, title);
            let first = half(f, halves.first, model, &now, false);
            first.and(half(f, halves.second, model, &then, true))
        }
        None => {
            if second.is_some() {
                model.drawn.set_cramped();
            }
            alone(f, inner, model, &now)
        }
    };
    let border = Rect {
        x: area.x + 1,
        y: area.bottom() - 1,
        width: area.width.saturating_sub(2),
        height: 1,
    };
    let free = match both {
        Some(_) => border,
        None => status::draw(f, border, model, &now, image_cell(model, inner, &now)),
    };
    legend::draw(f, free, model, shown);
}

/// Metres a cell of the only map is wide; `None` for an image, which has its own scale.
fn image_cell(model: &Model, inner: Rect, now: &Moment<'_>) -> Option<f64> {
    let is_image = image::encoder(model).is_some() && image::shown(model, inner).is_some();
    (!is_image).then(|| model.camera_of((inner.width, inner.height), now).cell)
}

/// What a camera sees of a moment in an area.
fn seen(model: &Model, area: Rect, moment: &Moment<'_>) -> CellView {
    let camera = model.camera_of((area.width, area.height), moment);
    let (cell, row) = (camera.cell, camera.row());
    let half = (
        cell * f64::from(area.width) / 2.0,
        row * f64::from(area.height) / 2.0,
    );
    CellView::new(camera.frame(moment.ego()), half, (cell, row))
}

/// Tells the mouse where a map is.
fn register(model: &Model, area: Rect, frame: Pose, (cell, row): (f64, f64), second: bool) {
    model.drawn.map(MapDrawn {
        second,
        area,
        frame,
        cell,
        row,
    });
}

/// One of two maps, with its scale and the picked obstacle in a row of its own.
fn half(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    moment: &Moment<'_>,
    second: bool,
) -> signs::Placed {
    let [map, row] = Layout::vertical([Constraint::Fill(1), Constraint::Length(1)]).areas(area);
    let placed = one(f, map, model, moment, second);
    let cell = model.camera_of((map.width, map.height), moment).cell;
    status::draw(f, row, model, moment, Some(cell));
    placed
}

/// The only map: an image, where the terminal shows images.
fn alone(f: &mut Frame<'_>, area: Rect, model: &Model, now: &Moment<'_>) -> signs::Placed {
    if let Some(encoder) = image::encoder(model) {
        let view = seen(model, area, now);
        image::request(model, now, encoder, area, &view);
        if let Some(shown) = image::shown(model, area) {
            register(model, area, view.frame, view.cell, false);
            shown.draw(f, area);
            return signs::Placed::default();
        }
    }
    one(f, area, model, now, false)
}

/// A map in cells.
fn one(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    moment: &Moment<'_>,
    second: bool,
) -> signs::Placed {
    let view = seen(model, area, moment);
    register(model, area, view.frame, view.cell, second);
    let scene = MapScene::new(&request(model, moment, view.seen));
    let scene = with_layers(scene, model, moment);
    cells::draw(f.buffer_mut(), area, &scene, &view, &look(model));
    write(f, area, model, moment, &scene, &view)
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

/// What is to be seen at a moment.
fn request<'a>(model: &'a Model, moment: &Moment<'a>, viewport: Viewport) -> MapRequest<'a> {
    let opened = moment.opened;
    MapRequest {
        subject: Subject {
            scenario: &opened.scenario,
            scene: opened.scene.as_deref(),
        },
        basemap: &opened.basemap,
        step: moment.step,
        viewport,
        highlighted: model.picked.as_slice(),
        series: opened.series.as_ref(),
        variations: moment.variations,
        trails: TRAILS,
    }
}

/// The scene with the layers that are on, and with what only the workbench shows.
fn with_layers<'a>(mut scene: MapScene<'a>, model: &'a Model, moment: &Moment<'a>) -> MapScene<'a> {
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
    scene.trails.retain(|trail| match layers.trails {
        Trails::Off => false,
        Trails::Picked => trail.owner == Owner::Ego || trail.highlighted.is_some(),
        Trails::All => true,
    });
    if !layers.occupancy {
        scene.regions.retain(|r| r.kind != RegionKind::Occupancy);
    }
    scene.underlays.extend(planner::fan(model, moment));
    scene.overlays.extend(paths::predictions(model, moment));
    scene.overlays.extend(planner::overlays(model, moment));
    scene.top.extend(tape::line(model, moment));
    scene
}

/// Signs and words on top; what has to be where it is comes first.
fn write(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    moment: &Moment<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) -> signs::Placed {
    let mut board = LabelPlacer::new(f.buffer_mut(), area, view);
    let look = &look(model);
    vehicles::arrows(&mut board, look, scene, view);
    vehicles::contacts(&mut board, look, scene, view);
    let lights = signs::lights(&mut board, model, scene, view);
    tape::ends(&mut board, model, moment, view);
    labels::draw(&mut board, model, moment, scene, view);
    tape::label(&mut board, model, moment, view);
    hollow::names(&mut board, look, scene, view);
    planner::seconds(&mut board, model, moment, view);
    vehicles::keep_clear(&mut board, scene, view);
    paths::ends(&mut board, model, moment, view);
    goals::labels(&mut board, model, moment.opened, view);
    let posts = signs::signs(&mut board, model, scene, view);
    signs::Placed { lights, posts }
}

fn nothing(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let words = match (&model.open_error, model.opening.is_some()) {
        (Some(error), _) => nearmiss_scene::description::visible(error).into_owned(),
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
