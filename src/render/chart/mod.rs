//! Charts of numbers with intervals, in the look of the other figures: bars, points over two axes, boundaries, cells of a corpus.

mod boundary;
mod rate;
mod two_axes;

pub use boundary::{BoundaryChart, BoundaryPanel};
pub use rate::{RateChart, RatePoint};
pub use two_axes::{JudgedEvent, TwoAxesChart};

use nearmiss_scene::corpus::{Coverage, SEVERITIES};
use nearmiss_scene::metrics::SEVERITY_NAMES;

use super::display::{Picture, Spot, Stroke};
use super::{COLUMN, Color};
use crate::display::{Anchor, Area, Provenance, Text};
use crate::{Palette, Ticks};

/// Width of a chart, points: two columns of a paper.
const WIDTH: f64 = 2.0 * COLUMN;

/// Size of the letters, points.
const LETTERS: f64 = 8.0;

/// Width of the lines of values, points.
const LINE: f64 = 1.1;

/// Half the length of the ends of an interval, points.
const CAP: f64 = 2.2;

/// Words that fit into so many points, shortened at their end.
fn fitted(words: &str, points: f64) -> String {
    use super::display::Text;
    if Text::width(words, LETTERS) <= points {
        return words.to_string();
    }
    let mut short = words.to_string();
    while !short.is_empty() && Text::width(&short, LETTERS) + LETTERS > points {
        short.pop();
    }
    short + "…"
}

/// An interval between two spots, with ends across it.
fn interval(picture: &mut Picture, from: Spot, to: Spot, color: Color) {
    let stroke = Stroke::new(color, 0.8);
    let across = from.1 == to.1;
    picture.line(&[from, to], stroke.clone());
    for (x, y) in [from, to] {
        let end = if across {
            [(x, y - CAP), (x, y + CAP)]
        } else {
            [(x - CAP, y), (x + CAP, y)]
        };
        picture.line(&end, stroke.clone());
    }
}

/// A bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// Its name.
    pub name: String,
    /// Its value, 0 to 1; `None` where there is none.
    pub value: Option<f64>,
    /// The ends of its interval.
    pub interval: Option<(f64, f64)>,
    /// How many answers it is of.
    pub n: u32,
    /// Whether it is set apart, in outline: the built-in judge.
    pub apart: bool,
}

/// Bars over one axis.
#[derive(Debug, Clone)]
pub struct BarChart {
    /// Name of the axis.
    pub axis: String,
    /// The bars, from top to bottom.
    pub bars: Vec<Bar>,
    /// Colours.
    pub palette: Palette,
    /// What stands in the file.
    pub provenance: Provenance,
}

/// Height of a bar with the space below it, points.
const ROW: f64 = 15.0;

