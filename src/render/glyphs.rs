//! Letters as outlines, without the system's fonts: traced once from a smooth bitmap of Noto Sans Mono.

use std::collections::HashMap;
use std::sync::{LazyLock, Mutex, PoisonError};

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// A closed line, in parts of the size of the letters, from the beginning of the letter on its base line; y is down.
pub type Contour = Vec<(f32, f32)>;

/// A letter.
#[derive(Debug, Clone)]
pub struct Glyph {
    /// Outlines, filled by the even-odd rule.
    pub contours: Vec<Contour>,
    /// Where its ink begins and ends; `None` for a space.
    pub ink: Option<(f32, f32)>,
}

/// Height of a capital in parts of the size, as in most fonts of this kind.
const CAPITAL: f32 = 0.714;
/// Letters are as narrow as those of other fonts for print.
const NARROW: f32 = 0.93;
/// Free on both sides of a letter together, in parts of the size.
const BEARING: f32 = 0.13;
/// Width of a space, in parts of the size.
const SPACE: f32 = 0.3;
/// A pixel is inside from half of its brightest value on.
const INSIDE: f32 = 127.5;

/// How the bitmaps lie: pixels.
struct Face {
    base: f32,
    size: f32,
}

fn face() -> &'static Face {
    static FACE: LazyLock<Face> = LazyLock::new(|| {
        let capital = contours('H', false);
        let ys = || capital.iter().flatten().map(|p| p.1);
        let top = ys().fold(f32::MAX, f32::min);
        let base = ys().fold(f32::MIN, f32::max);
        Face {
            base,
            size: (base - top) / CAPITAL,
        }
    });
    &FACE
}

/// The width that every letter has where letters stand in columns, in parts of the size.
pub fn pitch() -> f32 {
    get_raster_width(FontWeight::Regular, RasterHeight::Size32) as f32 / face().size
}

/// The outlines of a character; an empty box for one that the font does not have.
pub fn glyph(c: char, bold: bool) -> Glyph {
    static KNOWN: LazyLock<Mutex<HashMap<(char, bool), Glyph>>> = LazyLock::new(Mutex::default);
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    known
        .entry((c, bold))
        .or_insert_with(|| trace(c, bold))
        .clone()
}

/// How far a letter takes the line where letters have their own widths, and how far it is moved for that.
pub fn advance(c: char, glyph: &Glyph) -> (f32, f32) {
    // Figures stand below each other in columns of numbers.
    if c.is_ascii_digit() {
        return (pitch() * NARROW, 0.0);
    }
    match glyph.ink {
        Some((from, to)) => (
            (to - from) * NARROW + BEARING,
            BEARING / 2.0 - from * NARROW,
        ),
        None => (SPACE, 0.0),
    }
}

/// The narrowing of letters that have their own widths.
pub fn narrow() -> f32 {
    NARROW
}

fn trace(c: char, bold: bool) -> Glyph {
    let face = face();
    let known = contours(substitute(c), bold);
    let on_line = |(x, y): (f32, f32)| (x / face.size, (y - face.base) / face.size);
    let mut contours: Vec<Contour> = known
        .into_iter()
        .map(|ring| ring.into_iter().map(on_line).collect())
        .collect();
    let drawable = get_raster(substitute(c), FontWeight::Regular, RasterHeight::Size32).is_some();
    if !drawable {
        let frame = |i: f32| {
            vec![
                (0.08 + i, -0.7 + i),
                (0.5 - i, -0.7 + i),
                (0.5 - i, -i),
                (0.08 + i, -i),
            ]
        };
        contours = vec![frame(0.0), frame(0.05)];
    }
    let xs = || contours.iter().flatten().map(|p| p.0);
    let ink = xs().reduce(f32::min).zip(xs().reduce(f32::max));
    Glyph { contours, ink }
}

