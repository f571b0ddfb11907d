//! A screen of the terminal as a picture: cells in colours, signs as shapes where fonts leave gaps, letters as text.

use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::metrics::Measure;

use super::Color;
use super::cells::Blocks;
use super::display::{Area, Item, Picture, Provenance, Segment, Spot, Stroke, Text, circle};

/// A cell of the screen.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// What stands in it; nothing in the second half of a wide character.
    pub symbol: String,
    /// Colour of what stands in it.
    pub text: Color,
    /// Colour behind it; that of the screen if none.
    pub ground: Option<Color>,
    /// Whether it is bold.
    pub bold: bool,
    /// Whether it is underlined.
    pub underlined: bool,
}

/// A screen of cells, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Screen {
    /// How many cells a row has.
    pub columns: usize,
    /// All of them.
    pub cells: Vec<Cell>,
    /// Colour of the screen.
    pub ground: Color,
}

/// Which screen of the workbench is wanted.
#[derive(Debug, Clone)]
pub struct ScreenRequest {
    /// The scenario that is open.
    pub entry: Entry,
    /// Its ego.
    pub ego: EgoSelection,
    /// Columns and rows.
    pub size: (u16, u16),
    /// The time step; the one of the first contact or the lowest risk if none.
    pub step: Option<i64>,
    /// The picked obstacle; the most dangerous one if none.
    pub obstacle: Option<i64>,
    /// What is plotted.
    pub measure: Option<&'static Measure>,
    /// Name of the theme.
    pub theme: String,
}

/// Draws a screen, and says which step it shows; the command line gets it from the terminal's side, which it does not
/// know.
pub type ScreenPainter = fn(&ScreenRequest) -> Result<(Screen, i64), String>;

/// Width and height of a cell, points.
const CELL: (f64, f64) = (4.5, 9.0);

/// Size of the letters, points: they fill their cells.
const LETTERS: f64 = 7.5;

/// Height of the base line above the lower end of a cell, points.
const BASE: f64 = 2.3;

impl Screen {
    /// The screen as a picture, a column 4.5 points wide.
    #[must_use]
    pub fn picture(&self, provenance: Provenance) -> Picture {
        let columns = self.columns.max(1);
        let rows = self.cells.len().div_ceil(columns);
        let size = (columns as f64 * CELL.0, rows as f64 * CELL.1);
        let mut picture = Picture::new(size, self.ground);
        picture.provenance = provenance;
        picture.group("screen", None, |p| {
            for (y, row) in self.cells.chunks(columns).enumerate() {
                grounds(p, row, y);
            }
            let mut signs = Signs::default();
            for (y, row) in self.cells.chunks(columns).enumerate() {
                self.row(p, &mut signs, row, y);
            }
            signs.draw(p);
        });
        picture
    }

    fn row(&self, picture: &mut Picture, signs: &mut Signs, row: &[Cell], y: usize) {
        let mut letters: Option<(usize, usize, &Cell, String)> = None;
        for (x, cell) in row.iter().enumerate() {
            let area = area(x, y, 1);
            if cell.underlined {
                let line = Area {
                    y: area.bottom() - 1.2,
                    height: 0.5,
                    ..area
                };
                signs.add(cell.text, rectangle(&line));
            }
            let mut chars = cell.symbol.chars();
            let first = chars.next().unwrap_or(' ');
            let shape = shape(first, &area);
            let blank = first == ' ' || shape.is_some();
            if let Some(shape) = shape {
                signs.add_shape(cell.text, shape);
            }
            // Letters of a kind that follow each other are one text.
            let follows = letters.as_ref().is_some_and(|(_, end, like, _)| {
                *end == x && (like.text, like.bold) == (cell.text, cell.bold)
            });
            match &mut letters {
                Some((_, end, _, words)) if follows && !blank => {
                    words.push(first);
                    *end = x + 1;
                }
                _ => {
                    write(picture, letters.take(), y);
                    letters = (!blank).then(|| (x, x + 1, cell, first.to_string()));
                }
            }
        }
        write(picture, letters, y);
    }
}

fn write(picture: &mut Picture, letters: Option<(usize, usize, &Cell, String)>, y: usize) {
    let Some((x, _, cell, words)) = letters else {
        return;
    };
    let at = area(x, y, 1);
    let mut text =
        Text::new((at.x, at.bottom() - BASE), words, LETTERS, cell.text).in_bold(cell.bold);
    text.pitch = Some(CELL.0);
    picture.text(text);
}

fn area(x: usize, y: usize, columns: usize) -> Area {
    Area {
        x: x as f64 * CELL.0,
        y: y as f64 * CELL.1,
        width: columns as f64 * CELL.0,
        height: CELL.1,
    }
}

/// Cells of one ground beside each other are one box.
fn grounds(picture: &mut Picture, row: &[Cell], y: usize) {
    let mut x = 0;
    while x < row.len() {
        let ground = row[x].ground;
        let same = row[x..].iter().take_while(|c| c.ground == ground).count();
        if ground.is_some() {
            picture.rectangle(&area(x, y, same), ground, None);
        }
        x += same;
    }
}

/// What is drawn as shapes, by colour, so that a map of dots is one path.
#[derive(Default)]
struct Signs {
    filled: Vec<(Color, Vec<Segment>)>,
    lines: Vec<(Color, f64, Vec<Segment>)>,
}

impl Signs {
    fn add(&mut self, color: Color, path: Vec<Segment>) {
        match self.filled.iter_mut().find(|(c, _)| *c == color) {
            Some((_, all)) => all.extend(path),
            None => self.filled.push((color, path)),
        }
    }

    fn add_shape(&mut self, color: Color, shape: Shape) {
        self.add(color, shape.filled);
        for (width, points) in shape.lines {
            let path = points
                .iter()
                .enumerate()
                .map(|(i, p): (usize, &Spot)| match i {
                    0 => Segment::Move(*p),
                    _ => Segment::Line(*p),
                });
            match self
                .lines
                .iter_mut()
                .find(|(c, w, _)| (*c, *w) == (color, width))
            {
                Some((_, _, all)) => all.extend(path),
                None => self.lines.push((color, width, path.collect())),
            }
        }
    }

    fn draw(self, picture: &mut Picture) {
        for (color, path) in self.filled {
            if !path.is_empty() {
                picture.items.push(Item::Path {
                    path,
                    fill: Some(color),
                    stroke: None,
                });
            }
        }
        for (color, width, path) in self.lines {
            picture.items.push(Item::Path {
                path,
                fill: None,
                stroke: Some(Stroke::new(color, width)),
            });
        }
    }
}

/// A sign.
#[derive(Default)]
struct Shape {
    /// Outlines that are filled.
    filled: Vec<Segment>,
    /// Lines with their widths, points.
    lines: Vec<(f64, Vec<Spot>)>,
}

/// Widths of box lines, points.
const LIGHT: f64 = 0.55;

const HEAVY: f64 = 1.1;

/// The shape of a character; `None` for letters.
fn shape(c: char, cell: &Area) -> Option<Shape> {
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
fn rectangle(area: &Area) -> Vec<Segment> {
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
