//! The frame of a pane: border, title and focus indicator.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::{Block, BorderType};

use crate::model::{Model, Pane};

/// Draws the frame of a pane and gives the area inside.
pub fn pane(frame: &mut Frame<'_>, area: Rect, model: &Model, pane: Pane, title: Line<'_>) -> Rect {
    let look = look(model, pane);
    let block = Block::bordered()
        .border_type(look.kind)
        .border_style(look.border)
        .title(spaced(title).style(look.title));
    let inner = block.inner(area);
    frame.render_widget(block, area);
    model.drawn.pane(pane, area);
    inner
}

/// Draws a line across a pane, a column or a row inside its frame, and the title of what is behind it.
pub fn divide(
    frame: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    pane: Pane,
    line: Rect,
    title: Line<'_>,
) {
    let look = look(model, pane);
    let thick = matches!(look.kind, BorderType::Thick);
    let upright = line.width < line.height;
    // From border to border.
    let (whole, signs, title_at) = if upright {
        let whole = Rect {
            y: area.y,
            height: area.height,
            ..line
        };
        let signs = if thick {
            ["┯", "│", "┷"]
        } else {
            ["┬", "│", "┴"]
        };
        (whole, signs, (line.x + 1, area.y))
    } else {
        let whole = Rect {
            x: area.x,
            width: area.width,
            ..line
        };
        let signs = if thick {
            ["┠", "─", "┨"]
        } else {
            ["├", "─", "┤"]
        };
        (whole, signs, (area.x + 1, line.y))
    };
    let count = whole.positions().count();
    let buffer = frame.buffer_mut();
    for (place, at) in whole.positions().enumerate() {
        let sign = match place {
            0 => signs[0],
            _ if place + 1 == count => signs[2],
            _ => signs[1],
        };
        buffer[at].set_symbol(sign).set_style(look.border);
    }
    let title = spaced(title).style(look.title);
    let (x, y) = title_at;
    let room = area.right().saturating_sub(x + 1);
    buffer.set_line(x, y, &title, room);
}

/// How the frame of a pane looks.
struct FrameLook {
    title: Style,
    border: Style,
    kind: BorderType,
}

/// A thick border says without colour which pane has the keys.
fn look(model: &Model, pane: Pane) -> FrameLook {
    let theme = &model.theme;
    // Beside answers that are compared, the map only shows.
    if model.focus == pane && model.screens.is_empty() && !model.compare.open {
        FrameLook {
            title: Style::new().fg(theme.accent).add_modifier(Modifier::BOLD),
            border: Style::new().fg(theme.border_focused),
            kind: BorderType::Thick,
        }
    } else {
        FrameLook {
            title: Style::new().fg(theme.title),
            border: Style::new().fg(theme.border),
            kind: BorderType::Plain,
        }
    }
}

fn spaced(title: Line<'_>) -> Line<'_> {
    let mut spaced = Line::from(" ");
    spaced.spans.extend(title.spans);
    spaced.spans.push(" ".into());
    spaced
}
