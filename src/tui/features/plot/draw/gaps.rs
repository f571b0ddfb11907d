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
/// Columns that the plot keeps before names stand at the ends of lines.
const COLUMNS: u16 = 36;

/// Draws the gaps to an obstacle around a moment, which is marked; each line has its name at its end.
pub fn draw(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    drives: &[GapCurve<'_>],
    obstacle: i64,
    moment: Event,
) {
    let all: Vec<Curve> = { drives.iter() }
        .map(|drive| curve(drive, obstacle, moment.time))
        .collect();
    let Some((time, high)) = seen(&all, moment.time) else {
        return;
    };
    // The moment is named in the first row.
    let rest = Rect {
        y: area.y + 1.min(area.height),
        height: area.height.saturating_sub(1),
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
    for (curve, whole) in curves.iter().zip(&all) {
        let mut points = whole.runs.iter().flatten();
        let there = points.find(|(time, _)| *time >= moment.time - 1e-6);
        name(f, &axes, area, curve, there.map(|(_, gap)| *gap));
    }
    // Steps of the clock outside of it say nothing here.
    let clock = model.clock.time();
    let now = if (time.0..=time.1).contains(&clock) {
        clock
    } else {
        moment.time
    };
    let accent = Style::new().fg(model.theme.accent);
    marks::events(f, &axes, area, &[moment], (now, accent));
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

/// The stretches of a line from a time on and up to a gap.
fn below(runs: &[Vec<(f64, f64)>], from: f64, top: f64) -> Vec<Vec<(f64, f64)>> {
    let is_seen = |(time, gap): &(f64, f64)| *time >= from - 1e-6 && *gap <= top;
    runs.iter()
        .flat_map(|run| run.chunk_by(|a, b| is_seen(a) == is_seen(b)))
        .filter(|part| part.first().is_some_and(is_seen))
        .map(<[_]>::to_vec)
        .collect()
}

/// Writes the name of a line beside its end, or a row above or below, where it is free; of one above the plot, how far
/// away it is at the moment.
fn name(f: &mut Frame<'_>, axes: &Axes, area: Rect, curve: &Curve, above: Option<f64>) {
    let end = curve.runs.last().and_then(|run| run.last());
    let (words, x, row) = match (end, above) {
        (Some((time, gap)), _) => (curve.name.clone(), axes.column(*time) + 3, axes.row(*gap)),
        (None, Some(gap)) => {
            let words = format!("↑ {} {gap:.0} m", curve.name);
            (words, axes.plot.x + 1, Some(axes.plot.y))
        }
        (None, None) => return,
    };
    let Some(row) = row else { return };
    let width = u16::try_from(words.width()).unwrap_or(u16::MAX);
    let rows = axes.plot.top()..axes.plot.bottom();
    let buffer = f.buffer_mut();
    let is_free = |y: &u16| {
        let mut cells = x.saturating_sub(1)..x.saturating_add(width);
        rows.contains(y)
            && x.saturating_add(width) <= area.right()
            && cells.all(|x| marks::is_free(buffer, x, *y))
    };
    let near = [0, -1, 1, -2, 2].map(|by| row.saturating_add_signed(by));
    if let Some(y) = near.into_iter().find(is_free) {
        let words = Span::styled(words, Style::new().fg(curve.color));
        buffer.set_span(x, y, &words, width);
    }
}
