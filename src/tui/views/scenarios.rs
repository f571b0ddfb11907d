//! The list of scenarios, with the lowest risk and a mark for collisions.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use crate::metrics::Headline;
use crate::tui::action::Action;
use crate::tui::loaded::Facts;
use crate::tui::model::{Extent, Model, Pane};
use crate::tui::widgets::frame;
use crate::tui::widgets::words::{fit, pad};

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let list = &model.list;
    let count = if list.filter.is_empty() {
        format!("scenarios {}", list.rows.len())
    } else {
        format!("scenarios {}/{}", list.visible.len(), list.rows.len())
    };
    let order = list.order.map_or(String::new(), |m| match m.unit {
        "" => format!(" by {}", m.id),
        unit => format!(" by {}, {unit}", m.id),
    });
    let title = Line::from(count + &order);
    let mut inner = frame::pane(f, area, model, Pane::Scenarios, title);
    passed_over(f, area, model);
    if list.filtering || !list.filter.is_empty() {
        let cursor = if list.filtering { "▏" } else { "" };
        let text = format!(
            "/{}{cursor}",
            fit(&list.filter, usize::from(inner.width).saturating_sub(2))
        );
        let style = Style::new().fg(model.theme.accent);
        f.render_widget(Line::styled(text, style), Rect { height: 1, ..inner });
        inner.y += 1;
        inner.height = inner.height.saturating_sub(1);
    }
    let rows = usize::from(inner.height);
    let top = list
        .selected
        .saturating_sub(rows / 2)
        .min(list.visible.len().saturating_sub(rows));
    model.drawn.text(
        Pane::Scenarios,
        Extent {
            lines: list.visible.len(),
            rows,
            top,
        },
    );
    if let Some(words) = nothing(model) {
        let text = Paragraph::new(words).wrap(ratatui::widgets::Wrap { trim: true });
        f.render_widget(text.style(Style::new().fg(model.theme.dim)), inner);
        return;
    }
    let width = usize::from(inner.width);
    let shown = list.visible.iter().enumerate().skip(top).take(rows);
    let lines = shown.map(|(i, &place)| {
        let row = &list.rows[place];
        let chosen = i == list.selected;
        // With an obstacle as the ego, the list agrees with what is open; what it is sorted by is the recorded ego's.
        let taken = model.opened.as_ref();
        let taken = taken.filter(|_| model.taken.is_some() && list.opened == Some(place));
        let (badge, color) = match taken {
            Some(opened) => headline_badge(model, opened.headline.as_ref()),
            None => badge(model, row.facts.as_ref()),
        };
        let value = match list.order {
            Some(_) if taken.is_some() => format!("{:>5} ", "·"),
            Some(_) => value(row.value),
            None => String::new(),
        };
        let name = width.saturating_sub(5 + value.chars().count());
        let name = pad(&row.entry.name, name);
        let sign = if chosen { "▸ " } else { "  " };
        let mut line = Line::from(vec![Span::raw(sign), Span::raw(name), Span::raw(" ")]);
        line = line.style(model.theme.base());
        line.push_span(Span::styled(value, Style::new().fg(model.theme.accent)));
        let style = Style::new().fg(color).add_modifier(Modifier::BOLD);
        line.push_span(Span::styled(badge, style));
        if chosen {
            line = model.theme.select(line);
        }
        line
    });
    f.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), inner);
}

/// In the lower border, where it takes no row: that not everything is in the list, and the key that tells why.
fn passed_over(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let count = model.list.passed_over.len();
    if count == 0 || area.height < 2 {
        return;
    }
    let width = usize::from(area.width).saturating_sub(4);
    let key = model.look.key(Action::About);
    let words = format!(" {} ", fit(&format!("{count} passed over · {key}"), width));
    let below = Rect {
        x: area.x + 1,
        y: area.bottom() - 1,
        width: area.width.saturating_sub(2),
        height: 1,
    };
    f.render_widget(
        Span::styled(words, Style::new().fg(model.theme.warning)),
        below,
    );
}

/// The value by which the list is sorted, in the width of its column.
fn value(value: Option<Option<f64>>) -> String {
    let words = match value {
        None => "…".to_string(),
        Some(None) => "–".to_string(),
        Some(Some(value)) if value.abs() >= 100.0 => format!("{value:.0}"),
        Some(Some(value)) => format!("{value:.2}"),
    };
    format!("{words:>5} ")
}

fn nothing(model: &Model) -> Option<&'static str> {
    let list = &model.list;
    if !list.found {
        Some("looking for scenarios…")
    } else if list.rows.is_empty() {
        Some("no scenarios")
    } else if list.visible.is_empty() {
        Some("the filter lets nothing through; Esc clears it")
    } else {
        None
    }
}

/// The lowest risk score, and a mark: X for a collision, - without ego, ! for a file that cannot be read.
fn badge(model: &Model, facts: Option<&Result<Facts, String>>) -> (String, ratatui::style::Color) {
    let theme = &model.theme;
    match facts {
        None => ("·".into(), theme.dim),
        Some(Err(_)) => ("!".into(), theme.danger),
        Some(Ok(facts)) => headline_badge(model, facts.headline.as_ref()),
    }
}

fn headline_badge(model: &Model, headline: Option<&Headline>) -> (String, ratatui::style::Color) {
    let theme = &model.theme;
    let Some((headline, risk)) = headline.and_then(|h| Some((h, h.risk?))) else {
        return ("-".into(), theme.dim);
    };
    if headline.collides() {
        (format!("{}X", risk.value), theme.danger)
    } else {
        (format!("{}", risk.value), theme.risk(risk.value))
    }
}
