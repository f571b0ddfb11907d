//! A panel of a plot: one measure, its axes and lines, and what is marked in it.

use super::super::display::{Anchor, Area, Picture, Spot, Stroke, Text};
use super::{Curve, Plot, Ticks, steps, value_range};
use nearmiss_scene::metrics::{Measure, Threshold};

/// Dashes of thresholds.
const THRESHOLD: [f64; 2] = [2.0, 2.0];
/// Dashes of the contact.
const CONTACT: [f64; 2] = [3.0, 1.6];

/// A measure in its part of the page.
pub(super) struct Panel<'a> {
    plot: &'a Plot<'a>,
    measure: &'a Measure,
    area: Area,
    curves: Vec<Curve>,
    thresholds: Vec<&'a Threshold>,
    upwards: Ticks,
}

impl<'a> Panel<'a> {
    /// The panel of a measure.
    pub(super) fn new(plot: &'a Plot<'a>, measure: &'a Measure, area: Area) -> Self {
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
    pub(super) fn draw(&self, picture: &mut Picture, last: bool) {
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
