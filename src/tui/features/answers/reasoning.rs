//! Reasoning and answer of one judge, streamed.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Text};
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::action::Action;
use crate::model::{Column, Model, Pane, Progress};
use crate::widgets::highlight::markdown;
use crate::widgets::long_text::MarkedClaims;
use crate::widgets::row::{self, PageSection};
use crate::widgets::words::{fit_end, whole_parts};
use crate::widgets::{claimed, unbroken, window};
use nearmiss_scene::judge;
use nearmiss_study::evaluation::{JudgeOutcome, MissingVerdict, tool_rounds};

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let theme = &model.theme;
    let title = match model.answers.column() {
        None => format!("reasoning · {}", judge::NAME),
        Some(column) => {
            let state = state(column);
            // The border's corners, and two spaces.
            let inside = usize::from(area.width).saturating_sub(4);
            let name = fit_end(&column.model, inside.saturating_sub("reasoning · ".width()));
            whole_parts(["reasoning", &name, &state, &column.how], inside)
        }
    };
    // How it was asked stands in the title, or where that has no room for it below the text.
    let column = model.answers.column();
    let below = column.filter(|column| !title.ends_with(&column.how));
    let how = below.map(|column| column.how.clone());
    let inner = window::pane(f, area, model, Pane::Reasoning, Line::from(title));
    let document = model.document(model.answers.shown);
    let marks = document
        .as_ref()
        .map_or_else(MarkedClaims::default, |d| model.claims.marks(d.key));
    let inner = claims(f, inner, model, &marks);
    let mut readings = model.drawn.readings.borrow_mut();
    let said = document.as_ref().map(|document| {
        let reading = readings.answer(model.answers.shown);
        reading.show_as(model.reading_mode());
        PageSection::Text(reading, &document.text, marks)
    });
    let parts = match model.answers.column() {
        None => said.map_or_else(|| unjudged(model), |said| vec![said]),
        Some(column) => answer(model, column, said, how),
    };
    let extent = row::page(
        f,
        inner,
        model,
        Pane::Reasoning,
        parts,
        model.answers.scroll,
    );
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

/// Rows from which on the picked claim stands below the text with all that is known about it.
const ROOM_FOR_CLAIM: u16 = 6;

/// Below the text: the picked claim, or how many there are; gives what is left for the text.
fn claims(f: &mut Frame<'_>, inner: Rect, model: &Model, marks: &MarkedClaims<'_>) -> Rect {
    let claims = marks.claims;
    let picked = marks.picked.and_then(|place| claims.get(place));
    let least = if picked.is_some() { 2 } else { ROOM_FOR_CLAIM };
    if claims.is_empty() && marks.unread.is_empty() || inner.height < least {
        return inner;
    }
    // The text keeps two lines.
    let most = inner.height.saturating_sub(2).clamp(1, 3);
    let line = match picked {
        Some(claim) if inner.height < ROOM_FOR_CLAIM => {
            let line = claimed::short_line(claim, &model.theme);
            claimed::cut(line, usize::from(inner.width) * usize::from(most))
        }
        Some(claim) => claimed::line(claim, &model.theme),
        None => {
            let summary = claimed::summary(claims, marks.unread.len());
            let with_keys = format!("{summary} · ( ) next");
            // The keys take no row of their own.
            let alone = (summary.width()..with_keys.width()).contains(&usize::from(inner.width));
            let words = if alone { summary } else { with_keys };
            Line::styled(words, Style::new().fg(model.theme.dim))
        }
    };
    let words = Paragraph::new(unbroken::line(line)).wrap(Wrap { trim: true });
    let rows = u16::try_from(words.line_count(inner.width))
        .unwrap_or(1)
        .clamp(1, most);
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

/// Why the built-in judge says nothing.
fn unjudged(model: &Model) -> Vec<PageSection<'static>> {
    let words = model
        .open_error
        .clone()
        .unwrap_or_else(|| why_unjudged(model));
    let text = markdown(&words, &model.theme);
    text.lines.into_iter().map(PageSection::Line).collect()
}

