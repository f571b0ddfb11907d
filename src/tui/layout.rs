//! Pane layout for every terminal size.

use ratatui::layout::{Constraint, Layout, Rect};

use super::model::{Border, Edge, Model, Pane, PaneShares};

/// The smallest terminal that the workbench fits into.
pub const SMALLEST: (u16, u16) = (80, 24);

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
    } else if screen.width >= 110 && screen.height >= 32 {
        arranged.wide(body, model.look.sizes.wide, model.list.longest);
    } else {
        arranged.compact(body, model.look.sizes.compact, model.focus);
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

/// Fewest columns of a pane.
const NARROWEST: u16 = 18;
/// Fewest columns of the map, and of the column on the right.
const NARROW: u16 = 30;
/// Fewest rows of a pane: its frame and two lines.
const LOWEST: u16 = 4;
/// Fewest rows of what needs more to be understood: map and plot.
const LOW: u16 = 6;

/// Where panes are, and the borders between them.
#[derive(Default)]
struct Arranged {
    panes: Vec<(Pane, Rect)>,
    borders: Vec<Border>,
}

/// Columns of a list that shows names of this length, up to a limit: its border, the sign before a name, and what
/// answers say and the risk behind it.
fn named(longest: usize) -> u16 {
    u16::try_from(longest + 9).unwrap_or(u16::MAX).clamp(24, 34)
}

/// A cut across an area: which border it is, how far its pane usually goes, and how far it may.
struct Cut {
    edge: Edge,
    /// Whether it goes from top to bottom.
    upright: bool,
    /// Whether its pane lies before it.
    before: bool,
    usual: u16,
    limits: (u16, u16),
}

impl Arranged {
    /// Cuts an area in two, with a border between them; `whole` is the area that shares are parts of.
    fn cut(
        &mut self,
        area: Rect,
        whole: Rect,
        shares: PaneShares,
        wide: bool,
        cut: Cut,
    ) -> [Rect; 2] {
        let total = if cut.upright {
            whole.width
        } else {
            whole.height
        };
        let size = shares.cells(cut.edge, total, cut.usual, cut.limits);
        let constraints = match cut.before {
            true => [Constraint::Length(size), Constraint::Min(0)],
            false => [Constraint::Min(0), Constraint::Length(size)],
        };
        let layout = match cut.upright {
            true => Layout::horizontal(constraints),
            false => Layout::vertical(constraints),
        };
        let [first, second] = layout.areas(area);
        let strip = match cut.upright {
            true => Rect {
                x: second.x.saturating_sub(1),
                width: 2,
                ..area
            },
            false => Rect {
                y: second.y.saturating_sub(1),
                height: 2,
                ..area
            },
        };
        self.borders.push(Border {
            edge: cut.edge,
            wide,
            strip,
            upright: cut.upright,
            before: cut.before,
            size,
            limits: cut.limits,
            total,
        });
        [first, second]
    }

    /// Everything at once.
    fn wide(&mut self, body: Rect, shares: PaneShares, longest: usize) {
        // Where there is room, the list shows more than names.
        let list = match body.width {
            ..160 => (body.width * 17 / 100).max(named(longest)),
            wide => (wide * 21 / 100).min(48),
        };
        let [left, right] = self.cut(
            body,
            body,
            shares,
            true,
            Cut {
                edge: Edge::Right,
                upright: true,
                before: false,
                usual: (body.width * 36 / 100).clamp(44, 84),
                limits: (NARROW, body.width.saturating_sub(NARROWEST + NARROW)),
            },
        );
        let [upper, prompt] = self.cut(
            left,
            body,
            shares,
            true,
            Cut {
                edge: Edge::Prompt,
                upright: false,
                before: false,
                usual: (body.height * 26 / 100).clamp(8, 18),
                limits: (LOWEST, body.height.saturating_sub(LOW + LOWEST)),
            },
        );
        let [list, middle] = self.cut(
            upper,
            body,
            shares,
            true,
            Cut {
                edge: Edge::List,
                upright: true,
                before: true,
                usual: list,
                limits: (NARROWEST, left.width.saturating_sub(NARROW)),
            },
        );
        let [map, timeline] = self.cut(
            middle,
            body,
            shares,
            true,
            Cut {
                edge: Edge::Timeline,
                upright: false,
                before: false,
                usual: if body.height >= 45 { 8 } else { 6 },
                limits: (LOWEST, upper.height.saturating_sub(LOW)),
            },
        );
        self.panes.extend([
            (Pane::Scenarios, list),
            (Pane::Map, map),
            (Pane::Timeline, timeline),
            (Pane::Prompt, prompt),
        ]);
        let verdict = if body.height >= 45 { 17 } else { 14 };
        let risk = (body.height / 4).clamp(8, 14);
        self.answers(right, body, shares, true, (verdict, risk));
    }

    /// Two columns: the subject on the left (list, map or prompt), statements about it on the right.
    fn compact(&mut self, body: Rect, shares: PaneShares, focus: Pane) {
        let [left, right] = self.cut(
            body,
            body,
            shares,
            false,
            Cut {
                edge: Edge::Right,
                upright: true,
                before: false,
                usual: (body.width * 46 + 50) / 100,
                limits: (NARROW, body.width.saturating_sub(NARROW)),
            },
        );
        let [upper, timeline] = self.cut(
            left,
            body,
            shares,
            false,
            Cut {
                edge: Edge::Timeline,
                upright: false,
                before: false,
                usual: 5,
                limits: (LOWEST, body.height.saturating_sub(LOWEST + LOW)),
            },
        );
        let shown = match focus {
            Pane::Scenarios | Pane::Prompt => focus,
            _ => Pane::Map,
        };
        if shown == Pane::Scenarios {
            // The map stays in sight while one looks through the list.
            let [list, map] = self.cut(
                upper,
                body,
                shares,
                false,
                Cut {
                    edge: Edge::List,
                    upright: false,
                    before: true,
                    usual: (f64::from(upper.height) * 0.42).round() as u16,
                    limits: (LOWEST, upper.height.saturating_sub(LOW)),
                },
            );
            self.panes
                .extend([(Pane::Scenarios, list), (Pane::Map, map)]);
        } else {
            self.panes.push((shown, upper));
        }
        self.panes.push((Pane::Timeline, timeline));
        self.answers(right, body, shares, false, (9, 7));
    }

    /// The column on the right: verdicts, reasoning and plot, of which the first and the last usually have so many
    /// rows.
    fn answers(
        &mut self,
        area: Rect,
        body: Rect,
        shares: PaneShares,
        wide: bool,
        usual: (u16, u16),
    ) {
        let rest = area.height.saturating_sub(LOWEST);
        let verdict = shares.cells(
            Edge::Verdict,
            body.height,
            usual.0,
            (LOWEST, rest.saturating_sub(LOW)),
        );
        let [upper, plot] = self.cut(
            area,
            body,
            shares,
            wide,
            Cut {
                edge: Edge::Plot,
                upright: false,
                before: false,
                usual: usual.1,
                limits: (LOW, rest.saturating_sub(verdict)),
            },
        );
        let [verdict, reasoning] = self.cut(
            upper,
            body,
            shares,
            wide,
            Cut {
                edge: Edge::Verdict,
                upright: false,
                before: true,
                usual: usual.0,
                limits: (LOWEST, upper.height.saturating_sub(LOWEST)),
            },
        );
        self.panes.extend([
            (Pane::Verdict, verdict),
            (Pane::Reasoning, reasoning),
            (Pane::Plot, plot),
        ]);
    }
}
