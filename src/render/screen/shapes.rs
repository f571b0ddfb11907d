//! Signs that fill their cell as shapes: boxes, blocks, Braille, arrows; fonts leave gaps between them.

use crate::cells::Blocks;
use crate::display::{Area, Segment, Spot, circle};

/// A sign.
#[derive(Default)]
pub struct Shape {
    /// Outlines that are filled.
    pub filled: Vec<Segment>,
    /// Lines with their widths, points.
    pub lines: Vec<(f64, Vec<Spot>)>,
}

/// Widths of box lines, points.
const LIGHT: f64 = 0.55;
const HEAVY: f64 = 1.1;

/// The shape of a character; `None` for letters.
pub fn shape(c: char, cell: &Area) -> Option<Shape> {
    let at = |x: f64, y: f64| (cell.x + x * cell.width, cell.y + y * cell.height);
    let part = |x: f64, y: f64, width: f64, height: f64| {
        let (x, y) = at(x, y);
        rectangle(&Area {
            x,
            y,
            width: width * cell.width,
            height: height * cell.height,
        })
    };
    let filled = |filled: Vec<Segment>| {
        Some(Shape {
            filled,
            lines: Vec::new(),
        })
    };
    let polygon = |points: &[(f64, f64)]| {
        let mut path = Vec::new();
        for (i, &(x, y)) in points.iter().enumerate() {
            let spot = at(x, y);
            path.push(if i == 0 {
                Segment::Move(spot)
            } else {
                Segment::Line(spot)
            });
        }
        path.push(Segment::Close);
        path
    };
    let strokes = |lines: &[&[(f64, f64)]]| {
        let line =
            |points: &&[(f64, f64)]| (LIGHT * 1.2, points.iter().map(|&(x, y)| at(x, y)).collect());
        Some(Shape {
            filled: Vec::new(),
            lines: lines.iter().map(line).collect(),
        })
    };
    // An arrow to a corner of the square in the middle of the cell.
    let slanted = |right: bool, up: bool| {
        let spot = |x: f64, y: f64| {
            let x = if right { x } else { 1.0 - x };
            (x, if up { y } else { 1.06 - y })
        };
        strokes(&[
            &[spot(0.1, 0.73), spot(0.9, 0.33)],
            &[spot(0.42, 0.33), spot(0.9, 0.33), spot(0.9, 0.57)],
        ])
    };
    let dot = |radius: f64| circle(at(0.5, 0.53), radius * cell.width);
    let code = u32::from(c);
    match c {
        '\u{2800}'..='\u{28ff}' => filled(braille(code - 0x2800, cell)),
        '█' => filled(part(0.0, 0.0, 1.0, 1.0)),
        '▀' => filled(part(0.0, 0.0, 1.0, 0.5)),
        '▁'..='▇' => {
            let height = f64::from(code - 0x2580) / 8.0;
            filled(part(0.0, 1.0 - height, 1.0, height))
        }
        '▉'..='▏' => filled(part(0.0, 0.0, f64::from(0x2590 - code) / 8.0, 1.0)),
        '▐' => filled(part(0.5, 0.0, 0.5, 1.0)),
        '▔' => filled(part(0.0, 0.0, 1.0, 0.125)),
        '▕' => filled(part(0.875, 0.0, 0.125, 1.0)),
        '▸' | '▶' | '►' => filled(polygon(&[(0.15, 0.27), (0.9, 0.53), (0.15, 0.79)])),
        '◂' | '◀' | '◄' => filled(polygon(&[(0.85, 0.27), (0.1, 0.53), (0.85, 0.79)])),
        '▴' | '▲' => filled(polygon(&[(0.1, 0.75), (0.5, 0.33), (0.9, 0.75)])),
        '▾' | '▼' => filled(polygon(&[(0.1, 0.33), (0.5, 0.75), (0.9, 0.33)])),
        '◆' => filled(polygon(&[
            (0.5, 0.28),
            (0.95, 0.53),
            (0.5, 0.78),
            (0.05, 0.53),
        ])),
        '■' | '▪' => filled(part(0.15, 0.36, 0.7, 0.35)),
        '●' => filled(dot(0.42)),
        '…' => filled(
            (0..3)
                .flat_map(|i| circle(at(0.17 + 0.33 * f64::from(i), 0.7), 0.09 * cell.width))
                .collect(),
        ),
        '≠' => strokes(&[
            &[(0.1, 0.46), (0.9, 0.46)],
            &[(0.1, 0.62), (0.9, 0.62)],
            &[(0.28, 0.74), (0.72, 0.34)],
        ]),
        '≤' => strokes(&[
            &[(0.88, 0.32), (0.14, 0.48), (0.88, 0.63)],
            &[(0.14, 0.74), (0.88, 0.74)],
        ]),
        '≥' => strokes(&[
            &[(0.12, 0.32), (0.86, 0.48), (0.12, 0.63)],
            &[(0.12, 0.74), (0.86, 0.74)],
        ]),
        '–' | '—' | '−' => strokes(&[&[(0.08, 0.55), (0.92, 0.55)]]),
        '✓' => strokes(&[&[(0.12, 0.57), (0.4, 0.74), (0.9, 0.32)]]),
        '✗' => strokes(&[&[(0.15, 0.36), (0.85, 0.74)], &[(0.85, 0.36), (0.15, 0.74)]]),
        '→' => strokes(&[
            &[(0.05, 0.54), (0.92, 0.54)],
            &[(0.58, 0.4), (0.93, 0.54), (0.58, 0.68)],
        ]),
        '←' => strokes(&[
            &[(0.95, 0.54), (0.08, 0.54)],
            &[(0.42, 0.4), (0.07, 0.54), (0.42, 0.68)],
        ]),
        '↑' => strokes(&[
            &[(0.5, 0.8), (0.5, 0.26)],
            &[(0.2, 0.43), (0.5, 0.25), (0.8, 0.43)],
        ]),
        '↓' => strokes(&[
            &[(0.5, 0.25), (0.5, 0.8)],
            &[(0.2, 0.63), (0.5, 0.81), (0.8, 0.63)],
        ]),
        '↗' => slanted(true, true),
        '↖' => slanted(false, true),
        '↘' => slanted(true, false),
        '↙' => slanted(false, false),
        '↩' | '⏎' => strokes(&[
            &[(0.9, 0.3), (0.9, 0.58), (0.1, 0.58)],
            &[(0.4, 0.46), (0.1, 0.58), (0.4, 0.7)],
        ]),
        _ => boxes(c, cell).or_else(|| filled(blocks(c, cell)?)),
    }
}

