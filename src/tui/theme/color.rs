//! Colours: written, as the terminal has them, and at its depth.

use std::fmt::Write;

use nearmiss_render::cells::colors::{SIXTEEN, nearest, nearest_of};
use nearmiss_settings::ThemeColor;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::Line;

pub use nearmiss_render::cells::colors::{components, number};

/// A colour of a theme file as the terminal has it.
pub fn terminal_color(color: ThemeColor) -> Color {
    match color {
        ThemeColor::Rgb(red, green, blue) => Color::Rgb(red, green, blue),
        ThemeColor::Indexed(index) => Color::Indexed(index),
        ThemeColor::Ansi(number) => {
            let named = SIXTEEN.get(usize::from(number));
            named.map_or(Color::Reset, |(color, _)| *color)
        }
        ThemeColor::Terminal => Color::Reset,
    }
}

/// The nearest colour that a terminal of this depth has; never the likely background of a `dark` or light theme.
pub fn at_depth(color: Color, depth: ColorDepth, dark: bool) -> Color {
    match (depth, color) {
        (ColorDepth::None, _) => Color::Reset,
        (ColorDepth::Indexed, Color::Rgb(r, g, b)) => Color::Indexed(nearest(r, g, b)),
        (ColorDepth::Sixteen, Color::Rgb(..) | Color::Indexed(_)) => {
            let background = if dark { Color::Black } else { Color::White };
            nearest_of_sixteen(color, Some(background))
        }
        (_, color) => color,
    }
}

/// The same for what lies behind others, which may be the background.
pub fn surface_at_depth(color: Color, depth: ColorDepth) -> Color {
    match (depth, color) {
        (ColorDepth::Sixteen, Color::Rgb(..) | Color::Indexed(_)) => {
            nearest_of_sixteen(color, None)
        }
        // The background matters for sixteen colours alone.
        (depth, color) => at_depth(color, depth, true),
    }
}

fn nearest_of_sixteen(color: Color, but: Option<Color>) -> Color {
    let Some(wanted) = components(color) else {
        return color;
    };
    nearest_of(
        SIXTEEN.iter().filter(|(color, _)| Some(*color) != but),
        wanted,
    )
}

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
            let number = number(color)?;
            let code = if number < 8 { base } else { base + 60 - 8 };
            Some((code + number).to_string())
        }
    }
}

/// Colour depth of a terminal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColorDepth {
    /// All of them.
    True,
    /// 256.
    Indexed,
    /// The sixteen that every terminal with colours has.
    Sixteen,
    /// None: `NO_COLOR` is set, or the terminal has none.
    None,
}

/// Terminals that show 256 colours at least, and whose `TERM` does not say so.
const CAPABLE: [&str; 9] = [
    "alacritty",
    "contour",
    "foot",
    "ghostty",
    "iterm",
    "kitty",
    "mlterm",
    "rio",
    "wezterm",
];

impl ColorDepth {
    /// Every depth with its name, the most colours first.
    pub const NAMED: [(&str, Self); 4] = [
        ("true", Self::True),
        ("256", Self::Indexed),
        ("16", Self::Sixteen),
        ("none", Self::None),
    ];

    /// Detects the depth from the environment.
    #[must_use]
    pub fn of_environment(env: impl Fn(&str) -> Option<String>) -> Self {
        let says = |name: &str| env(name).filter(|v| !v.is_empty());
        if says("NO_COLOR").is_some() {
            return Self::None;
        }
        if matches!(says("COLORTERM").as_deref(), Some("truecolor" | "24bit")) {
            return Self::True;
        }
        // Windows Terminal has no TERM.
        if says("WT_SESSION").is_some() {
            return Self::True;
        }
        let term = says("TERM").unwrap_or_default();
        if term.ends_with("-direct") {
            Self::True
        } else if term.contains("256color") || CAPABLE.iter().any(|name| term.contains(name)) {
            Self::Indexed
        } else if term == "dumb"
            || term.ends_with("-m")
            || term.starts_with("vt1")
            || term.starts_with("vt2")
        {
            Self::None
        } else {
            Self::Sixteen
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_render::cells::colors::rgb;
    use ratatui::text::Span;

    #[test]
    fn fewer_colours() {
        assert_eq!(nearest(255, 0, 0), 196);
        assert_eq!(nearest(128, 128, 128), 244);
        assert_eq!(rgb(196), [255, 0, 0]);
        assert_eq!(rgb(244), [128, 128, 128]);
        let red = Color::Rgb(220, 10, 10);
        assert_eq!(at_depth(red, ColorDepth::Sixteen, true), Color::Red);
        assert_eq!(at_depth(red, ColorDepth::None, true), Color::Reset);
        let ground = Color::Rgb(20, 20, 20);
        assert_eq!(surface_at_depth(ground, ColorDepth::Sixteen), Color::Black);
        // A dark gray is not lost on a dark background, nor a light one on a light one.
        let (dark, light) = (Color::Rgb(20, 20, 20), Color::Rgb(250, 250, 250));
        assert_eq!(at_depth(dark, ColorDepth::Sixteen, true), Color::DarkGray);
        assert_eq!(at_depth(dark, ColorDepth::Sixteen, false), Color::Black);
        assert_eq!(at_depth(light, ColorDepth::Sixteen, false), Color::Gray);
    }

    #[test]
    fn sixteen_have_numbers() {
        assert_eq!(number(Color::Red), Some(1));
        assert_eq!(number(Color::White), Some(15));
        assert_eq!(number(Color::Reset), None);
    }

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

    #[test]
    fn the_environment_says() {
        let of = |pairs: &[(&str, &str)]| {
            ColorDepth::of_environment(|name| {
                let pair = pairs.iter().find(|(n, _)| *n == name);
                pair.map(|(_, value)| (*value).to_string())
            })
        };
        assert_eq!(
            of(&[("NO_COLOR", "1"), ("COLORTERM", "truecolor")]),
            ColorDepth::None
        );
        assert_eq!(
            of(&[("NO_COLOR", ""), ("COLORTERM", "truecolor")]),
            ColorDepth::True
        );
        for (term, depth) in [
            ("xterm-256color", ColorDepth::Indexed),
            ("xterm-kitty", ColorDepth::Indexed),
            ("xterm-direct", ColorDepth::True),
            ("xterm", ColorDepth::Sixteen),
            ("linux", ColorDepth::Sixteen),
            ("screen", ColorDepth::Sixteen),
            ("vt100", ColorDepth::None),
            ("xterm-m", ColorDepth::None),
        ] {
            assert_eq!(of(&[("TERM", term)]), depth, "{term}");
        }
    }
}
