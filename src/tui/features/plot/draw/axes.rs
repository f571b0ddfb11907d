//! Plot axes with round numbers, each on a row of its own at even distances, and the area between them.

use nearmiss_render::Ticks;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{Context, Points};
use unicode_width::UnicodeWidthStr;

use crate::widgets::line_placer::LinePlacer;

/// Rows that a plot needs for a line along its lower end.
const ROWS_WITH_LINE: u16 = 9;
/// Columns that a number of the lower axis needs.
const COLUMNS: u16 = 7;
/// Most numbers of the vertical axis.
const MAX_NUMBERS: usize = 6;

/// Values at the two ends of an axis.
pub type Range = (f64, f64);

/// What axes are drawn from.
pub struct Drawn<'a> {
    /// From when to when, seconds.
    pub time: Range,
    /// The vertical axis.
    pub upwards: &'a Upwards,
    /// Its unit.
    pub unit: &'a str,
    /// The colour of lines and numbers.
    pub color: Color,
}

/// A vertical axis: its numbers, and the rows at whose middles they stand.
pub struct Upwards {
    ticks: Ticks,
    rows: u16,
}

impl Upwards {
    /// Numbers for a plot in this area, of those that `ticks` gives for at most so many: the tallest plot, then the
    /// most numbers.
    pub fn fitting(area: Rect, ticks: impl Fn(usize) -> Ticks) -> Self {
        let room = rows(area);
        let most = usize::from(room / 2 + 1).clamp(2, MAX_NUMBERS - 1);
        let all = (2..=most).map(|most| Self::even(ticks(most), room));
        let best = all.max_by_key(|axis| {
            let count = axis.ticks.labels().len();
            (count > 2, axis.rows, count)
        });
        best.unwrap_or_else(|| Self::even(ticks(2), room))
    }

    /// The axis of risk scores, always whole: all six numbers where each can have a row.
    pub fn of_risk(area: Rect) -> Self {
        let room = rows(area);
        if usize::from(room) < MAX_NUMBERS {
            Self::even(Ticks::ends(0.0, 5.0), room)
        } else {
            Self::even(Ticks::around(0.0, 5.0, MAX_NUMBERS), room)
        }
    }

    /// As many rows as put every number on one.
    fn even(ticks: Ticks, room: u16) -> Self {
        let gaps = u16::try_from(ticks.labels().len().saturating_sub(1))
            .unwrap_or(1)
            .max(1);
        let rows = match room.saturating_sub(1) / gaps {
            0 => room,
            each => each * gaps + 1,
        };
        Self { ticks, rows }
    }

    /// The lowest and the highest number.
    pub fn bounds(&self) -> Range {
        self.ticks.bounds()
    }
}

/// Where points of the plot are on the screen.
pub struct Axes {
    /// The area between the axes.
    pub plot: Rect,
    time: Range,
    values: Range,
}

impl Axes {
    /// A point in dots of a canvas of Braille: two in a column and four in a row, from below.
    pub fn dots(&self, (time, value): (f64, f64)) -> (f64, f64) {
        let (width, height) = self.last_dot();
        let part = |v: f64, (from, to): Range| ((v - from) / (to - from)).clamp(0.0, 1.0);
        // Numbers stand in the middle of their rows, so the axis begins and ends there.
        let tall = height - 2.0 * HALF;
        (
            part(time, self.time) * width,
            HALF + part(value, self.values) * tall,
        )
    }

    /// The last dots to the right and upwards.
    pub fn last_dot(&self) -> (f64, f64) {
        let last = |cells: u16, dots: f64| (f64::from(cells) * dots - 1.0).max(1.0);
        (last(self.plot.width, 2.0), last(self.plot.height, 4.0))
    }

    /// The lowest and the highest value.
    pub fn values(&self) -> Range {
        self.values
    }

    /// The column of a time.
    pub fn column(&self, time: f64) -> u16 {
        let part = (time - self.time.0) / (self.time.1 - self.time.0);
        self.plot.x + place(part, self.plot.width)
    }

    /// The row of a value that is on the axis.
    pub fn row(&self, value: f64) -> Option<u16> {
        let (low, high) = self.values;
        let on = (low..=high).contains(&value);
        on.then(|| self.plot.y + place((high - value) / (high - low), self.plot.height))
    }
}

