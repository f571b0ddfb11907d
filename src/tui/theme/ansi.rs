//! Text lines with ANSI colour escapes, for the shell.

use std::fmt::Write;

use ratatui::style::{Color, Modifier, Style};
use ratatui::text::Line;

use super::color;

/// A line as a terminal takes it. The caller has made its text safe to show.
pub fn line(line: &Line<'_>) -> String {
    let mut text = String::new();
    for span in &line.spans {
        let codes = codes(line.style.patch(span.style));
        if codes.is_empty() {
            text.push_str(&span.content);
        } else {
            // Writing to a string cannot fail.
            let _ = write!(text, "\x1b[{}m{}\x1b[0m", codes.join(";"), span.content);
        }
    }
    text
}

fn codes(style: Style) -> Vec<String> {
    let mut codes = Vec::new();
    let modifiers = [
        (Modifier::BOLD, "1"),
        (Modifier::ITALIC, "3"),
        (Modifier::UNDERLINED, "4"),
        (Modifier::REVERSED, "7"),
    ];
    for (modifier, code) in modifiers {
        if style.add_modifier.contains(modifier) {
            codes.push(code.to_string());
        }
    }
    codes.extend(style.fg.and_then(|color| code(color, 30)));
    codes.extend(style.bg.and_then(|color| code(color, 40)));
    codes
}

/// The code of a colour; `base` is 30 for text and 40 for its background.
fn code(color: Color, base: u8) -> Option<String> {
    match color {
        Color::Rgb(r, g, b) => Some(format!("{};2;{r};{g};{b}", base + 8)),
        Color::Indexed(index) => Some(format!("{};5;{index}", base + 8)),
        color => {
            let number = color::number(color)?;
            let code = if number < 8 { base } else { base + 60 - 8 };
            Some((code + number).to_string())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::text::Span;

    #[test]
    fn sequences() {
        let styled = |style: Style| line(&Line::from(vec![Span::styled("x", style)]));
        let new = Style::new;
        assert_eq!(styled(new()), "x");
        assert_eq!(styled(new().fg(Color::Reset)), "x");
        assert_eq!(styled(new().fg(Color::Red)), "\x1b[31mx\x1b[0m");
        assert_eq!(styled(new().bg(Color::White)), "\x1b[107mx\x1b[0m");
        assert_eq!(
            styled(new().fg(Color::Indexed(99)).bold()),
            "\x1b[1;38;5;99mx\x1b[0m"
        );
        assert_eq!(
            styled(new().fg(Color::Rgb(1, 2, 3))),
            "\x1b[38;2;1;2;3mx\x1b[0m"
        );
    }
}