impl BarChart {
    /// Draws it.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let names = self.bars.iter().map(|bar| Text::width(&bar.name, LETTERS));
        let left = names.fold(40.0, f64::max).min(0.5 * WIDTH) + 8.0;
        let right = Text::width("0.00 [0.00, 0.00]  n = 00000", LETTERS) + 6.0;
        let area = Area {
            x: left,
            y: 6.0,
            width: WIDTH - left - right,
            height: ROW * self.bars.len().max(1) as f64,
        };
        let size = (WIDTH, area.bottom() + 3.0 * LETTERS + 4.0);
        let mut picture = Picture::new(size, self.palette.background);
        picture.provenance = self.provenance.clone();
        picture.group("axis", None, |p| self.axis(p, &area));
        picture.group("bars", None, |p| {
            for (place, bar) in self.bars.iter().enumerate() {
                self.bar(p, &area, place, bar);
            }
        });
        let base = [(area.x, area.y), (area.x, area.bottom())];
        picture.line(&base, Stroke::new(self.palette.text, 0.6));
        picture
    }

    fn axis(&self, picture: &mut Picture, area: &Area) {
        let palette = &self.palette;
        for (value, words) in Ticks::around(0.0, 1.0, 6).labels() {
            let x = area.x + area.width * value;
            let grid = Stroke::new(palette.grid, 0.5);
            picture.line(&[(x, area.y), (x, area.bottom())], grid);
            let at = (x, area.bottom() + LETTERS + 2.0);
            picture.text(Text::new(at, words, LETTERS, palette.text).anchored(Anchor::Middle));
        }
        let at = (
            area.x + area.width / 2.0,
            area.bottom() + 2.4 * LETTERS + 2.0,
        );
        let name = Text::new(at, &self.axis, LETTERS, palette.text);
        picture.text(name.anchored(Anchor::Middle));
    }

    fn bar(&self, picture: &mut Picture, area: &Area, place: usize, bar: &Bar) {
        let palette = &self.palette;
        let middle = area.y + ROW * (place as f64 + 0.5);
        let base = middle + 0.34 * LETTERS;
        let name = fitted(&bar.name, area.x - 8.0);
        let name = Text::new((area.x - 5.0, base), name, LETTERS, palette.text);
        picture.text(name.anchored(Anchor::End));
        let words = (area.right() + 6.0, base);
        let Some(value) = bar.value else {
            let none = format!("no value  n = {}", bar.n);
            return picture.text(Text::new(words, none, LETTERS, palette.dim));
        };
        let shape = Area {
            x: area.x,
            y: middle - 4.5,
            width: area.width * value.clamp(0.0, 1.0),
            height: 9.0,
        };
        if bar.apart {
            picture.rectangle(&shape, None, Some(Stroke::new(palette.ego, 0.9)))
        } else {
            picture.rectangle(&shape, Some(palette.ego), None)
        }
        let mut number = format!("{value:.2}");
        if let Some((low, high)) = bar.interval {
            let at = |share: f64| (area.x + area.width * share.clamp(0.0, 1.0), middle);
            interval(picture, at(low), at(high), palette.text);
            number += &format!(" [{low:.2}, {high:.2}]");
        }
        number += &format!("  n = {}", bar.n);
        picture.text(Text::new(words, number, LETTERS, palette.text));
    }
}

/// A point.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartPoint {
    /// Where it is along the horizontal axis.
    pub x: f64,
    /// Where it is along the vertical axis.
    pub y: f64,
    /// The ends of the interval of `y`.
    pub interval: Option<(f64, f64)>,
}

/// Points of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartSeries {
    /// Their name.
    pub name: String,
    /// The points in the order of the line.
    pub points: Vec<ChartPoint>,
}

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Its name, with the unit.
    pub name: String,
    /// What is to be seen at least.
    pub range: (f64, f64),
}

/// Points over two axes.
#[derive(Debug, Clone)]
pub struct PointChart {
    /// The horizontal axis.
    pub across: Axis,
    /// The vertical axis.
    pub up: Axis,
    /// What is drawn.
    pub series: Vec<ChartSeries>,
    /// Whether the points of a series are joined.
    pub joined: bool,
    /// Whether the line is drawn on which both axes are equal.
    pub diagonal: bool,
    /// Colours.
    pub palette: Palette,
    /// What stands in the file.
    pub provenance: Provenance,
}

/// Dashes of lines, beside their colours and marks.
const DASHES: [&[f64]; 5] = [
    &[],
    &[4.0, 1.6],
    &[1.4, 1.4],
    &[5.0, 1.4, 1.2, 1.4],
    &[8.0, 2.0],
];

/// Half the size of a mark, points.
const MARK: f64 = 2.9;

/// The part of the page that the axes enclose, and the numbers on them.
struct Frame {
    area: Area,
    across: Ticks,
    up: Ticks,
}

impl Frame {
    fn spot(&self, x: f64, y: f64) -> Spot {
        let share = |ticks: &Ticks, value: f64| {
            let (low, high) = ticks.bounds();
            (value - low) / (high - low).max(f64::MIN_POSITIVE)
        };
        (
            self.area.x + self.area.width * share(&self.across, x),
            self.area.bottom() - self.area.height * share(&self.up, y),
        )
    }
}

