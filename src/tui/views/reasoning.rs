//! The reasoning and the answer of one judge, as they arrive.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};
use ratatui::widgets::{Paragraph, Wrap};

use crate::evaluation::{Judged, Missing};
use crate::tui::action::Action;
use crate::tui::model::{Column, Model, Pane, Progress};
use crate::tui::widgets::highlight::markdown;
use crate::tui::widgets::words::fit_end;
use crate::tui::widgets::{claimed, frame, scroll};

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let theme = &model.theme;
    let (title, text) = match model.answers.column() {
        None => ("reasoning · built-in".to_string(), reference(model)),
        Some(column) => {
            let name = fit_end(&column.model, usize::from(area.width).saturating_sub(28));
            (
                format!("reasoning · {name} · {}", state(column)),
                answer(model, column),
            )
        }
    };
    let inner = frame::pane(f, area, model, Pane::Reasoning, Line::from(title));
    let inner = claims(f, inner, model);
    let extent = scroll::text(f, inner, model, Pane::Reasoning, text, model.answers.scroll);
    let below = extent.lines.saturating_sub(extent.top + extent.rows);
    let running = model.answers.column().is_some_and(Column::is_running);
    if running && model.answers.scroll.is_some() && below > 0 {
        let words = format!(" {below} new lines below, G follows ");
        let line = Line::styled(
            words,
            Style::new()
                .fg(theme.accent)
                .add_modifier(Modifier::REVERSED),
        );
        let row = Rect {
            y: inner.bottom().saturating_sub(1),
            height: 1,
            ..inner
        };
        f.render_widget(line.right_aligned(), row);
    }
}

/// What the shown answer says, with its claims marked.
fn said_text(model: &Model) -> Text<'static> {
    let Some(document) = model.document(model.answers.shown) else {
        return Text::default();
    };
    let claims = model.claims.of(document.key);
    let picked = model.claims.picked_of(document.key);
    claimed::text(&document.text, claims, picked, &model.theme).0
}

/// Below the text: the picked claim, or how many there are; gives what is left for the text.
fn claims(f: &mut Frame<'_>, inner: Rect, model: &Model) -> Rect {
    let Some(document) = model.document(model.answers.shown) else {
        return inner;
    };
    let claims = model.claims.of(document.key);
    if claims.is_empty() || inner.height < 6 {
        return inner;
    }
    let picked = model
        .claims
        .picked_of(document.key)
        .and_then(|place| claims.get(place));
    let line = match picked {
        Some(claim) => claimed::line(claim, &model.theme),
        None => Line::styled(
            format!("{} · ( ) go to them", claimed::summary(claims)),
            Style::new().fg(model.theme.dim),
        ),
    };
    let words = Paragraph::new(line).wrap(Wrap { trim: true });
    let rows = u16::try_from(words.line_count(inner.width))
        .unwrap_or(1)
        .clamp(1, 3);
    let below = Rect {
        y: inner.bottom() - rows,
        height: rows,
        ..inner
    };
    f.render_widget(words, below);
    Rect {
        height: inner.height - rows,
        ..inner
    }
}

fn reference(model: &Model) -> Text<'static> {
    match &model.answers.reference {
        Some(_) => said_text(model),
        None => {
            let words = model.open_error.clone().unwrap_or_else(|| unjudged(model));
            markdown(&words, &model.theme)
        }
    }
}

/// Why the built-in judge says nothing.
fn unjudged(model: &Model) -> String {
    if model.scene().is_none() {
        return format!("nothing to judge yet: {}", model.without_ego());
    }
    format!(
        "the built-in judge does not answer the {} task: {} chooses a language model, {} asks it",
        model.task.name(),
        model.look.key(Action::ChooseModel),
        model.look.key(Action::Run)
    )
}

fn state(column: &Column) -> String {
    match &column.progress {
        Progress::Waiting(seconds) => format!("waiting {seconds:.0} s"),
        Progress::Retrying(_) => "trying again".into(),
        Progress::Arriving(seconds) => format!("arriving {seconds:.0} s"),
        Progress::Done(answer) if matches!(answer.judged, Judged::Missing(Missing::NotSent(_))) => {
            "not sent".into()
        }
        Progress::Done(_) if column.failed() => "no answer".into(),
        Progress::Done(answer) => answer.word(),
        Progress::Unasked(_) => "not sent".into(),
        Progress::Broken(_) => "no answer".into(),
    }
}

fn answer(model: &Model, column: &Column) -> Text<'static> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let mut text = Text::default();
    let said = !column.text.is_empty() || !column.reasoning.is_empty();
    // Where nothing was said, the reason is what there is to read: it comes first.
    if !column.how.is_empty() && (said || why_missing(column).is_none()) {
        text.push_line(Line::styled(column.how.clone(), dim));
        text.push_line("");
    }
    if said {
        text.extend(said_text(model));
    }
    if let Some(why) = why_missing(column) {
        if said {
            text.push_line("");
        }
        let why = crate::text::visible(&why).into_owned();
        text.extend(Text::styled(why, Style::new().fg(theme.danger)));
        if !said {
            text.push_line(Line::styled(column.how.clone(), dim));
        }
    }
    match &column.progress {
        Progress::Retrying(why) => {
            text.extend(Text::styled(
                crate::text::visible(why).into_owned(),
                Style::new().fg(theme.warning),
            ));
        }
        Progress::Waiting(_) if !said => {
            text.push_line(Line::styled("the question is on its way…", dim));
        }
        _ => {}
    }
    text
}

/// Why there is no verdict, once that is known.
fn why_missing(column: &Column) -> Option<String> {
    match &column.progress {
        Progress::Done(answer) => match &answer.judged {
            Judged::Missing(missing) => Some(missing.to_string()),
            Judged::Verdict(_) | Judged::Other(_) => None,
        },
        Progress::Unasked(why) | Progress::Broken(why) => Some(why.clone()),
        _ => None,
    }
}
