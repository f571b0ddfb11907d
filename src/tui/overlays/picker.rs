//! A line to type into and what matches below: the palette and the lists of models and measures.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::judge;
use crate::metrics::Measure;
use crate::prompts::{Library, Origin};
use crate::text::visible;
use crate::tui::model::{
    Model, Order, Picker, measures_shown, models_shown, orders_shown, palette_shown,
    pictures_shown, templates_shown, themes_shown,
};
use crate::tui::widgets::words::{fit, pad};

pub fn palette(frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
    let inner = super::window(frame, screen, model, "actions", (84, 22));
    let rows = palette_shown(picker).into_iter().map(|entry| {
        let keys: Vec<String> = model
            .look
            .keymap
            .keys(entry)
            .map(|k| k.to_string())
            .collect();
        (
            format!("{} {}", pad(entry.id, 18), entry.doc),
            keys.join("  "),
        )
    });
    draw(frame, inner, model, picker, &rows.collect::<Vec<_>>());
}

pub fn themes(frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
    // To the side, so that the colours are seen.
    let side = Rect {
        x: screen.x,
        width: screen.width.min(56),
        ..screen
    };
    let rows = themes_shown(model, picker).into_iter().map(|name| {
        let named = model.look.themes.iter().find(|named| named.name == name);
        let note = match named.map(|named| (&named.theme, &named.file)) {
            None => "as the terminal's background".to_string(),
            Some((Err(mistakes), _)) => mistakes.first().cloned().unwrap_or_default(),
            Some((Ok(theme), file)) => {
                let ground = if theme.dark { "dark" } else { "light" };
                let yours = if file.is_some() { ", yours" } else { "" };
                format!("{ground}{yours}")
            }
        };
        (name, note)
    });
    let rows: Vec<_> = rows.collect();
    // The line that is typed, an empty one, the list, the words below it, and the borders.
    let height = u16::try_from(model.look.themes.len() + 1 + 5 + WHOLE).unwrap_or(u16::MAX);
    let inner = super::window(frame, side, model, "theme", (52, height.min(24)));
    draw(frame, inner, model, picker, &rows);
}

pub fn models(frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker, ask: bool) {
    let title = if ask { "ask another model" } else { "model" };
    let inner = super::window(frame, screen, model, title, (76, 18));
    let rows = models_shown(model, picker).into_iter().map(|id| {
        let offer = model.offers.iter().find(|o| o.id == id);
        let warning = offer.and_then(|o| o.warning.clone());
        let note = match offer.map(|o| &o.key) {
            _ if id == judge::MODEL => "built in, no network".to_string(),
            Some(Some((name, false))) => format!("{name} is not set"),
            _ if warning.is_some() => warning.unwrap_or_default(),
            Some(Some((name, true))) => format!("key in {name}"),
            Some(None) => "no key needed".to_string(),
            None => "as typed".to_string(),
        };
        (id, note)
    });
    let rows: Vec<_> = rows.collect();
    draw(frame, inner, model, picker, &rows);
    let hint = "any provider/model can be typed; providers are set in config.toml";
    let row = Rect {
        y: inner.bottom().saturating_sub(1),
        height: 1,
        ..inner
    };
    frame.render_widget(Line::styled(hint, Style::new().fg(model.theme.dim)), row);
}

pub fn pictures(frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
    let inner = super::window(frame, screen, model, "save a picture", (64, 16));
    let rows = pictures_shown(picker, model.focus).into_iter();
    let rows = rows.map(|offer| (offer.name.to_string(), offer.format.name().to_string()));
    draw(frame, inner, model, picker, &rows.collect::<Vec<_>>());
}

pub fn templates(frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker) {
    let title = format!("templates · {} · {}", model.task.name(), model.frame.name());
    let inner = super::window(frame, screen, model, &title, (92, 18));
    let drafts = model.prompt.drafted();
    let rows = templates_shown(model, picker).into_iter().map(|file| {
        let sign = if model.library.in_use(&file) {
            "* "
        } else {
            "  "
        };
        let draft = if drafts.contains(&file) {
            ", with a draft"
        } else {
            ""
        };
        let from = match model.library.file(&file) {
            Some((_, Origin::Shipped)) => "shipped",
            _ if Library::shipped(&file).is_some() => "yours, overrides the shipped one",
            _ => "yours",
        };
        (format!("{sign}{file}"), format!("{from}{draft}"))
    });
    let rows: Vec<_> = rows.collect();
    draw(frame, inner, model, picker, &rows);
    let hint = "* in use; Ctrl-A in the editor makes a new one";
    let row = Rect {
        y: inner.bottom().saturating_sub(1),
        height: 1,
        ..inner
    };
    frame.render_widget(Line::styled(hint, Style::new().fg(model.theme.dim)), row);
}

