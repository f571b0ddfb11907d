//! Boundaries of preventability: panels over two parameters of a family of cases, with a line for each driver.

use super::{DASHES, LETTERS, LINE, WIDTH, color, mark};
use crate::display::{Anchor, Area, Picture, Provenance, Spot, Stroke, Text};
use crate::{Palette, Ticks};

/// Cases over two parameters, each with each.
#[derive(Debug, Clone)]
pub struct BoundaryPanel {
    /// What its cases have in common.
    pub name: String,
    /// The values along the horizontal axis, at even distances.
    pub across: Vec<f64>,
    /// The values along the vertical axis, at even distances.
    pub up: Vec<f64>,
    /// For each driver of the chart, in its order, whether it avoids each case: by `across`, then `up`; empty for a driver
    /// without a rule.
    pub avoided: Vec<Vec<bool>>,
    /// The cases that could not be, in the same order.
    pub invalid: Vec<bool>,
    /// The case that was recorded, along both axes; it need not be one of the others.
    pub recorded: Option<(f64, f64)>,
}

/// Panels with the same axes.
#[derive(Debug, Clone)]
pub struct BoundaryChart {
    /// Name of the horizontal axis, with the unit.
    pub across: String,
    /// Name of the vertical axis, with the unit.
    pub up: String,
    /// Names of the drivers; a driver has its colour, dashes and mark from its place.
    pub drivers: Vec<String>,
    /// The panels in rows, from above.
    pub rows: Vec<Vec<BoundaryPanel>>,
    /// What else it says, below.
    pub note: Option<String>,
    /// Colours.
    pub palette: Palette,
    /// What stands in the file.
    pub provenance: Provenance,
}

/// Between two panels, points.
const BETWEEN: f64 = 7.0;

/// Height of a panel by its width, and at most, points.
const ASPECT: f64 = 0.72;
const HIGHEST: f64 = 220.0;

/// Size of numbers at the axes, points.
const SMALL: f64 = 6.5;

/// Half the size of the cross of an impossible case, points.
const CROSS: f64 = 1.6;

/// Radius of the ring around the recorded case, points.
const RING: f64 = 2.4;

/// How far the bar at a mark reaches into the shape, points.
const INSIDE: f64 = 9.0;

/// A shape of fewer cases has no mark.
const MARKED: usize = 8;

/// Cases of a row that are not avoided, without one between them that is: the row, the first and the last.
type Run = (usize, usize, usize);