/// The parts of a cell that a block character fills, as the map is made of them.
fn blocks(c: char, cell: &Area) -> Option<Vec<Segment>> {
    let (blocks, parts) = Blocks::of_symbol(c)?;
    let (across, down) = blocks.per_cell();
    let (width, height) = (cell.width / across as f64, cell.height / down as f64);
    let part = |i: usize| {
        rectangle(&Area {
            x: cell.x + (i % across) as f64 * width,
            y: cell.y + (i / across) as f64 * height,
            width,
            height,
        })
    };
    let set = (0..across * down).filter(|i| parts >> i & 1 == 1);
    Some(set.flat_map(part).collect())
}

/// A filled box.
pub fn rectangle(area: &Area) -> Vec<Segment> {
    vec![
        Segment::Move((area.x, area.y)),
        Segment::Line((area.right(), area.y)),
        Segment::Line((area.right(), area.bottom())),
        Segment::Line((area.x, area.bottom())),
        Segment::Close,
    ]
}

/// Two columns of four dots, as the terminal's map is made of.
fn braille(bits: u32, cell: &Area) -> Vec<Segment> {
    const PLACES: [(u8, u8); 8] = [
        (0, 0),
        (0, 1),
        (0, 2),
        (1, 0),
        (1, 1),
        (1, 2),
        (0, 3),
        (1, 3),
    ];
    let (width, height) = (cell.width / 2.0, cell.height / 4.0);
    let set = PLACES
        .iter()
        .enumerate()
        .filter(|(bit, _)| bits >> bit & 1 == 1);
    let dot = |(_, (x, y)): (usize, &(u8, u8))| {
        let center = (
            cell.x + (f64::from(*x) + 0.5) * width,
            cell.y + (f64::from(*y) + 0.5) * height,
        );
        circle(center, width * 0.34)
    };
    set.flat_map(dot).collect()
}

