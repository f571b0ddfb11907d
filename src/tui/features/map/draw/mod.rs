//! The map from above: lanes, then trails and paths, obstacles, the ego, and signs and labels on top.

pub mod bodies;
pub mod labels;

use nearmiss_base::geometry::Pose;
use nearmiss_render::cells::{Appearance, CellView, MapStyle, Painting};
use nearmiss_render::scene::{
    MapRequest, MapScene, Overlay, Owner, RegionKind, TrailSpan, Viewport,
};
use nearmiss_render::{Color as Ink, MapPage, Palette, Picture, Subject, WorkbenchMap};
use nearmiss_scene::metrics::Grade;
use nearmiss_scene::scenario::Obstacle;
use nearmiss_settings::{Theme, ThemeColor};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Margin, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::features::map::draw::request as scene_request;
use crate::model::{Camera, MapChoice, MapDrawn, MapPicture, Model, Moment, Pane, Strip, Trails};
use crate::pixels::{Encoder, MapImage};
use crate::theme::components;
use crate::widgets::window;
use crate::widgets::words::hundredths;
use labels::{Body, LabelPlacer};

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

/// The map of a pane, whose cells are painted while the other panes are drawn.
pub struct Begun<'a> {
    area: Rect,
    inner: Rect,
    shown: Shown<'a>,
}

enum Shown<'a> {
    /// No scenario is open, or there is no room.
    Nothing,
    /// An image, which the terminal paints.
    Image(Moment<'a>),
    /// A map in cells.
    One(Box<Painted<'a>>),
    /// Two of them, each with a row below it.
    Two(Box<[(Painted<'a>, Rect); 2]>),
}

/// Begins the map: everything but what stands on it and below it.
pub fn begin<'a>(f: &mut Frame<'_>, area: Rect, model: &'a Model) -> Begun<'a> {
    let camera = &model.camera;
    // Answers side by side leave room for one map.
    let second = model.second_moment().filter(|_| !model.compare.open);
    let inside = area.inner(Margin::new(1, 1));
    let halves = second.and_then(|_| model.halves(inside));
    let both = second.zip(halves);
    let title = first(model, both.map(|(_, halves)| halves.first), inside);
    let inner = window::pane(f, area, model, Pane::Map, title);
    let begun = |shown| Begun { area, inner, shown };
    let Some(now) = model.moment() else {
        let cell = (camera.cell, camera.row());
        register(model, inner, camera.frame(None), cell, false);
        nothing(f, inner, model);
        return begun(Shown::Nothing);
    };
    if inner.width < 4 || inner.height < 2 {
        return begun(Shown::Nothing);
    }
    begun(match both {
        Some((then, halves)) => {
            let title = second_title(&then, halves.second);
            window::divide(f, area, model, Pane::Map, halves.line, title);
            let first = half(f, halves.first, model, now, false);
            Shown::Two(Box::new([first, half(f, halves.second, model, then, true)]))
        }
        None => {
            if second.is_some() {
                model.drawn.set_cramped();
            }
            alone(f, inner, model, now)
        }
    })
}

impl Begun<'_> {
    /// Shows the map, and draws what stands on it and below it.
    pub fn end(self, f: &mut Frame<'_>, model: &Model) {
        let Self { area, inner, shown } = self;
        let border = Rect {
            x: area.x + 1,
            y: area.bottom() - 1,
            width: area.width.saturating_sub(2),
            height: 1,
        };
        let (free, placed) = match shown {
            Shown::Nothing => return,
            Shown::Two(maps) => {
                let [first, second] = maps.map(|(map, row)| {
                    let (moment, size) = (map.moment, (map.area.width, map.area.height));
                    let placed = map.end(f, model);
                    let cell = model.camera_of(size, &moment).cell;
                    draw_status(f, row, model, &moment, Some(cell));
                    placed
                });
                (border, first.and(second))
            }
            Shown::One(map) => {
                let moment = map.moment;
                let placed = map.end(f, model);
                let cell = model.camera_of((inner.width, inner.height), &moment).cell;
                (draw_status(f, border, model, &moment, Some(cell)), placed)
            }
            // It has its own scale.
            Shown::Image(moment) => (
                draw_status(f, border, model, &moment, None),
                bodies::Placed::default(),
            ),
        };
        labels::draw_legend(f, free, model, placed);
    }
}

/// What is seen of a moment in an area.
fn seen(model: &Model, area: Rect, moment: &Moment<'_>) -> CellView {
    let camera = model.camera_of((area.width, area.height), moment);
    seen_by(&camera, area, moment)
}

/// What a camera sees of it.
fn seen_by(camera: &Camera, area: Rect, moment: &Moment<'_>) -> CellView {
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

/// One of two maps, and a row of its own for its scale and the picked obstacle.
fn half<'a>(
    f: &mut Frame<'_>,
    area: Rect,
    model: &'a Model,
    moment: Moment<'a>,
    second: bool,
) -> (Painted<'a>, Rect) {
    let [map, row] = Layout::vertical([Constraint::Fill(1), Constraint::Length(1)]).areas(area);
    (one(f, map, model, moment, second), row)
}

/// The only map: an image, where the terminal shows images.
fn alone<'a>(f: &mut Frame<'_>, area: Rect, model: &'a Model, now: Moment<'a>) -> Shown<'a> {
    if let Some(encoder) = encoder(model) {
        let view = seen(model, area, &now);
        request_image(model, &now, encoder, area, &view);
        if let Some(shown) = shown(model, area) {
            register(model, area, view.frame, view.cell, false);
            shown.draw(f, area);
            return Shown::Image(now);
        }
    }
    Shown::One(Box::new(one(f, area, model, now, false)))
}

/// A map in cells.
fn one<'a>(
    f: &mut Frame<'_>,
    area: Rect,
    model: &'a Model,
    moment: Moment<'a>,
    second: bool,
) -> Painted<'a> {
    let view = seen(model, area, &moment);
    register(model, area, view.frame, view.cell, second);
    Painted::begin(f, area, model, moment, view, true)
}