impl BoundaryChart {
    /// Draws it.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let palette = &self.palette;
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0).max(1) as f64;
        let (left, top) = (4.4 * LETTERS, 2.4 * LETTERS);
        let width = (WIDTH - left - 4.0 - BETWEEN * (columns - 1.0)) / columns;
        let height = (ASPECT * width).min(HIGHEST);
        let deep = 1.4 * LETTERS + height + 1.5 * LETTERS;
        let bottom = top + deep * self.rows.len() as f64;
        let lines = if self.note.is_some() { 4.2 } else { 3.0 };
        let mut picture = Picture::new((WIDTH, bottom + lines * LETTERS), palette.background);
        picture.provenance = self.provenance.clone();
        picture.group("legend", None, |p| self.legend(p, left));
        for (place, row) in self.rows.iter().enumerate() {
            for (column, panel) in row.iter().enumerate() {
                let area = Area {
                    x: left + (width + BETWEEN) * column as f64,
                    y: top + deep * place as f64 + 1.4 * LETTERS,
                    width,
                    height,
                };
                picture.group("panel", None, |p| self.panel(p, panel, area, column == 0));
            }
        }
        let at = ((left + WIDTH) / 2.0, bottom + LETTERS);
        let name = Text::new(at, &self.across, LETTERS, palette.text);
        picture.text(name.anchored(Anchor::Middle));
        let at = (WIDTH - 4.0, bottom + 2.4 * LETTERS);
        let words = "inside its line, to which the bar points, a driver does not avoid contact";
        picture.text(Text::new(at, words, SMALL, palette.dim).anchored(Anchor::End));
        if let Some(note) = &self.note {
            let at = (left, bottom + 3.6 * LETTERS);
            picture.text(Text::new(at, note, SMALL, palette.dim));
        }
        let panels = || self.rows.iter().flatten();
        let mut x = left;
        if panels().any(|panel| panel.invalid.contains(&true)) {
            self.cross(&mut picture, (x + CROSS, at.1 - 0.34 * SMALL));
            x += 2.0 * CROSS + 4.0;
            picture.text(Text::new((x, at.1), "impossible", SMALL, palette.dim));
            x += Text::width("impossible", SMALL) + 9.0;
        }
        if panels().any(|panel| panel.recorded.is_some()) {
            self.ring(&mut picture, (x + RING, at.1 - 0.34 * SMALL));
            x += 2.0 * RING + 4.0;
            picture.text(Text::new((x, at.1), "recorded", SMALL, palette.dim));
        }
        let at = (1.2 * LETTERS, (top + bottom) / 2.0);
        let mut name = Text::new(at, &self.up, LETTERS, palette.text);
        name.upwards = true;
        picture.text(name.anchored(Anchor::Middle));
        picture
    }

    fn legend(&self, picture: &mut Picture, left: f64) {
        let (palette, middle) = (&self.palette, 0.9 * LETTERS);
        let base = middle + 0.34 * LETTERS;
        let mut x = left;
        for (place, name) in self.drivers.iter().enumerate() {
            let mut panels = self.rows.iter().flatten();
            if panels.all(|panel| panel.avoided[place].is_empty()) {
                continue;
            }
            picture.line(&[(x, middle), (x + 22.0, middle)], self.stroke(place));
            self.mark(picture, (x + 11.0, middle), place);
            picture.text(Text::new((x + 26.0, base), name, LETTERS, palette.text));
            x += 26.0 + Text::width(name, LETTERS) + 9.0;
        }
        let swatch = Area {
            x,
            y: middle - 4.0,
            width: 12.0,
            height: 8.0,
        };
        picture.rectangle(&swatch, Some(self.shade()), None);
        let none = "no driver avoids contact";
        picture.text(Text::new((x + 16.0, base), none, LETTERS, palette.text));
    }

    /// A case that could not be.
    fn cross(&self, picture: &mut Picture, (x, y): Spot) {
        let stroke = || Stroke::new(self.palette.dim, 0.5);
        picture.line(&[(x - CROSS, y - CROSS), (x + CROSS, y + CROSS)], stroke());
        picture.line(&[(x - CROSS, y + CROSS), (x + CROSS, y - CROSS)], stroke());
    }

    /// The case that was recorded.
    fn ring(&self, picture: &mut Picture, at: Spot) {
        let stroke = Stroke::new(self.palette.text, 1.0);
        picture.circle(at, RING, Some(self.palette.background), Some(stroke));
    }

    /// Where nobody avoids it.
    fn shade(&self) -> crate::Color {
        self.palette
            .background
            .towards(self.palette.static_obstacle, 0.6)
    }

    fn stroke(&self, place: usize) -> Stroke {
        Stroke::new(color(&self.palette, place), LINE).dashed(DASHES[place % DASHES.len()])
    }

    /// The sixth driver has the dashes of the first, but another mark.
    fn mark(&self, picture: &mut Picture, at: Spot, place: usize) {
        let sign = place + place / DASHES.len();
        mark(picture, at, sign, color(&self.palette, place));
    }

    fn panel(&self, picture: &mut Picture, panel: &BoundaryPanel, area: Area, first: bool) {
        let palette = &self.palette;
        let at = (area.x, area.y - 0.4 * LETTERS);
        picture.text(Text::new(at, &panel.name, LETTERS, palette.text));
        let scales = (
            Scale::new(&panel.across, (area.x, area.width)),
            Scale::new(&panel.up, (area.bottom(), -area.height)),
        );
        let ruled = panel.avoided.iter().filter(|avoided| !avoided.is_empty());
        let cases = 0..panel.across.len() * panel.up.len();
        let anyone = cases.map(|case| ruled.clone().any(|avoided| avoided[case]));
        picture.group("nobody", Some(area), |p| {
            for shape in shapes(&anyone.collect::<Vec<_>>(), panel.up.len()) {
                p.polygon(&outline(&shape, &scales), Some(self.shade()), None);
            }
        });
        self.axes(picture, &scales, &area, first);
        if panel.invalid.contains(&true) {
            picture.group("invalid", Some(area), |p| {
                for case in (0..panel.invalid.len()).filter(|case| panel.invalid[*case]) {
                    let (column, row) = (case / panel.up.len(), case % panel.up.len());
                    self.cross(p, (scales.0.of(column as f64), scales.1.of(row as f64)));
                }
            });
        }
        picture.group("boundaries", Some(area), |p| {
            for (place, avoided) in panel.avoided.iter().enumerate() {
                for shape in shapes(avoided, panel.up.len()) {
                    match &outline(&shape, &scales)[..] {
                        // There and back, dashes would fill each other's gaps.
                        ring @ [_, _] => p.line(ring, self.stroke(place)),
                        ring => p.polygon(ring, None, Some(self.stroke(place))),
                    }
                    // At different heights, as boundaries may be the same.
                    let height = shape.len() * (place + 1) / (self.drivers.len() + 1);
                    let (row, first, last) = shape[height];
                    let (side, inside) = if last + 1 < panel.across.len() {
                        (last as f64 + 0.5, -INSIDE)
                    } else {
                        (first as f64 - 0.5, INSIDE)
                    };
                    let cases: usize = shape.iter().map(|(_, from, to)| to + 1 - from).sum();
                    if cases >= MARKED {
                        let (x, y) = (scales.0.of(side), scales.1.of(row as f64));
                        p.line(
                            &[(x, y), (x + inside, y)],
                            Stroke::new(color(palette, place), LINE),
                        );
                        self.mark(p, (x, y), place);
                    }
                }
            }
        });
        if let Some((across, up)) = panel.recorded {
            let at = (scales.0.at(across), scales.1.at(up));
            picture.group("recorded", Some(area), |p| self.ring(p, at));
        }
        picture.rectangle(&area, None, Some(Stroke::new(palette.text, 0.6)));
    }

    fn axes(&self, picture: &mut Picture, scales: &(Scale, Scale), area: &Area, first: bool) {
        let (palette, (across, up)) = (&self.palette, scales);
        let grid = || Stroke::new(palette.grid, 0.4);
        for (value, words) in across.ticks(area.width / 22.0) {
            let x = across.at(value);
            picture.line(&[(x, area.y), (x, area.bottom())], grid());
            let text = Text::new((x, area.bottom() + SMALL + 2.0), words, SMALL, palette.text);
            picture.text(text.anchored(Anchor::Middle));
        }
        for (value, words) in up.ticks(area.height / 14.0) {
            let y = up.at(value);
            picture.line(&[(area.x, y), (area.right(), y)], grid());
            if first {
                let text = Text::new((area.x - 3.0, y + 0.34 * SMALL), words, SMALL, palette.text);
                picture.text(text.anchored(Anchor::End));
            }
        }
    }
}

