//! Verdicts side by side, the built-in judge's last; what differs from it is marked.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use unicode_width::UnicodeWidthStr;

use crate::evaluation::{Answer, Judged, Past};
use crate::judge;
use crate::store::{Origin, RunId};
use crate::tui::model::{Answers, Column, Model, Pane, Progress, Shown};
use crate::tui::widgets::words::{date, duration, fit, pad, thousands};
use crate::tui::widgets::{frame, scroll};
use crate::verdict::{Task, Verdict};

/// Columns of the names of the rows.
const LABEL: usize = 10;
/// What the built-in judge is called here.
const BUILT_IN: &str = "built-in";
/// Columns that an answer needs.
const NARROWEST: usize = 8;

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let mut title = Line::from(format!("verdict · {}", model.task.name()));
    // Inside the border, without the column of the scroll bar.
    let room = usize::from(area.width).saturating_sub(3);
    let seen_now = seen(&model.answers, room);
    if let (Some(first), Some(last)) = (seen_now.clone().min(), seen_now.clone().max()) {
        let all = model.answers.columns.len();
        let hint = format!(" · {}–{}/{all} [ ]", first + 1, last + 1);
        title.push_span(Span::styled(hint, Style::new().fg(model.theme.dim)));
    }
    let inner = frame::pane(f, area, model, Pane::Verdict, title);
    let answers = &model.answers;
    let Some(reference) = &answers.reference else {
        let dim = Style::new().fg(model.theme.dim);
        let error = model.open_error.clone();
        let words = error.unwrap_or_else(|| model.without_ego());
        let text = Text::styled(crate::text::visible(&words).into_owned(), dim);
        scroll::text(f, inner, model, Pane::Verdict, text, Some(0));
        return;
    };
    let seen = seen(answers, room);
    let width = usize::from(inner.width).saturating_sub(LABEL + 1) / (seen.len() + 1);
    let mut table = Table {
        model,
        width,
        lines: vec![Line::default(); if differ(&answers.columns) { 9 } else { 7 }],
    };
    table.labels();
    for i in seen {
        let column = &answers.columns[i];
        let truth = column.truth.as_ref().unwrap_or(&reference.verdict);
        table.column(column, truth, answers.shown == Shown::Column(i));
    }
    table.reference(answers, &reference.verdict);
    let mut text = Text::from(table.lines);
    text.push_line("");
    text.extend(comment(model, reference));
    scroll::text(f, inner, model, Pane::Verdict, text, Some(0));
}

/// The answers that fit beside the built-in judge, the shown one among them.
fn seen(answers: &Answers, room: usize) -> std::ops::Range<usize> {
    let fit = (room.saturating_sub(LABEL) / NARROWEST)
        .saturating_sub(1)
        .max(1);
    let count = answers.columns.len();
    let last = match answers.shown {
        Shown::Column(i) if i + fit < count => i.max(fit - 1) + 1,
        _ => count,
    };
    last.saturating_sub(fit)..last
}

struct Table<'a> {
    model: &'a Model,
    width: usize,
    lines: Vec<Line<'static>>,
}

