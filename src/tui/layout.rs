//! Pane layout for every terminal size. Where there is no room for all panes, the least important ones are left out;
//! the pane that has the keys is always there.

use ratatui::layout::{Constraint, Layout, Rect};

use crate::model::Arrangement::{self, Compact, Narrow, Wide};
use crate::model::{Border, Edge, List, Model, Pane, PaneShares};

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
            (THREE_COLUMNS.., TALL..) => {
                let verdict = match (body.height, model.answers.columns.is_empty()) {
                    (45.., false) => 22,
                    (45.., true) => 17,
                    _ => 15,
                };
                arranged.wide(body, sizes.wide, &model.list, verdict);
            }
            (THREE_COLUMNS.., _) => {
                arranged.low(body, sizes.wide, model.list.longest, model.focus);
            }
            (TWO_COLUMNS.., _) => {
                arranged.compact(body, sizes.compact, list_rows(&model.list), model.focus);
            }
            _ => arranged.narrow(body, sizes.narrow, list_rows(&model.list), model.focus),
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

/// Fewest columns of a pane.
const NARROWEST: u16 = 18;
/// Fewest columns of the map, and of the column on the right.
const NARROW: u16 = 30;
/// Fewest rows of a pane: its frame and two lines.
const LOWEST: u16 = 4;
/// Fewest rows of what needs more to be understood: map and plot.
const LOW: u16 = 6;
/// Rows of list and map in two columns from which on the list stays while one looks at something else.
const ROOM_FOR_LIST: u16 = 20;

/// Where panes are, and the borders between them.
#[derive(Default)]
struct Arranged {
    /// Every pane that is shown.
    pub panes: Vec<(Pane, Rect)>,
    /// The borders between them that can be moved.
    pub borders: Vec<Border>,
}

/// Columns of a list that shows names of this length, up to a limit: its border, the sign before a name, and what
/// answers say and the risk behind it.
fn named(longest: usize) -> u16 {
    u16::try_from(longest + 9).unwrap_or(u16::MAX).clamp(24, 34)
}

/// Columns of the list where it has a column of its own: with room it shows more than names.
fn list_columns(width: u16, longest: usize) -> u16 {
    match width {
        ..160 => (width * 17 / 100).max(named(longest)),
        // Names whole, and how many answers say otherwise.
        wide => {
            let whole = u16::try_from(longest + 14).unwrap_or(u16::MAX).min(41);
            (wide * 27 / 100).max(whole).min(55)
        }
    }
}

/// Rows that the list can fill: its frame, filter and headings, and all scenarios, however few match the filter. While
/// they are looked for, there may be any number.
fn list_rows(list: &List) -> u16 {
    let lines = list.rows.len() + list.groups.len() + 4;
    if list.found {
        u16::try_from(lines).unwrap_or(u16::MAX)
    } else {
        u16::MAX
    }
}

/// Columns from which on the prompt may stand below a short list, and its rows there at least.
const PROMPT_BELOW_LIST: (u16, u16) = (180, 12);

