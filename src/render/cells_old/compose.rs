//! Two colours and a character for a cell, from the dots of its areas and lines and what the terminal can draw.

use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::pixel::{OCTANTS, QUADRANTS, SEXTANTS};

use super::MapStyle;
use super::canvas::{Dot, GROUND};

/// The first Braille character; the dots are bits of what is added.
const BRAILLE: u32 = 0x2800;
/// The bits of the dots, row by row.
const BITS: [u32; 8] = [0x01, 0x08, 0x02, 0x10, 0x04, 0x20, 0x40, 0x80];

/// The dots of a cell, row by row.
#[derive(Debug)]
pub(super) struct Sample<'a> {
    /// Of areas: 4, 6 or 8.
    pub areas: &'a [Dot],
    /// Of lines.
    pub lines: &'a [Dot; 8],
}

/// What a cell shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Glyph {
    /// The character.
    pub symbol: char,
    /// Its colours.
    pub style: Style,
}

/// A cell; `None` where nothing is drawn.
pub(super) fn compose(style: MapStyle, sample: &Sample<'_>) -> Option<Glyph> {
    let top = |dots: &[Dot]| dots.iter().map(|dot| dot.layer).max().unwrap_or(0);
    let lines = top(sample.lines);
    // Shades fill whole cells: those of which a body has less than half stay free.
    let areas = match shade(style, sample.areas) {
        Some(false) => 0,
        _ => top(sample.areas),
    };
    // Lines on a body are those that were drawn after it.
    let line = if areas > GROUND { areas + 1 } else { GROUND };
    if lines >= line {
        return Some(lined(style, sample, line, lines));
    }
    if areas == 0 {
        return None;
    }
    filled(style, sample.areas)
}

/// Whether a shaded body fills this cell, where it lies on top of others.
fn shade(style: MapStyle, areas: &[Dot]) -> Option<bool> {
    let solid = |dot: &&Dot| dot.layer > 0 && !dot.shaded;
    let shaded = areas.iter().filter(|dot| dot.shaded).count();
    let covers = shaded > 0 && areas.iter().filter(solid).count() < shaded.max(2);
    (covers && !style.has_backgrounds()).then_some(2 * shaded >= areas.len())
}

/// Braille dots of the lines from a layer on, in the colour of the topmost.
fn lined(style: MapStyle, sample: &Sample<'_>, from: u8, top: u8) -> Glyph {
    let mut dots = 0;
    let mut shown = Style::new();
    let mut faint = true;
    for (dot, bit) in sample.lines.iter().zip(BITS) {
        if dot.layer >= from {
            dots |= bit;
            faint &= dot.faint;
        }
        if dot.layer == top {
            shown = shown.fg(dot.color);
        }
    }
    if faint && shown.fg == Some(Color::Reset) {
        shown = shown.add_modifier(Modifier::DIM);
    }
    if let Some(ground) = ranked(sample.areas)[0].filter(|ground| ground.layer > 0) {
        if style.has_backgrounds() {
            shown = shown.bg(ground.color);
        } else if ground.layer > GROUND {
            shown = shown.add_modifier(Modifier::REVERSED);
        }
    }
    let symbol = match style {
        MapStyle::Ascii => few(dots),
        _ => char::from_u32(BRAILLE + dots).unwrap_or(' '),
    };
    Glyph {
        symbol,
        style: shown,
    }
}

/// A block of the two colours that matter most.
fn filled(style: MapStyle, areas: &[Dot]) -> Option<Glyph> {
    let (front, back) = match ranked(areas) {
        [Some(a), Some(b)] if b.layer > a.layer => (b, Some(a)),
        [Some(a), other] => (a, other),
        [None, _] => return None,
    };
    if let Some(fills) = shade(style, areas) {
        let symbol = if style == MapStyle::Ascii { '%' } else { '▒' };
        return fills.then(|| Glyph {
            symbol,
            style: Style::new().fg(front.color),
        });
    }
    let is_front = |dot: &Dot| match back.filter(|_| style.has_backgrounds()) {
        Some(back) => same(dot, &front) || !same(dot, &back) && dot.layer > back.layer,
        // Without backgrounds, bodies in one cell have one colour.
        None => dot.layer > 0 && !dot.shaded,
    };
    let parts = areas.iter().enumerate();
    let mask = parts.fold(0_usize, |mask, (i, dot)| {
        mask | usize::from(is_front(dot)) << i
    });
    if style == MapStyle::Ascii {
        let symbol = if mask.count_ones() as usize * 2 >= areas.len() {
            '#'
        } else {
            '+'
        };
        return Some(Glyph {
            symbol,
            style: Style::new().fg(front.color),
        });
    }
    let full = (1 << areas.len()) - 1;
    if style.has_backgrounds() && mask == full {
        return Some(Glyph {
            symbol: ' ',
            style: Style::new().bg(front.color),
        });
    }
    let mut shown = Style::new().fg(front.color);
    if let Some(back) = back.filter(|_| style.has_backgrounds()) {
        shown = shown.bg(back.color);
    }
    Some(Glyph {
        symbol: style.blocks().symbol(mask),
        style: shown,
    })
}

