//! A chart of rates with intervals over a logarithmic axis, a row for each class of events.

use super::{LETTERS, ROW, WIDTH, fitted, interval, mark};
use crate::Palette;
use crate::display::{Anchor, Area, Picture, Provenance, Stroke, Text};

/// A rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RatePoint {
    /// The rate; 0 where nothing was seen: then the interval has the bound alone.
    pub rate: f64,
    /// The ends of its interval.
    pub interval: (f64, f64),
}

/// Rates over one axis.
#[derive(Debug, Clone)]
pub struct RateChart {
    /// Name of the axis, with the unit.
    pub axis: String,
    /// Names of rows from top to bottom, and the rates in each.
    pub rows: Vec<(String, Vec<RatePoint>)>,
    /// Colours.
    pub palette: Palette,
    /// What stands in the file.
    pub provenance: Provenance,
}

/// A logarithmic axis over whole powers of ten.
pub(super) struct Decades {
    low: i32,
    high: i32,
}

impl Decades {
    /// The powers of ten around all that is above 0.
    pub fn around<'a>(points: impl Iterator<Item = &'a RatePoint>) -> Self {
        let values = points.flat_map(|point| [point.interval.0, point.rate, point.interval.1]);
        let positive = values.filter(|value| *value > 0.0 && value.is_finite());
        let ends = positive.fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        if ends.1 == 0.0 {
            return Self { low: -1, high: 0 };
        }
        let (low, high) = (ends.0.log10().floor() as i32, ends.1.log10().ceil() as i32);
        Self {
            low: low.min(high - 1),
            high,
        }
    }

    /// Where a value stands in an area; what is beyond an end, there.
    pub fn across(&self, area: &Area, value: f64) -> f64 {
        let share = (value.log10() - f64::from(self.low)) / f64::from(self.high - self.low);
        area.x + area.width * share.clamp(0.0, 1.0)
    }

    /// Draws lines through an area, their values `below` it (points), and the name of the axis.
    pub fn draw(&self, p: &mut Picture, area: &Area, below: f64, name: &str, palette: &Palette) {
        for decade in self.low..=self.high {
            let value = 10_f64.powi(decade);
            let x = self.across(area, value);
            p.line(
                &[(x, area.y), (x, area.bottom())],
                Stroke::new(palette.grid, 0.5),
            );
            let at = (x, area.bottom() + below + LETTERS + 2.0);
            let words = Text::new(at, value.to_string(), LETTERS, palette.text);
            p.text(words.anchored(Anchor::Middle));
        }
        let at = (area.center().0, area.bottom() + below + 2.4 * LETTERS + 2.0);
        let name = Text::new(at, name, LETTERS, palette.text);
        p.text(name.anchored(Anchor::Middle));
    }
}

impl RateChart {
    /// Draws it.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let names = self.rows.iter().map(|(name, _)| Text::width(name, LETTERS));
        let left = names.fold(40.0, f64::max).min(0.5 * WIDTH) + 8.0;
        let area = Area {
            x: left,
            y: 6.0,
            width: WIDTH - left - 16.0,
            height: ROW * self.rows.len().max(1) as f64,
        };
        let size = (WIDTH, area.bottom() + 3.0 * LETTERS + 4.0);
        let mut picture = Picture::new(size, self.palette.background);
        picture.provenance = self.provenance.clone();
        let decades = Decades::around(self.rows.iter().flat_map(|(_, points)| points));
        let across = |value: f64| decades.across(&area, value);
        let palette = &self.palette;
        picture.group("axis", None, |p| {
            decades.draw(p, &area, 0.0, &self.axis, palette);
        });
        for (place, (name, points)) in self.rows.iter().enumerate() {
            picture.group("rate", None, |p| {
                let middle = area.y + ROW * (place as f64 + 0.5);
                let at = (area.x - 5.0, middle + 0.34 * LETTERS);
                let name = Text::new(at, fitted(name, area.x - 8.0), LETTERS, palette.text);
                p.text(name.anchored(Anchor::End));
                for point in points {
                    let ends = [point.interval.0, point.interval.1].map(across);
                    interval(p, (ends[0], middle), (ends[1], middle), palette.text);
                    if point.rate > 0.0 {
                        mark(p, (across(point.rate), middle), 0, palette.ego);
                    }
                }
            });
        }
        picture.rectangle(&area, None, Some(Stroke::new(palette.text, 0.6)));
        picture
    }
}