/// An axis on the page: each case has as much room as any other.
struct Scale {
    first: f64,
    /// From one value to the next.
    step: f64,
    /// How many there are.
    count: f64,
    /// Where it begins on the page and how long it is, points.
    page: (f64, f64),
}

impl Scale {
    fn new(values: &[f64], page: (f64, f64)) -> Self {
        let first = values.first().copied().unwrap_or_default();
        Self {
            first,
            step: values.get(1).map_or(1.0, |second| second - first),
            count: values.len().max(1) as f64,
            page,
        }
    }

    /// Where the value at this place is.
    fn of(&self, place: f64) -> f64 {
        self.page.0 + self.page.1 * (place + 0.5) / self.count
    }

    fn at(&self, value: f64) -> f64 {
        self.of((value - self.first) / self.step)
    }

    fn ticks(&self, most: f64) -> Vec<(f64, String)> {
        let value = |place: f64| self.first + self.step * place;
        let most = most.clamp(2.0, 9.0) as usize;
        Ticks::within(value(-0.5), value(self.count - 0.5), most).labels()
    }
}

/// The cases that are not avoided, as shapes of runs in consecutive rows; `avoided` is by columns of so many rows.
fn shapes(avoided: &[bool], rows: usize) -> Vec<Vec<Run>> {
    let columns = avoided.len() / rows.max(1);
    let mut shapes: Vec<Vec<Run>> = Vec::new();
    for row in 0..rows {
        let column = (0..columns).collect::<Vec<_>>();
        let runs = column.chunk_by(|a, b| avoided[a * rows + row] == avoided[b * rows + row]);
        for run in runs.filter(|run| !avoided[run[0] * rows + row]) {
            let (first, last) = (run[0], run[run.len() - 1]);
            // Those of slow lateral motion move on by more than their length from row to row.
            let goes_on = |shape: &&mut Vec<Run>| {
                let (before, from, to) = shape[shape.len() - 1];
                let apart = first.saturating_sub(to).max(from.saturating_sub(last));
                before + 1 == row && apart <= last - first + to - from + 2
            };
            match shapes.iter_mut().find(goes_on) {
                Some(shape) => shape.push((row, first, last)),
                None => shapes.push(vec![(row, first, last)]),
            }
        }
    }
    shapes
}