/// A map of a strip in cells, which the mouse does not reach; goals have no labels there, which would have room in some
/// maps alone, nor lines, which nothing would tell from others.
pub fn still(f: &mut Frame<'_>, area: Rect, model: &Model, moment: &Moment<'_>, strip: &Strip<'_>) {
    if area.width >= 4 && area.height >= 2 {
        let camera = model.camera_of_strip((area.width, area.height), strip);
        let view = seen_by(&camera, area, &strip.ego);
        Painted::begin(f, area, model, *moment, view, false).end(f, model);
    }
}

/// A map in cells that is being painted.
struct Painted<'a> {
    area: Rect,
    view: CellView,
    moment: Moment<'a>,
    scene: MapScene<'a>,
    cells: Painting,
    /// Whether goals have labels.
    goals: bool,
}

impl<'a> Painted<'a> {
    fn begin(
        f: &mut Frame<'_>,
        area: Rect,
        model: &'a Model,
        moment: Moment<'a>,
        view: CellView,
        goals: bool,
    ) -> Self {
        let look = look(model);
        let page = page(&view, area, look.style.samples());
        let request = request(model, &moment, page.viewport());
        let mut scene = with_layers(MapScene::new(&request), model, &moment);
        if !goals && !look.style.has_backgrounds() {
            scene.goals.clear();
        }
        let (palette, theme) = inks(model);
        let workbench = WorkbenchMap {
            theme: &theme,
            filled: look.style.has_backgrounds(),
            markings: model.map.layers.lanes,
            hollow: bodies::is_hollow(&look),
            cell: view.cell.0,
        };
        let picture = page.draw(&request, &scene, &palette, workbench);
        Self {
            cells: Painting::begin(f.buffer_mut(), area, picture, &look),
            area,
            view,
            moment,
            scene,
            goals,
        }
    }

    /// Shows it with what stands on it.
    fn end(self, f: &mut Frame<'_>, model: &Model) -> bodies::Placed {
        let Self {
            area,
            view,
            moment,
            scene,
            cells,
            goals,
        } = self;
        cells.show(f.buffer_mut());
        let look = look(model);
        let ground = (look.style.has_backgrounds()).then_some(look.theme.map_ground);
        let mut board = LabelPlacer::new(f.buffer_mut(), area, &view, ground);
        let lights = write(&mut board, model, &moment, &scene, &view);
        if goals {
            bodies::labels(&mut board, model, moment.opened, &view);
        }
        if scene.contacts.is_empty() {
            bodies::seconds(&mut board, model, &moment, &view);
        }
        let posts = bodies::signs(&mut board, model, &scene, &view);
        bodies::Placed { lights, posts }
    }
}

/// The page of a map in an area, whose characters have so many samples across and down.
fn page(view: &CellView, area: Rect, samples: (usize, usize)) -> MapPage {
    let width = u32::from(area.width) * samples.0 as u32;
    let height = f64::from(width) * view.half.1 / view.half.0;
    MapPage {
        pixels: (width, height.round() as u32),
        line: samples.1 as f64,
        frame: view.frame,
        width: 2.0 * view.half.0,
    }
}

