//! Bars from 0 to 1 below each other, each with its interval and its number.

use super::{LETTERS, WIDTH, fitted, interval};
use crate::display::{Anchor, Area, Picture, Provenance, Stroke, Text};
use crate::{Palette, Ticks};

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
