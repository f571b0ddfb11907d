//! The matrix of prompt configurations: counts, shares and intervals, sorted by any column.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use unicode_width::UnicodeWidthStr;

use super::draw::foot;
use crate::description::visible;
use crate::evaluation::{Outcome, PromptConfig, Results};
use crate::tui::model::{Model, RESULTS_COLUMNS, ResultsDrawn};
use crate::tui::theme::Theme;
use crate::tui::widgets::window;
use crate::tui::widgets::words::{fit_end, pad};

/// Heads of the columns of numbers.
pub const HEADS: [&str; RESULTS_COLUMNS] = [
    "n", "tp", "fp", "fn", "tn", "open", "unp", "fail", "prec", "rec", "F1",
];

/// The columns that need a truth: while it is worked out they have no numbers.
const OF_TRUTH: [bool; RESULTS_COLUMNS] = [
    false, true, true, true, true, true, false, false, true, true, true,
];

/// Columns of the terminal for how was asked, at most.
pub const NAMES: usize = 64;

/// Header of the column of false negatives that say yes but name another obstacle.
const WRONG: &str = "wrong obstacle";

/// Columns from which on the intervals of F1 stand in the matrix too.
const WIDE: u16 = 110;

/// Columns of an interval.
const INTERVAL: usize = 12;

/// How it was asked, in few columns.
pub fn asked(way: &PromptConfig) -> String {
    let frame = way.frame.map_or("-", |frame| match frame.name() {
        "cartesian" => "cart",
        name => name,
    });
    let techniques = way.techniques.map_or("-".into(), |t| t.to_string());
    let techniques = techniques.replace("cp+cot+icl", "all");
    let task = match way.task.name() {
        "collision" => "coll.",
        name => name,
    };
    let (task, frame) = (pad(task, 6), pad(frame, 4));
    format!("{task} {frame} {}", pad(&techniques, 7))
}

/// The version of the template, where it is not the one that this program ships.
pub fn version(way: &PromptConfig) -> Option<String> {
    let own = way.template.as_ref().filter(|own| !own.is_shipped());
    own.map(|own| visible(&own.to_string()).into_owned())
}

/// The numbers of a row.
fn cells(row: &Results, judging: bool) -> Vec<String> {
    let counts = Outcome::ALL.map(|outcome| row.count(outcome).to_string());
    let c = row.confusion();
    let shares = [c.precision(), c.recall(), c.f1()];
    let shares = shares.map(|share| share.map_or("-".into(), |v| format!("{v:.2}")));
    let all = std::iter::once(row.answers.len().to_string());
    let all = all.chain(counts).chain(shares);
    all.zip(OF_TRUTH)
        .map(|(cell, of_truth)| match judging && of_truth {
            true => "…".into(),
            false => cell,
        })
        .collect()
}

fn interval(row: &Results, judging: bool) -> String {
    let ends = row.f1.map(|i| format!("{:.2} to {:.2}", i.low, i.high));
    let none = if judging { "…" } else { "–" };
    pad(&ends.unwrap_or_else(|| none.into()), INTERVAL)
}

