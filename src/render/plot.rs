//! Measures over time: a panel for each with what is marked in it, below each other, with one axis of time.

use nearmiss_scene::metrics::{Measure, Series, Threshold, Thresholds};
use nearmiss_scene::scenario::Window;

use super::Color;
use super::display::{Anchor, Area, Picture, Spot, Stroke, Text};
use super::palette::Palette;

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

    /// All obstacles together in a fine line, and those who are pointed out.
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

/// Levels hold until the next one: the corners of their steps.
#[must_use]
pub fn steps(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let corners = points.windows(2).map(|pair| (pair[1].0, pair[0].1));
    let mut all = Vec::with_capacity(points.len() * 2);
    for (point, corner) in points.iter().zip(corners.map(Some).chain([None])) {
        all.push(*point);
        all.extend(corner);
    }
    all
}

/// An axis that begins and ends on round numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Ticks {
    /// The first round number.
    first: f64,
    step: f64,
    /// How many there are, at least two.
    count: usize,
}

impl Ticks {
    /// Round numbers that `low` and `high` lie between, at most `most` of them but always two.
    #[must_use]
    pub fn around(low: f64, high: f64, most: usize) -> Self {
        Self::new(low, high, most, |from, to| (from.floor(), to.ceil()))
    }

    /// Round numbers between `low` and `high`, for an axis whose ends are given.
    #[must_use]
    pub fn within(low: f64, high: f64, most: usize) -> Self {
        Self::new(low, high, most, |from, to| (from.ceil(), to.floor()))
    }

    /// The two numbers, if nothing better is wanted.
    #[must_use]
    pub fn ends(low: f64, high: f64) -> Self {
        Self {
            first: low,
            step: high - low,
            count: 2,
        }
    }

    fn new(low: f64, high: f64, most: usize, round: fn(f64, f64) -> (f64, f64)) -> Self {
        let most = most.max(2) as f64;
        let span = (high - low).max(f64::MIN_POSITIVE);
        let rough = 10_f64.powf((span / most).log10().floor());
        // A span of nothing, or one that numbers cannot hold, has no round parts.
        if !rough.is_normal() {
            return Self::ends(low, high);
        }
        let steps = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0].map(|m| m * rough);
        let fitting = steps.into_iter().find_map(|step| {
            // What differs by rounding alone is the same number.
            let near = |v: f64| {
                if (v - v.round()).abs() < 1e-9 {
                    v.round()
                } else {
                    v
                }
            };
            let (from, to) = round(near(low / step), near(high / step));
            let count = to - from + 1.0;
            (count <= most).then_some((from, step, count))
        });
        match fitting {
            Some((from, step, count)) => Self {
                first: from * step,
                step,
                count: count.max(0.0) as usize,
            },
            None => Self::ends(low, high),
        }
    }

    /// The first and the last one.
    #[must_use]
    pub fn bounds(&self) -> (f64, f64) {
        (self.first, self.at(self.count.saturating_sub(1)))
    }

    fn at(&self, place: usize) -> f64 {
        self.first + place as f64 * self.step
    }

    /// The numbers, and how they are written.
    #[must_use]
    pub fn labels(&self) -> Vec<(f64, String)> {
        let values = (0..self.count).map(|i| self.at(i));
        values.map(|v| (v, self.written(v))).collect()
    }

    /// With as many decimals as the steps have.
    fn written(&self, value: f64) -> String {
        if value != 0.0 && (value.abs() >= 1e6 || self.step < 1e-3) {
            return format!("{value:.1e}");
        }
        let decimals = (-(self.step * 1.000_001).log10().floor()).clamp(0.0, 4.0) as usize;
        // No minus before a zero.
        let value = if value.abs() < self.step * 1e-6 {
            0.0
        } else {
            value
        };
        format!("{value:.decimals$}")
    }
}

/// A run of points, time and value, for every stretch without gaps: nothing is drawn where there is no value.
#[must_use]
pub fn runs(series: &Series, dt: f64, value: impl Fn(i64) -> Option<f64>) -> Vec<Vec<(f64, f64)>> {
    let points: Vec<_> = series
        .steps()
        .map(|step| Some((step as f64 * dt, value(step)?)))
        .collect();
    let runs = points.split(Option::is_none).filter(|run| !run.is_empty());
    runs.map(|run| run.iter().flatten().copied().collect())
        .collect()
}