fn why_unjudged(model: &Model) -> String {
    if model.scene().is_none() {
        // How to get an ego, the verdicts say.
        return if model.awaits_ego() {
            format!("nothing to judge yet: {}", model.without_ego())
        } else {
            "nothing to judge without an ego".into()
        };
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
        Progress::Retrying(_) => "retrying".into(),
        Progress::Arriving(seconds) => format!("streaming {seconds:.0} s"),
        Progress::Done(answer)
            if matches!(
                answer.judged,
                JudgeOutcome::Missing(MissingVerdict::NotSent(_))
            ) =>
        {
            "not sent".into()
        }
        Progress::Done(_) if column.failed() => "no answer".into(),
        Progress::Done(answer) => answer.verdict_label(),
        Progress::Unasked(_) => "not sent".into(),
        Progress::Broken(_) => "no answer".into(),
    }
}

fn answer<'a>(
    model: &Model,
    column: &Column,
    text: Option<PageSection<'a>>,
    how: Option<String>,
) -> Vec<PageSection<'a>> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let mut parts = Vec::new();
    let in_color = |words: &str, color| {
        let words = nearmiss_scene::description::visible(words).into_owned();
        let text = Text::styled(words, Style::new().fg(color));
        let style = text.style;
        text.lines
            .into_iter()
            .map(move |line| PageSection::Line(line.patch_style(style)))
    };
    let said = !column.text.is_empty() || !column.reasoning.is_empty();
    parts.extend(tool_calls(model, column));
    if said {
        parts.extend(text);
    }
    if let Some(why) = why_missing(column) {
        if said {
            parts.push(PageSection::Line(Line::default()));
        }
        parts.extend(in_color(&why, theme.danger));
    }
    match &column.progress {
        Progress::Retrying(why) => parts.extend(in_color(why, theme.warning)),
        Progress::Waiting(_) if !said => {
            let words = "question sent, waiting for the answer…";
            parts.push(PageSection::Line(Line::styled(words, dim)));
        }
        _ => {}
    }
    if let Some(how) = how {
        parts.push(PageSection::Line(Line::default()));
        parts.push(PageSection::Line(Line::styled(how, dim)));
    }
    parts
}

/// The tools that were called: in a line, or unfolded each with its result, as JSON is.
fn tool_calls<'a>(model: &Model, column: &Column) -> Vec<PageSection<'a>> {
    let rounds = &column.tool_rounds;
    if rounds.is_empty() {
        return Vec::new();
    }
    let dim = Style::new().fg(model.theme.dim);
    let calls = tool_rounds::rounds_summary(rounds, "tool call");
    let mode = model.reading_mode();
    let line = |words: String| {
        let words = nearmiss_scene::description::visible(&words).into_owned();
        PageSection::Line(Line::styled(words, dim))
    };
    let mut parts = Vec::new();
    if mode.unfold || mode.raw {
        parts.push(line(format!("▾ {calls}")));
        for (number, round) in rounds.iter().enumerate() {
            let lines = tool_rounds::lines(round).into_iter();
            parts.extend(lines.map(|words| line(format!("  {}  {words}", number + 1))));
        }
    } else {
        parts.push(line(format!("▸ {calls}{}", mode.hint)));
    }
    parts.push(PageSection::Line(Line::default()));
    parts
}

/// Why there is no verdict, once that is known.
fn why_missing(column: &Column) -> Option<String> {
    match &column.progress {
        Progress::Done(answer) => match &answer.judged {
            JudgeOutcome::Missing(missing) => Some(missing.to_string()),
            JudgeOutcome::Verdict(_) | JudgeOutcome::Other(_) => None,
        },
        Progress::Unasked(why) | Progress::Broken(why) => Some(why.clone()),
        _ => None,
    }
}
