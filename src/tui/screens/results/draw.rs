//! Draws the matrix of prompt configurations, and bars by technique for the selected one.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use super::{answers, bars, choice};
use crate::description::visible;
use crate::evaluation::batch::AnswerSet;
use crate::evaluation::{Confusion, Outcome, PromptConfig, Results};
use crate::tui::action::Action;
use crate::tui::model::{Model, ResultsDrawn, ResultsView};
use crate::tui::theme::Theme;
use crate::tui::widgets::window;
use crate::tui::widgets::words::{fit_end, pad, thousands};

/// Columns after the way, before the shares.
pub const HEADS: [&str; 8] = ["n", "tp", "fp", "fn", "tn", "open", "unp", "fail"];

/// Columns of a way at most: the numbers stay near it on a wide screen.
pub const NAMES: usize = 64;

/// Header of the column of false negatives that say yes but name another obstacle.
const ANOTHER: &str = "named another";

/// Columns from which on the intervals of F1 stand in the matrix too.
const WIDE: u16 = 110;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    let body = Rect {
        height: screen.height.saturating_sub(1),
        ..screen
    };
    frame.render_widget(Clear, body);
    frame.render_widget(Block::new().style(model.theme.base()), body);
    let results = &model.results;
    let mut drawn = match results.inside {
        _ if results.rows.is_empty() => {
            empty(frame, body, model);
            ResultsDrawn::default()
        }
        Some(selected) => answers::draw(frame, body, model, selected),
        None => {
            let rows = bars::rows(model);
            // The borders, the lines about the truth, and a matrix of some rows come before the bars.
            let height = u16::try_from(rows.len() + 2).unwrap_or(u16::MAX);
            let height = height.min(body.height / 2);
            let [above, below] =
                Layout::vertical([Constraint::Min(0), Constraint::Length(height)]).areas(body);
            let mut drawn = matrix(frame, above, model);
            drawn.bars = bars::draw(frame, below, model, &rows);
            drawn
        }
    };
    if let Some(selected) = results.choosing {
        drawn = choice::draw(frame, body, model, selected);
    }
    model.drawn.set_results(drawn);
}

/// Why there is nothing to count.
fn empty(frame: &mut Frame<'_>, body: Rect, model: &Model) {
    let results = &model.results;
    let inner = window::window_at(frame, body, model, &title(results));
    let key = model.look.key(Action::ChooseCounted);
    let words = match (&results.error, results.reading, results.counting) {
        (Some(error), ..) => error.clone(),
        (None, true, _) => "reading the store…".into(),
        (None, false, Some(counting @ AnswerSet::Batch(..))) => format!(
            "nothing of {counting} is answered; not asked, or not yet: {}; {key} counts other answers",
            results.unasked
        ),
        (None, false, _) => {
            let key = model.look.key(Action::Run);
            format!(
                "no model has been asked yet; {key} on the main screen asks, and `nearmiss import` reads recorded answers"
            )
        }
    };
    let text = Paragraph::new(visible(&words).into_owned()).wrap(Wrap { trim: true });
    frame.render_widget(text.style(Style::new().fg(model.theme.dim)), inner);
}

fn title(results: &ResultsView) -> String {
    let count: usize = results.rows.iter().map(|row| row.answers.len()).sum();
    let reading = if results.reading { " …" } else { "" };
    let counting = results
        .counting
        .map_or(String::new(), |c| format!("{c} · "));
    format!(
        "results · {counting}{} answers{reading}",
        thousands(count as u64)
    )
}

/// The lines about the truth, at the bottom of an area; gives what is above them.
pub fn foot(frame: &mut Frame<'_>, area: Rect, model: &Model) -> Rect {
    let results = &model.results;
    let mut words = results.offer().map_or("truth: not known".into(), |offer| {
        format!("truth: {}", visible(&offer.truth))
    });
    // In the matrix the title says it.
    if let Some(counting) = results.counting.filter(|_| results.inside.is_some()) {
        words.push_str(&format!(" · of {counting}"));
    }
    if results.judging {
        words.push_str(" · it is at work: what is open may not stay so");
    }
    match results.unasked {
        0 => {}
        1 => words.push_str(" · 1 question was not asked and is not counted"),
        n => words.push_str(&format!(
            " · {n} questions were not asked and are not counted"
        )),
    }
    words.push_str(" · open: truth not known · unp: no verdict was read · fail: no whole answer");
    let text = Paragraph::new(words)
        .style(Style::new().fg(model.theme.dim))
        .wrap(Wrap { trim: true });
    let lines = u16::try_from(text.line_count(area.width)).unwrap_or(u16::MAX);
    let lines = lines.min(area.height.saturating_sub(2) / 2);
    let [above, below] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(lines)]).areas(area);
    frame.render_widget(text, below);
    above
}

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

