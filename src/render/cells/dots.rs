//! A map of lines: dots of Braille, or ASCII, and solid bodies; for terminals with few colours, or without Unicode.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use tiny_skia::{BlendMode, FillRule, Pixmap, PremultipliedColorU8, Transform};

use super::colors::Inks;
use super::{Appearance, Blocks, MapStyle};
use crate::clip;
use crate::display::{Item, Picture};
use crate::raster::{line, outline, paint};

/// Dots of a Braille character: columns and rows.
pub const DOTS: (usize, usize) = (2, 4);
/// The first Braille character; the dots are bits of what is added.
const BRAILLE: u32 = 0x2800;
/// The bits of the dots, row by row.
const BITS: [u32; 8] = [0x01, 0x08, 0x02, 0x10, 0x04, 0x20, 0x40, 0x80];
/// The dots of the four quarters of a cell.
const QUARTERS: [[usize; 2]; 4] = [[0, 2], [1, 3], [4, 6], [5, 7]];
/// What is less opaque than this is a tint, not a line.
const OPAQUE: f64 = 0.4;
/// Lines are finer than this many dots.
const FINE: f32 = 1.5;

/// What a dot shows, written as its opacity: what matters more has more.
const FAINT: u8 = 252;
const LINE: u8 = 253;
const BODY: u8 = 254;
const EGO: u8 = 255;

/// Dots of a picture of so many, from the upper left corner.
pub fn dots(picture: &Picture, columns: u32, rows: u32) -> Option<Pixmap> {
    let mut pixmap = Pixmap::new(columns, rows)?;
    let scale = (
        columns as f32 / picture.size.0 as f32,
        rows as f32 / picture.size.1 as f32,
    );
    let transform = Transform::from_scale(scale.0, scale.1);
    let mut groups: Vec<u8> = Vec::new();
    clip::each(picture, |item| match item {
        Item::Begin { name, .. } => groups.push(match *name {
            "markings" => FAINT,
            "obstacles" | "contact" => BODY,
            "ego" => EGO,
            _ => LINE,
        }),
        Item::End => drop(groups.pop()),
        Item::Text(_) => {}
        Item::Path { path, fill, stroke } => {
            let Some(path) = outline(path) else { return };
            let kind = groups.last().copied().unwrap_or(LINE);
            let ink = |color: crate::Color| {
                let mut paint = paint(color.at(f64::from(kind) / 255.0));
                paint.anti_alias = false;
                paint.blend_mode = BlendMode::Source;
                paint
            };
            if let Some(color) = fill.filter(|color| color.opacity > OPAQUE) {
                let rule = FillRule::Winding;
                pixmap.fill_path(&path, &ink(color), rule, transform, None);
            }
            if let Some(stroke) = stroke {
                let mut line = line(stroke);
                if line.width * scale.0 < FINE {
                    line.width = 0.0;
                }
                pixmap.stroke_path(&path, &ink(stroke.color), &line, transform, None);
            }
        }
    });
    Some(pixmap)
}

/// Writes the cells that show dots.
pub fn write(buffer: &mut Buffer, area: Rect, pixmap: &Pixmap, look: &Appearance<'_>) {
    let columns = pixmap.width() as usize;
    for row in 0..usize::from(area.height) {
        for column in 0..usize::from(area.width) {
            let dot = |i: usize| {
                let (x, y) = (column * DOTS.0 + i % DOTS.0, row * DOTS.1 + i / DOTS.0);
                pixmap.pixels()[y * columns + x]
            };
            let at = (area.x + column as u16, area.y + row as u16);
            let shown = compose(look, std::array::from_fn(dot));
            if let (Some((symbol, style)), Some(cell)) = (shown, buffer.cell_mut(at)) {
                cell.set_char(symbol).set_style(style);
            }
        }
    }
}

/// What a cell shows; `None` where nothing is drawn. Bodies hide lines.
fn compose(look: &Appearance<'_>, dots: [PremultipliedColorU8; 8]) -> Option<(char, Style)> {
    let most = dots.iter().max_by_key(|dot| dot.alpha())?;
    let ascii = look.style == MapStyle::Ascii;
    let style = Style::new().fg(ink(look, *most));
    let covers = |from: u8| {
        let covered = |(i, dot): (usize, &PremultipliedColorU8)| {
            usize::from(dot.alpha() >= from).wrapping_shl(i as u32)
        };
        dots.iter().enumerate().map(covered).sum::<usize>()
    };
    match most.alpha() {
        0 => None,
        BODY | EGO => {
            let covered = covers(BODY);
            let half = covered.count_ones() as usize >= dots.len() / 2;
            // Without colours, bodies of dense dots are told from the ego, which is solid.
            let is_shaded = !look.has_colors() && most.alpha() == BODY;
            let symbol = match (ascii, is_shaded) {
                (true, true) if !half => return None,
                (true, true) => '%',
                (false, true) => braille(covered),
                (true, false) if half => '#',
                (true, false) => '+',
                (false, false) => {
                    let is_set =
                        |quarter: [usize; 2]| quarter.iter().any(|i| covered >> i & 1 == 1);
                    let set = QUARTERS.map(|quarter| usize::from(is_set(quarter)));
                    let parts = set.iter().enumerate().map(|(i, set)| set << i);
                    Blocks::Quadrants.symbol(parts.sum())
                }
            };
            Some((symbol, style))
        }
        faintest => {
            let set = covers(1);
            let symbol = if ascii { few(shape(set)) } else { braille(set) };
            let dim = faintest == FAINT && !look.has_colors();
            let style = if dim {
                style.add_modifier(Modifier::DIM)
            } else {
                style
            };
            Some((symbol, style))
        }
    }
}

/// The bits of a Braille character for dots, row by row.
fn shape(dots: usize) -> u32 {
    let numbered = BITS.iter().enumerate();
    let bits = numbered.map(|(i, bit)| if dots >> i & 1 == 1 { *bit } else { 0 });
    bits.sum()
}

fn braille(dots: usize) -> char {
    char::from_u32(BRAILLE + shape(dots)).unwrap_or(' ')
}

/// The colour of a dot, as the terminal has it.
fn ink(look: &Appearance<'_>, dot: PremultipliedColorU8) -> Color {
    if !look.has_colors() {
        return Color::Reset;
    }
    let rgb = [dot.red(), dot.green(), dot.blue()].map(f32::from);
    Inks::of(look.theme.ego).nearest(rgb).0
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