impl Table<'_> {
    fn labels(&mut self) {
        let key = self.model.task.key();
        let names = [
            "", key, "who", "risk", "steps", "tokens", "time", "frame", "how",
        ];
        for (line, name) in self.lines.iter_mut().zip(names) {
            let name = name.replace("safety_critical", "critical");
            line.push_span(Span::styled(
                pad(&name, LABEL),
                Style::new().fg(self.model.theme.dim),
            ));
        }
    }

    fn cell(&mut self, row: usize, text: &str, style: Style) {
        let cell = format!("{} ", pad(text, self.width.saturating_sub(1)));
        self.lines[row].push_span(Span::styled(cell, style));
    }

    fn head(&mut self, name: &str, shown: bool) {
        let theme = &self.model.theme;
        // The last column needs no gap behind it.
        let gap = usize::from(name != BUILT_IN);
        let name = short_model(name, self.width.saturating_sub(gap));
        let rest = " ".repeat(self.width.saturating_sub(name.width()));
        let style = if shown {
            theme
                .base()
                .add_modifier(Modifier::BOLD | Modifier::UNDERLINED)
        } else {
            Style::new().fg(theme.title)
        };
        self.lines[0].push_span(Span::styled(name, style));
        self.lines[0].push_span(Span::raw(rest));
    }

    fn reference(&mut self, answers: &Answers, verdict: &Verdict) {
        self.head(BUILT_IN, answers.shown == Shown::Reference);
        let base = self.model.theme.base();
        let color = if verdict.dangerous {
            self.model.theme.danger
        } else {
            self.model.theme.safe
        };
        self.cell(
            1,
            yes(verdict.dangerous),
            Style::new().fg(color).add_modifier(Modifier::BOLD),
        );
        let worst = verdict.worst();
        self.cell(2, &worst.map_or("–".into(), |w| w.id.to_string()), base);
        self.cell(
            3,
            &worst.map_or("–".into(), |w| w.risk_score.to_string()),
            base,
        );
        let step = self
            .model
            .window()
            .map_or("–".into(), |w| w.last().to_string());
        let steps = match verdict.task {
            crate::verdict::Task::Collision => "all".into(),
            _ => step,
        };
        self.cell(4, &steps, base);
        self.cell(5, "–", base);
        self.cell(6, &answers.reference_ms.map_or("–".into(), duration), base);
    }

    fn column(&mut self, column: &Column, truth: &Verdict, shown: bool) {
        let theme = &self.model.theme;
        let (base, dim) = (theme.base(), Style::new().fg(theme.dim));
        self.head(&column.model, shown);
        self.way(&column.how);
        let waiting = match &column.progress {
            Progress::Done(answer) => return self.answer(answer, column.steps, truth),
            Progress::Waiting(_) => "waiting…",
            Progress::Retrying(_) => "trying again…",
            Progress::Arriving(_) => "arriving…",
            Progress::Broken(_) => "no answer",
        };
        self.cell(1, waiting, dim);
        for row in 2..6 {
            let steps = steps(column.steps);
            self.cell(row, if row == 4 { &steps } else { "" }, base);
        }
        let time = match column.progress {
            Progress::Waiting(s) | Progress::Arriving(s) => format!("{s:.0} s"),
            _ => String::new(),
        };
        self.cell(6, &time, base);
    }

    /// Frame and techniques, where answers differ in them.
    fn way(&mut self, how: &str) {
        if self.lines.len() < 9 {
            return;
        }
        let (frame, techniques) = how.split_once(" · ").unwrap_or((how, ""));
        for (row, words) in [(7, frame), (8, techniques)] {
            let words = match words {
                "cartesian" => "cart",
                "cp+cot+icl" => "all",
                other => other,
            };
            let style = Style::new().fg(self.model.theme.dim);
            self.cell(row, &crate::text::visible(words), style);
        }
    }

    fn answer(&mut self, answer: &Answer, told: Option<(i64, i64)>, truth: &Verdict) {
        let theme = &self.model.theme;
        let (base, dim) = (theme.base(), Style::new().fg(theme.dim));
        let mark = |text: String, same: bool| {
            let color = if same { theme.safe } else { theme.danger };
            let sign = if same { "=" } else { "≠" };
            (
                format!("{text} {sign}"),
                Style::new().fg(color).add_modifier(Modifier::BOLD),
            )
        };
        match answer.verdict() {
            // The truth of the safety task is that of a window.
            Some(verdict) if told.is_none() && verdict.task == Task::Safety => {
                let worst = verdict.worst();
                self.cell(1, yes(verdict.dangerous), base);
                self.cell(2, &worst.map_or("–".into(), |w| w.id.to_string()), base);
                let score = worst.map(|w| w.risk_score);
                self.cell(3, &score.map_or("–".into(), |s| s.to_string()), base);
            }
            Some(verdict) => {
                let repaired = if answer.repairs().is_empty() { "" } else { "*" };
                let (text, style) = mark(
                    format!("{}{repaired}", yes(verdict.dangerous)),
                    verdict.dangerous == truth.dangerous,
                );
                self.cell(1, &text, style);
                let who = verdict.worst().map(|w| w.id);
                let same = !truth.dangerous || who == truth.worst().map(|w| w.id);
                let (text, style) = match who {
                    Some(id) if truth.dangerous => mark(id.to_string(), same),
                    Some(id) => (id.to_string(), base),
                    None => ("–".into(), base),
                };
                self.cell(2, &text, style);
                let score = verdict.worst().map(|w| w.risk_score);
                self.cell(3, &score.map_or("–".into(), |s| s.to_string()), base);
            }
            None => {
                let warning = Style::new().fg(theme.warning).add_modifier(Modifier::BOLD);
                self.cell(1, "no verdict", warning);
                self.cell(2, "–", base);
                self.cell(3, "–", base);
            }
        }
        let consumed = &answer.consumed;
        let recorded = answer.past.filter(|p| p.origin == Origin::Recorded);
        let tokens = match (consumed.input_tokens, consumed.output_tokens) {
            _ if recorded.is_some() => "recorded".into(),
            (Some(i), Some(o)) => format!("{}+{}", thousands(i), thousands(o)),
            _ => "unknown".into(),
        };
        self.cell(4, &steps(told), dim);
        self.cell(5, &tokens, dim);
        self.cell(6, &consumed.duration_ms.map_or("–".into(), duration), dim);
    }
}