impl PointChart {
    /// Draws it, with the names of the series beside it.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let names = self
            .series
            .iter()
            .map(|one| Text::width(&one.name, LETTERS));
        let legend = names.fold(30.0, f64::max).min(0.4 * WIDTH) + 30.0;
        let height = (0.42 * WIDTH).max(14.0 * self.series.len() as f64);
        let area = Area {
            x: 5.0 * LETTERS,
            y: 8.0,
            width: WIDTH - 5.0 * LETTERS - legend,
            height,
        };
        let frame = Frame {
            across: Ticks::around(self.across.range.0, self.across.range.1, 7),
            up: Ticks::around(self.up.range.0, self.up.range.1, 6),
            area,
        };
        let size = (WIDTH, area.bottom() + 3.2 * LETTERS + 4.0);
        let mut picture = Picture::new(size, self.palette.background);
        picture.provenance = self.provenance.clone();
        picture.group("axes", None, |p| self.axes(p, &frame));
        for (place, series) in self.series.iter().enumerate() {
            picture.group("series", None, |p| self.series(p, &frame, place, series));
        }
        picture.group("legend", None, |p| self.legend(p, &frame.area, legend));
        picture
    }

    fn axes(&self, picture: &mut Picture, frame: &Frame) {
        let (palette, area) = (&self.palette, &frame.area);
        let grid = || Stroke::new(palette.grid, 0.5);
        let (low, high) = (frame.across.bounds(), frame.up.bounds());
        for (value, words) in frame.up.labels() {
            let (_, y) = frame.spot(low.0, value);
            picture.line(&[(area.x, y), (area.right(), y)], grid());
            let at = (area.x - 4.0, y + 0.34 * LETTERS);
            picture.text(Text::new(at, words, LETTERS, palette.text).anchored(Anchor::End));
        }
        for (value, words) in frame.across.labels() {
            let (x, _) = frame.spot(value, high.0);
            picture.line(&[(x, area.y), (x, area.bottom())], grid());
            let at = (x, area.bottom() + LETTERS + 3.0);
            picture.text(Text::new(at, words, LETTERS, palette.text).anchored(Anchor::Middle));
        }
        if self.diagonal {
            let ends = [frame.spot(0.0, 0.0), frame.spot(1.0, 1.0)];
            picture.line(&ends, Stroke::new(palette.dim, 0.8).dashed(&[2.0, 2.0]));
        }
        picture.rectangle(area, None, Some(Stroke::new(palette.text, 0.6)));
        let at = (
            area.x + area.width / 2.0,
            area.bottom() + 2.6 * LETTERS + 3.0,
        );
        let name = Text::new(at, &self.across.name, LETTERS, palette.text);
        picture.text(name.anchored(Anchor::Middle));
        let at = (1.2 * LETTERS, area.y + area.height / 2.0);
        let mut name = Text::new(at, &self.up.name, LETTERS, palette.text);
        name.upwards = true;
        picture.text(name.anchored(Anchor::Middle));
    }

    fn series(&self, picture: &mut Picture, frame: &Frame, place: usize, series: &ChartSeries) {
        let color = color(&self.palette, place);
        if self.joined {
            let line: Vec<Spot> = series.points.iter().map(|p| frame.spot(p.x, p.y)).collect();
            let stroke = Stroke::new(color, LINE);
            picture.line(&line, stroke.dashed(DASHES[place % DASHES.len()]));
        }
        for point in &series.points {
            if let Some((low, high)) = point.interval {
                interval(
                    picture,
                    frame.spot(point.x, low),
                    frame.spot(point.x, high),
                    color,
                );
            }
            mark(picture, frame.spot(point.x, point.y), place, color);
        }
    }

    fn legend(&self, picture: &mut Picture, area: &Area, width: f64) {
        for (place, series) in self.series.iter().enumerate() {
            let (x, y) = (area.right() + 12.0, area.y + 6.0 + 14.0 * place as f64);
            let color = color(&self.palette, place);
            if self.joined {
                let stroke = Stroke::new(color, LINE).dashed(DASHES[place % DASHES.len()]);
                picture.line(&[(x - 7.0, y), (x + 7.0, y)], stroke);
            }
            mark(picture, (x, y), place, color);
            let at = (x + 11.0, y + 0.34 * LETTERS);
            let name = fitted(&series.name, width - 24.0);
            picture.text(Text::new(at, name, LETTERS, self.palette.text));
        }
    }
}

