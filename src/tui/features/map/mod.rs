//! Map tools: layers, predicted paths, measuring tape, the second moment beside it, picked obstacles.

pub mod draw;
pub mod state;

use nearmiss_base::geometry::{Point, Pose};
use ratatui::Frame;
use ratatui::layout::{Margin, Position, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Text};
use ratatui::widgets::Paragraph;

use crate::action::{Action, Scope};
use crate::features::{Screen, Step, planner};
use crate::message::Effect;
use crate::model::{
    End, Foreseen, Foresight, Future, Layers, Model, Moment, On, Pane, PathRequest, Tape,
};
use crate::pixels::{ImageRequest, MapImage};
use crate::request::Computation;
use crate::update::{open, open_again};
use crate::widgets::hints::{self, Hint};
use crate::widgets::window;
use crate::widgets::words::pad;

/// Cells that a key moves the end of the tape.
const STRIDE: f64 = 2.0;

/// An end of the tape sticks to a body that is within this many cells.
const STICKS: f64 = 1.0;

/// Requests the predicted paths that are shown, if they changed.
pub fn request(model: &mut Model) -> Vec<PathRequest> {
    let whose = model.map.layers.paths;
    if whose == Foreseen::Off {
        model.map.foresight = Foresight::default();
        model.map.second.foresight = Foresight::default();
        return Vec::new();
    }
    let history = model.decided().history;
    let picked = model.picked;
    let of =
        |moment: Option<Moment<'_>>| moment.map_or((None, 0), |m| (m.opened.scene.clone(), m.step));
    let (now, then) = (of(model.moment()), of(model.second_moment()));
    let both = [
        (&mut model.map.foresight, now),
        (&mut model.map.second.foresight, then),
    ];
    let requests = both
        .map(|(foresight, (scene, step))| {
            foresight.request(scene.as_ref(), step, history, whose, picked)
        })
        .into_iter()
        .flatten();
    requests.collect()
}

/// Requests the image of the map as it was drawn last, where the terminal shows images.
pub fn image(model: &mut Model) -> Option<DrawMap> {
    let drawn = model.drawn.take_picture()?;
    let images = &mut model.map.images;
    let request = images.request(drawn.picture, drawn.dpi, drawn.cells)?;
    Some(DrawMap(Box::new(request)))
}

/// Cycles the shown paths: none, the picked obstacle's, those of all near the ego.
pub fn next_paths(model: &mut Model) {
    model.map.layers.paths = model.map.layers.paths.next();
    let words = match model.map.layers.paths {
        Foreseen::Off => "no predicted paths",
        _ if model.scene().is_none() => return model.say(model.without_ego()),
        Foreseen::Picked if model.picked.is_none() => {
            "predicted paths of the picked obstacle: pick one first"
        }
        Foreseen::Picked => "predicted paths of the picked obstacle",
        Foreseen::Near => "predicted paths of all near the ego",
    };
    model.say(words);
}

/// Takes the tape out, from the ego to the picked obstacle, or puts it away.
pub fn tape(model: &mut Model) {
    if model.map.tape.take().is_some() {
        return;
    }
    let step = model.clock.step();
    let Some(opened) = model.opened.as_deref() else {
        return model.say("no scenario is open");
    };
    let at = |on| End::on(opened, on, step);
    let ego = at(On::Ego);
    let picked = model.picked.and_then(|id| at(On::Obstacle(id)));
    let frame = model.camera.frame(ego_pose(model));
    let ahead = |end: End| End {
        point: end.point + frame.forward() * (STRIDE * 4.0 * model.camera.cell),
        on: None,
    };
    let middle = End {
        point: frame.position,
        on: None,
    };
    let (from, to) = match (ego, picked) {
        (Some(ego), Some(picked)) => (ego, picked),
        (Some(end), None) | (None, Some(end)) => (end, ahead(end)),
        (None, None) => (middle, ahead(middle)),
    };
    model.map.tape = Some(Tape { from, to });
    model.focus = Pane::Map;
    let keys = [
        Action::PanLeft,
        Action::PanDown,
        Action::PanUp,
        Action::PanRight,
    ]
    .map(|action| model.look.keymap.key_in(action, Scope::Map));
    model.say(format!(
        "{} or drag to measure, {} takes the other end, {} puts it away",
        keys.join(" "),
        model.look.key(Action::SwapTape),
        model.look.key(Action::TakeTape)
    ));
}

