//! The gaps of several drives to one obstacle around a moment.

use nearmiss_render::Ticks;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::text::Span;
use unicode_width::UnicodeWidthStr;

use crate::features::plot::draw::axes::{self, Axes, Dash, Drawn, Range, Upwards};
use crate::features::plot::draw::marks::{self, Event};
use crate::features::plot::draw::{Curve, lines};
use crate::loaded::Opened;
use crate::model::Model;

/// A drive whose gaps are drawn.
pub struct GapCurve<'a> {
    /// Its name.
    pub name: &'a str,
    /// How its line looks.
    pub color: Color,
    /// The same.
    pub dash: Dash,
    /// The drive.
    pub opened: &'a Opened,
}

/// Seconds before and after the moment that are drawn at most.
const AROUND: Range = (2.5, 1.0);
/// Seconds before the moment that are drawn at least.
const LEAST: f64 = 0.8;
/// The axis reaches to this many times the gap of the middle drive at the moment, and to this many metres at least.
const REACH: f64 = 2.0;
const NEAR: f64 = 2.0;
/// A row between a name and the end of its line counts as so many columns.
const ROW: u16 = 4;
/// Columns that the plot keeps before names stand at the ends of lines.
const COLUMNS: u16 = 36;
/// Rows from which on the moment has a row of its own above the plot.
const ROOMY: u16 = 9;

/// Whether the area is too low for the moment's label, which then belongs in the title.
pub fn is_low(area: Rect) -> bool {
    area.height < ROOMY
}

/// Draws the gaps to an obstacle around a moment, which is marked, and named where the area is not low; each line has its
/// name at its end.
pub fn draw(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    drives: &[GapCurve<'_>],
    obstacle: i64,
    mut moment: Event,
) {
    let all: Vec<Curve> = { drives.iter() }
        .map(|drive| curve(drive, obstacle, moment.time))
        .collect();
    let Some((time, high)) = seen(&all, moment.time) else {
        return;
    };
    // The moment is named in the first row.
    let named = u16::from(!is_low(area));
    if named == 0 {
        moment.label.clear();
    }
    let rest = Rect {
        y: area.y + named,
        height: area.height - named,
        ..area
    };
    let upwards = Upwards::fitting(rest, |most| Ticks::around(0.0, high, most));
    let top = upwards.bounds().1;
    let curves: Vec<Curve> = { all.iter() }
        .map(|curve| Curve {
            name: curve.name.clone(),
            runs: below(&curve.runs, time.0, top),
            ..*curve
        })
        .collect();
    let longest = curves.iter().map(|curve| curve.name.width()).max();
    let names = u16::try_from(longest.unwrap_or(0) + 1).unwrap_or(u16::MAX);
    let margin = match area.width.saturating_sub(names) {
        COLUMNS.. => names,
        _ => 0,
    };
    let drawn = Drawn {
        time,
        upwards: &upwards,
        unit: "m",
        color: model.theme.dim,
    };
    let plot = Rect {
        width: rest.width - margin,
        ..rest
    };
    let axes = axes::draw(f, plot, &drawn);
    lines(f, &axes, &curves, false);
    // Steps of the clock outside of it say nothing here.
    let clock = model.clock.time();
    let now = if (time.0..=time.1).contains(&clock) {
        clock
    } else {
        moment.time
    };
    let accent = Style::new().fg(model.theme.accent);
    let at = moment.time;
    marks::events(f, &axes, area, &[moment], (now, accent));
    for (curve, whole) in curves.iter().zip(&all) {
        let mut points = whole.runs.iter().flatten();
        let there = points.find(|(time, _)| *time >= at - 1e-6);
        name(f, &axes, area, curve, there.map(|(_, gap)| *gap));
    }
}

/// The gaps of a drive where they may be drawn.
fn curve(drive: &GapCurve<'_>, obstacle: i64, moment: f64) -> Curve {
    let dt = drive.opened.scenario.dt();
    let back = |seconds: f64| (seconds / dt).round() as i64;
    let steps = back(moment - AROUND.0)..=back(moment + AROUND.1);
    let series = drive.opened.series.as_ref();
    let gap = |step: i64| series?.at("distance", obstacle, step).value();
    let points = steps.filter_map(|step| Some((step as f64 * dt, gap(step)?)));
    marks::line(drive.name, drive.color, drive.dash, points.collect())
}

/// From when to when, and up to which gap: as high as tells most drives apart at the moment, and from where the first
/// is that near. Nothing where there are no gaps.
fn seen(curves: &[Curve], moment: f64) -> Option<(Range, f64)> {
    let points = || curves.iter().flat_map(|curve| curve.runs.iter().flatten());
    let last = points().map(|(time, _)| *time).reduce(f64::max)?;
    let mut now: Vec<f64> = points()
        .filter(|(time, _)| (time - moment).abs() < 1e-6)
        .map(|(_, gap)| *gap)
        .collect();
    now.sort_by(f64::total_cmp);
    let middle = now.get(now.len() / 2).copied().unwrap_or(NEAR);
    let high = (REACH * middle).max(NEAR);
    let near = points()
        .filter(|(_, gap)| *gap <= high)
        .map(|(time, _)| *time)
        .reduce(f64::min);
    let from = (moment - LEAST).min(near.unwrap_or(moment));
    Some(((from, last.max(from + LEAST)), high))
}

/// The stretches of a line from a time on and up to a gap, which they reach where the line goes on above it.
fn below(runs: &[Vec<(f64, f64)>], from: f64, top: f64) -> Vec<Vec<(f64, f64)>> {
    let is_seen = |(time, gap): &(f64, f64)| *time >= from - 1e-6 && *gap <= top;
    let crossed = |run: &Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        let mut all: Vec<(f64, f64)> = run.first().copied().into_iter().collect();
        for pair in run.windows(2) {
            let ((start, gap), (end, next)) = (pair[0], pair[1]);
            if (gap - top) * (next - top) < 0.0 {
                all.push((start + (end - start) * (top - gap) / (next - gap), top));
            }
            all.push(pair[1]);
        }
        all
    };
    let runs: Vec<Vec<(f64, f64)>> = runs.iter().map(crossed).collect();
    runs.iter()
        .flat_map(|run| run.chunk_by(|a, b| is_seen(a) == is_seen(b)))
        .filter(|part| part.first().is_some_and(is_seen))
        .map(<[_]>::to_vec)
        .collect()
}

