//! Colours: those of a theme file, and the nearest a terminal supports.

use ratatui::style::Color;

use super::ColorDepth;
use nearmiss_render::cells::compose::{SIXTEEN, nearest};
use nearmiss_settings::ThemeColor;

pub use nearmiss_render::cells::compose::{components, number};

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
    let others = SIXTEEN.iter().filter(|(color, _)| Some(*color) != but);
    let nearest = others.min_by_key(|(_, rgb)| {
        let off = rgb.iter().zip(wanted);
        off.map(|(a, b)| u32::from(a.abs_diff(b)).pow(2))
            .sum::<u32>()
    });
    nearest.map_or(Color::Reset, |(color, _)| *color)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nearmiss_render::cells::compose::rgb;

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
}