/// The ring around a shape, half a case away along the rows; beyond the axes where it goes on to their ends.
fn outline(shape: &[Run], (across, up): &(Scale, Scale)) -> Vec<Spot> {
    const BEYOND: f64 = 2.0;
    let left = |first: usize| match first {
        0 => -BEYOND,
        first => first as f64 - 0.5,
    };
    let right = |last: usize| {
        if last as f64 + 1.0 < across.count {
            last as f64 + 0.5
        } else {
            across.count + BEYOND
        }
    };
    let mut runs: Vec<(f64, Run)> = shape.iter().map(|run| (run.0 as f64, *run)).collect();
    let ends = (runs[0], runs[runs.len() - 1]);
    if ends.0.0 == 0.0 {
        runs.insert(0, (-BEYOND, ends.0.1));
    }
    if ends.1.0 + 1.0 == up.count {
        runs.push((up.count + BEYOND, ends.1.1));
    }
    let there = { runs.iter() }.map(|(row, (_, first, _))| (left(*first), *row));
    let back = { runs.iter().rev() }.map(|(row, (.., last))| (right(*last), *row));
    let ring = there.chain(back);
    ring.map(|(i, j)| (across.of(i), up.of(j))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_hold_what_is_not_avoided_and_nothing_else() {
        let (columns, rows) = (9, 3);
        let drawn = ["xx...x...", ".xxx.....", "........x"];
        let avoided: Vec<bool> = (0..columns * rows)
            .map(|place| drawn[place % rows].as_bytes()[place / rows] == b'.')
            .collect();
        let found = shapes(&avoided, rows);
        let wanted = [vec![(0, 0, 1), (1, 1, 3)], vec![(0, 5, 5)], vec![(2, 8, 8)]];
        assert_eq!(found, wanted);
        assert!(shapes(&[], rows).is_empty() && shapes(&[true; 6], rows).is_empty());
        let scale = |count: usize| Scale::new(&vec![0.0; count], (0.0, count as f64));
        let ring = outline(&found[0], &(scale(columns), scale(rows)));
        // From the left end, below the lowest row, to half a case from the last one of each row.
        let last = [(4.0, 1.5), (2.0, 0.5), (2.0, -1.5)];
        assert_eq!(ring[..2], [(-1.5, -1.5), (-1.5, 0.5)]);
        assert_eq!(ring[3..], last);
    }

    #[test]
    fn nobody_avoids_what_no_driver_with_a_rule_avoids() {
        let chart = |second: Vec<bool>| BoundaryChart {
            across: "gap (m)".into(),
            up: "lateral speed (m/s)".into(),
            drivers: vec!["first".into(), "second".into()],
            rows: vec![vec![BoundaryPanel {
                name: "one".into(),
                across: vec![1.0, 2.0],
                up: vec![0.0, 1.0],
                avoided: vec![vec![false, false, true, true], second],
                invalid: vec![false; 4],
                recorded: None,
            }]],
            note: None,
            palette: Palette::paper(),
            provenance: Provenance::default(),
        };
        let seen = |second| {
            let svg = crate::svg(&chart(second).picture());
            (
                svg.matches(r#"class="nobody""#).count(),
                svg.contains(">second<"),
            )
        };
        assert_eq!(seen(vec![]), (1, false));
        assert_eq!(seen(vec![false, true, true, true]), (1, true));
        assert_eq!(seen(vec![true; 4]), (0, true));
    }
}