/// Whether not all were asked in the same way.
fn differ(columns: &[Column]) -> bool {
    columns.windows(2).any(|pair| pair[0].how != pair[1].how)
}

fn steps(told: Option<(i64, i64)>) -> String {
    told.map_or("unknown".into(), |(first, last)| format!("{first}–{last}"))
}

/// Whence an answer of the store.
fn stored(past: &Past, run: Option<RunId>) -> String {
    let run = run.map_or("of the store".into(), |run| {
        format!("run {run} of the store")
    });
    let at = date(past.created_ms);
    match past.origin {
        Origin::Asked => format!("{run}, asked {at}"),
        Origin::Replayed => format!("{run}, replayed: asked {at} elsewhere"),
        Origin::Recorded => format!("{run}, recorded by others"),
    }
}

fn yes(dangerous: bool) -> &'static str {
    if dangerous { "yes" } else { "no" }
}

/// What the shown answer says, and what is to be known about it.
fn comment(model: &Model, reference: &judge::Judgement) -> Text<'static> {
    let theme = &model.theme;
    let warning = Style::new().fg(theme.warning);
    let words = |s: &str| crate::text::visible(s).into_owned();
    let mut text = Text::default();
    match model.answers.column() {
        None => {
            text.extend(Text::styled(
                words(&reference.verdict.justification),
                theme.base(),
            ));
            if model.answers.columns.is_empty() {
                let hint = "m chooses a language model, r asks it, c adds another one to compare";
                text.push_line("");
                text.push_line(Line::styled(hint, Style::new().fg(theme.dim)));
            }
        }
        Some(column) => match column.answer() {
            Some(answer) => {
                if let Some(past) = &answer.past {
                    let words = stored(past, answer.run);
                    text.push_line(Line::styled(words, Style::new().fg(theme.dim)));
                }
                if answer.model_differs() {
                    let returned = answer.model_returned.as_deref().unwrap_or_default();
                    text.push_line(Line::styled(
                        words(&format!("answered by {returned}")),
                        warning,
                    ));
                }
                let scenario = model.opened.as_ref().map(|o| &o.scenario);
                let unknown = scenario.map_or(Vec::new(), |s| answer.unknown_obstacles(s));
                if !unknown.is_empty() {
                    let note = format!("names obstacles that are not there: {unknown:?}");
                    text.push_line(Line::styled(note, warning));
                }
                if !answer.repairs().is_empty() {
                    let notes = format!("* repaired: {}", answer.repairs().join("; "));
                    text.push_line(Line::styled(words(&notes), warning));
                }
                match &answer.judged {
                    Judged::Verdict(parsed) => {
                        text.extend(Text::styled(
                            words(&parsed.verdict.justification),
                            theme.base(),
                        ));
                    }
                    Judged::Other(reading) => {
                        text.extend(Text::styled(
                            words(reading.said.justification()),
                            theme.base(),
                        ));
                    }
                    Judged::Missing(missing) => {
                        text.push_line(Line::styled(words(&missing.to_string()), warning));
                    }
                }
            }
            None => {
                if let Progress::Broken(why) | Progress::Retrying(why) = &column.progress {
                    text.push_line(Line::styled(words(why), warning));
                }
            }
        },
    }
    text
}

/// A model's id in so many columns: whole, or without its provider, and then with its beginning, which tells models
/// apart. The title of the reasoning has it whole.
fn short_model(id: &str, width: usize) -> String {
    match id.split_once('/') {
        Some((_, model)) if id.width() > width => fit(model, width),
        _ => fit(id, width),
    }
}
