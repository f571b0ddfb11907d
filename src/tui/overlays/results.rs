//! The screen of results: a matrix of all ways of asking, what techniques make of the selected one, and the answers of a cell.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::evaluation::{Confusion, Counted, Outcome, Results, Way};
use crate::text::visible;
use crate::tui::model::{Model, ResultsView};
use crate::tui::theme::Theme;
use crate::tui::widgets::words::{fit_end, pad, thousands};

/// Columns after the way, before the shares.
const HEADS: [&str; 8] = ["n", "tp", "fp", "fn", "tn", "open", "unp", "fail"];

/// Columns of a way at most: the numbers stay near it on a wide screen.
const NAMES: usize = 64;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    let body = Rect {
        height: screen.height.saturating_sub(1),
        ..screen
    };
    frame.render_widget(Clear, body);
    frame.render_widget(Block::new().style(model.theme.base()), body);
    let results = &model.results;
    if results.rows.is_empty() {
        let inner = super::window_at(frame, body, model, &title(results));
        let words = match (&results.error, results.reading) {
            (Some(error), _) => error.as_str(),
            (None, true) => "reading the store…",
            (None, false) => {
                "no model has been asked yet; r on the main screen asks, and `nearmiss import` reads recorded answers"
            }
        };
        let text = Paragraph::new(visible(words).into_owned()).wrap(Wrap { trim: true });
        frame.render_widget(text.style(Style::new().fg(model.theme.dim)), inner);
        return;
    }
    if results.inside.is_some() {
        return answers(frame, body, model);
    }
    let bars = ablation(model, usize::from(body.width).saturating_sub(2));
    // The borders, the line about the truth, and a matrix of some rows come before the bars.
    let height = u16::try_from(bars.len() + 2).unwrap_or(u16::MAX);
    let height = height.min(body.height / 2);
    let [above, below] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(height)]).areas(body);
    matrix(frame, above, model);
    let way = results.row().map_or(String::new(), |row| {
        let task = row.way.task.name();
        let frame = row.way.frame.map_or("", |frame| frame.name());
        visible(&format!(
            "F1 by techniques · {task} {frame} · {}",
            row.way.model
        ))
        .into_owned()
    });
    let inner = super::window_at(frame, below, model, &way);
    frame.render_widget(Paragraph::new(bars), inner);
}

fn title(results: &ResultsView) -> String {
    let count: usize = results.rows.iter().map(|row| row.answers.len()).sum();
    let reading = if results.reading { " …" } else { "" };
    format!("results · {} answers{reading}", thousands(count as u64))
}

/// How it was asked, in few columns.
fn asked(way: &Way) -> String {
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

fn matrix(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let (theme, results) = (&model.theme, &model.results);
    let inner = super::window_at(frame, area, model, &title(results));
    let table: Vec<Vec<String>> = results.rows.iter().map(cells).collect();
    let widths: Vec<usize> = (0..HEADS.len())
        .map(|column| {
            let longest = table.iter().map(|row| row[column].len()).max();
            // Room for the sign of the selected cell, or for a gap.
            (longest.unwrap_or(0) + 1).max(HEADS[column].len() + 1)
        })
        .collect();
    let fixed: usize = widths.iter().sum::<usize>() + 3 * 5 + 2;
    let names = usize::from(inner.width).saturating_sub(fixed).min(NAMES);
    let dim = Style::new().fg(theme.dim);
    let mut head = format!("  {}", pad("asked", names));
    for (word, width) in HEADS.iter().zip(&widths) {
        head.push_str(&format!("{word:>width$}"));
    }
    head.push_str(" prec  rec   F1");
    let truth = "truth: the built-in judge · open: truth not known · unp: no verdict was read";
    let rows = usize::from(inner.height).saturating_sub(2);
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
        let line = Line::from(spans);
        lines.push(match chosen {
            true => theme.select(line),
            false => line.style(theme.base()),
        });
    }
    frame.render_widget(Paragraph::new(lines), inner);
    let foot = Rect {
        y: inner.bottom().saturating_sub(1),
        height: 1.min(inner.height),
        ..inner
    };
    frame.render_widget(Span::styled(truth, dim), foot);
}

