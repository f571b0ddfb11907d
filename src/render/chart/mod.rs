//! Charts of numbers with intervals, in the look of the other figures: bars, and points over two axes.

mod bars;
mod points;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

pub use bars::{Bar, BarChart};
pub use points::{Axis, ChartPoint, ChartSeries, PointChart};

use super::display::{Picture, Spot, Stroke};
use super::{COLUMN, Color};

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