/// Draws the matrix; gives where its rows and numbers stand.
pub fn draw(frame: &mut Frame<'_>, area: Rect, model: &Model, title: &str) -> ResultsDrawn {
    let (theme, results) = (&model.theme, &model.results);
    let inner = window::window_at(frame, area, model, title);
    let inner = foot(frame, inner, model);
    let wide = inner.width >= WIDE;
    let judging = results.judging.is_some();
    let table: Vec<Vec<String>> = results.rows.iter().map(|row| cells(row, judging)).collect();
    let widths: Vec<usize> = (0..HEADS.len())
        .map(|column| {
            let longest = table.iter().map(|row| row[column].width()).max();
            // Room for the sign of the selected cell or of the order, or for a gap.
            (longest.unwrap_or(0) + 1).max(HEADS[column].len() + 1)
        })
        .collect();
    let behind = if wide {
        2 + INTERVAL + WRONG.len() + 2
    } else {
        0
    };
    let fixed: usize = widths.iter().sum::<usize>() + behind + 2;
    let longest = results.rows.iter().map(|row| name_width(&row.way)).max();
    let names = usize::from(inner.width)
        .saturating_sub(fixed)
        .min(NAMES)
        .min(longest.unwrap_or(0));
    let dim = Style::new().fg(theme.dim);
    let mut head = format!("  {}", pad("asked", names));
    for (column, (word, width)) in HEADS.iter().zip(&widths).enumerate() {
        let sign = match results.order {
            Some((by, true)) if by == column => "▲",
            Some((by, false)) if by == column => "▼",
            _ => "",
        };
        head.push_str(&format!("{:>width$}", format!("{sign}{word}")));
    }
    if wide {
        head.push_str(&format!("  {}  {WRONG}", pad("F1, 95 %", INTERVAL)));
    }
    let rows = usize::from(inner.height).saturating_sub(1);
    let top = (results.selected + 1).saturating_sub(rows);
    let mut lines = vec![Line::styled(head, dim.add_modifier(Modifier::BOLD))];
    let shown = results.rows.iter().zip(&table).enumerate();
    for (place, (row, cells)) in shown.skip(top).take(rows) {
        let chosen = place == results.selected;
        let mut spans = vec![Span::raw(if chosen { "▸ " } else { "  " })];
        spans.extend(name(theme, &row.way, names));
        for (column, (cell, width)) in cells.iter().zip(&widths).enumerate() {
            let picked = chosen && results.column == column;
            let text = match picked {
                true => format!("{:>width$}", format!(">{cell}")),
                false => format!("{cell:>width$}"),
            };
            let style = match cell.as_str() {
                _ if picked => Style::new().add_modifier(Modifier::BOLD),
                "0" | "…" => dim,
                _ => color_of(theme, column).map_or(Style::new(), |c| Style::new().fg(c)),
            };
            spans.push(Span::styled(text, style));
        }
        if wide {
            let wrong = match judging {
                true => "…".into(),
                false => row.named_another().to_string(),
            };
            let (ends, width) = (interval(row, judging), WRONG.len());
            let words = format!("  {ends}  {wrong:>width$}");
            spans.push(Span::styled(words, dim));
        }
        let line = Line::from(spans);
        lines.push(match chosen {
            true => theme.select(line),
            false => line.style(theme.base()),
        });
    }
    frame.render_widget(Paragraph::new(lines), inner);
    let list = Rect {
        y: inner.y + 1.min(inner.height),
        height: inner.height.saturating_sub(1),
        ..inner
    };
    let column = |columns: usize| u16::try_from(columns).unwrap_or(u16::MAX);
    let mut x = inner.x.saturating_add(column(2 + names));
    let cells = widths.iter().map(|width| {
        let cell = (x, column(*width));
        x = x.saturating_add(cell.1);
        cell
    });
    ResultsDrawn {
        list,
        top,
        cells: cells.collect(),
        ..ResultsDrawn::default()
    }
}

/// Columns that a way of asking takes, with a gap behind it.
fn name_width(way: &PromptConfig) -> usize {
    let version = version(way).map_or(0, |version| version.width() + 1);
    asked(way).width() + 1 + visible(&way.model).width() + version + 1
}

/// How was asked, whom, and with which version of the prompt; of the model the end stays where there is little room.
fn name(theme: &Theme, way: &PromptConfig, width: usize) -> Vec<Span<'static>> {
    let how = asked(way);
    let left = width.saturating_sub(how.width() + 2);
    let whole = version(way).map_or(String::new(), |version| format!(" {version}"));
    // Where there is no room for its name, the hash tells versions apart.
    let version = match (whole.split_once('@'), visible(&way.model).width()) {
        (Some((_, hash)), model) if model + whole.width() > left => format!(" @{hash}"),
        _ => whole,
    };
    let model = fit_end(&visible(&way.model), left.saturating_sub(version.width()));
    let gap = left.saturating_sub(model.width() + version.width()) + 1;
    vec![
        Span::raw(how),
        Span::raw(" "),
        Span::styled(model, Style::new().fg(theme.accent)),
        Span::styled(version, Style::new().fg(theme.warning)),
        Span::raw(" ".repeat(gap)),
    ]
}

fn color_of(theme: &Theme, column: usize) -> Option<Color> {
    match Outcome::ALL.get(column.checked_sub(1)?)? {
        Outcome::TruePositive | Outcome::TrueNegative => Some(theme.safe),
        Outcome::FalsePositive | Outcome::FalseNegative | Outcome::Failed => Some(theme.danger),
        Outcome::Unparsed => Some(theme.warning),
        Outcome::Open => None,
    }
}