/// How the map is drawn in this terminal.
pub fn look(model: &Model) -> Appearance<'_> {
    let theme = &model.theme;
    let style = match model.look.map_style() {
        // A theme without colours for the road.
        MapStyle::Cells(_) if theme.map_road == theme.map_ground => MapStyle::Braille,
        style => style,
    };
    Appearance { style, theme }
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
    scene.underlays.extend(bodies::fan(model, moment));
    scene.overlays.extend(bodies::predictions(model, moment));
    scene.overlays.extend(bodies::overlays(model, moment));
    scene.top.extend(bodies::line(model, moment));
    if !scene.contacts.is_empty() {
        // The contact is to be seen: neither plans nor recorded paths lead across it.
        for overlays in [&mut scene.overlays, &mut scene.variation] {
            overlays.retain(|overlay| matches!(overlay, Overlay::Outline(_)));
        }
        for trail in &mut scene.trails {
            trail.future = &[];
        }
    }
    scene
}

/// Signs and words on top; what has to be where it is comes first. Says whether there are lights.
fn write(
    board: &mut LabelPlacer<'_>,
    model: &Model,
    moment: &Moment<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) -> bool {
    let look = &look(model);
    bodies::arrows(board, look, scene, view);
    bodies::contacts(board, look, scene, view);
    labels::reserve_bodies(board, scene, view);
    labels::avoid_ways(board, moment, scene, view);
    let lights = bodies::lights(board, model, scene, view);
    bodies::tape_ends(board, model, moment, view);
    labels::beyond(board, model, moment, view);
    labels::draw(board, model, moment, scene, view);
    bodies::label(board, model, moment, view);
    names(board, look, scene, view);
    bodies::ends(board, model, moment, view);
    lights
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

/// Of the only map, or of the first of two: `half` is its area.
fn first(model: &Model, half: Option<Rect>, inner: Rect) -> Line<'static> {
    let camera = &model.camera;
    let width = half.map_or(inner.width, |half| half.width);
    let size = half.map_or((inner.width, inner.height), |half| {
        (half.width, half.height.saturating_sub(1))
    });
    let cell = model
        .moment()
        .map_or(camera.cell, |now| model.camera_of(size, &now).cell);
    let across = format!("{:.0} m", cell * f64::from(width));
    let mode = match (camera.follow, camera.ego_up) {
        (true, true) => Some("follows ego"),
        (true, false) => Some("follows ego, north up"),
        (false, true) => None,
        (false, false) => Some("north up"),
    };
    let dim = Style::new().fg(model.theme.dim);
    let Some((half, now)) = half.zip(model.moment()) else {
        let mut title = why(model, &format!("map · {across}"), room(inner));
        let mode = mode.map_or(String::new(), |mode| format!(" · {mode}"));
        if title.width() + mode.width() <= room(inner) {
            title.push_span(Span::styled(mode, dim));
        }
        return title;
    };
    let mut title = second_title(&now, half);
    for words in [Some(across.as_str()), mode].into_iter().flatten() {
        let words = format!(" · {words}");
        if title.width() + words.width() <= room(half) {
            title.push_span(Span::styled(words, dim));
        }
    }
    title
}

/// The only map, with why which moment matters, and when it is where the clock is elsewhere: as much as there is room
/// for. The width of the map makes way for the reason, as the scale tells it, too.
fn why(model: &Model, map: &str, room: usize) -> Line<'static> {
    let headline = model.opened.as_deref().and_then(|opened| {
        let moment = opened.headline.as_ref()?.worst()?;
        Some((opened, moment))
    });
    let Some((opened, moment)) = headline else {
        return Line::from(map.to_string());
    };
    let is_now = moment.step == model.clock.step();
    let time = moment.step as f64 * opened.scenario.dt();
    let hazard = moment.hazard.to_string();
    let brief = hazard.split(';').next().unwrap_or_default();
    let [briefer, briefest] =
        [", ", " at constant"].map(|from| brief.split(from).next().unwrap_or_default());
    let briefest = if briefest == brief { briefer } else { briefest };
    let when = if is_now {
        String::new()
    } else {
        format!("{time:.1} s ")
    };
    let sign = match moment.grade {
        Grade::Contact => 'X',
        _ => '▼',
    };
    let obstacle = moment.obstacle;
    let color = if !is_now {
        model.theme.dim
    } else if moment.grade == Grade::Contact {
        model.theme.danger
    } else {
        model.theme.text
    };
    let who = format!(" · {sign} {when}{obstacle}");
    let all = [
        (map, format!("{who}: {hazard}")),
        (map, format!("{who}: {brief}")),
        ("map", format!("{who}: {brief}")),
        (map, format!("{who}: {briefest}")),
        ("map", format!("{who}: {briefest}")),
        (map, who),
    ];
    let fits = all
        .into_iter()
        .find(|(map, words)| map.width() + words.width() <= room);
    let (map, words) = fits.unwrap_or((map, String::new()));
    Line::from(vec![
        Span::raw(map.to_string()),
        Span::styled(words, Style::new().fg(color)),
    ])
}