/// Moves the free end of the tape by a key; says whether there is a tape.
pub fn move_tape(model: &mut Model, action: Action) -> bool {
    let (right, up) = match action {
        Action::PanLeft => (-STRIDE, 0.0),
        Action::PanRight => (STRIDE, 0.0),
        Action::PanUp => (0.0, STRIDE / 2.0),
        Action::PanDown => (0.0, -STRIDE / 2.0),
        _ => return false,
    };
    let Some(tape) = model.map.tape else {
        return false;
    };
    let frame = model.camera.frame(ego_pose(model));
    let (cell, row) = (model.camera.cell, model.camera.row());
    let by = frame.forward() * (up * row) - frame.left() * (right * cell);
    let point = tape.to.point + by;
    let to = model.moment().map(|now| end_at(model, &now, point));
    model.map.tape = to.map(|to| Tape { to, ..tape });
    true
}

/// The other end is the free one from now on.
pub fn swap_tape(model: &mut Model) {
    match &mut model.map.tape {
        Some(tape) => std::mem::swap(&mut tape.from, &mut tape.to),
        None => {
            let key = model.look.key(Action::TakeTape);
            model.say(format!("{key} takes the tape out first"));
        }
    }
}

/// The free end of the tape goes to the obstacle that was picked.
pub fn picked(model: &mut Model) {
    let Some((tape, id)) = model.map.tape.zip(model.picked) else {
        return;
    };
    let opened = model.opened.as_deref();
    let to = opened.and_then(|o| End::on(o, On::Obstacle(id), model.clock.step()));
    if let Some(to) = to {
        model.map.tape = Some(Tape { to, ..tape });
    }
}

/// The mouse puts both ends of the tape at a point, or moves the free one there.
pub fn point_tape(model: &mut Model, at: Position, press: bool) {
    let Some((point, _)) = model.drawn.point_at(at) else {
        return;
    };
    let end = model
        .moment_at(at)
        .map(|moment| end_at(model, &moment, point));
    let Some((tape, end)) = model.map.tape.zip(end) else {
        return;
    };
    let from = if press { end } else { tape.from };
    model.map.tape = Some(Tape { from, to: end });
}

fn end_at(model: &Model, moment: &Moment<'_>, point: Point) -> End {
    let reach = STICKS * model.camera.cell;
    End::near(moment.opened, point, moment.step, reach)
}

/// Where the ego is now.
pub fn ego_pose(model: &Model) -> Option<Pose> {
    model.moment()?.ego()
}

/// Times that the map is moved at once at most: what is beyond is out of sight.
const MOST_MOVES: i64 = 200;

/// Moves the map, or the end of the tape.
pub fn move_map(model: &mut Model, action: Action) {
    let drawn = |pane| model.drawn.area(pane).is_some();
    if drawn(model.focus) && !drawn(Pane::Map) {
        let key = model.look.key(Action::NextPane);
        return model.say(format!("the map is hidden here; {key} leads to it"));
    }
    let again = matches!(
        action,
        Action::ZoomIn
            | Action::ZoomOut
            | Action::PanLeft
            | Action::PanRight
            | Action::PanUp
            | Action::PanDown
    );
    let times = if again { model.look.times() } else { 1 };
    for _ in 0..times.min(MOST_MOVES) {
        move_map_once(model, action);
    }
}

fn move_map_once(model: &mut Model, action: Action) {
    if move_tape(model, action) {
        return;
    }
    let ego = ego_pose(model);
    let size = model.drawn.map_size();
    let part = 6.0;
    match action {
        Action::ZoomIn => model.camera.zoom(0.8, size),
        Action::ZoomOut => model.camera.zoom(1.25, size),
        Action::PanLeft => model.camera.pan(-part, 0.0, ego),
        Action::PanRight => model.camera.pan(part, 0.0, ego),
        Action::PanUp => model.camera.pan(0.0, part / 2.0, ego),
        Action::PanDown => model.camera.pan(0.0, -part / 2.0, ego),
        Action::Follow => {
            let follow = !model.camera.follow;
            // Letting go keeps the view where it is.
            model.camera.stay(model.camera.frame(ego), Point::origin());
            model.camera.follow = follow;
            // Following again, the map chooses its zoom again.
            model.camera.auto = follow;
        }
        Action::EgoUp => model.camera.turn(ego),
        _ => {
            let bounds = model
                .opened
                .as_ref()
                .and_then(|o| o.scenario.network.bounds());
            if let Some(bounds) = bounds {
                model.camera.fit(&bounds, ego, size);
                model.camera.auto = false;
            }
        }
    }
}

impl Computation for PathRequest {
    type Value = (Self, Vec<Future>);

