//! Map tools: layers, predicted paths, measuring tape, obstacle details.

use ratatui::layout::Position;

use super::super::action::{Action, Scope};
use super::super::model::{
    End, Foreseen, Foresight, Future, Model, Moment, On, Pane, PathRequest, Tape,
};
use crate::pixels::{ImageRequest, MapImage};
use crate::request::Computation;
use nearmiss_base::geometry::{Point, Pose, Vector};

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
        "{} or dragging measures, {} takes the other end, {} puts it away",
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
    let part = 6.0;
    match action {
        Action::ZoomIn => model.camera.zoom(0.8),
        Action::ZoomOut => model.camera.zoom(1.25),
        Action::PanLeft => model.camera.pan(-part, 0.0, ego),
        Action::PanRight => model.camera.pan(part, 0.0, ego),
        Action::PanUp => model.camera.pan(0.0, part / 2.0, ego),
        Action::PanDown => model.camera.pan(0.0, -part / 2.0, ego),
        Action::Follow => {
            // Letting go keeps the view where it is.
            model.camera.center = model.camera.frame(ego).position;
            model.camera.follow = !model.camera.follow;
            model.camera.shift = Vector::zeros();
            // Following again, the map chooses its zoom again.
            model.camera.auto = model.camera.follow;
        }
        Action::EgoUp => model.camera.ego_up = !model.camera.ego_up,
        _ => {
            let bounds = model
                .opened
                .as_ref()
                .and_then(|o| o.scenario.network.bounds());
            if let Some(bounds) = bounds {
                let size = model.drawn.map_size();
                model.camera.fit(&bounds, size);
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
