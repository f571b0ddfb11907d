//! What terminal colours look like: their components, and colours between two others.

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

/// A colour that lies a part of the way (0 to 1) from one to another; where a colour is the terminal's own or one of the
/// sixteen, whose components are not known, the nearer of both.
pub fn mix(from: Color, to: Color, part: f64) -> Color {
    let (Some(a), Some(b)) = (components(from), components(to)) else {
        return if part < 0.5 { from } else { to };
    };
    let mixed = std::array::from_fn(|i| {
        let value = f64::from(a[i]) + (f64::from(b[i]) - f64::from(a[i])) * part;
        value.round().clamp(0.0, 255.0) as u8
    });
    match (from, to) {
        (Color::Indexed(_), _) | (_, Color::Indexed(_)) => {
            let [red, green, blue] = mixed;
            Color::Indexed(nearest(red, green, blue))
        }
        _ => {
            let [red, green, blue] = mixed;
            Color::Rgb(red, green, blue)
        }
    }
}
