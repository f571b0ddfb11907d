//! A figure of how many windows of which manoeuvre, road and severity a corpus holds.

use super::color::Color;
use super::display::{Anchor, Area, Picture, Provenance, Text};
use super::palette::Palette;
use nearmiss_scene::corpus::{Coverage, SEVERITIES};
use nearmiss_scene::metrics::SEVERITY_NAMES;

/// Size of the letters, points.
const LETTERS: f64 = 8.0;

/// Width and height of a cell, points.
const CELL: (f64, f64) = (48.0, 16.0);

/// Room around the table, points.
const MARGIN: f64 = 6.0;

/// Draws the table: darker cells have more windows, on a logarithmic scale; each has its number.
#[must_use]
pub fn coverage_picture(coverage: &Coverage, palette: &Palette) -> Picture {
    let names: Vec<String> = coverage
        .rows()
        .map(|(cell, _)| format!("{}, {}", cell.manoeuvre, cell.road))
        .collect();
    let widest = names.iter().map(|name| Text::width(name, LETTERS));
    let left = MARGIN + widest.fold(0.0, f64::max) + MARGIN;
    let top = MARGIN + CELL.1;
    let size = (
        left + CELL.0 * SEVERITIES as f64 + MARGIN,
        top + CELL.1 * names.len() as f64 + MARGIN,
    );
    let mut picture = Picture::new(size, palette.background);
    let base = |y: f64| y + (CELL.1 + 0.7 * LETTERS) / 2.0;
    let column = |place: usize| left + CELL.0 * place as f64;
    for (place, name) in SEVERITY_NAMES.iter().enumerate() {
        let at = (column(place) + CELL.0 / 2.0, base(MARGIN));
        picture.text(Text::new(at, *name, LETTERS, palette.text).anchored(Anchor::Middle));
    }
    let largest = coverage.largest().max(1) as f64;
    for (row, ((_, counts), name)) in coverage.rows().zip(&names).enumerate() {
        let y = top + CELL.1 * row as f64;
        let at = (left - MARGIN, base(y));
        picture.text(Text::new(at, name, LETTERS, palette.text).anchored(Anchor::End));
        for (place, count) in counts.iter().enumerate() {
            let area = Area {
                x: column(place),
                y,
                width: CELL.0 - 1.0,
                height: CELL.1 - 1.0,
            };
            let share = (*count as f64 + 1.0).ln() / (largest + 1.0).ln();
            let fill: Color = palette.background.towards(palette.ego, 0.85 * share);
            picture.rectangle(&area, Some(fill), None);
            let (words, ink) = match (count, share > 0.6) {
                (0, _) => ("·".to_string(), palette.dim),
                (count, true) => (count.to_string(), palette.background),
                (count, false) => (count.to_string(), palette.text),
            };
            let at = (area.x + area.width / 2.0, base(y));
            picture.text(Text::new(at, words, LETTERS, ink).anchored(Anchor::Middle));
        }
    }
    let windows: u64 = coverage.totals().iter().sum();
    picture.provenance = Provenance {
        title: "nearmiss, coverage of a corpus".into(),
        description: format!("{windows} windows by manoeuvre, road and severity."),
        facts: vec![(
            "program",
            concat!("nearmiss ", env!("CARGO_PKG_VERSION")).into(),
        )],
    };
    picture
}