fn shares(counts: &Confusion) -> [String; 3] {
    let share = |value: Option<f64>| value.map_or("-".into(), |v| format!("{v:.2}"));
    [counts.precision(), counts.recall(), counts.f1()].map(share)
}

fn cells(row: &Results) -> Vec<String> {
    let counts = Outcome::ALL.map(|outcome| row.count(outcome).to_string());
    let all = std::iter::once(row.answers.len().to_string());
    all.chain(counts).collect()
}

fn interval(row: &Results) -> String {
    let ends = row.f1.map(|i| format!("{:.2} to {:.2}", i.low, i.high));
    format!("  {}", pad(&ends.unwrap_or_default(), 12))
}

/// Draws the matrix; gives where its rows and numbers stand.
fn matrix(frame: &mut Frame<'_>, area: Rect, model: &Model) -> ResultsDrawn {
    let (theme, results) = (&model.theme, &model.results);
    let inner = window::window_at(frame, area, model, &title(results));
    let inner = foot(frame, inner, model);
    let wide = inner.width >= WIDE;
    let table: Vec<Vec<String>> = results.rows.iter().map(cells).collect();
    let widths: Vec<usize> = (0..HEADS.len())
        .map(|column| {
            let longest = table.iter().map(|row| row[column].len()).max();
            // Room for the sign of the selected cell, or for a gap.
            (longest.unwrap_or(0) + 1).max(HEADS[column].len() + 1)
        })
        .collect();
    let intervals = if wide { 2 + 12 + ANOTHER.len() + 2 } else { 0 };
    let fixed: usize = widths.iter().sum::<usize>() + 3 * 5 + intervals + 2;
    let names = usize::from(inner.width).saturating_sub(fixed).min(NAMES);
    let dim = Style::new().fg(theme.dim);
    let mut head = format!("  {}", pad("asked", names));
    for (word, width) in HEADS.iter().zip(&widths) {
        head.push_str(&format!("{word:>width$}"));
    }
    head.push_str(" prec  rec   F1");
    if wide {
        head.push_str(&format!("  {}  {ANOTHER}", pad("F1, 95 %", 12)));
    }
    let rows = usize::from(inner.height).saturating_sub(1);
    let top = (results.selected + 1).saturating_sub(rows);
    let mut lines = vec![Line::styled(head, dim.add_modifier(Modifier::BOLD))];
    let shown = results.rows.iter().zip(&table).enumerate();
    for (place, (row, cells)) in shown.skip(top).take(rows) {
        let chosen = place == results.selected;
        let way = asked(&row.way);
        let model_width = names.saturating_sub(way.width() + 2);
        let mut spans = vec![
            Span::raw(if chosen { "▸ " } else { "  " }),
            Span::raw(way),
            Span::raw(" "),
            Span::styled(
                pad(
                    &fit_end(&visible(&row.way.model), model_width),
                    model_width + 1,
                ),
                Style::new().fg(theme.accent),
            ),
        ];
        for (column, (cell, width)) in cells.iter().zip(&widths).enumerate() {
            let picked = chosen && results.column == column;
            let text = match picked {
                true => format!("{:>width$}", format!(">{cell}")),
                false => format!("{cell:>width$}"),
            };
            let style = match cell.as_str() {
                _ if picked => Style::new().add_modifier(Modifier::BOLD),
                "0" => dim,
                _ => color_of(theme, column).map_or(Style::new(), |c| Style::new().fg(c)),
            };
            spans.push(Span::styled(text, style));
        }
        for share in shares(&row.confusion()) {
            spans.push(Span::raw(format!("{share:>5}")));
        }
        if wide {
            spans.push(Span::styled(interval(row), dim));
            let another = row.named_another().to_string();
            spans.push(Span::styled(format!("  {another:>0$}", ANOTHER.len()), dim));
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

fn color_of(theme: &Theme, column: usize) -> Option<Color> {
    match Outcome::ALL.get(column.checked_sub(1)?)? {
        Outcome::TruePositive | Outcome::TrueNegative => Some(theme.safe),
        Outcome::FalsePositive | Outcome::FalseNegative | Outcome::Failed => Some(theme.danger),
        Outcome::Unparsed => Some(theme.warning),
        Outcome::Open => None,
    }
}
