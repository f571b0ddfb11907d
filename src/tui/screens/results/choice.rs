//! Picker for what to count: batches with their own ground truth, or all answers.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

use crate::model::{Model, ResultsDrawn};
use crate::widgets::window;
use crate::widgets::words::{date, fit, pad, thousands};
use nearmiss_scene::description::visible;
use nearmiss_study::evaluation::batch::CountingChoice;
use nearmiss_workflow::TruthChoice;

/// Columns of the window, and of what stands in a line of it.
const COLUMNS: u16 = 116;
const NAME: usize = 32;

/// Columns for the truth at least: with fewer it stands below the list alone.
const LEAST: usize = 16;

/// Lines below the list, for the truth of the selected line.
const TRUTH: u16 = 3;

/// Draws the list; gives where it stands.
pub fn draw(frame: &mut Frame<'_>, body: Rect, model: &Model, selected: usize) -> ResultsDrawn {
    let (theme, offers) = (&model.theme, &model.results.offers);
    let lines = u16::try_from(offers.len()).unwrap_or(u16::MAX);
    let height = lines.saturating_add(TRUTH + 2);
    let title = "answers to count";
    let inner = window::window(frame, body, model, title, (COLUMNS, height));
    let [list, below] =
        Layout::vertical([Constraint::Min(1), Constraint::Length(TRUTH)]).areas(inner);
    let rows = usize::from(list.height);
    let top = (selected + 1).saturating_sub(rows);
    let shown = offers.iter().enumerate().skip(top).take(rows);
    let line = |(place, offer): (usize, &CountingChoice)| {
        let chosen = place == selected;
        let line = line(model, offer, chosen, usize::from(list.width));
        if chosen {
            theme.select(line)
        } else {
            line.style(theme.base())
        }
    };
    frame.render_widget(Paragraph::new(shown.map(line).collect::<Vec<_>>()), list);
    if let Some(offer) = offers.get(selected) {
        let words = match offer.truth.as_str() {
            "" => format!("\ntruth: {}", TruthChoice::Usual.label()),
            truth => format!("\ntruth: {}", visible(truth)),
        };
        let text = Paragraph::new(words).wrap(Wrap { trim: true });
        frame.render_widget(text.style(Style::new().fg(theme.dim)), below);
    }
    ResultsDrawn {
        list,
        top,
        ..ResultsDrawn::default()
    }
}

fn line(model: &Model, offer: &CountingChoice, chosen: bool, width: usize) -> Line<'static> {
    let dim = Style::new().fg(model.theme.dim);
    let begun = offer.created_ms.map_or(String::new(), date);
    let progress = offer.progress;
    let done = match progress.all() {
        0 => String::new(),
        all => format!(
            "{} of {}",
            // As `evaluate list` has it.
            thousands(progress.answered),
            thousands(all)
        ),
    };
    let sign = if model.results.counting == Some(offer.counting) {
        "*"
    } else {
        " "
    };
    let head = format!(
        "{sign} {}",
        pad(&fit(&offer.counting.to_string(), NAME), NAME)
    );
    let tail = format!(" {} {}  ", pad(&begun, 16), pad(&done, 15));
    let left = width.saturating_sub(2 + 2 + NAME + 1 + 16 + 1 + 15 + 2);
    Line::from(vec![
        Span::raw(if chosen { "▸ " } else { "  " }),
        Span::raw(head),
        Span::styled(tail, dim),
        Span::raw(if left < LEAST {
            String::new()
        } else {
            fit(&visible(&offer.truth), left)
        }),
    ])
}
