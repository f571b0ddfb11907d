//! A canvas of character cells: areas at the resolution of block characters, lines and strokes at that of Braille dots.
//!
//! Coordinates are metres from the middle of the map, x to the right and y up. What is drawn in a later layer covers
//! what is below it; [`Canvas::paint`] chooses two colours and a character for every cell.

use nearmiss_base::geometry::Point;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;

use super::compose::{Sample, compose};
use super::silhouette::{self, Silhouette};
use super::{CellView, MapStyle};
use crate::scene::LineStyle;

/// Dots of a Braille character: columns and rows.
const DOTS: (usize, usize) = (2, 4);
/// A line has at most so many dots.
const MOST_DOTS: f64 = 20_000.0;

/// What is seen at a dot; in layer 0 nothing is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Later layers cover earlier ones.
    pub layer: u8,
    /// Its colour.
    pub color: Color,
    /// Whether it matters less, for terminals without colours.
    pub faint: bool,
    /// Whether it is shaded, for terminals without colours: a body beside the ego.
    pub shaded: bool,
}

/// The layer of the road and what else lies on the ground.
pub const GROUND: u8 = 1;

const EMPTY: Dot = Dot {
    layer: 0,
    color: Color::Reset,
    faint: false,
    shaded: false,
};

/// Dots of one size over the whole map.
#[derive(Debug)]
struct Grid {
    dots: Vec<Dot>,
    columns: usize,
    rows: usize,
    /// Metres from a dot to the next.
    size: (f64, f64),
}

/// The canvas.
#[derive(Debug)]
pub struct Canvas<'a> {
    view: &'a CellView,
    style: MapStyle,
    columns: usize,
    rows: usize,
    areas: Grid,
    lines: Grid,
    layer: u8,
    faint: bool,
    /// Room for the spans of an area.
    spans: Vec<(usize, usize, usize)>,
}

impl Grid {
    fn new(view: &CellView, cells: (usize, usize), per_cell: (usize, usize), dot: Dot) -> Self {
        let (columns, rows) = (cells.0 * per_cell.0, cells.1 * per_cell.1);
        Self {
            dots: vec![dot; columns * rows],
            columns,
            rows,
            size: (
                view.cell.0 / per_cell.0 as f64,
                view.cell.1 / per_cell.1 as f64,
            ),
        }
    }

    /// The dot at a place, in parts of dots from the upper left corner.
    fn place(&self, half: (f64, f64), (x, y): (f64, f64)) -> (f64, f64) {
        ((x + half.0) / self.size.0, (half.1 - y) / self.size.1)
    }

    fn set(&mut self, column: f64, row: f64, dot: Dot) -> bool {
        let inside =
            column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        if inside {
            self.dots[row as usize * self.columns + column as usize] = dot;
        }
        inside
    }

    /// Sets the dots of a line from one place to another, both in parts of dots and near the map.
    fn line(&mut self, from: (f64, f64), to: (f64, f64), dot: Dot) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let count = dx.abs().max(dy.abs()).ceil();
        if !(0.0..=MOST_DOTS).contains(&count) {
            return;
        }
        for i in 0..=count as usize {
            let part = if count > 0.0 { i as f64 / count } else { 0.0 };
            self.set(
                (from.0 + dx * part).floor(),
                (from.1 + dy * part).floor(),
                dot,
            );
        }
    }

    /// The dots whose centres lie in a ring: their row, the first column and the one behind the last.
    fn spans(
        &self,
        half: (f64, f64),
        ring: &[(f64, f64)],
        mut with: impl FnMut(usize, usize, usize),
    ) {
        let corners: Vec<(f64, f64)> = ring.iter().map(|p| self.place(half, *p)).collect();
        let rows = corners.iter().map(|p| p.1);
        let (low, high) = rows.fold((f64::MAX, f64::MIN), |(low, high), y| {
            (low.min(y), high.max(y))
        });
        let row = |y: f64| y.clamp(0.0, self.rows as f64) as usize;
        let mut crossings: Vec<f64> = Vec::new();
        for row in row((low - 0.5).ceil())..row((high + 0.5).floor()) {
            let y = row as f64 + 0.5;
            crossings.clear();
            for (i, &(x1, y1)) in corners.iter().enumerate() {
                let (x2, y2) = corners[(i + 1) % corners.len()];
                if (y1 > y) != (y2 > y) {
                    crossings.push(x1 + (y - y1) / (y2 - y1) * (x2 - x1));
                }
            }
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                let column = |x: f64| (x - 0.5).ceil().clamp(0.0, self.columns as f64) as usize;
                let (from, to) = (column(pair[0]), column(pair[1]));
                if from < to {
                    with(row, from, to);
                }
            }
        }
    }
}

