//! The mouse, and which pane has the keys and the room.

use ratatui::layout::{Position, Rect};

use crate::action::Action;
use crate::features::{compare, map, scenarios, timeline};
use crate::message::{Effect, Mouse};
use crate::model::{Border, Model, Notice, On, Pane};
use crate::update::{actions, keys, open_current};

/// The mouse did something.
pub fn on_mouse(model: &mut Model, mouse: Mouse) -> Vec<Effect> {
    if !model.screens.is_empty() {
        return keys::on_mouse(model, mouse);
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
    if on_border(model, mouse, at) {
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
                None => model.camera.zoom(factor, size),
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
                super::keys::scroll(model, pane, direction);
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

/// Columns and rows that a key moves a border by.
const COLUMNS: i32 = 4;
const ROWS: i32 = 2;

/// Moves a border of the pane that has the keys: the one on its right or below, else the other one.
pub fn resize(model: &mut Model, action: Action) {
    let upright = matches!(action, Action::WidenPane | Action::NarrowPane);
    let grows = matches!(action, Action::WidenPane | Action::TallerPane);
    let by = if upright { COLUMNS } else { ROWS };
    let alone = model.drawn.area(model.focus);
    let mut areas = area(model, model.focus).into_iter().chain(alone);
    let found = areas.find_map(|area| border(model, area, upright));
    let Some((border, on_far_side)) = found else {
        let side = if upright { "beside" } else { "above or below" };
        return model.say(format!("no pane {side} to take room from"));
    };
    // Pushed away from the pane, a border makes it bigger: the one before it the other way around.
    let by = if grows == on_far_side { by } else { -by };
    let cells = border.moved(if border.before { by } else { -by });
    if cells == border.size {
        let more = if grows { "grow" } else { "shrink" };
        return model.say(format!("this pane cannot {more} further"));
    }
    model.look.sizes.set(&border, cells);
}

/// Where a pane is; the map with its timeline, which makes room for it only where nothing else does.
fn area(model: &Model, pane: Pane) -> Option<Rect> {
    let area = model.drawn.area(pane)?;
    let timeline = model.drawn.area(Pane::Timeline);
    let whole = timeline.filter(|t| pane == Pane::Map && t.x == area.x && t.width == area.width);
    Some(whole.map_or(area, |timeline| area.union(timeline)))
}

/// The border of an area that can be moved, and whether it is the one on the right or below.
fn border(model: &Model, area: Rect, upright: bool) -> Option<(Border, bool)> {
    let borders = model.drawn.borders();
    let at = |edge: u16| {
        let touches = move |b: &&Border| {
            let place = if b.upright { b.strip.x } else { b.strip.y };
            b.upright == upright && place + 1 == edge && b.strip.intersects(area)
        };
        borders.iter().find(touches).copied()
    };
    let (near, far) = if upright {
        (area.x, area.right())
    } else {
        (area.y, area.bottom())
    };
    let alone = || {
        let map = model.drawn.area(Pane::Map)?;
        (!upright && map.x == area.x).then(|| at(map.bottom()))?
    };
    let far = at(far).map(|b| (b, true));
    far.or_else(|| Some((at(near)?, false)))
        .or_else(|| Some((alone()?, true)))
}

/// All panes have their usual sizes again.
pub fn reset(model: &mut Model) {
    model.look.sizes = Default::default();
    model.say("pane sizes reset");
}

/// Goes to the pane in a direction. Panes that are not on the screen have their place all the same.
pub fn go(model: &mut Model, action: Action) {
    use Action::{FocusDown as Down, FocusLeft as Left, FocusRight as Right, FocusUp as Up};
    use Pane::{Map, Plot, Prompt, Reasoning, Scenarios, Verdict};
    model.focus = match (model.focus, action) {
        (Scenarios, Right) | (Prompt, Up) => Map,
        (Scenarios | Map, Down) | (Plot, Left) => Prompt,
        (Map, Left) => Scenarios,
        (Verdict | Reasoning, Left) => Map,
        (Map, Right) | (Reasoning, Up) => Verdict,
        (Verdict, Down) | (Plot, Up) => Reasoning,
        (Reasoning, Down) | (Prompt, Right) => Plot,
        (Pane::Timeline, _) => Map,
        (pane, _) => pane,
    };
}

/// The mouse takes, moves or lets go of a border; says whether it was one.
pub fn on_border(model: &mut Model, mouse: Mouse, at: Position) -> bool {
    match (mouse, model.look.held) {
        (Mouse::Press(_), _) => {
            let borders = model.drawn.borders();
            let taken = borders.into_iter().find(|b| b.strip.contains(at));
            model.look.held = taken.map(|border| (border, at));
            taken.is_some()
        }
        (Mouse::Drag(_), Some((border, from))) => {
            let cells = border.dragged(from, at);
            model.look.sizes.set(&border, cells);
            true
        }
        (Mouse::Release(_), Some((_, from))) => {
            model.look.held = None;
            if let Some((pane, _)) = model.drawn.pane_at(at)
                && pane != Pane::Timeline
                && at == from
            {
                // A click on a title is one on its pane. While a border is dragged, all panes stay where they are.
                model.focus = pane;
            }
            true
        }
        _ => false,
    }
}