/// The colour of what stands at this place.
fn color(palette: &Palette, place: usize) -> Color {
    match place % 6 {
        0 => palette.ego,
        place => palette.emphasised(place - 1),
    }
}

/// A circle, square, triangle, diamond or ring: colour is not the only sign.
fn mark(picture: &mut Picture, (x, y): Spot, place: usize, color: Color) {
    let m = MARK;
    let ring = |corners: &[Spot]| -> Vec<Spot> {
        corners
            .iter()
            .map(|(dx, dy)| (x + m * dx, y + m * dy))
            .collect()
    };
    match place % 5 {
        0 => picture.circle((x, y), m, Some(color), None),
        1 => picture.polygon(
            &ring(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
            Some(color),
            None,
        ),
        2 => picture.polygon(
            &ring(&[(0.0, -1.2), (1.1, 0.9), (-1.1, 0.9)]),
            Some(color),
            None,
        ),
        3 => picture.polygon(
            &ring(&[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)]),
            Some(color),
            None,
        ),
        _ => picture.circle((x, y), m, None, Some(Stroke::new(color, LINE))),
    }
}

/// Width and height of a cell, points.
const CELL: (f64, f64) = (48.0, 16.0);

/// Room around the table, points.
const MARGIN: f64 = 6.0;

/// Draws the table: darker cells have more windows, on a logarithmic scale; each has its number.
#[must_use]
pub fn coverage_picture(coverage: &Coverage, palette: &Palette) -> Picture {
    let names: Vec<String> = coverage
        .rows()
        .map(|(cell, _)| format!("{}, {}", cell.manoeuvre, cell.road))
        .collect();
    let widest = names.iter().map(|name| Text::width(name, LETTERS));
    let left = MARGIN + widest.fold(0.0, f64::max) + MARGIN;
    let top = MARGIN + CELL.1;
    let size = (
        left + CELL.0 * SEVERITIES as f64 + MARGIN,
        top + CELL.1 * names.len() as f64 + MARGIN,
    );
    let mut picture = Picture::new(size, palette.background);
    let base = |y: f64| y + (CELL.1 + 0.7 * LETTERS) / 2.0;
    let column = |place: usize| left + CELL.0 * place as f64;
    for (place, name) in SEVERITY_NAMES.iter().enumerate() {
        let at = (column(place) + CELL.0 / 2.0, base(MARGIN));
        picture.text(Text::new(at, *name, LETTERS, palette.text).anchored(Anchor::Middle));
    }
    let largest = coverage.largest().max(1) as f64;
    for (row, ((_, counts), name)) in coverage.rows().zip(&names).enumerate() {
        let y = top + CELL.1 * row as f64;
        let at = (left - MARGIN, base(y));
        picture.text(Text::new(at, name, LETTERS, palette.text).anchored(Anchor::End));
        for (place, count) in counts.iter().enumerate() {
            let area = Area {
                x: column(place),
                y,
                width: CELL.0 - 1.0,
                height: CELL.1 - 1.0,
            };
            let share = (*count as f64 + 1.0).ln() / (largest + 1.0).ln();
            let fill: Color = palette.background.towards(palette.ego, 0.85 * share);
            picture.rectangle(&area, Some(fill), None);
            let (words, ink) = match (count, share > 0.6) {
                (0, _) => ("·".to_string(), palette.dim),
                (count, true) => (count.to_string(), palette.background),
                (count, false) => (count.to_string(), palette.text),
            };
            let at = (area.x + area.width / 2.0, base(y));
            picture.text(Text::new(at, words, LETTERS, ink).anchored(Anchor::Middle));
        }
    }
    let windows: u64 = coverage.totals().iter().sum();
    picture.provenance = Provenance {
        title: "nearmiss, coverage of a corpus".into(),
        description: format!("{windows} windows by manoeuvre, road and severity."),
        facts: vec![(
            "program",
            concat!("nearmiss ", env!("CARGO_PKG_VERSION")).into(),
        )],
    };
    picture
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