    fn compute(self) -> Self::Value {
        let futures = self.predict();
        (self, futures)
    }

    fn take(model: &mut Model, (request, futures): Self::Value) {
        let second = &mut model.map.second.foresight;
        second.take(&request, futures.clone());
        model.map.foresight.take(&request, futures);
    }
}

/// The map as an image.
#[derive(Debug)]
pub struct DrawMap(pub Box<ImageRequest>);

impl Computation for DrawMap {
    /// The image, or why there is none.
    type Value = Result<MapImage, String>;

    fn compute(self) -> Self::Value {
        self.0.run()
    }

    fn take(model: &mut Model, image: Self::Value) {
        if let Err(why) = model.map.images.take(image) {
            model.complain(format!("the map is drawn in cells: {why}"));
        }
    }
}

/// How much farther away the map is seen while there are two, so that both show as much as the one before.
const FARTHER: f64 = 2.0;

/// Does what an action about the second map says.
pub fn perform(model: &mut Model, action: Action) {
    if model.opened.is_none() {
        return model.say("no scenario is open");
    }
    match action {
        Action::SplitMap => split(model),
        Action::DriverMap => driver(model),
        Action::PinMoment => pin(model),
        Action::MomentBack => step(model, -model.look.times()),
        _ => step(model, model.look.times()),
    }
}

/// Shows the driver beside the ego, or what was there before.
fn driver(model: &mut Model) {
    let shown = model.map.second.on && model.map.second.driver;
    if !shown && let Some(why) = model.without_drivers() {
        return model.say(why);
    }
    if !shown && !model.is_encounter_here() {
        let key = model.look.key(Action::SwitchVariant);
        return model.say(format!("drivers drive in the variant: {key} shows it"));
    }
    model.map.second.driver = !shown;
    if !model.map.second.on {
        turn(model);
    }
    let key = model.look.key(Action::DriverMap);
    model.say(match (shown, model.drive_shown()) {
        (true, _) => format!("second map: {}", moment_words(model)),
        (false, Some(_)) => format!("second map: {}; {key} closes it", moment_words(model)),
        (false, None) => format!("second map: {}; {key} closes it", model.driver_shown().name),
    });
}

fn split(model: &mut Model) {
    turn(model);
    model.map.second.driver = false;
    if !model.map.second.on {
        return model.say("one map");
    }
    let opened = model.opened.as_deref();
    let saved = opened.and_then(|opened| opened.saved.as_deref());
    if let Some(Err(why)) = saved.map(|saved| &saved.original) {
        let why = why.clone();
        return model.say(why);
    }
    let keys = [Action::MomentBack, Action::MomentForward];
    let [back, forward] = keys.map(|action| model.look.key(action));
    let pin = model.look.key(Action::PinMoment);
    let words = moment_words(model);
    model.say(format!(
        "second map: {words}; {back} {forward} move it, {pin} pins it to this step"
    ));
}

/// Splits the map, or makes it whole again.
fn turn(model: &mut Model) {
    let fits = fits(model);
    let second = &mut model.map.second;
    second.on = !second.on;
    second.warned = false;
    // Where maps choose their zoom, each does so for itself.
    let widens = second.on && fits && !model.camera.auto;
    if std::mem::replace(&mut second.widened, widens) && !model.camera.auto {
        model.camera.scale(1.0 / FARTHER);
    }
    if widens {
        model.camera.scale(FARTHER);
    }
    if model.drawn.area(Pane::Map).is_none() {
        model.focus = Pane::Map;
    }
}

/// Whether the map has room for two, as it was drawn last.
fn fits(model: &Model) -> bool {
    let fits = |area: Rect| model.halves(area.inner(Margin::new(1, 1))).is_some();
    model.drawn.area(Pane::Map).is_none_or(fits)
}

/// The present step is pinned; where it is already, the second map goes back to the moment that follows from the scene.
fn pin(model: &mut Model) {
    let step = model.clock.step();
    if !model.map.second.on {
        turn(model);
    } else if model.map.second.pinned == Some(step) {
        model.map.second.pinned = None;
        let words = moment_words(model);
        return model.say(format!("second map: {words}"));
    }
    model.map.second.pinned = Some(step);
    let words = moment_words(model);
    let key = model.look.key(Action::PinMoment);
    model.say(format!("second map: {words}; {key} again frees it"));
}

