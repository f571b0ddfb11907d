//! A measure over time: the most dangerous of all obstacles, the picked one, the marked ones, and thresholds.

mod axes;
mod drives;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{Canvas, Context, Line as Stroke, Points};
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::metrics::{Measure, Series};
use crate::render::Ticks;
use crate::tui::loaded::Opened;
use crate::tui::model::{Model, Pane};
use crate::tui::widgets::frame;
use crate::tui::widgets::words::{fit, quantity};

/// A line of the plot: what it is called, its colour, its points.
struct Curve {
    name: String,
    color: Color,
    /// Whether it is of an obstacle that was picked or marked.
    chosen: bool,
    /// A run of points for every stretch without gaps, so that nothing is drawn where there is no value.
    runs: Vec<Vec<(f64, f64)>>,
}

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    if let (Some(what), Some(_)) = (model.plot.drives, model.planned()) {
        return drives::draw(f, area, model, what);
    }
    let theme = &model.theme;
    let opened = model.opened.as_ref();
    let (Some(opened), Some(series)) = (opened, &model.plot.series) else {
        let title = Line::from(model.plot.measure.id);
        let inner = frame::pane(f, area, model, Pane::Plot, title);
        let words = match model.scene() {
            Some(_) => "computing…".to_string(),
            None => model.without_ego(),
        };
        let words = Paragraph::new(words).wrap(Wrap { trim: true });
        f.render_widget(words.style(Style::new().fg(theme.dim)), inner);
        return;
    };
    let room = usize::from(area.width).saturating_sub(4);
    let title = fitting(title(model, opened, series), room);
    let pane = frame::pane(f, area, model, Pane::Plot, title);
    let curves = curves(model, opened, series);
    let inner = legend(f, area, pane, model, &curves);
    let dt = opened.scenario.dt();
    let steps = series.steps();
    let (from, to) = (steps.start as f64 * dt, (steps.end - 1) as f64 * dt);
    let to = to.max(from + dt);
    let measure = model.plot.measure;
    let values: Vec<f64> = model
        .thresholds
        .for_measure(measure.id)
        .map(|t| t.value)
        .collect();
    let upwards = upwards(measure, &curves, &values, axes::most_upwards(inner));
    let plot = axes::draw(f, inner, (from, to), &upwards, measure.unit, theme.dim);
    let (low, high) = upwards.bounds();
    let now = model.clock.step() as f64 * dt;
    let canvas = Canvas::default()
        .marker(Marker::Braille)
        .x_bounds([from, to])
        .y_bounds([low, high])
        .paint(|ctx| {
            for &value in values.iter().filter(|v| (low..=high).contains(*v)) {
                stroke(ctx, &[(from, value), (to, value)], theme.dim);
            }
            stroke(ctx, &[(now, low), (now, high)], theme.accent);
            for curve in &curves {
                for run in &curve.runs {
                    stroke(ctx, run, curve.color);
                }
            }
        });
    f.render_widget(canvas, plot);
    beyond(f, plot, model, (low, high));
    model.drawn.time_scale(plot);
}

/// A line from point to point; a lonely point is a dot.
fn stroke(ctx: &mut Context<'_>, points: &[(f64, f64)], color: Color) {
    if let [only] = points {
        ctx.draw(&Points {
            coords: &[*only],
            color,
        });
    }
    for pair in points.windows(2) {
        ctx.draw(&Stroke::new(
            pair[0].0, pair[0].1, pair[1].0, pair[1].1, color,
        ));
    }
}

/// An arrow towards each threshold that the axis does not reach, with its value.
fn beyond(f: &mut Frame<'_>, plot: Rect, model: &Model, (low, high): (f64, f64)) {
    let measure = model.plot.measure;
    let words = |above: bool| {
        let of_measure = model.thresholds.for_measure(measure.id);
        let there = of_measure.filter(|t| if above { t.value > high } else { t.value < low });
        let sign = if above { "↑" } else { "↓" };
        let each = there.map(|t| format!("{sign} {} {}", t.name, quantity(t.value, measure.unit)));
        each.collect::<Vec<_>>().join("  ")
    };
    let style = Style::new().fg(model.theme.dim);
    for (above, y) in [(true, plot.top()), (false, plot.bottom().saturating_sub(1))] {
        let words = fit(&words(above), usize::from(plot.width));
        let width = u16::try_from(words.width()).unwrap_or(0);
        if width > 0 && plot.height > 0 {
            let at = Rect::new(plot.right() - width, y, width, 1);
            f.render_widget(Span::styled(words, style), at);
        }
    }
}

/// The measure, its most dangerous value now, the most dangerous of all, and who is picked: the most telling first.
fn title(model: &Model, opened: &Opened, series: &Series) -> Vec<Vec<Span<'static>>> {
    let (theme, measure) = (&model.theme, model.plot.measure);
    let mut parts = vec![vec![Span::raw(measure.id)]];
    let colored = |value: f64| match measure.id {
        "risk" => theme.risk(value),
        _ => theme.warning,
    };
    if let Some((id, value)) = series.most_dangerous_at(measure.id, model.clock.step()) {
        let words = format!("now {}", quantity(value, measure.unit));
        parts.push(vec![
            Span::styled(words, Style::new().fg(colored(value))),
            Span::raw(format!(" ({id})")),
        ]);
    }
    if let Some((step, value)) = series.most_dangerous(measure.id) {
        let time = step as f64 * opened.scenario.dt();
        let (word, value) = (measure.danger.extreme(), quantity(value, measure.unit));
        parts.push(vec![Span::raw(format!("{word} {value} at {time:.1} s"))]);
    }
    if let Some(id) = model.picked {
        let style = Style::new().fg(theme.picked);
        parts.push(vec![Span::styled(format!("picked {id}"), style)]);
    }
    parts
}

