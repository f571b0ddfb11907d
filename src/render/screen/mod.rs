//! A screen of the terminal as a picture: cells in colours, signs as shapes, letters as text.

mod shapes;

use super::Color;
use super::display::{Area, Item, Picture, Provenance, Segment, Spot, Stroke, Text};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::metrics::Measure;

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
                signs.add(cell.text, shapes::rectangle(&line));
            }
            let mut chars = cell.symbol.chars();
            let first = chars.next().unwrap_or(' ');
            let shape = shapes::shape(first, &area);
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

    fn add_shape(&mut self, color: Color, shape: shapes::Shape) {
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
