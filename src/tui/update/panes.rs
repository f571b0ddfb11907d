//! Pane sizes and focus.

use ratatui::layout::{Position, Rect};

use super::super::action::Action;
use super::super::message::Mouse;
use super::super::model::{Border, Model, Pane};

/// Columns and rows that a key moves a border by.
const COLUMNS: i32 = 4;
const ROWS: i32 = 2;

/// Moves a border of the pane that has the keys: the one on its right or below, else the other one.
pub fn resize(model: &mut Model, action: Action) {
    let upright = matches!(action, Action::WidenPane | Action::NarrowPane);
    let grows = matches!(action, Action::WidenPane | Action::TallerPane);
    let by = if upright { COLUMNS } else { ROWS };
    let found = area(model, model.focus).and_then(|area| border(model, area, upright));
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
pub fn on_mouse(model: &mut Model, mouse: Mouse, at: Position) -> bool {
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
