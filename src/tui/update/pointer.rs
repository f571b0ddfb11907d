//! The mouse: the wheel scrolls under the pointer, a click focuses and selects.

use ratatui::layout::{Position, Rect};

use super::super::action::Action;
use super::super::message::{Effect, Mouse};
use super::super::model::{Model, Notice, On, Pane};
use super::{actions, open_current, panes, screens};
use crate::features::{compare, map, scenarios, timeline};

/// The mouse did something.
pub fn on_mouse(model: &mut Model, mouse: Mouse) -> Vec<Effect> {
    if !model.screens.is_empty() {
        return screens::on_mouse(model, mouse);
    }
    if model.compare.open {
        return on_compare(model, mouse);
    }
    if model.prompt.editing && crate::features::prompt::on_mouse(model, mouse) {
        return Vec::new();
    }
    let at = match mouse {
        Mouse::Press(at)
        | Mouse::Drag(at)
        | Mouse::Release(at)
        | Mouse::WheelUp(at)
        | Mouse::WheelDown(at) => at,
    };
    if let Some((from, moved)) = model.map.held
        && matches!(mouse, Mouse::Drag(_) | Mouse::Release(_))
    {
        hold(model, from, moved, mouse, at);
        return Vec::new();
    }
    if panes::on_mouse(model, mouse, at) {
        return Vec::new();
    }
    let Some((pane, area)) = model.drawn.pane_at(at) else {
        return Vec::new();
    };
    if matches!(mouse, Mouse::Press(_)) {
        model.look.pending.clear();
        model.look.count = None;
        model.toasts.retain(|t| t.kind != Notice::Reply);
    }
    match mouse {
        Mouse::WheelUp(_) => wheel(model, pane, at, Action::Up),
        Mouse::WheelDown(_) => wheel(model, pane, at, Action::Down),
        Mouse::Press(_) => press(model, pane, area, at),
        Mouse::Drag(_) => match pane {
            Pane::Timeline | Pane::Plot => seek(model, area, at),
            _ => Vec::new(),
        },
        Mouse::Release(_) => Vec::new(),
    }
}

/// The map is in hand: dragging moves it, or measures; letting go where it was taken picks.
fn hold(model: &mut Model, from: Position, moved: bool, mouse: Mouse, at: Position) {
    if matches!(mouse, Mouse::Release(_)) {
        model.map.held = None;
        if !moved && model.map.tape.is_none() {
            pick(model, at);
        }
    } else if model.map.tape.is_some() {
        map::point_tape(model, at, false);
        model.map.held = Some((at, true));
    } else if at != from {
        let by = |from: u16, to: u16| f64::from(from) - f64::from(to);
        let (right, up) = (by(from.x, at.x), by(at.y, from.y));
        let ego = model.moment_at(from).and_then(|moment| moment.ego());
        model.camera.pan(right, up, ego);
        model.map.held = Some((at, true));
    }
}

/// The wheel scrolls the answers side by side, over the map too: it follows the picked claim.
fn on_compare(model: &mut Model, mouse: Mouse) -> Vec<Effect> {
    let action = match mouse {
        Mouse::WheelUp(_) => Action::Up,
        Mouse::WheelDown(_) => Action::Down,
        Mouse::Press(_) | Mouse::Drag(_) | Mouse::Release(_) => return Vec::new(),
    };
    compare::perform(model, action)
}

fn wheel(model: &mut Model, pane: Pane, at: Position, direction: Action) -> Vec<Effect> {
    match pane {
        Pane::Map => {
            let factor = if direction == Action::Up {
                0.85
            } else {
                1.0 / 0.85
            };
            // The point under the pointer stays where it is.
            let ego = model.moment_at(at).and_then(|moment| moment.ego());
            let size = model.drawn.map_size();
            match model.drawn.point_at(at) {
                Some((point, _)) => model.camera.zoom_about(&point, factor, ego, size),
                None => model.camera.zoom(factor),
            }
            Vec::new()
        }
        Pane::Scenarios => {
            model
                .list
                .move_by(if direction == Action::Up { -1 } else { 1 });
            open_current(model)
        }
        Pane::Timeline | Pane::Plot => {
            let back = direction == Action::Up;
            actions::perform(
                model,
                if back {
                    Action::StepBack
                } else {
                    Action::StepForward
                },
            )
        }
        _ => {
            for _ in 0..3 {
                actions::scroll(model, pane, direction);
            }
            Vec::new()
        }
    }
}

fn press(model: &mut Model, pane: Pane, area: Rect, at: Position) -> Vec<Effect> {
    if pane != Pane::Timeline {
        model.focus = pane;
    }
    match pane {
        Pane::Scenarios => {
            let line = model.drawn.list_line(at);
            if let Some(line) = line.filter(|&line| line < model.list.lines.len()) {
                model.list.selected = line;
                return scenarios::choose(model);
            }
            Vec::new()
        }
        Pane::Map => {
            model.map.held = Some((at, false));
            map::point_tape(model, at, true);
            Vec::new()
        }
        Pane::Timeline | Pane::Plot => seek(model, area, at),
        _ => Vec::new(),
    }
}

/// Goes to the step under the pointer; the border is not part of the scale.
fn seek(model: &mut Model, area: Rect, at: Position) -> Vec<Effect> {
    let (first, last) = model.clock.range();
    let (from, width) = model.drawn.scale(area);
    let part = f64::from(at.x.saturating_sub(from)) / f64::from(width.saturating_sub(1).max(1));
    let step = first as f64 + part.clamp(0.0, 1.0) * (last - first) as f64;
    model.clock.playing = false;
    model.clock.go(step.round() as i64);
    timeline::stepped(model);
    Vec::new()
}

/// Picks the obstacle under the pointer, or the nearest within two cells.
fn pick(model: &mut Model, at: Position) {
    let Some((point, cell)) = model.drawn.point_at(at) else {
        return;
    };
    let Some(moment) = model.moment_at(at) else {
        return;
    };
    let nearest = moment.opened.nearest_body(&point, moment.step, false);
    let within = nearest.filter(|(_, d)| *d < REACH * cell);
    model.picked = within.and_then(|(on, _)| match on {
        On::Obstacle(id) => Some(id),
        On::Ego => None,
    });
}

/// Cells that a click may be beside a body.
const REACH: f64 = 2.0;
