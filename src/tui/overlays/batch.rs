//! The card before a batch: what it would ask, what of it is there already, and what it would cost.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Paragraph, Wrap};

use crate::judge;
use crate::text::visible;
use crate::tui::model::{Card, Model};
use crate::tui::widgets::words::{fit, thousands};
use crate::verdict::Task;

pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    let Some(card) = &model.card else { return };
    let title = if card.is_counted() {
        "ask · Enter yes · Esc no"
    } else {
        "ask · counting …"
    };
    let text = Paragraph::new(text(model, card)).wrap(Wrap { trim: false });
    let lines = text.line_count(u16::try_from(super::width_in(screen, 84)).unwrap_or(u16::MAX));
    let height = u16::try_from(lines + 2).unwrap_or(u16::MAX);
    let inner = super::window(frame, screen, model, title, (84, height));
    frame.render_widget(text, inner);
}

fn text(model: &Model, card: &Card) -> Text<'static> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let (batch, counts) = (&card.batch, &card.counts);
    let mut text = Text::default();
    let mut row = |name: &str, value: String, style: Style| {
        let value = visible(&value).into_owned();
        text.push_line(Line::from(vec![
            Span::styled(format!(" {name:<11} "), dim),
            Span::styled(value, style),
        ]));
    };
    let estimate = &counts.estimate;
    row("model", batch.model.clone(), bold);
    let how = format!(
        "{} · {} · {}",
        batch.task.name(),
        batch.frame.name(),
        batch.techniques
    );
    row("how", how, Style::new());
    let window = match batch.task {
        Task::Collision => "the end of each scenario".to_string(),
        _ => format!(
            "of each scenario the {} steps that end two before the last",
            batch.history
        ),
    };
    row("window", window, Style::new());
    let which = if card.marked { "marked" } else { "listed" };
    row(
        "scenarios",
        format!("{} {which}", batch.entries.len()),
        Style::new(),
    );
    if !card.is_counted() {
        let done = format!("{} of {} so far", counts.looked, batch.entries.len());
        row("counted", done, Style::new().fg(theme.warning));
    }
    if counts.unlabelled > 0 {
        let words = format!("{} whose truth is unknown", counts.unlabelled);
        row("left out", words, Style::new().fg(theme.warning));
    }
    if estimate.unaskable > 0 {
        let why = estimate.why.first().map_or("", |(why, _)| why.as_str());
        let words = format!(
            "{} cannot be asked about: {}",
            estimate.unaskable,
            fit(why, 300)
        );
        row("left out", words, Style::new().fg(theme.warning));
    }
    let there = format!("{}, at no cost", estimate.stored);
    row("in store", there, Style::new());
    let own = batch.model == judge::MODEL;
    let name = if own { "answers" } else { "requests" };
    let asks = match own {
        true => format!("{}, on this machine", estimate.free),
        false => format!("{}, {} at once", estimate.requests, counts.at_once),
    };
    row(name, asks, bold);
    if !own {
        let tokens = format!("about {} in the questions", thousands(estimate.tokens));
        row("tokens", tokens, Style::new());
        row("price", counts.price(), bold);
    }
    if let Some(left) = counts.budget {
        row(
            "budget",
            format!("${left:.4} left in this session"),
            Style::new(),
        );
    }
    if let Some(why) = &counts.refused {
        row("but", fit(why, 400), Style::new().fg(theme.danger));
    }
    text
}