/// A character of the font that stands for one that it does not have.
fn substitute(c: char) -> char {
    match c {
        '\u{2212}' | '\u{2010}' | '\u{2011}' | '–' | '—' => '-',
        '‘' | '’' => '\'',
        '“' | '”' => '"',
        '\u{202f}' | '\u{2009}' => ' ',
        '•' => '·',
        c => c,
    }
}

/// Lines along half brightness, in pixels: between two pixels where the brightness between them is that of an edge.
fn contours(c: char, bold: bool) -> Vec<Contour> {
    let weight = if bold {
        FontWeight::Bold
    } else {
        FontWeight::Regular
    };
    let Some(raster) = get_raster(c, weight, RasterHeight::Size32) else {
        return Vec::new();
    };
    let (width, height) = (raster.width() as i32, raster.height() as i32);
    let value = |x: i32, y: i32| {
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        let pixel = inside
            .then(|| raster.pixel(x as usize, y as usize))
            .flatten();
        f32::from(pixel.unwrap_or(0))
    };
    // An edge lies between two neighbouring pixels: (x, y, whether they are one above the other).
    type Edge = (i32, i32, bool);
    let spot = |(x, y, down): Edge| {
        let (a, b) = (
            value(x, y),
            if down {
                value(x, y + 1)
            } else {
                value(x + 1, y)
            },
        );
        let part = (INSIDE - a) / (b - a);
        let (x, y) = (x as f32 + 0.5, y as f32 + 0.5);
        if down { (x, y + part) } else { (x + part, y) }
    };
    let mut next: HashMap<Edge, Vec<Edge>> = HashMap::new();
    let mut starts = Vec::new();
    for y in -1..height {
        for x in -1..width {
            let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
            let inside = corners.map(|(x, y)| value(x, y) > INSIDE);
            let edges: [Edge; 4] = [
                (x, y, false),
                (x + 1, y, true),
                (x, y + 1, false),
                (x, y, true),
            ];
            // Around the cell, a line leaves where the inside ends and comes in where it begins.
            for i in 0..4 {
                if inside[i] && !inside[(i + 1) % 4] {
                    let mut back = i;
                    while inside[(back + 3) % 4] {
                        back = (back + 3) % 4;
                    }
                    // Two corners across from each other belong together where the middle is inside.
                    let across = inside[(i + 2) % 4] && back == i && !inside[(i + 3) % 4];
                    let middle = corners.iter().map(|(x, y)| value(*x, *y)).sum::<f32>() / 4.0;
                    let to = if across && middle > INSIDE {
                        edges[(i + 1) % 4]
                    } else {
                        edges[(back + 3) % 4]
                    };
                    let from = edges[i];
                    next.entry(from).or_default().push(to);
                    starts.push(from);
                }
            }
        }
    }
    let mut rings = Vec::new();
    for start in starts {
        let mut ring = Vec::new();
        let mut at = start;
        while let Some(to) = next.get_mut(&at).and_then(Vec::pop) {
            ring.push(spot(at));
            at = to;
        }
        if ring.len() > 2 {
            rings.push(ring);
        }
    }
    rings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_have_their_holes_and_stand_on_the_line() {
        for (c, rings) in [('H', 1), ('o', 2), ('8', 3), ('i', 2), ('%', 5), (' ', 0)] {
            assert_eq!(glyph(c, false).contours.len(), rings, "{c}");
        }
        let h = glyph('H', true);
        let ys = || h.contours.iter().flatten().map(|p| p.1);
        assert!(ys().fold(f32::MIN, f32::max).abs() < 0.02);
        assert!((ys().fold(f32::MAX, f32::min) + CAPITAL).abs() < 0.02);
        assert!((0.5..0.7).contains(&pitch()), "{}", pitch());
    }

    #[test]
    fn what_the_font_does_not_have_is_a_box() {
        assert_eq!(glyph('漢', false).contours.len(), 2);
        assert_eq!(glyph('\u{2212}', false).contours.len(), 1);
        assert!(glyph('²', false).contours.len() == 1);
    }
}