fn same(a: &Dot, b: &Dot) -> bool {
    a.color == b.color && (a.layer > GROUND) == (b.layer > GROUND)
}

/// The two kinds of dots that matter most: what covers the ground counts twice.
fn ranked(areas: &[Dot]) -> [Option<Dot>; 2] {
    let mut kinds: [Option<(Dot, u32)>; 8] = [None; 8];
    for dot in areas {
        let weight = match dot.layer {
            0 | GROUND => 2,
            _ => 3,
        };
        for kind in &mut kinds {
            match kind {
                Some((known, sum)) if same(known, dot) => {
                    *sum += weight;
                    known.layer = known.layer.max(dot.layer);
                    break;
                }
                Some(_) => {}
                None => {
                    *kind = Some((*dot, weight));
                    break;
                }
            }
        }
    }
    let mut best: [Option<(Dot, u32)>; 2] = [None; 2];
    for kind in kinds.into_iter().flatten() {
        if best[0].is_none_or(|(_, sum)| kind.1 > sum) {
            best[1] = best[0];
            best[0] = Some(kind);
        } else if best[1].is_none_or(|(_, sum)| kind.1 > sum) {
            best[1] = Some(kind);
        }
    }
    best.map(|kind| kind.map(|(dot, _)| dot))
}

/// ASCII for the dots of a line: above, below, or both.
fn few(dots: u32) -> char {
    const UPPER: u32 = 0b0001_1011;
    match (dots & UPPER, dots & !UPPER) {
        (_, 0) => '\'',
        (0, _) => '.',
        _ => ':',
    }
}

/// How finely a character divides its cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blocks {
    /// 2 × 2, which every font has.
    Quadrants,
    /// 2 × 3, Unicode 13.
    Sextants,
    /// 2 × 4, Unicode 16.
    Octants,
}

impl Blocks {
    /// All with their names in the configuration.
    pub const NAMED: [(&str, Self); 3] = [
        ("quadrants", Self::Quadrants),
        ("sextants", Self::Sextants),
        ("octants", Self::Octants),
    ];

    /// What the terminal draws itself, whatever the font has: by `TERM` and `TERM_PROGRAM`. Within tmux and screen the
    /// outer terminal is not known, so quadrants are used.
    #[must_use]
    pub fn of_environment(env: impl Fn(&str) -> Option<String>) -> Self {
        let value = |name: &str| env(name).unwrap_or_default().to_lowercase();
        let (term, program) = (value("TERM"), value("TERM_PROGRAM"));
        let is = |names: &[&str]| {
            let said = |name: &&str| term.contains(*name) || program.contains(*name);
            names.iter().any(said)
        };
        if is(&["tmux", "screen"]) {
            return Self::Quadrants;
        }
        // Ghostty draws octants since its first release.
        if is(&["ghostty"]) {
            return Self::Octants;
        }
        let vte = value("VTE_VERSION").parse::<u32>().unwrap_or(0);
        let known = is(&["kitty", "foot", "wezterm", "alacritty", "contour", "iterm"]);
        // VTE (GNOME Terminal and others) draws sextants since 0.62, Windows Terminal since 1.22, which WT_SESSION does
        // not tell.
        if known || vte >= 6200 {
            Self::Sextants
        } else {
            Self::Quadrants
        }
    }

    /// Columns and rows of a cell.
    #[must_use]
    pub fn per_cell(self) -> (usize, usize) {
        match self {
            Self::Quadrants => (2, 2),
            Self::Sextants => (2, 3),
            Self::Octants => (2, 4),
        }
    }

    /// Which parts of its cell a character fills: a bit each, row by row; `None` for one that is no block.
    #[must_use]
    pub fn of_symbol(symbol: char) -> Option<(Self, usize)> {
        let mut named = Self::NAMED.into_iter();
        named.find_map(|(_, blocks)| {
            let parts = blocks.symbols().iter().position(|c| *c == symbol)?;
            (parts > 0).then_some((blocks, parts))
        })
    }

    fn symbols(self) -> &'static [char] {
        match self {
            Self::Quadrants => &QUADRANTS,
            Self::Sextants => &SEXTANTS,
            Self::Octants => &OCTANTS,
        }
    }

    /// The character in which these parts are filled: a bit each, row by row.
    #[must_use]
    pub fn symbol(self, parts: usize) -> char {
        self.symbols().get(parts).copied().unwrap_or('█')
    }
}

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