/// Lines from the middle of the cell to its sides: left, right, up, down, each none, light or heavy.
fn boxes(c: char, cell: &Area) -> Option<Shape> {
    let arms: [u8; 4] = match c {
        '─' => [1, 1, 0, 0],
        '━' => [2, 2, 0, 0],
        '│' => [0, 0, 1, 1],
        '┃' => [0, 0, 2, 2],
        '┌' => [0, 1, 0, 1],
        '┐' => [1, 0, 0, 1],
        '└' => [0, 1, 1, 0],
        '┘' => [1, 0, 1, 0],
        '┏' => [0, 2, 0, 2],
        '┓' => [2, 0, 0, 2],
        '┗' => [0, 2, 2, 0],
        '┛' => [2, 0, 2, 0],
        '├' => [0, 1, 1, 1],
        '┤' => [1, 0, 1, 1],
        '┬' => [1, 1, 0, 1],
        '┴' => [1, 1, 1, 0],
        '┼' => [1, 1, 1, 1],
        '┣' => [0, 2, 2, 2],
        '┫' => [2, 0, 2, 2],
        '┳' => [2, 2, 0, 2],
        '┻' => [2, 2, 2, 0],
        '╋' => [2, 2, 2, 2],
        '╴' => [1, 0, 0, 0],
        '╵' => [0, 0, 1, 0],
        '╶' => [0, 1, 0, 0],
        '╷' => [0, 0, 0, 1],
        '═' | '║' | '╌' | '┄' | '┈' | '╎' | '┆' | '╭' | '╮' | '╰' | '╯' => {
            return Some(special(c, cell));
        }
        _ => return None,
    };
    let middle = cell.center();
    let ends = [
        (cell.x, middle.1),
        (cell.right(), middle.1),
        (middle.0, cell.y),
        (middle.0, cell.bottom()),
    ];
    let lines = arms
        .iter()
        .zip(ends)
        .filter(|(arm, _)| **arm > 0)
        .map(|(arm, end)| {
            let width = if *arm > 1 { HEAVY } else { LIGHT };
            // Over the middle by half of the width, so that corners are closed.
            let over =
                |m: f64, e: f64| m - (e - m).signum() * width / 2.0 * f64::from(u8::from(e != m));
            (
                width,
                vec![(over(middle.0, end.0), over(middle.1, end.1)), end],
            )
        });
    Some(Shape {
        filled: Vec::new(),
        lines: lines.collect(),
    })
}

/// Round corners, dashes, and double lines.
fn special(c: char, cell: &Area) -> Shape {
    let at = |x: f64, y: f64| (cell.x + x * cell.width, cell.y + y * cell.height);
    let corner = |x: f64, y: f64| {
        // From the side at x through a quarter of an ellipse to the end at y.
        let bend = |t: f64| {
            let (sin, cos) = (t * std::f64::consts::FRAC_PI_2).sin_cos();
            at(
                0.5 + (x - 0.5) * (1.0 - sin),
                0.5 + (y - 0.5) * 0.5 * (1.0 - cos),
            )
        };
        let mut points = vec![at(x, 0.5)];
        points.extend((0..=6).map(|i| bend(f64::from(i) / 6.0)));
        points.push(at(0.5, y));
        (LIGHT, points)
    };
    let lines = match c {
        '╭' => vec![corner(1.0, 1.0)],
        '╮' => vec![corner(0.0, 1.0)],
        '╰' => vec![corner(1.0, 0.0)],
        '╯' => vec![corner(0.0, 0.0)],
        '═' => [0.43, 0.57]
            .map(|y| (LIGHT, vec![at(0.0, y), at(1.0, y)]))
            .to_vec(),
        '║' => [0.36, 0.64]
            .map(|x| (LIGHT, vec![at(x, 0.0), at(x, 1.0)]))
            .to_vec(),
        '╎' | '┆' => [0.1, 0.6]
            .map(|y| (LIGHT, vec![at(0.5, y), at(0.5, y + 0.3)]))
            .to_vec(),
        _ => [0.05, 0.55]
            .map(|x| (LIGHT, vec![at(x, 0.5), at(x + 0.35, 0.5)]))
            .to_vec(),
    };
    Shape {
        filled: Vec::new(),
        lines,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_shapes_and_letters_are_not() {
        let cell = Area {
            x: 0.0,
            y: 0.0,
            width: 4.0,
            height: 8.0,
        };
        for c in "⣿▁█▌▸●…≠─│┌╭╯═→↗↙▚▛🬝🬎𜺠".chars() {
            assert!(shape(c, &cell).is_some(), "{c}");
        }
        for c in "aZ0ü²·".chars() {
            assert!(shape(c, &cell).is_none(), "{c}");
        }
        // The upper left and the lower right quarter.
        let quarters = shape('▚', &cell).map(|s| s.filled).unwrap_or_default();
        let corners: Vec<Spot> = quarters
            .iter()
            .filter_map(|s| match s {
                Segment::Move(spot) => Some(*spot),
                _ => None,
            })
            .collect();
        assert_eq!(corners, [(0.0, 0.0), (2.0, 4.0)]);
        let lines = shape('┼', &cell).map_or(0, |s| s.lines.len());
        assert_eq!(lines, 4);
    }
}
