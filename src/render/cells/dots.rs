//! Lines of a map: dots of Braille over its surfaces. Without surfaces, for terminals without colours or without Unicode,
//! dots or ASCII, and bodies.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use tiny_skia::{
    BlendMode, FillRule, FilterQuality, Paint, Pattern, Pixmap, PremultipliedColorU8, SpreadMode,
    Transform,
};

use super::colors::Inks;
use super::{Appearance, Blocks, MapStyle};
use crate::clip;
use crate::display::{Item, Picture, Stroke};
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

/// What a dot shows, written as its opacity: what matters more has more. Between the dashes of a marking it is empty.
const GAP: u8 = 251;
const FAINT: u8 = 252;
const LINE: u8 = 253;
const BODY: u8 = 254;
const EGO: u8 = 255;

/// Columns and rows of dots.
pub fn size(area: Rect) -> (u32, u32) {
    let dots = |cells: u16, each: usize| u32::from(cells) * each as u32;
    (dots(area.width, DOTS.0), dots(area.height, DOTS.1))
}

/// Dots of a picture as large as an area of cells, from the upper left corner. Where others draw the surfaces, those of
/// bodies alone.
pub fn dots(picture: &Picture, area: Rect, style: MapStyle) -> Option<Pixmap> {
    let (columns, rows) = size(area);
    let mut pixmap = Pixmap::new(columns, rows)?;
    let scale = (
        columns as f32 / picture.size.0 as f32,
        rows as f32 / picture.size.1 as f32,
    );
    let transform = Transform::from_scale(scale.0, scale.1);
    // Without colours every second dot of a body is set, so that it is one, however it is turned; the ego alone is
    // solid.
    let mut hatched = Pixmap::new(2, 2)?;
    let dot = PremultipliedColorU8::from_rgba(0, 0, 0, BODY)?;
    hatched.pixels_mut()[0] = dot;
    hatched.pixels_mut()[3] = dot;
    let mut groups: Vec<&str> = Vec::new();
    let mut junctions = Vec::new();
    clip::each(picture, |item| match item {
        Item::Begin { name, .. } => groups.push(name),
        Item::End => {
            if groups.pop() == Some("markings") {
                // Lanes that lead through a junction have theirs beside it alone.
                let paint = cleared();
                for path in &junctions {
                    pixmap.fill_path(path, &paint, FillRule::Winding, transform, None);
                }
            }
        }
        Item::Path {
            path,
            fill: Some(_),
            ..
        } if groups.last() == Some(&"junctions") => junctions.extend(outline(path)),
        Item::Text(_) => {}
        Item::Path { path, fill, stroke } => {
            let group = groups.last().copied().unwrap_or_default();
            let kind = kind(group);
            let opaque = fill.filter(|color| color.opacity > OPAQUE);
            let fill = opaque.filter(|_| kind >= BODY || !style.has_backgrounds());
            if fill.is_none() && stroke.is_none() {
                return;
            }
            let Some(path) = outline(path) else { return };
            let ink = |color: crate::Color, kind: u8| Paint {
                blend_mode: BlendMode::Source,
                anti_alias: false,
                ..paint(color.at(f64::from(kind) / 255.0))
            };
            if let Some(color) = fill {
                let mut paint = ink(color, kind);
                if group == "outlines" {
                    paint.shader = Pattern::new(
                        hatched.as_ref(),
                        SpreadMode::Repeat,
                        FilterQuality::Nearest,
                        1.0,
                        // The transform of the path is applied to it, too.
                        Transform::from_scale(1.0 / scale.0, 1.0 / scale.1),
                    );
                }
                pixmap.fill_path(&path, &paint, FillRule::Winding, transform, None);
            }
            if let Some(stroke) = stroke {
                let mut line = line(stroke);
                if line.width * scale.0 < FINE {
                    line.width = 0.0;
                }
                if kind == FAINT && style.has_backgrounds() && line.dash.take().is_some() {
                    let ink = ink(stroke.color, GAP);
                    pixmap.stroke_path(&path, &ink, &line, transform, None);
                    line.dash = crate::raster::line(stroke).dash;
                }
                let ink = ink(stroke.color, kind);
                pixmap.stroke_path(&path, &ink, &line, transform, None);
            }
        }
    });
    Some(pixmap)
}