/// Of the second map: its moment, in as many words as there is room for.
fn second_title(moment: &Moment<'_>, half: Rect) -> Line<'static> {
    let driven = moment.driven.map(|driven| moment.driven_words(driven));
    let title = std::iter::once(moment.title());
    let mut words = title.chain(driven.into_iter().flatten());
    let fits = words.find(|words| words.width() <= room(half));
    Line::from(fits.unwrap_or_else(|| moment.when()))
}

/// A title has a blank on both sides.
fn room(half: Rect) -> usize {
    usize::from(half.width).saturating_sub(2)
}

/// Names hollow bodies.
fn names(
    board: &mut LabelPlacer<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    for (name, outline) in scene.hollow() {
        let corners = outline.rings.iter().flatten().map(|p| view.at(p));
        if let Some(body) = Body::around(corners) {
            let cells = board.cells(&body);
            let style = Style::new().fg(look.color(outline.role));
            board.beside(&cells, &[name], style.add_modifier(Modifier::BOLD));
        }
    }
}

/// The part of the width that the scale may take.
const SHARE: f64 = 0.2;

/// Draws both into a row, and gives what is free between them. `cell` is how many metres a column is wide; without it
/// there is no scale.
fn draw_status(
    f: &mut Frame<'_>,
    row: Rect,
    model: &Model,
    moment: &Moment<'_>,
    cell: Option<f64>,
) -> Rect {
    let mut free = row;
    if let Some(bar) = cell.and_then(|cell| scale_bar(row, cell)) {
        let bar = format!(" {bar} ");
        let width = columns(&bar).min(row.width);
        f.render_widget(Span::styled(bar, Style::new().fg(model.theme.dim)), row);
        free.x += width;
        free.width -= width;
    }
    let words = picked_in_words(model, moment, usize::from(free.width).saturating_sub(2));
    if words.is_empty() {
        return free;
    }
    let words = format!(" {words} ");
    let width = columns(&words).min(free.width);
    free.width -= width;
    let at = Rect {
        x: free.right(),
        width,
        ..row
    };
    f.render_widget(Span::styled(words, Style::new().fg(model.theme.picked)), at);
    free
}

fn columns(words: &str) -> u16 {
    u16::try_from(words.width()).unwrap_or(u16::MAX)
}

fn scale_bar(area: Rect, cell: f64) -> Option<String> {
    let most = f64::from(area.width) * SHARE;
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
fn picked_in_words(model: &Model, moment: &Moment<'_>, room: usize) -> String {
    let Moment { opened, step, .. } = *moment;
    let picked = model.picked.and_then(|id| opened.scenario.obstacle(id));
    let Some(obstacle) = picked else {
        return String::new();
    };
    let value = |measure| {
        let series = opened.series.as_ref()?;
        series.at(measure, obstacle.id, step).value()
    };
    let distance = value("distance").map(hundredths);
    let speed = obstacle.track().at(step).map(|m| m.velocity);
    let alone = |words: String| [words, String::new()];
    // Each in more words, and in fewer if there are.
    let parts = [
        absent(obstacle, step, opened.scenario.dt()).map(|when| [when, "absent".into()]),
        distance.map(|d| [format!("{d} m away"), format!("{d} m")]),
        value("ttc").map(|t| alone(format!("TTC {} s", hundredths(t)))),
    ];
    let name = format!("{} {}", obstacle.kind.words(), obstacle.id);
    let mut text = name.clone();
    if text.width() > room {
        return String::new();
    }
    for part in parts.into_iter().flatten() {
        let left = room.saturating_sub(text.width() + 3);
        let fits = part.iter().find(|part| part.width() <= left);
        let Some(part) = fits.filter(|part| !part.is_empty()) else {
            break;
        };
        text.push_str(" · ");
        text.push_str(part);
    }
    if let Some(speed) = speed {
        let words = format!(" at {speed:.1} m/s");
        if text.width() + words.width() <= room {
            text.insert_str(name.len(), &words);
        }
    }
    text
}

/// Until or after when an obstacle is not there; `None` where it is there at a step.
fn absent(obstacle: &Obstacle, step: i64, dt: f64) -> Option<String> {
    if obstacle.placed_at(step).is_some() || obstacle.motion_at(step).is_some() {
        return None;
    }
    let steps = obstacle.track().steps();
    let time = |step: i64| step as f64 * dt;
    Some(if steps.is_empty() || steps.contains(&step) {
        "absent".into()
    } else if step < steps.start {
        format!("absent until {:.1} s", time(steps.start))
    } else {
        format!("absent after {:.1} s", time(steps.end - 1))
    })
}

/// How images are sent, where the map is to be one and nothing lies over it. What covers an image would leave marks at
/// terminals that paint it once; there, and below windows, the map is drawn in cells.
fn encoder(model: &Model) -> Option<&Encoder> {
    let chosen = matches!(model.look.map, MapChoice::Auto | MapChoice::Pixels);
    let encoder = model.map.images.encoder.as_ref()?;
    let covered = !model.screens.is_empty()
        || !model.look.pending.is_empty()
        || !encoder.can_be_covered() && !model.toasts.is_empty();
    (chosen && !covered && !model.drawn.is_for_picture()).then_some(encoder)
}

/// Draws the picture that the image is to show.
fn request_image(
    model: &Model,
    moment: &Moment<'_>,
    encoder: &Encoder,
    area: Rect,
    view: &CellView,
) {
    let (width, height) = encoder.cell();
    if model.map.layers.shown
        && let Some(picture) = for_models(model)
    {
        let pixels = (
            width * u32::from(area.width),
            height * u32::from(area.height),
        );
        let (picture, dpi) = filling(picture, pixels);
        model.drawn.set_picture(MapPicture {
            picture,
            dpi,
            cells: (area.width, area.height),
        });
        return;
    }
    let part = encoder.coarseness(model.clock.playing);
    let page = MapPage {
        pixels: (
            (width * u32::from(area.width)).div_ceil(part),
            (height * u32::from(area.height)).div_ceil(part),
        ),
        line: f64::from(height) / f64::from(part),
        frame: view.frame,
        width: 2.0 * view.half.0,
    };
    let request = scene_request(model, moment, page.viewport());
    let scene = with_layers(MapScene::new(&request), model, moment);
    let (palette, theme) = inks(model);
    let workbench = WorkbenchMap {
        theme: &theme,
        filled: true,
        markings: model.map.layers.lanes,
        hollow: false,
        cell: 0.0,
    };
    let picture = page.draw(&request, &scene, &palette, workbench);
    model.drawn.set_picture(MapPicture {
        picture,
        dpi: page.dpi(),
        cells: (area.width, area.height),
    });
}

/// The picture that models are shown with the present question, if its frame has one.
fn for_models(model: &Model) -> Option<Picture> {
    let question = model.prompt.question.as_ref()?;
    Some(question.picture.as_ref()?.picture())
}

/// A picture on a page of so many pixels, as large as it fits there, and its resolution.
fn filling(mut picture: Picture, (width, height): (u32, u32)) -> (Picture, f64) {
    let (width, height) = (f64::from(width), f64::from(height));
    let scale = (width / picture.size.0).min(height / picture.size.1);
    picture.size = (width / scale, height / scale);
    (picture, 72.0 * scale)
}

/// The image, where it fills the area.
fn shown(model: &Model, area: Rect) -> Option<&MapImage> {
    let shown = model.map.images.shown.as_ref();
    shown.filter(|image| image.fits(area))
}

/// The theme's colours; in place of those that only the terminal knows, those of pictures, and a gray.
fn inks(model: &Model) -> (Palette, Theme<Ink>) {
    let theme = model.theme.0.clone().map(|color| match components(color) {
        Some([red, green, blue]) => ThemeColor::Rgb(red, green, blue),
        None => ThemeColor::Terminal,
    });
    let palette = Palette::themed(&theme);
    let inks = theme.map(|color| match color {
        ThemeColor::Rgb(red, green, blue) => Ink::rgb(red, green, blue),
        _ => palette.dim,
    });
    (palette, inks)
}
