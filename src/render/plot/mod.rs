//! Measures over time: a panel for each, below each other, with one axis of time.

mod steps;
mod ticks;

pub use steps::steps;
pub use ticks::Ticks;

use super::Color;
use super::display::{Anchor, Area, Picture, Spot, Stroke, Text};
use super::palette::Palette;
use crate::metrics::{Measure, Series, Thresholds};

/// What a plot shows.
pub struct Plot<'a> {
    /// The measures' values.
    pub series: &'a Series,
    /// Seconds between two steps.
    pub dt: f64,
    /// The step at which a line stands; none for a plot of the whole.
    pub cursor: Option<i64>,
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
                self.panel(p, measure, panel(i), last);
            }
            self.legend(p, panel(0));
        });
    }

    fn time(&self) -> (f64, f64) {
        let steps = self.series.steps();
        let from = steps.start as f64 * self.dt;
        (from, ((steps.end - 1) as f64 * self.dt).max(from + self.dt))
    }

    fn panel(&self, picture: &mut Picture, measure: &Measure, area: Area, last: bool) {
        let (palette, size) = (self.palette, self.letters);
        let curves = self.curves(measure);
        let (from, to) = self.time();
        let thresholds: Vec<_> = self.thresholds.for_measure(measure.id).collect();
        let values: Vec<f64> = thresholds.iter().map(|t| t.value).collect();
        let most = (area.height / (1.9 * size)).clamp(2.0, 6.0) as usize;
        let upwards = match measure.is_ordinal() {
            // All six where numbers have room, one below the other.
            true if area.height >= 5.0 * 1.1 * size => Ticks::around(0.0, 5.0, 6),
            true => Ticks::ends(0.0, 5.0),
            false => upwards(&curves, &values, most),
        };
        let (low, high) = upwards.bounds();
        let spot = |(time, value): (f64, f64)| -> Spot {
            (
                area.x + (time - from) / (to - from) * area.width,
                area.bottom() - (value - low) / (high - low) * area.height,
            )
        };
        for (value, words) in upwards.labels() {
            let (_, y) = spot((from, value));
            picture.line(
                &[(area.x, y), (area.right(), y)],
                Stroke::new(palette.grid, 0.4),
            );
            picture.line(
                &[(area.x - 2.0, y), (area.x, y)],
                Stroke::new(palette.text, 0.5),
            );
            let at = (area.x - 3.5, y + size * 0.34);
            picture.text(Text::new(at, words, size, palette.text).anchored(Anchor::End));
        }
        self.time_axis(picture, area, last);
        let seen: Vec<_> = thresholds
            .iter()
            .filter(|t| (low..=high).contains(&t.value))
            .collect();
        for threshold in &seen {
            let (_, y) = spot((from, threshold.value));
            let stroke = Stroke::new(palette.dim, 0.6).dashed(&[2.0, 2.0]);
            picture.line(&[(area.x, y), (area.right(), y)], stroke);
        }
        let cursor = self.cursor.map(|step| step as f64 * self.dt);
        if let Some(now) = cursor {
            let (x, _) = spot((now, low));
            picture.line(
                &[(x, area.y), (x, area.bottom())],
                Stroke::new(palette.accent, 0.6),
            );
        }
        picture.group("curves", Some(area.grown(1.2)), |p| {
            for curve in &curves {
                for run in &curve.runs {
                    let run = match measure.is_ordinal() {
                        true => steps(run),
                        false => run.clone(),
                    };
                    let points: Vec<Spot> = run.into_iter().map(spot).collect();
                    if let [only] = points[..] {
                        p.circle(
                            only,
                            curve.stroke.width * 0.8,
                            Some(curve.stroke.color),
                            None,
                        );
                    }
                    p.line(&points, curve.stroke.clone());
                }
                let point = |now| {
                    curve
                        .runs
                        .iter()
                        .flatten()
                        .find(|p| (p.0 - now) as f32 == 0.0)
                };
                if let Some(point) = cursor.and_then(point) {
                    let edge = Stroke::new(palette.background, 0.5);
                    p.circle(spot(*point), 1.7, Some(curve.stroke.color), Some(edge));
                }
            }
        });
        // Names of thresholds that lie close together would lie over each other.
        let mut named: Vec<f64> = Vec::new();
        for threshold in &seen {
            let (_, y) = spot((from, threshold.value));
            let size = size * 0.85;
            if named.iter().all(|other| (other - y).abs() > size) {
                named.push(y);
                let baseline = if y - size < area.y { y + size } else { y - 1.8 };
                // On the left, as scenes end with what matters.
                let at = (area.x + 3.0, baseline);
                let text = Text::new(at, &*threshold.name, size, palette.dim);
                picture.text(text.with_halo(palette.background));
            }
        }
        picture.rectangle(&area, None, Some(Stroke::new(palette.text, 0.5)));
        let name = axis_name(measure, size, area.height);
        let at = (self.area.x + size * 0.9, area.y + area.height / 2.0);
        let mut text = Text::new(at, name, size, palette.text).anchored(Anchor::Middle);
        text.upwards = true;
        picture.text(text);
    }

    fn time_axis(&self, picture: &mut Picture, area: Area, last: bool) {
        let (palette, size) = (self.palette, self.letters);
        let (from, to) = self.time();
        let most = (area.width / (4.5 * size)).clamp(2.0, 11.0) as usize;
        for (time, words) in Ticks::within(from, to, most).labels() {
            let x = area.x + (time - from) / (to - from) * area.width;
            let y = area.bottom();
            picture.line(&[(x, y), (x, y + 2.0)], Stroke::new(palette.text, 0.5));
            if last {
                let at = (x, y + 3.0 + size * 0.85);
                picture.text(Text::new(at, words, size, palette.text).anchored(Anchor::Middle));
            }
        }
        if last {
            let at = (area.x + area.width / 2.0, area.bottom() + 3.0 + 2.1 * size);
            picture.text(Text::new(at, "time (s)", size, palette.text).anchored(Anchor::Middle));
        }
    }

    /// Everybody together in a fine line, and those who are pointed out.
    fn curves(&self, measure: &Measure) -> Vec<Curve> {
        let runs = |value: &dyn Fn(i64) -> Option<f64>| {
            let steps = self.series.steps();
            let values: Vec<_> = steps
                .map(|s| Some((s as f64 * self.dt, value(s)?)))
                .collect();
            let runs = values.split(Option::is_none).filter(|run| !run.is_empty());
            runs.map(|run| run.iter().flatten().copied().collect())
                .collect()
        };
        let all = Curve {
            name: format!("{} of all", measure.danger.extreme()),
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

/// Its name with its unit, or its short one where that is too long.
fn axis_name(measure: &Measure, size: f64, room: f64) -> String {
    let with_unit = |name: &str| match measure.unit {
        "" => name.to_string(),
        unit => format!("{name} ({unit})"),
    };
    let name = with_unit(measure.name);
    match Text::width(&name, size) <= room {
        true => name,
        false => with_unit(measure.id),
    }
}

/// So much of what the values take up may be added to reach a threshold, or zero.
const NEAR: f64 = 0.5;

/// The axis upwards: from the lowest to the highest value, and to thresholds near them.
fn upwards(curves: &[Curve], thresholds: &[f64], most: usize) -> Ticks {
    let points = curves.iter().flat_map(|c| c.runs.iter().flatten());
    let range = points.fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p.1), h.max(p.1)));
    let (mut low, mut high) = range;
    if low > high {
        return Ticks::ends(0.0, 1.0);
    }
    let room = NEAR * (high - low);
    let near = thresholds
        .iter()
        .chain(&[0.0])
        .filter(|t| (low - room..=high + room).contains(*t));
    let (wider_low, wider_high) = near.fold((low, high), |(l, h), &t| (l.min(t), h.max(t)));
    (low, high) = (wider_low, wider_high);
    if high - low <= 1e-9 * low.abs().max(1e-3) {
        // One value all the time: it stands between two others.
        let around = (low.abs() * 0.1).max(0.5);
        (low, high) = (low - around, high + around);
    }
    Ticks::around(low, high, most)
}
