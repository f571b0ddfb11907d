//! Where the panes are, for every size of the terminal.

use ratatui::layout::{Constraint, Layout, Rect};

use super::model::{Model, Pane};

/// The smallest terminal that the workbench fits into.
pub const SMALLEST: (u16, u16) = (80, 24);

/// The parts of the screen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parts {
    /// The line at the top.
    pub header: Rect,
    /// The panes that are shown.
    pub panes: Vec<(Pane, Rect)>,
    /// The line at the bottom.
    pub footer: Rect,
}

/// Splits the screen; nothing where it is too small.
#[must_use]
pub fn split(screen: Rect, model: &Model) -> Option<Parts> {
    if screen.width < SMALLEST.0 || screen.height < SMALLEST.1 {
        return None;
    }
    let [header, body, footer] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Min(0),
        Constraint::Length(1),
    ])
    .areas(screen);
    let panes = if model.prompt.editing {
        vec![(Pane::Prompt, body)]
    } else if model.zoomed {
        alone(body, model.focus)
    } else if screen.width >= 110 && screen.height >= 32 {
        wide(body, model.list.longest)
    } else {
        compact(body, model.focus)
    };
    Some(Parts {
        header,
        panes,
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

/// Columns of a list that shows names of this length, up to a limit: its border, the sign before a name, and what
/// answers say and the risk behind it.
fn named(longest: usize) -> u16 {
    u16::try_from(longest + 9).unwrap_or(u16::MAX).clamp(24, 34)
}

/// Everything at once.
fn wide(body: Rect, longest: usize) -> Vec<(Pane, Rect)> {
    let right = (body.width * 36 / 100).clamp(44, 84);
    // Where there is room, the list shows more than names.
    let list = match body.width {
        ..160 => (body.width * 17 / 100).max(named(longest)),
        wide => (wide * 21 / 100).min(48),
    };
    let prompt = (body.height * 26 / 100).clamp(8, 18);
    let timeline = if body.height >= 45 { 8 } else { 6 };
    let [left, right] =
        Layout::horizontal([Constraint::Min(0), Constraint::Length(right)]).areas(body);
    let [upper, prompt] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(prompt)]).areas(left);
    let [list, middle] =
        Layout::horizontal([Constraint::Length(list), Constraint::Min(0)]).areas(upper);
    let [map, timeline] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(timeline)]).areas(middle);
    let risk = (body.height / 4).clamp(8, 14);
    let verdict = if body.height >= 45 { 17 } else { 14 };
    let [verdict, reasoning, risk] = Layout::vertical([
        Constraint::Length(verdict),
        Constraint::Min(0),
        Constraint::Length(risk),
    ])
    .areas(right);
    vec![
        (Pane::Scenarios, list),
        (Pane::Map, map),
        (Pane::Timeline, timeline),
        (Pane::Prompt, prompt),
        (Pane::Verdict, verdict),
        (Pane::Reasoning, reasoning),
        (Pane::Plot, risk),
    ]
}

/// Two columns: what is looked at on the left (list, map or prompt), what is said about it on the right.
fn compact(body: Rect, focus: Pane) -> Vec<(Pane, Rect)> {
    let [left, right] =
        Layout::horizontal([Constraint::Percentage(54), Constraint::Percentage(46)]).areas(body);
    let [upper, timeline] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(5)]).areas(left);
    let shown = match focus {
        Pane::Scenarios | Pane::Prompt => focus,
        _ => Pane::Map,
    };
    let mut panes = Vec::new();
    if shown == Pane::Scenarios {
        // The map stays in sight while one looks through the list.
        let [list, map] =
            Layout::vertical([Constraint::Percentage(42), Constraint::Min(0)]).areas(upper);
        panes.extend([(Pane::Scenarios, list), (Pane::Map, map)]);
    } else {
        panes.push((shown, upper));
    }
    let [verdict, reasoning, risk] = Layout::vertical([
        Constraint::Length(9),
        Constraint::Min(0),
        Constraint::Length(7),
    ])
    .areas(right);
    panes.extend([
        (Pane::Timeline, timeline),
        (Pane::Verdict, verdict),
        (Pane::Reasoning, reasoning),
        (Pane::Plot, risk),
    ]);
    panes
}
