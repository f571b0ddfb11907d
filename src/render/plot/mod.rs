//! Measures over time: a panel for each, below each other, with one axis of time.

mod panel;
mod steps;
mod ticks;
mod values;

pub use steps::steps;
pub use ticks::Ticks;
pub use values::{runs, value_range};

use panel::Panel;

use super::Color;
use super::display::{Anchor, Area, Picture, Stroke, Text};
use super::palette::Palette;
use nearmiss_scene::metrics::{Measure, Series, Thresholds};
use nearmiss_scene::scenario::Window;

/// What a plot shows.
pub struct Plot<'a> {
    /// The measures' values.
    pub series: &'a Series,
    /// Seconds between two steps.
    pub dt: f64,
    /// The step at which a line stands; none for a plot of the whole.
    pub cursor: Option<i64>,
    /// The window of a question, which is shaded.
    pub window: Option<Window>,
    /// The step of the first contact, at which a line stands.
    pub contact: Option<i64>,
    /// Obstacles that are pointed out.
    pub emphasised: &'a [i64],
    /// From where on values are dangerous.
    pub thresholds: &'a Thresholds,
    /// Its colours.
    pub palette: &'a Palette,
    /// Where on the page.
    pub area: Area,
    /// Size of the letters, points.
    pub letters: f64,
}

/// A line of the plot.
struct Curve {
    name: String,
    stroke: Stroke,
    /// A run of points, time and value, for every stretch without gaps.
    runs: Vec<Vec<(f64, f64)>>,
}

/// Dashes of the lines of obstacles that are pointed out, beside the solid line of all: colour is not the only sign.
const DASHES: [&[f64]; 5] = [
    &[4.0, 1.6],
    &[2.4, 0.8],
    &[1.2, 1.2],
    &[5.0, 1.4, 1.2, 1.4],
    &[8.0, 2.0],
];

impl Plot<'_> {
    /// Draws it.
    pub fn draw(&self, picture: &mut Picture) {
        let measures = self.series.measures();
        let size = self.letters;
        let left = 4.2 * size;
        let (above, below) = (size + 5.0, 2.6 * size + 4.0);
        // The lowest number of a panel and the highest of the next one do not touch.
        let between = 1.4 * size;
        let panels = measures.len().max(1) as f64;
        let height = (self.area.height - above - below - (panels - 1.0) * between) / panels;
        let panel = |i: usize| Area {
            x: self.area.x + left,
            y: self.area.y + above + i as f64 * (height + between),
            width: self.area.width - left - 0.8 * size,
            height: height.max(4.0),
        };
        picture.group("plot", None, |p| {
            for (i, measure) in measures.iter().enumerate() {
                let last = i + 1 == measures.len();
                Panel::new(self, measure, panel(i)).draw(p, last);
            }
            self.legend(p, panel(0));
        });
    }

    fn time(&self) -> (f64, f64) {
        let steps = self.series.steps();
        let from = steps.start as f64 * self.dt;
        (from, ((steps.end - 1) as f64 * self.dt).max(from + self.dt))
    }

    /// Everybody together in a fine line, and those who are pointed out.
    fn curves(&self, measure: &Measure) -> Vec<Curve> {
        let runs = |value: &dyn Fn(i64) -> Option<f64>| runs(self.series, self.dt, value);
        let all = Curve {
            name: format!("{} of all", measure.extreme()),
            stroke: Stroke::new(self.palette.obstacle, 1.6).rounded(),
            runs: runs(&|s| self.series.most_dangerous_at(measure.id, s).map(|(_, v)| v)),
        };
        let of = |(place, &id): (usize, &i64)| Curve {
            name: id.to_string(),
            stroke: self.stroke(place),
            runs: runs(&|s| self.series.at(measure.id, id, s).value()),
        };
        std::iter::once(all)
            .chain(self.emphasised.iter().enumerate().map(of))
            .collect()
    }

    fn stroke(&self, place: usize) -> Stroke {
        let color: Color = self.palette.emphasised(place);
        Stroke::new(color, 1.0).dashed(DASHES[place % DASHES.len()])
    }

    /// Whose line is which, above the first panel.
    fn legend(&self, picture: &mut Picture, first: Area) {
        let (palette, size) = (self.palette, self.letters);
        let Some(measure) = self.series.measures().first() else {
            return;
        };
        let y = self.area.y + size * 0.9;
        let mut right = first.right();
        // From the right, so that the most telling is nearest to the end: all, then those pointed out.
        for curve in self.curves(measure).into_iter().rev() {
            let width = Text::width(&curve.name, size);
            let needed = width + 12.0 + 3.0 + 6.0;
            if right - needed < first.x {
                break;
            }
            let text = Text::new((right, y), curve.name, size, palette.text);
            picture.text(text.anchored(Anchor::End));
            let end = right - width - 3.0;
            picture.line(
                &[(end - 12.0, y - size * 0.32), (end, y - size * 0.32)],
                curve.stroke,
            );
            right -= needed;
        }
    }
}
