//! Two colours and a character for a cell, from the dots of its areas and lines.

use ratatui::style::{Color, Modifier, Style};

use super::MapStyle;
use super::canvas::{Dot, GROUND};

/// The first Braille character; the dots are bits of what is added.
const BRAILLE: u32 = 0x2800;
/// The bits of the dots, row by row.
const BITS: [u32; 8] = [0x01, 0x08, 0x02, 0x10, 0x04, 0x20, 0x40, 0x80];

/// The dots of a cell, row by row.
#[derive(Debug)]
pub struct Sample<'a> {
    /// Of areas: 4, 6 or 8.
    pub areas: &'a [Dot],
    /// Of lines.
    pub lines: &'a [Dot; 8],
}

/// What a cell shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Glyph {
    /// The character.
    pub symbol: char,
    /// Its colours.
    pub style: Style,
}

/// A cell; `None` where nothing is drawn.
pub fn compose(style: MapStyle, sample: &Sample<'_>) -> Option<Glyph> {
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