/// Writes the name of a line where it is free nearest to the end of it, behind it if both sides are; of one above the
/// plot, how far away it is at the moment.
fn name(f: &mut Frame<'_>, axes: &Axes, area: Rect, curve: &Curve, above: Option<f64>) {
    let (plot, end) = (axes.plot, curve.runs.last().and_then(|run| run.last()));
    let (words, column, row) = match (end, above) {
        (Some((time, gap)), _) => (curve.name.clone(), axes.column(*time), axes.row(*gap)),
        (None, Some(gap)) => {
            let words = format!("↑ {} {gap:.0} m", curve.name);
            (words, plot.x, Some(plot.y))
        }
        (None, None) => return,
    };
    let Some(row) = row else { return };
    let width = u16::try_from(words.width()).unwrap_or(u16::MAX);
    let buffer = f.buffer_mut();
    let is_free = |(x, y): &(u16, u16)| {
        let mut around = x.saturating_sub(1)..(x + width + 1).min(area.right());
        around.all(|x| marks::is_free(buffer, x, *y))
    };
    let away = |(x, y): &(u16, u16)| {
        let aside = x.saturating_sub(column);
        let before = column.saturating_sub(x + width.saturating_sub(1));
        aside.max(before) + ROW * row.abs_diff(*y)
    };
    let columns = || (plot.left()..(area.right() + 1).saturating_sub(width)).rev();
    let places = (plot.top()..plot.bottom()).flat_map(|y| columns().map(move |x| (x, y)));
    if let Some((x, y)) = places.filter(is_free).min_by_key(away) {
        let words = Span::styled(words, Style::new().fg(curve.color));
        buffer.set_span(x, y, &words, width);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_reach_the_top_where_they_go_on_above_it() {
        let run = vec![(0.0, 9.0), (1.0, 3.0), (2.0, 1.0), (3.0, 1.0), (4.0, 5.0)];
        let seen = below(std::slice::from_ref(&run), 0.0, 2.0);
        assert_eq!(seen, [[(1.5, 2.0), (2.0, 1.0), (3.0, 1.0), (3.25, 2.0)]]);
        assert_eq!(below(&[run], 3.0, 2.0), [[(3.0, 1.0), (3.25, 2.0)]]);
    }
}
