//! The line in which the user's tags of a scenario are typed, with those of its file and those in use elsewhere.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Line;
use ratatui::widgets::{Paragraph, Wrap};

use crate::text::visible;
use crate::tui::model::{Model, Picker};
use crate::tui::widgets::words::{fit, fit_end};

pub fn draw(
    frame: &mut Frame<'_>,
    screen: Rect,
    model: &Model,
    (typed, scenario): (&Picker, &str),
) {
    let title = format!("your tags of {}", fit(scenario, 48));
    let inner = super::window(frame, screen, model, &title, (76, 12));
    let width = usize::from(inner.width);
    let (accent, dim) = (
        Style::new().fg(model.theme.accent),
        Style::new().fg(model.theme.dim),
    );
    // The end is where one types.
    let line = format!("# {}▏", fit_end(&typed.text, width.saturating_sub(4)));
    let mut lines = vec![Line::styled(line, accent), Line::default()];
    let row = model.list.rows.iter().find(|r| r.entry.name == scenario);
    let of_file = row.and_then(|row| row.facts());
    let of_file = of_file.map_or(String::new(), |facts| facts.tags.join(" "));
    let in_use = model.list.tags.all().join(" ");
    for (what, tags) in [("in the file", of_file), ("yours, anywhere", in_use)] {
        let tags = if tags.is_empty() { "none" } else { &tags };
        lines.push(Line::styled(
            visible(&format!("{what}: {tags}")).into_owned(),
            dim,
        ));
    }
    lines.push(Line::default());
    let hint = "words with spaces between them; scenarios of the same name share them; tag:WORD in the filter finds them";
    lines.push(Line::styled(hint, dim));
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: true }), inner);
}
