//! Verdicts side by side, the built-in judge last; differences from it are marked.

mod heads;
mod other;
mod probabilities;
mod table;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span, Text};
use unicode_width::UnicodeWidthStr;

use self::table::{LABEL, Row, Table};
use crate::action::Action;
use crate::model::{Answers, Column, Model, Pane, Progress, ShownAnswer, parts};
use crate::widgets::words::date;
use crate::widgets::{frame, scroll};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Origin, RunId};
use nearmiss_study::evaluation::{JudgeOutcome, StoredOrigin};

/// Columns that an answer needs.
const NARROWEST: usize = 8;

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let mut title = Line::from(format!("verdict · {}", model.task.name()));
    if let Some(steps) = model.short_window() {
        let words = format!(" · {steps}-step window");
        title.push_span(Span::styled(words, Style::new().fg(model.theme.warning)));
    }
    // Inside the border, without the column of the scroll bar.
    let room = usize::from(area.width).saturating_sub(3);
    let seen_now = seen(&model.answers, room);
    if let (Some(first), Some(last)) = (seen_now.clone().min(), seen_now.clone().max()) {
        let all = model.answers.columns.len();
        let (first, last) = (first + 1, last + 1);
        let key = |action| model.look.key(action);
        let keys = format!(
            "{} {}",
            key(Action::PreviousAnswer),
            key(Action::NextAnswer)
        );
        // Inside the corners, with a space on both sides.
        let left = usize::from(area.width).saturating_sub(4 + title.width());
        let hints = if seen_now.len() != all {
            [
                format!(" · answers {first}–{last} of {all}, {keys} others"),
                format!(" · {first}–{last}/{all} {keys}"),
                format!(" · {first}–{last} of {all}"),
            ]
        } else if all == 1 {
            [String::new(), String::new(), String::new()]
        } else {
            [
                format!(" · {keys} select answer"),
                format!(" · {keys}"),
                String::new(),
            ]
        };
        let hint = hints
            .into_iter()
            .find(|hint| hint.width() <= left)
            .unwrap_or_default();
        title.push_span(Span::styled(hint, Style::new().fg(model.theme.dim)));
    }
    let inner = frame::pane(f, area, model, Pane::Verdict, title);
    let answers = &model.answers;
    let draw = |f: &mut Frame<'_>, text| {
        scroll::text(
            f,
            inner,
            model,
            Pane::Verdict,
            text,
            Some(answers.verdict_top),
        );
    };
    let other = matches!(model.task, Task::Attacker | Task::Trajectory);
    if other && model.scene().is_some() {
        let text = without_reference(model, seen_now, usize::from(inner.width));
        draw(f, text);
        return;
    }
    let reference = answers.reference.as_ref();
    if !model.has_reference() {
        let dim = Style::new().fg(model.theme.dim);
        let error = model.open_error.clone();
        let words = error.unwrap_or_else(|| model.without_ego());
        let text = Text::styled(
            nearmiss_scene::description::visible(&words).into_owned(),
            dim,
        );
        draw(f, text);
        return;
    }
    let verdict = reference.map(|r| &r.verdict);
    let seen = seen(answers, room);
    let rows = Row::visible(
        differ(&answers.columns),
        probabilities::known(
            probabilities::verdicts(&answers.columns[seen.clone()]).chain(verdict),
        ),
        answers.columns[seen.clone()]
            .iter()
            .any(|c| other_window(model, c)),
        answers.reference_ms.is_some() || answers.columns[seen.clone()].iter().any(is_measured),
    );
    let mut table = Table::new(model, rows);
    let ids: Vec<&str> = answers.columns[seen.clone()]
        .iter()
        .map(|c| c.model.as_str())
        .collect();
    // A gap behind each; the last column, the built-in judge's, needs none.
    let room = usize::from(inner.width).saturating_sub(LABEL + 1);
    let widths = heads::widths(&ids, Some(NARROWEST), NARROWEST, room);
    let heads = of_models(&ids, &widths);
    for ((i, head), width) in seen.zip(&heads).zip(&widths) {
        let column = &answers.columns[i];
        let truth = column.truth_or(verdict);
        table.set_width(*width);
        table.column(column, head, truth, answers.shown == ShownAnswer::Column(i));
    }
    table.set_width(widths.last().copied().unwrap_or(NARROWEST));
    table.reference(answers, verdict);
    let mut text = Text::from(table.lines());
    text.push_line("");
    text.extend(comment(model, reference));
    draw(f, text);
}

/// Answers to a task about which the built-in judge says nothing.
fn without_reference(model: &Model, seen: std::ops::Range<usize>, room: usize) -> Text<'static> {
    let answers = &model.answers;
    let dim = Style::new().fg(model.theme.dim);
    if seen.is_empty() {
        let hint = format!(
            "only language models answer this task: {} chooses one, {} asks it",
            model.look.key(Action::ChooseModel),
            model.look.key(Action::Run)
        );
        return Text::styled(hint, dim);
    }
    let measured = answers.columns[seen.clone()].iter().any(is_measured);
    let rows = Row::visible(differ(&answers.columns), (false, false), false, measured);
    let mut table = Table::new(model, rows);
    let ids: Vec<&str> = answers.columns[seen.clone()]
        .iter()
        .map(|c| c.model.as_str())
        .collect();
    let widths = heads::widths(&ids, None, NARROWEST, room.saturating_sub(LABEL + 1));
    let heads = of_models(&ids, &widths);
    for ((i, head), width) in seen.zip(&heads).zip(&widths) {
        let shown = answers.shown == ShownAnswer::Column(i);
        table.set_width(*width);
        table.column(&answers.columns[i], head, None, shown);
    }
    let mut text = Text::from(table.lines());
    text.push_line("");
    text.extend(of_column(model));
    text
}