/// Columns of verdicts, reasoning and plot where the list has a column of its own.
fn answer_columns(width: u16) -> u16 {
    (width * 36 / 100).clamp(44, 84)
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

impl Cut {
    /// The timeline below the map, so many rows high.
    fn timeline(area: Rect, usual: u16) -> Self {
        Self {
            edge: Edge::Timeline,
            upright: false,
            before: false,
            usual,
            limits: (LOWEST, area.height.saturating_sub(LOW)),
        }
    }

    /// The column of answers at the right.
    fn answers(body: Rect) -> Self {
        Self {
            edge: Edge::Right,
            upright: true,
            before: false,
            usual: answer_columns(body.width),
            limits: (NARROW, body.width.saturating_sub(NARROWEST + NARROW)),
        }
    }

    /// The list in a column of its own, left of the rest of `left`.
    fn list(body: Rect, left: Rect, longest: usize) -> Self {
        Self {
            edge: Edge::List,
            upright: true,
            before: true,
            usual: list_columns(body.width, longest),
            limits: (NARROWEST, left.width.saturating_sub(NARROW)),
        }
    }
}

impl Arranged {
    /// Cuts an area in two, with a border between them; `whole` is the area that shares are parts of.
    fn cut(
        &mut self,
        area: Rect,
        whole: Rect,
        shares: PaneShares,
        arrangement: Arrangement,
        cut: Cut,
    ) -> [Rect; 2] {
        let total = if cut.upright {
            whole.width
        } else {
            whole.height
        };
        let size = shares.cells(cut.edge, total, cut.usual, cut.limits);
        let constraints = if cut.before {
            [Constraint::Length(size), Constraint::Min(0)]
        } else {
            [Constraint::Min(0), Constraint::Length(size)]
        };
        let layout = if cut.upright {
            Layout::horizontal(constraints)
        } else {
            Layout::vertical(constraints)
        };
        let [first, second] = layout.areas(area);
        let strip = if cut.upright {
            Rect {
                x: second.x.saturating_sub(1),
                width: 2,
                ..area
            }
        } else {
            Rect {
                y: second.y.saturating_sub(1),
                height: 2,
                ..area
            }
        };
        self.borders.push(Border {
            edge: cut.edge,
            arrangement,
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
    /// The prompt stands below list and map; below the list alone, where that is short and wide.
    pub fn wide(&mut self, body: Rect, shares: PaneShares, list: &List, verdict: u16) {
        let [left, right] = self.cut(body, body, shares, Wide, Cut::answers(body));
        let (columns, rows) = PROMPT_BELOW_LIST;
        let needed = list_rows(list);
        let below_list = body.width >= columns && needed.saturating_add(rows) <= body.height;
        let prompt_rows = if below_list {
            body.height - needed
        } else {
            (body.height * 26 / 100).clamp(8, 18)
        };
        let prompt = Cut {
            edge: Edge::Prompt,
            upright: false,
            before: false,
            usual: prompt_rows,
            limits: (LOWEST, body.height.saturating_sub(LOW + LOWEST)),
        };
        let beside = Cut::list(body, left, list.longest);
        let (list, prompt, middle) = if below_list {
            let [column, middle] = self.cut(left, body, shares, Wide, beside);
            let [list, prompt] = self.cut(column, body, shares, Wide, prompt);
            (list, prompt, middle)
        } else {
            let [upper, prompt] = self.cut(left, body, shares, Wide, prompt);
            let [list, middle] = self.cut(upper, body, shares, Wide, beside);
            (list, prompt, middle)
        };
        let [map, timeline] = self.cut(
            middle,
            body,
            shares,
            Wide,
            Cut::timeline(middle, if body.height >= 45 { 8 } else { 6 }),
        );
        self.panes.extend([
            (Pane::Scenarios, list),
            (Pane::Map, map),
            (Pane::Timeline, timeline),
            (Pane::Prompt, prompt),
        ]);
        // So many rows that each of the six risk scores has one, or every second one.
        let risk = match body.height {
            ..45 => 9,
            45..90 => 12,
            _ => 17,
        };
        let focus = Pane::Scenarios;
        self.answers(right, body, shares, Wide, focus, (verdict, risk));
    }

    /// Three columns in a low terminal: the prompt takes turns with map and timeline.
    pub fn low(&mut self, body: Rect, shares: PaneShares, longest: usize, focus: Pane) {
        let [left, right] = self.cut(body, body, shares, Wide, Cut::answers(body));
        let [list, middle] = self.cut(left, body, shares, Wide, Cut::list(body, left, longest));
        self.panes.push((Pane::Scenarios, list));
        if focus == Pane::Prompt {
            self.panes.push((Pane::Prompt, middle));
        } else {
            let [map, timeline] = self.cut(middle, body, shares, Wide, Cut::timeline(middle, 5));
            self.panes
                .extend([(Pane::Map, map), (Pane::Timeline, timeline)]);
        }
        self.answers(right, body, shares, Wide, focus, (9, 7));
    }

    /// One column: what is looked at above (list, map or prompt), and what is said about it below; below the list, the
    /// map. The timeline is below the map, and more is shown below, where there is room.
    pub fn narrow(&mut self, body: Rect, shares: PaneShares, list_rows: u16, focus: Pane) {
        let lower = match focus {
            Pane::Scenarios => Pane::Map,
            Pane::Reasoning | Pane::Plot => focus,
            _ => Pane::Verdict,
        };
        let lowest = match lower {
            Pane::Verdict => Pane::Reasoning,
            _ => Pane::Verdict,
        };
        let (timeline, more) = (body.height >= 20, body.height >= 34);
        let mut rest = body;
        let mut below = |rest: &mut Rect, edge, usual, limits| {
            let cut = Cut {
                edge,
                upright: false,
                before: false,
                usual,
                limits,
            };
            let [upper, lower] = self.cut(*rest, body, shares, Narrow, cut);
            *rest = upper;
            lower
        };
        let mut panes = Vec::new();
        // What the panes above need at least.
        let least = if timeline { LOWEST + LOW } else { LOW };
        if more {
            let limits = (LOWEST, rest.height.saturating_sub(LOW + least));
            panes.push((
                lowest,
                below(&mut rest, Edge::Plot, body.height / 4, limits),
            ));
        }
        if lower == Pane::Map {
            if timeline {
                let limits = (LOWEST, rest.height.saturating_sub(LOW + LOW));
                panes.push((Pane::Timeline, below(&mut rest, Edge::Timeline, 5, limits)));
            }
            let usual = if more {
                body.height * 2 / 5
            } else {
                (body.height / 2).min(9)
            };
            let map = usual.max(rest.height.saturating_sub(list_rows));
            let limits = (LOW, rest.height.saturating_sub(LOW));
            panes.push((Pane::Map, below(&mut rest, Edge::List, map, limits)));
            panes.push((Pane::Scenarios, rest));
        } else {
            let lower_least = if lower == Pane::Plot { LOW } else { LOWEST };
            let limits = (lower_least, rest.height.saturating_sub(least));
            let usual = (body.height / 2).min(9);
            panes.push((lower, below(&mut rest, Edge::Verdict, usual, limits)));
            if timeline {
                let limits = (LOWEST, rest.height.saturating_sub(LOW));
                panes.push((Pane::Timeline, below(&mut rest, Edge::Timeline, 5, limits)));
            }
            let upper = if focus == Pane::Prompt {
                focus
            } else {
                Pane::Map
            };
            panes.push((upper, rest));
        }
        panes.reverse();
        self.panes.extend(panes);
    }

    /// Two columns: the subject on the left (list, map or prompt), statements about it on the right.
    pub fn compact(&mut self, body: Rect, shares: PaneShares, list_rows: u16, focus: Pane) {
        let [left, right] = self.cut(
            body,
            body,
            shares,
            Compact,
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
            Compact,
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
        // The map stays in sight while one looks through the list; the open scenario stays there, where there is room.
        let looks = shown == Pane::Scenarios;
        if looks || (shown == Pane::Map && upper.height >= ROOM_FOR_LIST) {
            let most = if looks {
                (f64::from(upper.height) * 0.42).round() as u16
            } else {
                LOWEST
            };
            let [list, map] = self.cut(
                upper,
                body,
                shares,
                Compact,
                Cut {
                    edge: Edge::List,
                    upright: false,
                    before: true,
                    usual: list_rows.min(most),
                    limits: (LOWEST, upper.height.saturating_sub(LOW)),
                },
            );
            self.panes
                .extend([(Pane::Scenarios, list), (Pane::Map, map)]);
        } else {
            self.panes.push((shown, upper));
        }
        self.panes.push((Pane::Timeline, timeline));
        let verdict = if (22..26).contains(&body.height) {
            8
        } else {
            9
        };
        self.answers(right, body, shares, Compact, focus, (verdict, 7));
    }

    /// The column on the right: verdicts, reasoning and plot, of which the first and the last usually have so many
    /// rows. In a low terminal two of them: verdicts, and the one that has the keys, else the reasoning.
    fn answers(
        &mut self,
        area: Rect,
        body: Rect,
        shares: PaneShares,
        arrangement: Arrangement,
        focus: Pane,
        usual: (u16, u16),
    ) {
        let all = area.height >= usual.0 + LOWEST + LOW;
        let (upper, plot) = if all {
            let rest = area.height.saturating_sub(LOWEST);
            let limits = (LOWEST, rest.saturating_sub(LOW));
            let verdict = shares.cells(Edge::Verdict, body.height, usual.0, limits);
            let cut = Cut {
                edge: Edge::Plot,
                upright: false,
                before: false,
                usual: usual.1,
                limits: (LOW, rest.saturating_sub(verdict)),
            };
            let [upper, plot] = self.cut(area, body, shares, arrangement, cut);
            (upper, Some(plot))
        } else {
            (area, None)
        };
        let second = match (plot, focus) {
            (None, Pane::Plot) => Pane::Plot,
            _ => Pane::Reasoning,
        };
        let least = if second == Pane::Plot { LOW } else { LOWEST };
        let cut = Cut {
            edge: Edge::Verdict,
            upright: false,
            before: true,
            usual: usual.0,
            limits: (LOWEST, upper.height.saturating_sub(least)),
        };
        let [verdict, lower] = self.cut(upper, body, shares, arrangement, cut);
        self.panes
            .extend([(Pane::Verdict, verdict), (second, lower)]);
        self.panes.extend(plot.map(|area| (Pane::Plot, area)));
    }
}

impl Arranged {
    /// Ends the panes at a column, where a panel stands. One that becomes too narrow gives its place to the pane on its
    /// left; the map and its timeline take the place of that pane instead.
    pub fn end_at(&mut self, column: u16) {
        for (_, area) in &mut self.panes {
            area.width = area.width.min(column.saturating_sub(area.x));
        }
        let narrow = |(_, area): &&(Pane, Rect)| area.width < NARROW && area.right() >= column;
        let shows_map = |pane: Pane| matches!(pane, Pane::Map | Pane::Timeline);
        let map = self
            .panes
            .iter()
            .filter(narrow)
            .find(|(p, _)| shows_map(*p));
        if let Some(left) = map.map(|(_, area)| area.x) {
            let before = self.panes.iter().filter(|(_, area)| area.right() == left);
            let from = before.map(|(_, area)| area.x).min().unwrap_or(left);
            self.panes.retain(|(_, area)| area.right() != left);
            for (_, area) in self.panes.iter_mut().filter(|(_, area)| area.x == left) {
                area.x = from;
                area.width = column - from;
            }
        }
        let narrow = self.panes.iter().filter(narrow).map(|(_, area)| area.x);
        if let Some(left) = narrow.min() {
            self.panes.retain(|(_, area)| area.x < left);
            for (_, area) in self
                .panes
                .iter_mut()
                .filter(|(_, area)| area.right() == left)
            {
                area.width = column - area.x;
            }
        }
        // They stand where they were until the panel closes.
        self.borders.clear();
    }
}