impl<'a> Canvas<'a> {
    /// An empty one for an area of cells; where the style has backgrounds, of the colour `ground`.
    pub fn new(view: &'a CellView, area: Rect, style: MapStyle, ground: Color) -> Self {
        let (columns, rows) = (usize::from(area.width), usize::from(area.height));
        let empty = if style.has_backgrounds() {
            Dot {
                layer: GROUND,
                color: ground,
                faint: false,
                shaded: false,
            }
        } else {
            EMPTY
        };
        Self {
            view,
            style,
            columns,
            rows,
            areas: Grid::new(view, (columns, rows), style.blocks().per_cell(), empty),
            lines: Grid::new(view, (columns, rows), DOTS, EMPTY),
            layer: GROUND,
            faint: false,
            spans: Vec::new(),
        }
    }

    /// What follows covers what was drawn before.
    pub fn layer(&mut self) {
        self.layer = self.layer.saturating_add(1);
    }

    /// Whether what follows matters less.
    pub fn faint(&mut self, faint: bool) {
        self.faint = faint;
    }

    fn dot(&self, color: Color) -> Dot {
        Dot {
            layer: self.layer,
            color,
            faint: self.faint,
            shaded: false,
        }
    }

    /// Fills a ring of points (not closed), at the resolution of blocks.
    pub fn area(&mut self, ring: &[(f64, f64)], color: Color) {
        let dot = self.dot(color);
        let mut spans = std::mem::take(&mut self.spans);
        self.areas.spans(self.view.half, ring, |row, from, to| {
            spans.push((row, from, to))
        });
        for (row, from, to) in spans.drain(..) {
            let start = row * self.areas.columns;
            self.areas.dots[start + from..start + to].fill(dot);
        }
        self.spans = spans;
    }

    /// The parts of blocks that a body covers, moved by so many metres.
    pub fn silhouette(&self, rings: &[Vec<(f64, f64)>], by: (f64, f64)) -> Silhouette {
        let moved = |&(x, y): &(f64, f64)| {
            let at = (x + by.0, y + by.1);
            self.areas.place(self.view.half, at)
        };
        let rings: Vec<Vec<(f64, f64)>> = rings
            .iter()
            .map(|ring| ring.iter().map(moved).collect())
            .collect();
        Silhouette::new(&rings, (self.areas.columns, self.areas.rows))
    }

    /// How far a body is moved, metres, so that equal bodies have equal silhouettes: their middles lie alike in the
    /// parts of blocks.
    pub fn snap(&self, rings: &[Vec<(f64, f64)>]) -> (f64, f64) {
        let places = rings
            .iter()
            .flatten()
            .map(|p| self.areas.place(self.view.half, *p));
        let (dx, dy) = silhouette::snap(places);
        (dx * self.areas.size.0, -dy * self.areas.size.1)
    }

    /// The parts of blocks of a line.
    pub fn add_line(
        &self,
        parts: &mut Silhouette,
        from: (f64, f64),
        to: (f64, f64),
        by: (f64, f64),
    ) {
        let place = |(x, y): (f64, f64)| self.areas.place(self.view.half, (x + by.0, y + by.1));
        parts.add_line(place(from), place(to));
    }

    /// Fills parts of blocks; shaded, they are told from others without colours.
    pub fn fill(&mut self, parts: &Silhouette, color: Color, shaded: bool) {
        let dot = Dot {
            shaded,
            ..self.dot(color)
        };
        let columns = self.areas.columns;
        for (column, row) in parts.within((columns, self.areas.rows)) {
            self.areas.dots[row * columns + column] = dot;
        }
    }