/// Dots from the edge of a row to its middle.
const HALF: f64 = 1.5;

/// Rows of the plot itself.
fn rows(area: Rect) -> u16 {
    area.height.saturating_sub(below(area))
}

/// Rows under the plot: numbers, and a line where there is room.
fn below(area: Rect) -> u16 {
    1 + u16::from(area.height >= ROWS_WITH_LINE)
}

/// Draws the axes; gives what lies between them. Rows that are left over stay free above.
pub fn draw(f: &mut Frame<'_>, area: Rect, drawn: &Drawn<'_>) -> Axes {
    let (time, upwards) = (drawn.time, drawn.upwards);
    let style = Style::new().fg(drawn.color);
    let mut labels = upwards.ticks.labels();
    if let Some((_, top)) = labels.last_mut().filter(|_| !drawn.unit.is_empty()) {
        top.push_str(&format!(" {}", drawn.unit));
    }
    let widths = labels.iter().map(|(_, words)| words.width());
    let width = u16::try_from(widths.max().unwrap_or(0))
        .unwrap_or(0)
        .min(area.width / 3);
    let room = rows(area);
    let height = upwards.rows.min(room);
    let mut axes = Axes {
        plot: Rect {
            x: area.x + width + 1,
            y: area.y + (room - height),
            width: area.width.saturating_sub(width + 1),
            height,
        },
        time,
        values: upwards.bounds(),
    };
    let plot = axes.plot;
    if plot.width < 2 || plot.height < 2 {
        axes.plot.height = 0;
        return axes;
    }
    let mut put = |x: u16, y: u16, words: &str| {
        let room = Rect::new(x, y, area.right().saturating_sub(x), 1).intersection(area);
        f.render_widget(Span::styled(words.to_string(), style), room);
    };
    for y in plot.top()..plot.bottom() {
        put(plot.x - 1, y, "│");
    }
    for (value, words) in &labels {
        let Some(y) = axes.row(*value) else { continue };
        let short = u16::try_from(words.width()).unwrap_or(width);
        put(area.x + width.saturating_sub(short), y, words);
        put(plot.x - 1, y, "┤");
    }
    let most = usize::from(plot.width / COLUMNS).clamp(2, 9);
    let ticks = Ticks::within(time.0, time.1, most).labels();
    if below(area) > 1 {
        let line = "─".repeat(usize::from(plot.width));
        put(plot.x - 1, plot.bottom(), &format!("└{line}"));
        for (value, _) in &ticks {
            put(axes.column(*value), plot.bottom(), "┴");
        }
    }
    let numbers = numbers(&axes, area, ticks, drawn);
    let lowest = Rect::new(area.x, area.bottom() - 1, area.width, 1);
    f.render_widget(numbers, lowest);
    axes
}

/// The numbers of the lower axis, below their ticks.
fn numbers(axes: &Axes, area: Rect, ticks: Vec<(f64, String)>, drawn: &Drawn<'_>) -> Line<'static> {
    let style = Style::new().fg(drawn.color);
    let mut row = LinePlacer::new(usize::from(area.width));
    let at = |time: f64| usize::from(axes.column(time) - area.x);
    // The last one has the unit, else the one before it that has room for it.
    let mut unit = " s";
    for (time, words) in ticks.into_iter().rev() {
        if row.words_around(at(time), &format!("{words}{unit}"), style) {
            unit = "";
        } else {
            row.words_around(at(time), &words, style);
        }
    }
    Line::from_iter(row.spans())
}

/// The cell at a fraction of this many cells.
fn place(part: f64, cells: u16) -> u16 {
    (part.clamp(0.0, 1.0) * f64::from(cells.saturating_sub(1))).round() as u16
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// Without gaps.
    Solid,
    /// Dashes.
    Dashed,
    /// Dots.
    Dotted,
    /// Dashes and dots.
    Alternating,
    /// Long dashes.
    Long,
}

impl Dash {
    /// Those of marked obstacles, one after the other.
    pub const MARKED: [Self; 3] = [Self::Dotted, Self::Alternating, Self::Long];

    /// Its sign in a legend: the dots of a level line, as it is drawn.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Solid => "⠒⠒",
            Self::Dashed => "⠒⠒⠀⠀⠒⠒",
            Self::Dotted => "⠂⠀⠂",
            Self::Alternating => "⠒⠒⠂⠐⠀",
            Self::Long => "⠒⠒⠒⠒⠂⠀⠐",
        }
    }

    /// Whether the dot at this place along the line is drawn.
    fn shows(self, place: usize) -> bool {
        match self {
            Self::Solid => true,
            Self::Dashed => place % 8 < 4,
            Self::Dotted => place.is_multiple_of(4),
            Self::Alternating => matches!(place % 10, 0..=4 | 7),
            Self::Long => place % 13 < 9,
        }
    }
}