/// The heads of answers, with a gap behind each.
fn of_models(ids: &[&str], widths: &[usize]) -> Vec<String> {
    let rooms = widths.iter().map(|width| width.saturating_sub(1));
    heads::heads(ids, &rooms.collect::<Vec<_>>())
}

/// The answers that fit beside the built-in judge, the shown one among them.
fn seen(answers: &Answers, room: usize) -> std::ops::Range<usize> {
    let fit = (room.saturating_sub(LABEL) / NARROWEST)
        .saturating_sub(1)
        .max(1);
    let count = answers.columns.len();
    let wanted = match answers.shown {
        ShownAnswer::Column(i) => (i + 1).max(fit),
        ShownAnswer::Reference => fit,
    };
    let last = wanted.min(count);
    last.saturating_sub(fit)..last
}

/// Whether not all were asked from the same frame with the same techniques, and whether not all with the same prompt.
fn differ(columns: &[Column]) -> (bool, bool) {
    let ways = columns.iter().map(|c| parts(&c.how));
    let ways: Vec<_> = ways.collect();
    let pairs = || ways.windows(2).map(|pair| (pair[0], pair[1]));
    (
        pairs().any(|(a, b)| (a.0, a.1) != (b.0, b.1)),
        pairs().any(|(a, b)| a.2 != b.2),
    )
}

/// Whether time or tokens of an answer are known, or still being counted: recorded answers have neither.
fn is_measured(column: &Column) -> bool {
    column.answer().is_none_or(|answer| {
        let consumed = &answer.consumed;
        consumed.duration_ms.or(consumed.output_tokens).is_some()
    })
}

/// Whether the built-in judge's column is about another window than the answer.
fn other_window(model: &Model, column: &Column) -> bool {
    let now = model.window().map(|w| (w.first(), w.last()));
    model.task == Task::Safety && column.steps.is_some() && column.steps != now
}

/// Whence an answer of the store.
fn stored(past: &StoredOrigin, run: Option<RunId>) -> String {
    let run = run.map_or("stored".into(), |run| format!("run {run}"));
    let at = date(past.created_ms);
    match past.origin {
        Origin::Asked => format!("{run}, asked {at}"),
        Origin::Replayed => format!("{run}, replayed: asked {at} elsewhere"),
        Origin::Recorded => format!("{run}, recorded by others"),
    }
}

/// The comment of the built-in judge or the shown answer.
fn comment(model: &Model, reference: Option<&judge::Judgement>) -> Text<'static> {
    let theme = &model.theme;
    let words = |s: &str| nearmiss_scene::description::visible(s).into_owned();
    match model.answers.column() {
        None => {
            let mut text = Text::default();
            let dim = Style::new().fg(theme.dim);
            text.extend(reference.and_then(|r| probabilities::critical(&r.verdict, dim)));
            let justification = reference.map_or("judging…", |r| &r.verdict.justification);
            text.extend(Text::styled(words(justification), theme.base()));
            if model.answers.columns.is_empty() {
                let key = |action| model.look.key(action);
                let hint = format!(
                    "{} chooses a language model, {} asks it, {} asks another one",
                    key(Action::ChooseModel),
                    key(Action::Run),
                    key(Action::Compare)
                );
                text.push_line("");
                text.push_line(Line::styled(hint, Style::new().fg(theme.dim)));
            }
            text
        }
        Some(_) => of_column(model),
    }
}

/// The shown answer's comment, and notes on it.
fn of_column(model: &Model) -> Text<'static> {
    let theme = &model.theme;
    let warning = Style::new().fg(theme.warning);
    let words = |s: &str| nearmiss_scene::description::visible(s).into_owned();
    let mut text = Text::default();
    match model.answers.column() {
        None => {}
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
                for flag in scenario.map_or(Vec::new(), |s| answer.flags(s)) {
                    text.push_line(Line::styled(format!("doubtful: {flag}"), warning));
                }
                if !answer.repairs().is_empty() {
                    let notes = format!("* repaired: {}", answer.repairs().join("; "));
                    text.push_line(Line::styled(words(&notes), warning));
                }
                match &answer.judged {
                    JudgeOutcome::Verdict(parsed) => {
                        let dim = Style::new().fg(theme.dim);
                        text.extend(probabilities::critical(&parsed.verdict, dim));
                        text.extend(Text::styled(
                            words(&parsed.verdict.justification),
                            theme.base(),
                        ));
                    }
                    JudgeOutcome::Other(reading) => {
                        text.extend(other::text(model, &reading.said));
                    }
                    JudgeOutcome::Missing(missing) => {
                        text.push_line(Line::styled(words(&missing.to_string()), warning));
                    }
                }
            }
            None => {
                if let Progress::Unasked(why) | Progress::Broken(why) | Progress::Retrying(why) =
                    &column.progress
                {
                    text.push_line(Line::styled(words(why), warning));
                }
            }
        },
    }
    text
}