    /// Scattered fine dots in a ring, so that what lies below stays readable.
    pub fn scatter(&mut self, ring: &[(f64, f64)], color: Color) {
        const EVERY: usize = 4;
        let dot = self.dot(color);
        let mut spans = std::mem::take(&mut self.spans);
        self.lines.spans(self.view.half, ring, |row, from, to| {
            spans.push((row, from, to))
        });
        for (row, from, to) in spans.drain(..) {
            // Every other row is shifted, so that the dots stand like bricks.
            let shift = row / EVERY % 2 * (EVERY / 2);
            let columns = (from..to).filter(|column| (column + shift).is_multiple_of(EVERY));
            for column in columns.filter(|_| row.is_multiple_of(EVERY)) {
                self.lines.dots[row * self.lines.columns + column] = dot;
            }
        }
        self.spans = spans;
    }

    /// A line as wide as a dot of an area.
    pub fn bar(&mut self, from: (f64, f64), to: (f64, f64), color: Color) {
        let dot = self.dot(color);
        Self::on(&mut self.areas, self.view, from, to, dot);
    }

    /// A line that stays unbroken to the eye: as wide as a dot of an area where bodies have backgrounds, else two fine
    /// ones.
    pub fn thick(&mut self, from: (f64, f64), to: (f64, f64), color: Color) {
        if self.style.has_backgrounds() {
            self.bar(from, to, color)
        } else {
            let (dx, dy) = (to.0 - from.0, to.1 - from.1);
            let length = dx.hypot(dy);
            self.line(from, to, color);
            if length > 0.0 && length.is_finite() {
                let by = (-dy / length * self.view.dot, dx / length * self.view.dot);
                let aside = |(x, y): (f64, f64)| (x + by.0, y + by.1);
                self.line(aside(from), aside(to), color);
            }
        }
    }

    /// A fine line.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), color: Color) {
        let dot = self.dot(color);
        Self::on(&mut self.lines, self.view, from, to, dot);
    }

    fn on(grid: &mut Grid, view: &CellView, from: (f64, f64), to: (f64, f64), dot: Dot) {
        if let Some((enters, leaves)) = view.part_seen(from, to) {
            let at = |part: f64| {
                let x = from.0 + (to.0 - from.0) * part;
                grid.place(view.half, (x, from.1 + (to.1 - from.1) * part))
            };
            let (from, to) = (at(enters), at(leaves));
            grid.line(from, to, dot);
        }
    }

    /// A fine dot.
    pub fn point(&mut self, at: (f64, f64), color: Color) {
        let (column, row) = self.lines.place(self.view.half, at);
        let dot = self.dot(color);
        self.lines.set(column.floor(), row.floor(), dot);
    }

    /// Writes all cells into the buffer.
    pub fn paint(&self, buffer: &mut Buffer, area: Rect) {
        let blocks = self.style.blocks();
        let (across, down) = blocks.per_cell();
        let mut areas = [EMPTY; 8];
        let mut lines = [EMPTY; 8];
        for row in 0..self.rows {
            for column in 0..self.columns {
                Self::gather(&self.areas, (column, row), (across, down), &mut areas);
                Self::gather(&self.lines, (column, row), DOTS, &mut lines);
                let sample = Sample {
                    areas: &areas[..across * down],
                    lines: &lines,
                };
                let at = (area.x + column as u16, area.y + row as u16);
                if let (Some(glyph), Some(cell)) =
                    (compose(self.style, &sample), buffer.cell_mut(at))
                {
                    cell.set_char(glyph.symbol).set_style(glyph.style);
                }
            }
        }
    }

    fn gather(
        grid: &Grid,
        cell: (usize, usize),
        (across, down): (usize, usize),
        to: &mut [Dot; 8],
    ) {
        for row in 0..down {
            let start = (cell.1 * down + row) * grid.columns + cell.0 * across;
            let dots = &grid.dots[start..start + across];
            to[row * across..(row + 1) * across].copy_from_slice(dots);
        }
    }
}

/// Dots of a dash and of the gap behind it.
const DASH: (f64, f64) = (5.0, 4.0);
/// Dots from one dot to the next of a dotted line.
const SPARSE: f64 = 5.0;
/// Dots from one cross to the next.
pub const CROSSES: f64 = 9.0;
/// Pieces of a line that are longer than this are no pieces of a road, metres.
const MAX_COORDINATE: f64 = 1e100;
/// Dashes that fit on the largest map, at a period of a dot.
const MOST_DASHES: f64 = 10_000.0;