fn kind(group: &str) -> u8 {
    match group {
        "markings" => FAINT,
        "obstacles" | "outlines" | "contact" => BODY,
        "ego" => EGO,
        _ => LINE,
    }
}

/// Whether a stroke is shown as dots in an area of cells, and not as blocks.
pub fn is_dots(picture: &Picture, area: Rect, group: &str, stroke: &Stroke) -> bool {
    let scale = f64::from(size(area).0) / picture.size.0;
    kind(group) < BODY && stroke.width * scale < f64::from(FINE)
}

fn cleared() -> Paint<'static> {
    Paint {
        blend_mode: BlendMode::Clear,
        anti_alias: false,
        ..Paint::default()
    }
}

/// A dot is larger than the line that it stands for: so much of its colour is the line's, the rest that of the surface.
const QUIET: f32 = 0.5;
/// Colours that are this far from each other, squared, are told apart at once.
const CLEAR: f32 = 2500.0;

fn is_clear(a: [f32; 3], b: [f32; 3]) -> bool {
    let both = a.iter().zip(b);
    both.map(|(a, b)| (a - b).powi(2)).sum::<f32>() > CLEAR
}

/// Writes lines over the cells of a picture, and leaves those out that show a body or an edge: `lines` and `surfaces` have
/// a pixel a dot. A line looks the same wherever it runs. The edge of the road is seen without its marking.
pub fn write_over(buffer: &mut Buffer, area: Rect, lines: &Pixmap, surfaces: &Pixmap, inks: Inks) {
    let columns = lines.width() as usize;
    let below = |x: usize, y: usize| {
        let x = x.min(columns - 1);
        let y = y.min(surfaces.height() as usize - 1);
        let pixel = surfaces.pixels()[y * columns + x];
        [pixel.red(), pixel.green(), pixel.blue()].map(f32::from)
    };
    let is_at_edge = |x: usize, y: usize| {
        let (left, up) = (x.saturating_sub(1), y.saturating_sub(1));
        is_clear(below(left, y), below(x + 1, y)) || is_clear(below(x, up), below(x, y + 1))
    };
    for row in 0..usize::from(area.height) {
        for column in 0..usize::from(area.width) {
            let place = |i: usize| (column * DOTS.0 + i % DOTS.0, row * DOTS.1 + i / DOTS.0);
            let dot = |i: usize| {
                let (x, y) = place(i);
                lines.pixels()[y * columns + x]
            };
            let Some(most) = (0..8).map(dot).max_by_key(|dot| dot.alpha()) else {
                continue;
            };
            let kind = most.alpha();
            if !(GAP..BODY).contains(&kind) {
                continue;
            }
            let is_shown = |i: &usize| {
                let (x, y) = place(*i);
                dot(*i).alpha() == kind && (kind == LINE || !is_at_edge(x, y))
            };
            let shown: usize = (0..8).filter(is_shown).map(|i| 1 << i).sum();
            let at = (area.x + column as u16, area.y + row as u16);
            let Some(cell) = buffer.cell_mut(at).filter(|_| shown > 0) else {
                continue;
            };
            let under: [[f32; 3]; 8] = std::array::from_fn(|i| below(place(i).0, place(i).1));
            let mean = std::array::from_fn(|i| under.iter().map(|c| c[i]).sum::<f32>() / 8.0);
            if under.iter().any(|color| is_clear(*color, under[0])) {
                continue;
            }
            let rgb = [most.red(), most.green(), most.blue()].map(f32::from);
            let quiet = std::array::from_fn(|i| rgb[i] * QUIET + mean[i] * (1.0 - QUIET));
            cell.bg = inks.nearest(mean).0;
            if kind == GAP {
                cell.set_char(' ');
            } else {
                let color = inks.nearest(quiet).0;
                // Few colours have none between the two.
                let is_seen = color != cell.bg;
                let color = if is_seen { color } else { inks.nearest(rgb).0 };
                cell.set_char(braille(shown)).set_fg(color);
            }
        }
    }
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
            // Without colours, bodies of dots are told from the ego, which is solid.
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
