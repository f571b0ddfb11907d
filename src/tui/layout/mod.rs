//! Pane layout for every terminal size. Where there is no room for all panes, the least important ones are left out;
//! the pane that has the keys is always there.

mod arranged;
mod beside_panel;

use ratatui::layout::{Constraint, Layout, Rect};

use self::arranged::Arranged;
use super::model::{Border, Model, Pane};

/// The smallest terminal that the workbench fits into.
pub const SMALLEST: (u16, u16) = (60, 18);

/// Columns from which on two panes stand side by side.
const TWO_COLUMNS: u16 = 80;
/// Columns from which on the list has a column of its own.
const THREE_COLUMNS: u16 = 110;
/// Rows from which on the prompt is shown with everything else.
const TALL: u16 = 32;

/// The parts of the screen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScreenAreas {
    /// The line at the top.
    pub header: Rect,
    /// The panes that are shown.
    pub panes: Vec<(Pane, Rect)>,
    /// The borders between them that can be moved.
    pub borders: Vec<Border>,
    /// The line at the bottom.
    pub footer: Rect,
}

/// Splits the screen; `None` if it is too small.
#[must_use]
pub fn split(screen: Rect, model: &Model) -> Option<ScreenAreas> {
    if screen.width < SMALLEST.0 || screen.height < SMALLEST.1 {
        return None;
    }
    let [header, body, footer] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Min(0),
        Constraint::Length(1),
    ])
    .areas(screen);
    let mut arranged = Arranged::default();
    if model.prompt.editing {
        arranged.panes.push((Pane::Prompt, body));
    } else if model.zoomed {
        arranged.panes = alone(body, model.focus);
    } else {
        let sizes = &model.look.sizes;
        match (screen.width, screen.height) {
            (THREE_COLUMNS.., TALL..) => arranged.wide(body, sizes.wide, model.list.longest),
            (THREE_COLUMNS.., _) => {
                arranged.low(body, sizes.wide, model.list.longest, model.focus);
            }
            (TWO_COLUMNS.., _) => arranged.compact(body, sizes.compact, model.focus),
            _ => arranged.narrow(body, sizes.narrow, model.focus),
        }
    }
    let at_right = model
        .screens
        .iter()
        .filter_map(|s| s.columns_at_right(screen));
    if let Some(columns) = at_right.max() {
        arranged.end_at(screen.right().saturating_sub(columns));
    }
    Some(ScreenAreas {
        header,
        panes: arranged.panes,
        borders: arranged.borders,
        footer,
    })
}

fn alone(body: Rect, pane: Pane) -> Vec<(Pane, Rect)> {
    if pane == Pane::Map {
        let [map, timeline] =
            Layout::vertical([Constraint::Min(0), Constraint::Length(8)]).areas(body);
        return vec![(Pane::Map, map), (Pane::Timeline, timeline)];
    }
    vec![(pane, body)]
}
