//! Draws the results screen: the matrix and bars by technique, the answers of a cell, or the choice of answers.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use super::{answers, bars, choice, matrix};
use crate::action::{Action, Scope};
use crate::model::{Model, ResultsDrawn, ResultsView};
use crate::widgets::words::thousands;
use crate::widgets::{hints, window};
use nearmiss_scene::description::visible;
use nearmiss_study::evaluation::Spending;
use nearmiss_study::evaluation::batch::AnswerSet;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    let body = window::whole(frame, screen, model);
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
            let height = u16::try_from(rows.len() + 2)
                .unwrap_or(u16::MAX)
                .min(body.height / 2);
            let [above, below] =
                Layout::vertical([Constraint::Min(0), Constraint::Length(height)]).areas(body);
            let mut drawn = matrix::draw(frame, above, model, &title_in(results, above.width));
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
    let inner = window::window_at(frame, body, model, &title_in(results, body.width));
    let key = model.look.key(Action::ChooseCounted);
    let words = match (&results.error, results.reading, results.counting) {
        (Some(error), ..) => error.clone(),
        (None, true, _) => "reading the store…".into(),
        (None, false, Some(counting)) if results.locked.is_some() => format!(
            "{counting}: {}: its figures are shown when all of it is answered; {key} selects other answers",
            results.locked.as_deref().unwrap_or_default()
        ),
        (None, false, Some(counting @ AnswerSet::Batch(..))) => format!(
            "{counting} has no answers yet ({} not asked); {key} selects other answers",
            results.unasked
        ),
        (None, false, _) => {
            let key = model.look.key(Action::Run);
            format!(
                "no model has been asked yet; {key} on the main screen asks one, `nearmiss runs import` reads recorded answers"
            )
        }
    };
    let text = Paragraph::new(visible(&words).into_owned()).wrap(Wrap { trim: true });
    frame.render_widget(text.style(Style::new().fg(model.theme.dim)), inner);
}

/// Which answers are counted, and what they are compared with where that fits; else it stands below the table.
fn title_in(results: &ResultsView, width: u16) -> String {
    let whole = title(results);
    let truth = format!(" · truth: {}", visible(&results.truth_words()));
    if whole.width() + CORNERS > usize::from(width) {
        whole.replacen(&truth, "", 1)
    } else {
        whole
    }
}

/// Which answers are counted, and what they are compared with.
fn title(results: &ResultsView) -> String {
    let count: usize = results.rows.iter().map(|row| row.answers.len()).sum();
    let counting = results
        .counting
        .map_or(String::new(), |c| format!("{c} · "));
    let truth = if results.rows.is_empty() {
        String::new()
    } else {
        format!(" · truth: {}", visible(&results.truth_words()))
    };
    let reading = if results.reading && results.judging.is_none() {
        " …"
    } else {
        ""
    };
    let answers = match count {
        1 => "1 answer".into(),
        n => format!("{} answers", thousands(n as u64)),
    };
    format!("results · {counting}{answers}{truth}{reading}")
}

/// What the answers cost, every attempt included; nothing where no cost is known.
fn cost(results: &ResultsView) -> Option<String> {
    let mut sum = Spending::default();
    let rows = results.rows.iter();
    rows.for_each(|row| sum.join(&row.spending));
    let usd = sum.cost().filter(|usd| *usd > 0.0)?;
    Some(match sum.unpriced() {
        0 => format!("cost ${usd:.4}"),
        n => format!("cost ${usd:.4}, and {n} of unknown cost"),
    })
}

/// Columns of the corners, and of the spaces in them.
const CORNERS: usize = 4;

/// The lines below a table: progress, what is left out, what the columns mean, and those without room, which appear
/// when they are selected; gives what is above them.
pub fn foot(frame: &mut Frame<'_>, area: Rect, model: &Model, hidden: &[&str]) -> Rect {
    let results = &model.results;
    let mut words = Vec::new();
    // In the matrix the title says it, where it fits.
    let inside = results.inside.is_some();
    if inside || title(results).width() + CORNERS > usize::from(area.width) {
        words.push(format!("truth: {}", visible(&results.truth_words())));
    }
    if let Some(counting) = results.counting.filter(|_| inside) {
        words.push(format!("of {counting}"));
    }
    match results.judging {
        Some((done, of)) if of > 0 => {
            words.push(format!("judging… {done} of {of} scenes; counts follow"))
        }
        Some(_) => words.push("judging…; counts follow".into()),
        None => {}
    }
    match results.unasked {
        0 => {}
        1 => words.push("1 question not asked, not counted".into()),
        n => words.push(format!("{n} questions not asked, not counted")),
    }
    words.extend(cost(results));
    if !inside {
        words.push("= right, ≠ wrong: t/f true or false, p/n yes or no".into());
    }
    if !hidden.is_empty() {
        let keys = [Action::CellLeft, Action::CellRight];
        let (keys, _) = hints::pair(model, Scope::Results, keys, "");
        words.push(format!("{keys} more: {}", hidden.join(", ")));
    }
    let text = Paragraph::new(words.join(" · "))
        .style(Style::new().fg(model.theme.dim))
        .wrap(Wrap { trim: true });
    let lines = u16::try_from(text.line_count(area.width))
        .unwrap_or(u16::MAX)
        .min(area.height.saturating_sub(2) / 2);
    let [above, below] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(lines)]).areas(area);
    frame.render_widget(text, below);
    above
}