/// As many whole parts as there is room for.
fn fitting(parts: Vec<Vec<Span<'static>>>, room: usize) -> Line<'static> {
    let mut line = Line::default();
    for (i, part) in parts.into_iter().enumerate() {
        let separator = if i == 0 { "" } else { " · " };
        let width: usize = part.iter().map(Span::width).sum();
        if i > 0 && line.width() + separator.width() + width > room {
            break;
        }
        line.push_span(Span::raw(separator));
        line.spans.extend(part);
    }
    line
}

fn curves(model: &Model, opened: &Opened, series: &Series) -> Vec<Curve> {
    let (theme, id) = (&model.theme, model.plot.measure.id);
    let dt = opened.scenario.dt();
    let runs = |value: &dyn Fn(i64) -> Option<f64>| {
        let values: Vec<_> = series
            .steps()
            .map(|s| Some((s as f64 * dt, value(s)?)))
            .collect();
        let runs = values.split(Option::is_none).filter(|run| !run.is_empty());
        runs.map(|run| run.iter().flatten().copied().collect())
            .collect()
    };
    let mut curves = vec![Curve {
        name: model.plot.measure.danger.extreme().into(),
        color: theme.warning,
        chosen: false,
        runs: runs(&|s| series.most_dangerous_at(id, s).map(|(_, v)| v)),
    }];
    let of = |obstacle: i64, color: Color| Curve {
        name: obstacle.to_string(),
        color,
        chosen: true,
        runs: runs(&|s| series.at(id, obstacle, s).value()),
    };
    let colors = [
        theme.safe,
        theme.danger,
        theme.obstacle,
        theme.goal,
        theme.ego,
    ];
    let marked = model
        .plot
        .marked
        .iter()
        .filter(|m| Some(**m) != model.picked);
    curves.extend(marked.zip(colors).map(|(&m, color)| of(m, color)));
    curves.extend(model.picked.map(|picked| of(picked, theme.picked)));
    curves
}

/// The axis of risk scores, always whole.
fn risk_axis(most: usize) -> Ticks {
    let (low, high) = (0.0, 5.0);
    if most < 5 {
        Ticks::ends(low, high)
    } else {
        Ticks::around(low, high, 6)
    }
}

/// So much of what the values take up may be added to reach a threshold.
const NEAR: f64 = 0.5;

/// The axis upwards: from the lowest to the highest value, and to thresholds near them; the risk score always whole.
fn upwards(measure: &Measure, curves: &[Curve], thresholds: &[f64], most: usize) -> Ticks {
    if measure.id == "risk" {
        return risk_axis(most);
    }
    let points = curves.iter().flat_map(|c| c.runs.iter().flatten());
    let values = points.map(|p| p.1);
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return Ticks::ends(0.0, 1.0);
    }
    let room = NEAR * (high - low);
    let near = |t: &&f64| (low - room..=high + room).contains(*t);
    let (mut low, mut high) = thresholds
        .iter()
        .filter(near)
        .fold((low, high), |(l, h), &t| (l.min(t), h.max(t)));
    if high - low <= 1e-9 * low.abs().max(1e-3) {
        // One value all the time: it stands between two others.
        let around = (low.abs() * 0.1).max(0.5);
        (low, high) = (low - around, high + around);
    }
    Ticks::around(low, high, most)
}

/// Whose line is which, names in the colours of their lines, and the thresholds: in the first line, or on a small plot
/// in the lower border. Gives the area that is left.
fn legend(f: &mut Frame<'_>, pane: Rect, inner: Rect, model: &Model, curves: &[Curve]) -> Rect {
    let (theme, measure) = (&model.theme, model.plot.measure);
    let small = inner.height < 8;
    // Lines the user chose are named first, even without values.
    let chosen = curves.iter().filter(|c| c.chosen);
    let all = curves.iter().filter(|c| !c.chosen && !c.runs.is_empty());
    let mut parts: Vec<Vec<Span<'static>>> = chosen
        .chain(all)
        .map(|c| {
            let (sign, none, color) = match c.runs.is_empty() {
                true => ("", " –", theme.dim),
                false => ("━", "", c.color),
            };
            let words = format!("{sign}{}{none}", c.name);
            vec![Span::styled(words, Style::new().fg(color))]
        })
        .collect();
    let thresholds = model.thresholds.for_measure(measure.id).map(|threshold| {
        let words = format!(
            "╌{} {}{}",
            threshold.name,
            quantity(threshold.value, measure.unit),
            if threshold.own { " (yours)" } else { "" },
        );
        vec![Span::styled(words, Style::new().fg(theme.dim))]
    });
    parts.extend(thresholds);
    let mut line = Line::default();
    for part in parts {
        let width: usize = part.iter().map(Span::width).sum();
        if line.width() + width + 2 > usize::from(inner.width) {
            break;
        }
        line.push_span(Span::raw(" "));
        line.spans.extend(part);
    }
    if small {
        if line.width() > 0 && pane.height > 2 {
            line.push_span(Span::raw(" "));
            let width = u16::try_from(line.width()).unwrap_or(0).min(inner.width);
            let border = Rect::new(inner.x, pane.bottom() - 1, width, 1);
            f.render_widget(line, border);
        }
        return inner;
    }
    f.render_widget(line, Rect { height: 1, ..inner });
    Rect {
        y: inner.y + 1,
        height: inner.height - 1,
        ..inner
    }
}