fn color_of(theme: &Theme, column: usize) -> Option<Color> {
    match Outcome::ALL.get(column.checked_sub(1)?)? {
        Outcome::TruePositive | Outcome::TrueNegative => Some(theme.safe),
        Outcome::FalsePositive | Outcome::FalseNegative | Outcome::Failed => Some(theme.danger),
        Outcome::Unparsed => Some(theme.warning),
        Outcome::Open => None,
    }
}

/// F1 of every set of techniques with which the selected row's model was asked the same, as bars with their numbers.
fn ablation(model: &Model, width: usize) -> Vec<Line<'static>> {
    let (theme, results) = (&model.theme, &model.results);
    let Some(row) = results.row() else {
        return Vec::new();
    };
    let like = |other: &&Results| {
        let (a, b) = (&row.way, &other.way);
        (a.task, a.frame, &a.model) == (b.task, b.frame, &b.model)
    };
    let lines = results.rows.iter().filter(like).map(|other| {
        let counts = other.confusion();
        let f1 = counts.f1();
        let number = f1.map_or(" -  ".into(), |f1| format!("{f1:.2}"));
        let of = counts.positives() + counts.negatives();
        let tail = format!(" {number}  of {of}");
        let techniques = other.way.techniques.map_or("-".into(), |t| t.to_string());
        let room = width.saturating_sub(2 + 11 + tail.width()).min(80);
        let long = (f1.unwrap_or(0.0) * room as f64).round() as usize;
        let chosen = other.way == row.way;
        let style = Style::new().fg(if chosen { theme.accent } else { theme.dim });
        Line::from(vec![
            Span::raw(if chosen { "▸ " } else { "  " }),
            Span::raw(pad(&techniques, 11)),
            Span::styled("█".repeat(long), style),
            Span::raw(tail),
        ])
    });
    lines.collect()
}

fn said(outcome: Outcome) -> (&'static str, &'static str) {
    match outcome {
        Outcome::TruePositive => ("right", "says yes"),
        Outcome::TrueNegative => ("right", "says no"),
        Outcome::FalsePositive => ("wrong", "says yes, the judge no"),
        Outcome::FalseNegative => ("wrong", "says no, the judge yes"),
        Outcome::Open => ("open", "has a verdict; truth not known"),
        Outcome::Unparsed => ("none", "no verdict in the answer"),
        Outcome::Failed => ("fail", "no whole answer"),
    }
}

fn answers(frame: &mut Frame<'_>, area: Rect, model: &Model) {
    let (theme, results) = (&model.theme, &model.results);
    let all = results.answers();
    let cell = results.column.min(HEADS.len() - 1);
    let title = results.row().map_or(String::new(), |row| {
        let how = asked(&row.way);
        let how: Vec<&str> = how.split_whitespace().collect();
        let (how, head) = (how.join(" "), HEADS[cell]);
        format!("{} · {how} · {head} {}", visible(&row.way.model), all.len())
    });
    let inner = super::window_at(frame, area, model, &title);
    let selected = results.inside.unwrap_or(0);
    let rows = usize::from(inner.height);
    let top = selected
        .saturating_sub(rows / 2)
        .min(all.len().saturating_sub(rows));
    let line = |(place, answer): (usize, &&Counted)| {
        let chosen = place == selected;
        let (word, what) = said(answer.outcome);
        let color = match answer.outcome.is_right() {
            Some(true) => theme.safe,
            Some(false) => theme.danger,
            None => theme.warning,
        };
        let sample = match answer.sample {
            0 => String::new(),
            n => format!(" sample {n}"),
        };
        let tail = format!("  run {}{sample}", answer.run);
        let rest = usize::from(inner.width).saturating_sub(2 + 6 + tail.width());
        let what_width = 38.min(rest / 2);
        let name_width = (rest - what_width).min(NAMES);
        let line = Line::from(vec![
            Span::raw(if chosen { "▸ " } else { "  " }),
            Span::styled(
                pad(word, 6),
                Style::new().fg(color).add_modifier(Modifier::BOLD),
            ),
            Span::raw(pad(&visible(&answer.scenario), name_width)),
            Span::raw(pad(what, what_width)),
            Span::styled(tail, Style::new().fg(theme.dim)),
        ]);
        match chosen {
            true => theme.select(line),
            false => line.style(theme.base()),
        }
    };
    let shown = all.iter().enumerate().skip(top).take(rows);
    frame.render_widget(Paragraph::new(shown.map(line).collect::<Vec<_>>()), inner);
}