fn step(model: &mut Model, by: i64) {
    let at = model
        .second_moment()
        .map(|then| (then.step, then.opened.steps()));
    let Some((step, steps)) = at else {
        let key = model.look.key(Action::SplitMap);
        return model.say(format!("{key} shows a second map first"));
    };
    let moved = step.saturating_add(by).min(steps.end - 1).max(steps.start);
    model.map.second.pinned = Some(moved);
}

fn moment_words(model: &Model) -> String {
    model
        .second_moment()
        .map_or(String::new(), |then| then.title())
}

/// A frame was drawn: where it had no room for the second map, that is said once.
pub fn drawn(model: &mut Model) {
    if !model.drawn.is_cramped() || std::mem::replace(&mut model.map.second.warned, true) {
        return;
    }
    let words = if model.zoomed && model.focus == Pane::Map {
        "the terminal is too small for two maps".into()
    } else {
        let key = model.look.key(Action::Zoom);
        format!("the pane is too small for two maps; {key} on the map gives it the whole screen")
    };
    model.say(words);
}

pub fn pick(model: &mut Model, by: isize) {
    let Some(opened) = &model.opened else { return };
    let order: Vec<i64> = if opened.ranking.is_empty() {
        opened.scenario.obstacles.iter().map(|o| o.id).collect()
    } else {
        opened.ranking.clone()
    };
    if order.is_empty() {
        return model.say("there are no obstacles");
    }
    let now = model
        .picked
        .and_then(|id| order.iter().position(|&o| o == id));
    let by = by.saturating_mul(isize::try_from(model.look.times()).unwrap_or(1));
    let next = match now {
        Some(place) => (place.cast_signed() + by)
            .rem_euclid(order.len().cast_signed())
            .unsigned_abs(),
        None => 0,
    };
    model.picked = Some(order[next]);
    picked(model);
    if model.frame.is_of_one_obstacle() {
        model.refresh();
    }
}

pub fn take_as_ego(model: &mut Model) -> Vec<Effect> {
    match model.picked {
        Some(id) => reopen(model, Some(id)),
        None if model.opened.is_none() => {
            model.say("no scenario is open");
            Vec::new()
        }
        None => {
            let key = model.look.key(Action::NextObstacle);
            model.say(format!("pick an obstacle first, with {key} or the mouse"));
            Vec::new()
        }
    }
}

pub fn recorded_ego(model: &mut Model) -> Vec<Effect> {
    if model.taken.is_some() || model.opening.is_some() || model.planned().is_some() {
        planner::take_back(model);
        return reopen(model, None);
    }
    let changed = model.opened.as_ref().is_some_and(|o| o.change.is_some());
    if let Some(place) = model.list.opened.filter(|_| changed) {
        return open(model, place, None);
    }
    model.say("no obstacle is the ego");
    Vec::new()
}

fn reopen(model: &mut Model, ego: Option<i64>) -> Vec<Effect> {
    match model.list.opened {
        Some(place) => open_again(model, place, ego),
        None => Vec::new(),
    }
}

/// Columns of the window, its borders included.
const COLUMNS: u16 = 46;

/// The layers of the map.
#[derive(Debug, Default)]
pub struct LayersScreen {
    selected: usize,
}

impl Screen for LayersScreen {
    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        match action {
            Action::Up => self.selected = self.selected.saturating_sub(1),
            Action::Down => self.selected = (self.selected + 1).min(Layers::COUNT - 1),
            Action::Accept => model.map.layers.switch(self.selected),
            _ => return Step::Ignored,
        }
        Step::stay()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let width = COLUMNS.min(screen.width);
        let height = (Layers::COUNT as u16 + 2).min(screen.height);
        let area = Rect {
            x: screen.right() - width,
            y: screen.y + 1.min(screen.height - height),
            width,
            height,
        };
        let inner = window::window_at(frame, area, model, "layers of the map");
        let columns = usize::from(inner.width);
        let layers = model.map.layers.rows();
        let rows = layers.iter().enumerate().map(|(row, (name, state))| {
            let style = if row == self.selected {
                model.theme.selected()
            } else {
                Style::new()
            };
            // A sign says it without words, too.
            let sign = if *state == "off" { "[ ]" } else { "[x]" };
            let more = if matches!(*state, "on" | "off") {
                String::new()
            } else {
                format!(": {state}")
            };
            Line::styled(pad(&format!("{sign} {name}{more}"), columns), style)
        });
        frame.render_widget(Paragraph::new(Text::from_iter(rows)), inner);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let keys = [Action::Up, Action::Down];
        let select = hints::pair(model, Scope::Window, keys, "select");
        let accept = (model.look.key(Action::Accept), "switch".to_string());
        vec![select, accept, hints::close(model)]
    }
}