pub fn measures(frame: &mut Frame<'_>, screen: Rect, model: &Model, picker: &Picker, sort: bool) {
    let title = if sort { "sort scenarios by" } else { "plot" };
    let of_measure = |m: &Measure| {
        let unit = match m.unit {
            "" => String::new(),
            unit => format!(", {unit}"),
        };
        (
            format!("{} {}{unit}", pad(m.id, 16), m.name),
            m.source.to_string(),
        )
    };
    let rows: Vec<_> = match sort {
        false => measures_shown(picker).into_iter().map(of_measure).collect(),
        true => {
            let of_order = |order: Order| match order {
                Order::Measure(measure) => of_measure(measure),
                _ => (
                    format!("{} {}", pad(order.id(), 16), order.doc()),
                    String::new(),
                ),
            };
            orders_shown(picker).into_iter().map(of_order).collect()
        }
    };
    // As wide as the widest row, so that nothing is cut where the screen has the room.
    let widths = rows
        .iter()
        .map(|(left, right)| left.width() + right.width());
    let width = widths
        .max()
        .unwrap_or(0)
        .saturating_add(7)
        .max(MEASURES_WIDE);
    let width = u16::try_from(width).unwrap_or(u16::MAX);
    let inner = super::window(frame, screen, model, title, (width, 48));
    draw(frame, inner, model, picker, &rows);
}

/// Columns of the list of measures at least, however few match.
const MEASURES_WIDE: usize = 92;

/// Lines below the list in which a cut row stands whole.
const WHOLE: usize = 2;

fn draw(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    picker: &Picker,
    rows: &[(String, String)],
) {
    let theme = &model.theme;
    let width = usize::from(area.width);
    let typed = format!("> {}▏", fit(&picker.text, width.saturating_sub(4)));
    let height = usize::from(area.height).saturating_sub(3 + WHOLE);
    let top = (picker.selected + 1).saturating_sub(height);
    let mut lines = vec![
        Line::styled(typed, Style::new().fg(theme.accent)),
        Line::default(),
    ];
    let mut whole = None;
    for (i, (left, right)) in rows.iter().enumerate().skip(top).take(height) {
        // What is on the left tells the rows apart: it is cut last.
        let half = width
            .saturating_sub(left.trim_end().width() + 5)
            .max(width / 3);
        let (full_left, full_right) = (left, right);
        let right = fit(right, half);
        let left = pad(left, width.saturating_sub(right.width() + 4));
        let sign = if i == picker.selected { "▸ " } else { "  " };
        if i == picker.selected && (left.trim_end() != full_left.trim_end() || right != *full_right)
        {
            let words = full_left.split_whitespace().collect::<Vec<_>>().join(" ");
            whole = Some(format!("{words} · {full_right}"));
        }
        let line = Line::from(vec![
            Span::raw(sign),
            Span::raw(left),
            Span::styled(format!(" {right} "), Style::new().fg(theme.dim)),
        ]);
        lines.push(if i == picker.selected {
            theme.select(line)
        } else {
            line
        });
    }
    if rows.is_empty() {
        lines.push(Line::styled(
            "  nothing matches",
            Style::new().fg(theme.dim),
        ));
    }
    frame.render_widget(Paragraph::new(lines), area);
    if let Some(words) = whole {
        let rows = u16::try_from(WHOLE).unwrap_or(0);
        let below = Rect {
            y: area.bottom().saturating_sub(rows),
            height: rows.min(area.height),
            ..area
        };
        let words = Paragraph::new(visible(&words).into_owned()).wrap(Wrap { trim: true });
        frame.render_widget(words.style(Style::new().fg(theme.accent)), below);
    }
}
