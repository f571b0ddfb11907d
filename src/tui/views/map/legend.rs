//! The legend on the map's lower border: only symbols in view, as many as fit.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Span;
use unicode_width::UnicodeWidthStr;

use super::signs::Placed;
use crate::tui::model::{Foreseen, Foresight, Model};

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model, shown: Placed) {
    // The corners stay.
    let room = usize::from(area.width.saturating_sub(4));
    let words = fitting(&entries(model, shown), room);
    if words.is_empty() || area.height < 2 {
        return;
    }
    let row = Rect {
        x: area.x + 1,
        y: area.bottom() - 1,
        width: area.width.saturating_sub(2),
        height: 1,
    };
    let style = Style::new().fg(model.theme.dim);
    f.render_widget(Span::styled(format!(" {words} "), style), row);
}

fn entries(model: &Model, shown: Placed) -> Vec<String> {
    let mut entries = Vec::new();
    let horizon = Foresight::HORIZON;
    let predicted = |whose: &str| {
        [
            format!("-- predicted {horizon:.0} s{whose}"),
            "xx constant velocity".into(),
        ]
    };
    if model.variant().is_some() && model.map.layers.variant {
        entries.push("━ attack, -- recorded instead".into());
    }
    if let Some(planned) = model.planned().filter(|_| model.map.layers.planner) {
        entries.push("━ chosen, 1 2 3 s ahead".into());
        entries.push("── drivable".into());
        entries.push("·· rejected".into());
        entries.push("[] predicted bodies".into());
        if planned.recorded.is_some() {
            entries.push("-- recorded ego".into());
        }
    }
    match model.map.layers.paths {
        Foreseen::Off => {}
        _ if model.scene().is_none() => entries.push("no predictions without an ego".into()),
        Foreseen::Picked => entries.extend(predicted(", picked: % how likely")),
        Foreseen::Near => entries.extend(predicted(", near the ego")),
    }
    if model.map.tape.is_some() {
        entries.push("+ # tape: # moves".into());
    }
    if shown.lights {
        entries.push("R A G lights".into());
    }
    if shown.posts {
        entries.push("▫ sign".into());
    }
    if model.map.layers.trails {
        entries.push("── past, .. recorded future".into());
    }
    entries
}

fn fitting(entries: &[String], room: usize) -> String {
    let mut words = String::new();
    for entry in entries {
        let separator = if words.is_empty() { "" } else { " │ " };
        if words.width() + separator.width() + entry.width() <= room {
            words.push_str(separator);
            words.push_str(entry);
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_left_out_whole() {
        let entries = ["one".to_string(), "a long one".into(), "two".into()];
        assert_eq!(fitting(&entries, 40), "one │ a long one │ two");
        assert_eq!(fitting(&entries, 12), "one │ two");
        assert_eq!(fitting(&entries, 2), "");
    }
}
