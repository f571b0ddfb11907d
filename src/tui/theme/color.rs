//! Colours: those of a theme file, and the nearest a terminal supports.

use ratatui::style::Color;

use super::ColorDepth;
use crate::settings::ThemeColor;

/// The sixteen colours as xterm has them, by their ANSI numbers.
const SIXTEEN: [(Color, [u8; 3]); 16] = [
    (Color::Black, [0, 0, 0]),
    (Color::Red, [205, 0, 0]),
    (Color::Green, [0, 205, 0]),
    (Color::Yellow, [205, 205, 0]),
    (Color::Blue, [0, 0, 238]),
    (Color::Magenta, [205, 0, 205]),
    (Color::Cyan, [0, 205, 205]),
    (Color::Gray, [229, 229, 229]),
    (Color::DarkGray, [127, 127, 127]),
    (Color::LightRed, [255, 0, 0]),
    (Color::LightGreen, [0, 255, 0]),
    (Color::LightYellow, [255, 255, 0]),
    (Color::LightBlue, [92, 92, 255]),
    (Color::LightMagenta, [255, 0, 255]),
    (Color::LightCyan, [0, 255, 255]),
    (Color::White, [255, 255, 255]),
];

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

/// The ANSI number of one of the sixteen.
pub fn number(color: Color) -> Option<u8> {
    let place = SIXTEEN.iter().position(|(named, _)| *named == color)?;
    u8::try_from(place).ok()
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

const STEPS: [u8; 6] = [0, 95, 135, 175, 215, 255];

/// Red, green and blue of one of 256 colours.
pub fn rgb(index: u8) -> [u8; 3] {
    match index {
        0..16 => SIXTEEN[usize::from(index)].1,
        16..232 => {
            let place = usize::from(index) - 16;
            [STEPS[place / 36], STEPS[place / 6 % 6], STEPS[place % 6]]
        }
        232.. => [8 + (index - 232) * 10; 3],
    }
}

/// Red, green and blue of a colour as xterm shows it; `None` for the terminal's own.
pub fn components(color: Color) -> Option<[u8; 3]> {
    match color {
        Color::Rgb(r, g, b) => Some([r, g, b]),
        Color::Indexed(index) => Some(rgb(index)),
        color => Some(rgb(number(color)?)),
    }
}

/// The nearest of the 240 colours that are the same in every terminal of 256.
fn nearest(r: u8, g: u8, b: u8) -> u8 {
    let step = |v: u8| (0..6).min_by_key(|&i| STEPS[i].abs_diff(v)).unwrap_or(0);
    let off = |x: u8, y: u8| i32::from(x.abs_diff(y)).pow(2);
    let (ri, gi, bi) = (step(r), step(g), step(b));
    let cube = off(STEPS[ri], r) + off(STEPS[gi], g) + off(STEPS[bi], b);
    let mean = (i32::from(r) + i32::from(g) + i32::from(b)) / 3;
    let gray = ((mean - 8 + 5) / 10).clamp(0, 23);
    let level = u8::try_from(8 + gray * 10).unwrap_or(u8::MAX);
    let gray_off = off(level, r) + off(level, g) + off(level, b);
    let index = if gray_off < cube {
        232 + gray as usize
    } else {
        16 + 36 * ri + 6 * gi + bi
    };
    u8::try_from(index).unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

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
