//! Foreseeable and preventable as two axes: how often a corpus holds an event, and how many drivers avoid it.

use super::rate::{Decades, RatePoint};
use super::{CAP, LETTERS, LINE, MARK, ROW, WIDTH, color, fitted, interval, mark};
use crate::Palette;
use crate::display::{Anchor, Area, Picture, Provenance, Spot, Stroke, Text};

/// An event of a scenario.
#[derive(Debug, Clone, PartialEq)]
pub struct JudgedEvent {
    /// Its name.
    pub name: String,
    /// Drivers that avoid it.
    pub avoided: usize,
    /// Drivers that decide; at least one.
    pub decided: usize,
    /// How often it is met, by the kinds of egos of the chart; nothing for a kind that did not drive.
    pub rates: Vec<Option<RatePoint>>,
}

/// Events by how often they are met and how many drivers avoid them.
#[derive(Debug, Clone)]
pub struct TwoAxesChart {
    /// Name of the horizontal axis, with the unit.
    pub axis: String,
    /// The kinds of egos, whose rates have marks of their own.
    pub egos: Vec<String>,
    /// The events.
    pub events: Vec<JudgedEvent>,
    /// Colours.
    pub palette: Palette,
    /// What stands in the file.
    pub provenance: Provenance,
}

/// Size of the words in the corners, points.
const SMALL: f64 = 6.5;

/// Height of a share of drivers without an event, points.
const EMPTY: f64 = 11.0;

/// Above and below the events of a share, points.
const PADDING: f64 = 3.0;

/// What stands at the corners: the left and the right one above, and below.
const CORNERS: [[[&str; 2]; 2]; 2] = [
    [
        ["preventable, not foreseeable", ""],
        ["foreseeable and preventable", "has to be avoided"],
    ],
    [
        ["neither", ""],
        ["foreseeable, not preventable", "to be mitigated"],
    ],
];

/// Events that the same share of drivers avoids.
struct Band<'a> {
    share: f64,
    words: String,
    events: Vec<&'a JudgedEvent>,
}

