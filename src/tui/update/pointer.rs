//! The mouse: the wheel acts under the pointer, a click focuses and selects.

use ratatui::layout::{Position, Rect};

use super::super::action::Action;
use super::super::message::{Effect, Mouse};
use super::super::model::{Model, Notice, Overlay, Pane};
use super::{actions, clock, compare, open_current};

/// The mouse did something.
pub fn on_mouse(model: &mut Model, mouse: Mouse) -> Vec<Effect> {
    if !model.overlays.is_empty() {
        return on_overlay(model, mouse);
    }
    if model.compare.open {
        return on_compare(model, mouse);
    }
    let at = match mouse {
        Mouse::Press(at) | Mouse::Drag(at) | Mouse::WheelUp(at) | Mouse::WheelDown(at) => at,
    };
    let Some((pane, area)) = model.drawn.pane_at(at) else {
        return Vec::new();
    };
    if matches!(mouse, Mouse::Press(_)) {
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
    }
}

/// The wheel scrolls the answers side by side, over the map too: it follows the picked claim.
fn on_compare(model: &mut Model, mouse: Mouse) -> Vec<Effect> {
    let action = match mouse {
        Mouse::WheelUp(_) => Action::Up,
        Mouse::WheelDown(_) => Action::Down,
        Mouse::Press(_) | Mouse::Drag(_) => return Vec::new(),
    };
    compare::perform(model, action)
}

fn on_overlay(model: &mut Model, mouse: Mouse) -> Vec<Effect> {
    if let Some(scroll) = model.overlays.last_mut().and_then(Overlay::scroll_mut) {
        match mouse {
            Mouse::WheelUp(_) => *scroll = scroll.saturating_sub(3),
            Mouse::WheelDown(_) => *scroll += 3,
            _ => {}
        }
    }
    Vec::new()
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
            if let (false, Some((point, _))) = (model.camera.follow, model.drawn.point_at(at)) {
                let before = model.camera.cell;
                model.camera.zoom(factor);
                let kept = model.camera.cell / before;
                model.camera.center = point + (model.camera.center - point) * kept;
            } else {
                model.camera.zoom(factor);
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
            let extent = model.drawn.extent(Pane::Scenarios);
            let line = usize::from(at.y.saturating_sub(area.y + 1)) + extent.top;
            if at.y > area.y && line < model.list.visible.len() {
                model.list.selected = line;
                return open_current(model);
            }
            Vec::new()
        }
        Pane::Map => {
            pick(model, at);
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
    clock::stepped(model);
    Vec::new()
}

/// Picks the obstacle under the pointer, or the nearest within two cells.
fn pick(model: &mut Model, at: Position) {
    let Some((point, cell)) = model.drawn.point_at(at) else {
        return;
    };
    let Some(opened) = &model.opened else { return };
    let step = model.clock.step();
    let distances = opened.scenario.obstacles.iter().filter_map(|o| {
        let track = o.track();
        let motion = track.at(step).or_else(|| {
            let stands = o.role == crate::scenario::ObstacleRole::Static;
            track.iter().next().map(|(_, m)| m).filter(|_| stands)
        })?;
        let reach = o.footprint.as_ref().map_or(0.0, |f| f.reach());
        Some((o.id, (motion.pose.position - point).norm() - reach))
    });
    let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1));
    model.picked = nearest.filter(|(_, d)| *d < 2.0 * cell).map(|(id, _)| id);
}
