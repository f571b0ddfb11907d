//! Points with intervals over two axes, joined or alone: curves by lead, reliability, cost against quality.

use super::{LETTERS, LINE, WIDTH, fitted, interval};
use crate::display::{Anchor, Area, Picture, Provenance, Spot, Stroke, Text};
use crate::{Color, Palette, Ticks};

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

    fn color(&self, place: usize) -> Color {
        match place % 6 {
            0 => self.palette.ego,
            place => self.palette.emphasised(place - 1),
        }
    }

    fn series(&self, picture: &mut Picture, frame: &Frame, place: usize, series: &ChartSeries) {
        let color = self.color(place);
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
            let color = self.color(place);
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