/// Draws a line through points, in dots of the canvas; a lonely point is a dot.
pub fn stroke(ctx: &mut Context<'_>, points: &[(f64, f64)], dash: Dash, color: Color) {
    let all = dots(points);
    let shown = all.iter().enumerate().filter(|(i, _)| dash.shows(*i));
    let coords: Vec<(f64, f64)> = shown
        .map(|(_, (x, y))| (f64::from(*x), f64::from(*y)))
        .collect();
    ctx.draw(&Points {
        coords: &coords,
        color,
    });
}

/// Every dot on the way from point to point, each once.
fn dots(points: &[(f64, f64)]) -> Vec<(i32, i32)> {
    // Dots of a canvas are few; what is not a number becomes zero.
    let rounded = |(x, y): &(f64, f64)| (x.round() as i32, y.round() as i32);
    let mut all: Vec<(i32, i32)> = points.first().map(rounded).into_iter().collect();
    for pair in points.windows(2) {
        let (from, to) = (rounded(&pair[0]), rounded(&pair[1]));
        let (dx, dy) = (
            f64::from(to.0) - f64::from(from.0),
            f64::from(to.1) - f64::from(from.1),
        );
        let count = dx.abs().max(dy.abs());
        for i in 1..=count as u32 {
            let part = f64::from(i) / count;
            let at = |start: i32, by: f64| (f64::from(start) + part * by).round() as i32;
            all.push((at(from.0, dx), at(from.1, dy)));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_has_a_row_at_even_distances() {
        for height in 3..60 {
            let area = Rect::new(0, 0, 60, height);
            let measured = |most| Ticks::around(0.3, 47.0, most);
            for upwards in [Upwards::of_risk(area), Upwards::fitting(area, measured)] {
                let axes = Axes {
                    plot: Rect::new(5, 0, 50, upwards.rows),
                    time: (0.0, 1.0),
                    values: upwards.bounds(),
                };
                let labels = upwards.ticks.labels();
                let rows: Vec<u16> = labels.iter().filter_map(|(v, _)| axes.row(*v)).collect();
                assert_eq!(rows.len(), labels.len());
                let gaps: Vec<u16> = rows.windows(2).map(|pair| pair[0] - pair[1]).collect();
                assert!(
                    gaps.iter().all(|gap| *gap == gaps[0] && *gap > 0),
                    "{height}: {rows:?}"
                );
                // A line at a number lies in its row.
                for ((value, _), row) in labels.iter().zip(&rows) {
                    let (_, dot) = axes.dots((0.0, *value));
                    let from_above = axes.last_dot().1 - dot.round();
                    assert_eq!((from_above / 4.0).floor() as u16, *row, "{height}: {value}");
                }
            }
            if rows(area) >= 6 {
                assert_eq!(Upwards::of_risk(area).ticks.labels().len(), 6, "{height}");
            }
        }
    }

    #[test]
    fn dots_have_no_gaps_and_dashes_do() {
        let all = dots(&[(0.0, 0.0), (9.0, 3.0), (9.0, 12.0)]);
        assert_eq!(all.len(), 1 + 9 + 9);
        let near = |pair: &[(i32, i32)]| {
            (pair[0].0 - pair[1].0).abs() <= 1 && (pair[0].1 - pair[1].1).abs() <= 1
        };
        assert!(all.windows(2).all(near), "{all:?}");
        for dash in Dash::MARKED.into_iter().chain([Dash::Dashed]) {
            let shown = (0..60).filter(|place| dash.shows(*place)).count();
            assert!((10..50).contains(&shown), "{dash:?}");
        }
    }
}