/// So much of what the values take up may be added to reach a threshold.
const MAX_STRETCH: f64 = 0.5;

/// From the lowest to the highest value, and to those of `near` that lie close to them; `None` without values.
#[must_use]
pub fn value_range(
    values: impl Iterator<Item = f64>,
    near: impl Iterator<Item = f64>,
) -> Option<(f64, f64)> {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return None;
    }
    let room = MAX_STRETCH * (high - low);
    let within = (low - room)..=(high + room);
    let near = near.filter(|v| within.contains(v));
    let (low, high) = near.fold((low, high), |(l, h), v| (l.min(v), h.max(v)));
    if high - low <= 1e-9 * low.abs().max(1e-3) {
        // One value all the time: it stands between two others.
        let around = (low.abs() * 0.1).max(0.5);
        return Some((low - around, high + around));
    }
    Some((low, high))
}

/// Dashes of thresholds.
const THRESHOLD: [f64; 2] = [2.0, 2.0];

/// Dashes of the contact.
const CONTACT: [f64; 2] = [3.0, 1.6];

/// A measure in its part of the page.
struct Panel<'a> {
    plot: &'a Plot<'a>,
    measure: &'a Measure,
    area: Area,
    curves: Vec<Curve>,
    thresholds: Vec<&'a Threshold>,
    upwards: Ticks,
}

impl<'a> Panel<'a> {
    /// The panel of a measure.
    fn new(plot: &'a Plot<'a>, measure: &'a Measure, area: Area) -> Self {
        let curves = plot.curves(measure);
        let thresholds: Vec<_> = plot.thresholds.for_measure(measure.id).collect();
        let most = (area.height / (1.9 * plot.letters)).clamp(2.0, 6.0) as usize;
        let upwards = if !measure.is_ordinal() {
            let points = curves.iter().flat_map(|c| c.runs.iter().flatten());
            let near = thresholds.iter().map(|t| t.value).chain([0.0]);
            let range = value_range(points.map(|p| p.1), near);
            range.map_or(Ticks::ends(0.0, 1.0), |(low, high)| {
                Ticks::around(low, high, most)
            })
        } else if area.height >= 5.0 * 1.1 * plot.letters {
            // All six where numbers have room, one below the other.
            Ticks::around(0.0, 5.0, 6)
        } else {
            Ticks::ends(0.0, 5.0)
        };
        Self {
            plot,
            measure,
            area,
            curves,
            thresholds,
            upwards,
        }
    }

    /// Draws it; the last one has the numbers of the axis of time.
    fn draw(&self, picture: &mut Picture, last: bool) {
        self.window(picture);
        self.values(picture);
        self.time_axis(picture, last);
        self.lines(picture);
        picture.group("curves", Some(self.area.grown(1.2)), |p| {
            for curve in &self.curves {
                self.curve(p, curve);
            }
        });
        self.names(picture);
        let frame = Stroke::new(self.plot.palette.text, 0.5);
        picture.rectangle(&self.area, None, Some(frame));
        let (area, size) = (self.area, self.plot.letters);
        let name = axis_name(self.measure, size, area.height);
        let at = (self.plot.area.x + size * 0.9, area.y + area.height / 2.0);
        let mut text = Text::new(at, name, size, self.plot.palette.text).anchored(Anchor::Middle);
        text.upwards = true;
        picture.text(text);
    }

    /// Where a time and a value are on the page.
    fn spot(&self, (time, value): (f64, f64)) -> Spot {
        let (low, high) = self.upwards.bounds();
        let up = (value - low) / (high - low) * self.area.height;
        (self.across(time), self.area.bottom() - up)
    }

    fn across(&self, time: f64) -> f64 {
        let (from, to) = self.plot.time();
        self.area.x + (time - from) / (to - from) * self.area.width
    }

    fn across_step(&self, step: i64) -> f64 {
        self.across(step as f64 * self.plot.dt)
    }