/// Draws an open line of the world in a style.
pub fn styled(
    canvas: &mut Canvas<'_>,
    view: &CellView,
    line: &[Point],
    style: LineStyle,
    color: Color,
) {
    match style {
        LineStyle::Solid => stroke(canvas, view, line, color),
        LineStyle::Thick => {
            for pair in line.windows(2) {
                canvas.thick(view.at(&pair[0]), view.at(&pair[1]), color);
            }
        }
        LineStyle::Dashed => {
            let (on, off) = DASH;
            dashes(canvas, view, line, (on * view.dot, off * view.dot), color);
        }
        LineStyle::Dotted => {
            walk(view, line, 0.0, SPARSE * view.dot, |at, _| {
                canvas.point(at, color)
            });
        }
    }
}

/// Draws an unbroken open line.
pub fn stroke(canvas: &mut Canvas<'_>, view: &CellView, points: &[Point], color: Color) {
    for pair in points.windows(2) {
        canvas.line(view.at(&pair[0]), view.at(&pair[1]), color);
    }
}

/// Draws the outlines of a region.
pub fn outlines(canvas: &mut Canvas<'_>, view: &CellView, rings: &[Vec<Point>], color: Color) {
    for ring in rings {
        stroke(canvas, view, ring, color);
        if let [first, .., last] = ring.as_slice() {
            stroke(canvas, view, &[*last, *first], color);
        }
    }
}

/// Draws dashes along a line; lengths of dash and gap in metres.
pub fn dashes(
    canvas: &mut Canvas<'_>,
    view: &CellView,
    line: &[Point],
    (on, off): (f64, f64),
    color: Color,
) {
    walk(view, line, on, off, |from, to| {
        canvas.line(from, to, color);
    });
}

/// A cross of three dots by three.
fn cross(canvas: &mut Canvas<'_>, view: &CellView, (x, y): (f64, f64), color: Color) {
    let d = view.dot;
    for side in [d, -d] {
        canvas.line((x - d, y - side), (x + d, y + side), color);
    }
}

type Place = (f64, f64);

/// Walks along a line on the canvas: `on` metres that are handed over by their two ends, `off` metres that are not, and
/// so on.
fn walk(view: &CellView, line: &[Point], on: f64, off: f64, mut with: impl FnMut(Place, Place)) {
    let period = on + off;
    let mut done = 0.0;
    // The number of the next dash; where one began that goes on behind a corner, and how far along the line it ends.
    let mut next = 0.0_f64;
    let mut open: Option<(Place, f64)> = None;
    let mut here = None;
    for pair in line.windows(2) {
        let (from, to) = (view.at(&pair[0]), view.at(&pair[1]));
        let length = (to.0 - from.0).hypot(to.1 - from.1);
        // Too far away to be drawn.
        if length <= 0.0 || length.is_nan() || length > MAX_COORDINATE {
            continue;
        }
        here = Some(to);
        // Only the visible part is sampled: coordinates may be of any size.
        let Some((enters, leaves)) = view.part_seen(from, to) else {
            if let Some((start, _)) = open.take() {
                with(start, from);
            }
            done += length;
            continue;
        };
        let at = |s: f64| {
            let part = ((s - done) / length).clamp(0.0, 1.0);
            (
                from.0 + (to.0 - from.0) * part,
                from.1 + (to.1 - from.1) * part,
            )
        };
        if let Some((start, end)) = open.take_if(|(_, end)| *end <= done + length) {
            with(start, at(end));
        }
        // The first dash that reaches into this piece, or into what is seen of it.
        let first = ((done + enters * length - on) / period).ceil().max(next);
        let last = (done + leaves * length) / period;
        // Counted: a number that is large enough does not change by adding to it.
        let count = (last - first).floor().clamp(-1.0, MOST_DASHES);
        for dash in (0_u32..).map(f64::from).take_while(|dash| *dash <= count) {
            let (start, end) = ((first + dash) * period, (first + dash) * period + on);
            if start >= done + length {
                break;
            }
            next = first + dash + 1.0;
            if end <= done + length {
                with(at(start), at(end))
            } else {
                open = Some((at(start), end))
            }
        }
        done += length;
    }
    if let Some(((start, _), end)) = open.zip(here) {
        with(start, end);
    }
}