impl TwoAxesChart {
    /// Draws it: the more drivers avoid an event, the higher it stands.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let palette = &self.palette;
        let bands = self.bands();
        let widest = |words: &mut dyn Iterator<Item = &str>, most: f64| {
            let widths = words.map(|words| Text::width(words, LETTERS));
            widths.fold(0.0, f64::max).min(most * WIDTH)
        };
        let shares = widest(&mut bands.iter().map(|band| &*band.words), 0.2);
        let names = widest(&mut self.events.iter().map(|one| &*one.name), 0.35);
        let corner = 2.4 * SMALL + 3.0;
        let left = 2.0 * LETTERS + shares + 8.0 + names + 8.0;
        let area = Area {
            x: left,
            y: 2.0 * LETTERS + corner,
            width: WIDTH - left - 16.0,
            height: bands.iter().map(Band::height).sum(),
        };
        let size = (WIDTH, area.bottom() + corner + 3.0 * LETTERS + 4.0);
        let mut picture = Picture::new(size, palette.background);
        picture.provenance = self.provenance.clone();
        let points = self
            .events
            .iter()
            .flat_map(|one| one.rates.iter().flatten());
        let decades = Decades::around(points);
        picture.group("legend", None, |p| self.legend(p, left));
        picture.group("axis", None, |p| {
            decades.draw(p, &area, corner, &self.axis, palette);
            let at = (1.2 * LETTERS, area.center().1);
            let mut name = Text::new(at, "drivers that avoid it", LETTERS, palette.text);
            name.upwards = true;
            p.text(name.anchored(Anchor::Middle));
        });
        picture.group("corners", None, |p| self.corners(p, &area));
        let mut y = area.y;
        for band in &bands {
            if y > area.y {
                let line = [(area.x, y), (area.right(), y)];
                picture.line(&line, Stroke::new(palette.grid, 0.5));
            }
            let at = (
                2.0 * LETTERS + shares,
                y + band.height() / 2.0 + 0.34 * LETTERS,
            );
            let share = Text::new(at, fitted(&band.words, shares + 1.0), LETTERS, palette.text);
            picture.text(share.anchored(Anchor::End));
            for (place, event) in band.events.iter().enumerate() {
                let middle = y + PADDING + ROW * (place as f64 + 0.5);
                picture.group("event", None, |p| {
                    self.event(p, event, &area, &decades, middle);
                });
            }
            y += band.height();
        }
        picture.rectangle(&area, None, Some(Stroke::new(palette.text, 0.6)));
        picture
    }

    /// From the share that all drivers are to none; where the same number decides everywhere, each number of drivers.
    fn bands(&self) -> Vec<Band<'_>> {
        let decided = self.events.first().map_or(0, |one| one.decided);
        let is_same = self.events.iter().all(|one| one.decided == decided);
        let share = |avoided: usize, of: usize| avoided as f64 / of.max(1) as f64;
        let mut counts: Vec<(usize, usize)> = if is_same {
            (0..=decided).map(|avoided| (avoided, decided)).collect()
        } else {
            let counts = self.events.iter().map(|one| (one.avoided, one.decided));
            counts.collect()
        };
        counts.sort_by(|a, b| share(b.0, b.1).total_cmp(&share(a.0, a.1)).then(b.cmp(a)));
        counts.dedup();
        let mut bands: Vec<Band<'_>> = Vec::new();
        for (avoided, of) in counts {
            let words = format!("{avoided} of {of}");
            match bands.last_mut() {
                Some(last) if last.share == share(avoided, of) => {
                    last.words += &format!(", {words}");
                }
                _ => bands.push(Band::new(share(avoided, of), words)),
            }
        }
        if bands.first().is_none_or(|band| band.share < 1.0) {
            bands.insert(0, Band::new(1.0, "all"));
        }
        if bands.last().is_none_or(|band| band.share > 0.0) {
            bands.push(Band::new(0.0, "none"));
        }
        for event in &self.events {
            let own = share(event.avoided, event.decided);
            if let Some(band) = bands.iter_mut().find(|band| band.share == own) {
                band.events.push(event);
            }
        }
        bands
    }

    fn event(
        &self,
        p: &mut Picture,
        event: &JudgedEvent,
        area: &Area,
        decades: &Decades,
        middle: f64,
    ) {
        let palette = &self.palette;
        let at = (area.x - 5.0, middle + 0.34 * LETTERS);
        let name = fitted(&event.name, 0.35 * WIDTH);
        p.text(Text::new(at, name, LETTERS, palette.text).anchored(Anchor::End));
        let kinds = event.rates.len().max(1) as f64;
        for (place, point) in event.rates.iter().enumerate() {
            let Some(point) = point else { continue };
            let y = middle + (place as f64 - (kinds - 1.0) / 2.0) * 0.42 * ROW;
            let [low, rate, high] = [point.interval.0, point.rate, point.interval.1]
                .map(|value| (decades.across(area, value), y));
            let color = color(palette, place);
            let is_seen = point.rate > 0.0;
            if point.interval.0 > 0.0 {
                interval(p, low, high, color);
            } else {
                // An arrow: it goes on to zero, which the axis does not have.
                let stroke = || Stroke::new(color, 0.8);
                let (tip, back) = (area.x + 1.0, area.x + 1.0 + 2.0 * CAP);
                p.line(&[(back, y - CAP), (tip, y), (back, y + CAP)], stroke());
                let end = if is_seen { high.0 } else { high.0 - MARK };
                p.line(&[(tip, y), (end, y)], stroke());
                if is_seen {
                    p.line(&[(end, y - CAP), (end, y + CAP)], stroke());
                }
            }
            if is_seen {
                mark(p, rate, place, color);
            } else {
                open_mark(p, high, place, Stroke::new(color, LINE));
            }
        }
    }

    fn legend(&self, p: &mut Picture, left: f64) {
        let (palette, middle) = (&self.palette, LETTERS);
        let base = middle + 0.34 * LETTERS;
        let mut x = left + MARK;
        for (place, name) in self.egos.iter().enumerate() {
            let color = color(palette, place);
            mark(p, (x, middle), place, color);
            open_mark(p, (x + 10.0, middle), place, Stroke::new(color, LINE));
            p.text(Text::new((x + 17.0, base), name, LETTERS, palette.text));
            x += 17.0 + Text::width(name, LETTERS) + 10.0;
        }
        let words = "open: not seen, upper bound";
        p.text(Text::new((x - MARK, base), words, LETTERS, palette.dim));
    }

    fn corners(&self, p: &mut Picture, area: &Area) {
        let ends = [(area.x, Anchor::Start), (area.right(), Anchor::End)];
        let tops = [area.y - 1.4 * SMALL - 3.0, area.bottom() + SMALL + 2.0];
        for (corners, y) in CORNERS.iter().zip(tops) {
            for (words, (x, anchor)) in corners.iter().zip(ends) {
                for (line, words) in words.iter().enumerate() {
                    let at = (x, y + 1.2 * SMALL * line as f64);
                    let text = Text::new(at, *words, SMALL, self.palette.dim).anchored(anchor);
                    p.text(text.in_bold(line == 1));
                }
            }
        }
    }
}

impl Band<'_> {
    fn new(share: f64, words: impl Into<String>) -> Self {
        Self {
            share,
            words: words.into(),
            events: Vec::new(),
        }
    }

    fn height(&self) -> f64 {
        match self.events.len() {
            0 => EMPTY,
            events => ROW * events as f64 + 2.0 * PADDING,
        }
    }
}

/// The outline of a circle, or of a square.
fn open_mark(p: &mut Picture, at: Spot, place: usize, stroke: Stroke) {
    match place % 2 {
        0 => p.circle(at, MARK, None, Some(stroke)),
        _ => {
            let side = 1.8 * MARK;
            let square = Area {
                x: at.0 - side / 2.0,
                y: at.1 - side / 2.0,
                width: side,
                height: side,
            };
            p.rectangle(&square, None, Some(stroke));
        }
    }
}
