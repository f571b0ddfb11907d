//! The answers behind a cell of the matrix.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use unicode_width::UnicodeWidthStr;

use super::draw;
use super::matrix::{HEADS, NAMES, asked, model_name, version};
use crate::model::{Model, ResultsDrawn};
use crate::widgets::window;
use crate::widgets::words::pad;
use nearmiss_scene::description::visible;
use nearmiss_study::evaluation::{AnswerOutcome, Outcome};

/// Columns of the outcome in a word.
const WORD: usize = 11;

/// Columns of what an answer says.
const WHAT: usize = 30;

/// Draws them; gives where the list stands.
pub fn draw(frame: &mut Frame<'_>, area: Rect, model: &Model, selected: usize) -> ResultsDrawn {
    let results = &model.results;
    let all = results.answers();
    let cell = results.column.min(HEADS.len() - 1);
    let title = results.row().map_or(String::new(), |row| {
        let (how, head) = (asked(&row.configuration).join(" "), HEADS[cell]);
        let version =
            version(&row.configuration).map_or(String::new(), |words| format!(" · {words}"));
        let model = model_name(&row.configuration);
        format!("{model} · {how}{version} · {head} {}", all.len())
    });
    let inner = window::window_at(frame, area, model, &title);
    let list = draw::foot(frame, inner, model, &[]);
    let rows = usize::from(list.height);
    let top = selected
        .saturating_sub(rows / 2)
        .min(all.len().saturating_sub(rows));
    let shown = all.iter().enumerate().skip(top).take(rows);
    let tails = all.iter().map(|answer| tail(answer).width());
    let tail = tails.max().unwrap_or(0);
    let lines = shown.map(|(place, answer)| {
        let chosen = place == selected;
        let line = line(model, answer, chosen, usize::from(list.width), tail);
        if chosen {
            model.theme.select(line)
        } else {
            line.style(model.theme.base())
        }
    });
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), list);
    ResultsDrawn {
        list,
        top,
        ..ResultsDrawn::default()
    }
}

/// The run of an answer, and which of several it is.
fn tail(answer: &AnswerOutcome) -> String {
    let sample = match answer.sample {
        0 => String::new(),
        n => format!(" sample {n}"),
    };
    let run = answer
        .run
        .map_or("no run".into(), |run| format!("run {run}"));
    let claims = claims(answer);
    format!("{claims}  {run}{sample}")
}

/// An answer; `tails` is the width of the widest of what stands last.
fn line(
    model: &Model,
    answer: &AnswerOutcome,
    chosen: bool,
    width: usize,
    tails: usize,
) -> Line<'static> {
    let theme = &model.theme;
    let (word, what) = said(answer);
    let color = match answer.outcome.is_right() {
        Some(true) => theme.agree,
        Some(false) => theme.disagree,
        None => theme.warning,
    };
    let rest = width.saturating_sub(2 + WORD + tails);
    let what_width = WHAT.min(rest / 2);
    let name_width = (rest - what_width).min(NAMES);
    Line::from(vec![
        Span::raw(if chosen { "▸ " } else { "  " }),
        Span::styled(
            pad(word, WORD),
            Style::new().fg(color).add_modifier(Modifier::BOLD),
        ),
        Span::raw(pad(
            &visible(&answer.scenario),
            name_width.saturating_sub(1),
        )),
        Span::raw(" "),
        Span::raw(pad(what, what_width)),
        Span::styled(tail(answer), Style::new().fg(theme.dim)),
    ])
}

/// Its claims about obstacles: right, wrong and open; nothing where there are none or they were not checked.
fn claims(answer: &AnswerOutcome) -> String {
    match answer.claims.known() {
        None | Some([0, 0, 0]) => String::new(),
        Some([right, wrong, open]) => format!("  claims {right}= {wrong}≠ {open}?"),
    }
}

fn said(answer: &AnswerOutcome) -> (&'static str, &'static str) {
    match answer.outcome {
        Outcome::TruePositive if answer.naming.windows > answer.naming.found => {
            ("= right", "yes, obstacle not named")
        }
        Outcome::TruePositive => ("= right", "says yes"),
        Outcome::TrueNegative => ("= right", "says no"),
        Outcome::FalsePositive => ("≠ wrong", "says yes, truth is no"),
        Outcome::FalseNegative => ("≠ wrong", "says no, truth is yes"),
        Outcome::Open => ("no truth", "nothing to compare with"),
        Outcome::Unparsed => ("no verdict", "none could be read"),
        Outcome::Failed => ("failed", "no complete answer"),
    }
}