    /// Shades the window of the question.
    fn window(&self, picture: &mut Picture) {
        let Some(window) = self.plot.window else {
            return;
        };
        let from = self.across_step(window.first()).max(self.area.x);
        let to = self.across_step(window.last()).min(self.area.right());
        let shaded = Area {
            x: from,
            width: to - from,
            ..self.area
        };
        if shaded.width > 0.0 {
            picture.group("window", None, |p| {
                p.rectangle(&shaded, Some(self.plot.palette.shade), None);
            });
        }
    }

    /// The vertical axis with its grid.
    fn values(&self, picture: &mut Picture) {
        let (palette, size, area) = (self.plot.palette, self.plot.letters, self.area);
        for (value, words) in self.upwards.labels() {
            let (_, y) = self.spot((0.0, value));
            let grid = Stroke::new(palette.grid, 0.4);
            picture.line(&[(area.x, y), (area.right(), y)], grid);
            let tick = Stroke::new(palette.text, 0.5);
            picture.line(&[(area.x - 2.0, y), (area.x, y)], tick);
            let at = (area.x - 3.5, y + size * 0.34);
            picture.text(Text::new(at, words, size, palette.text).anchored(Anchor::End));
        }
    }

    fn time_axis(&self, picture: &mut Picture, last: bool) {
        let (palette, size, area) = (self.plot.palette, self.plot.letters, self.area);
        let (from, to) = self.plot.time();
        let most = (area.width / (4.5 * size)).clamp(2.0, 11.0) as usize;
        for (time, words) in Ticks::within(from, to, most).labels() {
            let (x, y) = (self.across(time), area.bottom());
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

    /// Thresholds that lie on the axis.
    fn seen(&self) -> impl Iterator<Item = &'a Threshold> {
        let (low, high) = self.upwards.bounds();
        let all = self.thresholds.iter().copied();
        all.filter(move |t| (low..=high).contains(&t.value))
    }

    /// Lines behind the curves: thresholds, the current step and the contact.
    fn lines(&self, picture: &mut Picture) {
        let (palette, area) = (self.plot.palette, self.area);
        for threshold in self.seen() {
            let (_, y) = self.spot((0.0, threshold.value));
            let stroke = Stroke::new(palette.dim, 0.6).dashed(&THRESHOLD);
            picture.line(&[(area.x, y), (area.right(), y)], stroke);
        }
        let upright = |step| {
            let x = self.across_step(step);
            [(x, area.y), (x, area.bottom())]
        };
        if let Some(now) = self.plot.cursor {
            picture.line(&upright(now), Stroke::new(palette.accent, 0.6));
        }
        if let Some(contact) = self.plot.contact {
            // After the current step, so that the dashes are seen where both are one.
            let stroke = Stroke::new(palette.danger, 0.9).dashed(&CONTACT);
            picture.group("contact", None, |p| p.line(&upright(contact), stroke));
        }
    }

    fn curve(&self, picture: &mut Picture, curve: &Curve) {
        for run in &curve.runs {
            let run = if self.measure.is_ordinal() {
                steps(run)
            } else {
                run.clone()
            };
            let points: Vec<Spot> = run.into_iter().map(|point| self.spot(point)).collect();
            if let [only] = points[..] {
                let (radius, color) = (curve.stroke.width * 0.8, curve.stroke.color);
                picture.circle(only, radius, Some(color), None);
            }
            picture.line(&points, curve.stroke.clone());
        }
        let cursor = self.plot.cursor.map(|step| step as f64 * self.plot.dt);
        let mut points = curve.runs.iter().flatten();
        let at = cursor.and_then(|now| points.find(|p| (p.0 - now) as f32 == 0.0));
        if let Some(point) = at {
            let edge = Stroke::new(self.plot.palette.background, 0.5);
            picture.circle(self.spot(*point), 1.7, Some(curve.stroke.color), Some(edge));
        }
    }

    /// Names of the thresholds and of the contact; those of lines close together would lie over each other.
    fn names(&self, picture: &mut Picture) {
        let (palette, size, area) = (self.plot.palette, self.plot.letters * 0.85, self.area);
        let mut named: Vec<Area> = Vec::new();
        let mut name = |picture: &mut Picture, words: &str, at: Spot, color| {
            let taken = Area {
                x: at.0,
                y: at.1 - size,
                width: Text::width(words, size),
                height: size,
            };
            if named.iter().all(|other| !other.meets(&taken)) {
                named.push(taken);
                picture.text(Text::new(at, words, size, color).with_halo(palette.background));
            }
        };
        if let Some(contact) = self.plot.contact {
            let x = self.across_step(contact);
            let width = Text::width(CONTACT_WORDS, size);
            // Towards the side that has room.
            let left = if x + 3.0 + width > area.right() {
                x - 3.0 - width
            } else {
                x + 3.0
            };
            let at = (left, area.y + size + 1.0);
            name(picture, CONTACT_WORDS, at, palette.danger);
        }
        for threshold in self.seen() {
            let (_, y) = self.spot((0.0, threshold.value));
            let baseline = if y - size < area.y { y + size } else { y - 1.8 };
            // On the left, as scenes end with what matters.
            let at = (area.x + 3.0, baseline);
            name(picture, &threshold.name, at, palette.dim);
        }
    }
}

/// The name of the contact's line.
const CONTACT_WORDS: &str = "contact";

/// Its name with its unit, or its short one where that is too long.
fn axis_name(measure: &Measure, size: f64, room: f64) -> String {
    let name = measure.axis_name(measure.name);
    if Text::width(&name, size) <= room {
        name
    } else {
        measure.axis_name(measure.id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_hold_until_the_next_one() {
        let points = [(0.0, 5.0), (1.0, 3.0), (2.0, 3.0)];
        let corners = [(0.0, 5.0), (1.0, 5.0), (1.0, 3.0), (2.0, 3.0), (2.0, 3.0)];
        assert_eq!(steps(&points), corners);
        assert_eq!(steps(&points[..1]), points[..1]);
        assert!(steps(&[]).is_empty());
    }

    fn words(ticks: &Ticks) -> String {
        let labels = ticks.labels().into_iter().map(|(_, words)| words);
        labels.collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn round_numbers_around_a_range() {
        for (low, high, most, shown) in [
            (0.03, 9.71, 5, "0 5 10"),
            (0.0, 45.2, 5, "0 20 40 60"),
            (-83.3, -2.0, 4, "-100 -50 0"),
            (-0.13, 0.21, 5, "-0.2 0.0 0.2 0.4"),
            (1234.0, 1236.0, 4, "1234 1235 1236"),
            (0.0, 0.3, 5, "0.0 0.1 0.2 0.3"),
            (0.0, 4.0e6, 5, "0 1.0e6 2.0e6 3.0e6 4.0e6"),
        ] {
            let ticks = Ticks::around(low, high, most);
            assert_eq!(words(&ticks), shown, "{low} to {high}");
            let (from, to) = ticks.bounds();
            assert!(from <= low + 1e-12 && high <= to + 1e-12);
        }
    }

    #[test]
    fn round_numbers_within_a_range() {
        assert_eq!(words(&Ticks::within(0.0, 6.0, 7)), "0 1 2 3 4 5 6");
        assert_eq!(words(&Ticks::within(0.0, 14.9, 4)), "0 5 10");
        assert_eq!(words(&Ticks::within(3.1, 3.9, 5)), "3.2 3.4 3.6 3.8");
    }

    #[test]
    fn strange_ranges_end() {
        for (low, high) in [
            (0.0, 0.0),
            (5.0, 5.0),
            (-1e308, 1e308),
            (1e300, 1e300),
            (0.0, 1e-320),
        ] {
            let ticks = Ticks::around(low, high, 5);
            assert!(ticks.labels().len() <= 5, "{low} to {high}");
        }
    }

    #[test]
    fn a_range_reaches_what_is_near_and_is_never_empty() {
        let range = |values: &[f64], near: &[f64]| {
            value_range(values.iter().copied(), near.iter().copied())
        };
        assert_eq!(range(&[], &[1.0]), None);
        assert_eq!(range(&[2.0, 4.0], &[1.0, 9.0]), Some((1.0, 4.0)));
        assert_eq!(range(&[0.0, 0.0], &[]), Some((-0.5, 0.5)));
        assert_eq!(range(&[20.0], &[]), Some((18.0, 22.0)));
    }
}
