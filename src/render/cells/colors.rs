//! The colours that terminals have, and the nearest of them.

use ratatui::style::Color;

/// The sixteen colours as xterm has them, by their ANSI numbers.
pub const SIXTEEN: [(Color, [u8; 3]); 16] = [
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

/// The ANSI number of one of the sixteen.
pub fn number(color: Color) -> Option<u8> {
    let place = SIXTEEN.iter().position(|(named, _)| *named == color)?;
    u8::try_from(place).ok()
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
#[must_use]
pub fn nearest(r: u8, g: u8, b: u8) -> u8 {
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

/// Which colours a terminal has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inks {
    /// All.
    True,
    /// Those of the 256 that are the same in every terminal.
    Indexed,
    /// Sixteen.
    Sixteen,
}

impl Inks {
    /// Those of which this one is: a theme has its colours as the terminal can show them.
    #[must_use]
    pub fn of(color: Color) -> Self {
        match color {
            Color::Rgb(..) => Self::True,
            Color::Indexed(_) => Self::Indexed,
            _ => Self::Sixteen,
        }
    }

    /// The nearest colour, and what it looks like.
    pub fn nearest(self, rgb: [f32; 3]) -> (Color, [f32; 3]) {
        let [red, green, blue] = rgb.map(|v| (v + 0.5) as u8);
        let color = match self {
            Self::True => Color::Rgb(red, green, blue),
            Self::Indexed => Color::Indexed(nearest(red, green, blue)),
            Self::Sixteen => nearest_of(&SIXTEEN, [red, green, blue]),
        };
        let shown = components(color).map_or(rgb, |shown| shown.map(f32::from));
        (color, shown)
    }
}

/// The nearest of named colours.
pub fn nearest_of<'a>(
    named: impl IntoIterator<Item = &'a (Color, [u8; 3])>,
    wanted: [u8; 3],
) -> Color {
    let nearest = named.into_iter().min_by_key(|(_, rgb)| {
        let off = rgb.iter().zip(wanted);
        off.map(|(a, b)| u32::from(a.abs_diff(b)).pow(2))
            .sum::<u32>()
    });
    nearest.map_or(Color::Reset, |(color, _)| *color)
}
