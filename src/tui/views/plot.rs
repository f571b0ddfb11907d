//! A measure over time: the most dangerous of all obstacles, the picked one, the marked ones, and thresholds.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Chart, Dataset, GraphType, Paragraph, Wrap};

use crate::metrics::{Measure, Series};
use crate::tui::loaded::Opened;
use crate::tui::model::{Model, Pane};
use crate::tui::widgets::frame;
use crate::tui::widgets::words::{number, quantity};

/// A line of the plot: what it is called, its colour, its points.
struct Curve {
    name: String,
    color: Color,
    /// A run of points for every stretch without gaps, so that nothing is drawn where there is no value.
    runs: Vec<Vec<(f64, f64)>>,
}

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let theme = &model.theme;
    let opened = model.opened.as_ref();
    let (Some(opened), Some(series)) = (opened, &model.plot.series) else {
        let title = Line::from(model.plot.measure.id);
        let inner = frame::pane(f, area, model, Pane::Plot, title);
        let words = Paragraph::new("needs an ego").wrap(Wrap { trim: true });
        f.render_widget(words.style(Style::new().fg(theme.dim)), inner);
        return;
    };
    let inner = frame::pane(f, area, model, Pane::Plot, title(model, opened, series));
    let curves = curves(model, opened, series);
    let inner = legend(f, inner, model, &curves);
    let dt = opened.scenario.dt();
    let steps = series.steps();
    let (from, to) = (steps.start as f64 * dt, (steps.end - 1) as f64 * dt);
    let to = to.max(from + dt);
    let (low, high) = bounds(model.plot.measure, &curves);
    let now = model.clock.step() as f64 * dt;
    let cursor = [(now, low), (now, high)];
    let limits: Vec<[(f64, f64); 2]> = model
        .thresholds
        .of(model.plot.measure.id)
        .filter(|t| (low..=high).contains(&t.value))
        .map(|t| [(from, t.value), (to, t.value)])
        .collect();
    let mut lines: Vec<Dataset<'_>> = limits.iter().map(|l| dataset(l, theme.dim)).collect();
    lines.push(dataset(&cursor, theme.accent));
    for curve in &curves {
        lines.extend(curve.runs.iter().map(|run| dataset(run, curve.color)));
    }
    let dim = Style::new().fg(theme.dim);
    let chart = Chart::new(lines)
        .x_axis(
            Axis::default()
                .style(dim)
                .bounds([from, to])
                .labels([format!("{from:.0} s"), format!("{to:.1} s")]),
        )
        .y_axis(
            Axis::default()
                .style(dim)
                .bounds([low, high])
                .labels(labels(low, high, model.plot.measure)),
        );
    f.render_widget(chart, inner);
    let scale = Rect {
        x: inner.x + 2,
        width: inner.width.saturating_sub(2),
        ..inner
    };
    model.drawn.time_scale(scale);
}

fn dataset<'a>(points: &'a [(f64, f64)], color: Color) -> Dataset<'a> {
    Dataset::default()
        .marker(Marker::Braille)
        .graph_type(GraphType::Line)
        .style(Style::new().fg(color))
        .data(points)
}

/// The measure, its most dangerous value now, and the most dangerous of all.
fn title(model: &Model, opened: &Opened, series: &Series) -> Line<'static> {
    let (theme, measure) = (&model.theme, model.plot.measure);
    let mut title = Line::from(measure.id);
    let colored = |value: f64| match measure.id {
        "risk" => theme.risk(value),
        _ => theme.warning,
    };
    if let Some((id, value)) = series.most_dangerous_at(measure.id, model.clock.step()) {
        title.push_span(Span::styled(
            format!(" · now {}", quantity(value, measure.unit)),
            Style::new().fg(colored(value)),
        ));
        title.push_span(Span::raw(format!(" ({id})")));
    }
    if let Some(id) = model.picked {
        title.push_span(Span::raw(" · "));
        title.push_span(Span::styled(
            format!("picked {id}"),
            Style::new().fg(theme.picked),
        ));
    }
    if let Some((step, value)) = series.most_dangerous(measure.id) {
        let time = step as f64 * opened.scenario.dt();
        let word = measure.danger.extreme();
        title.push_span(Span::raw(format!(
            " · {word} {} at {time:.1} s",
            quantity(value, measure.unit)
        )));
    }
    title
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
        runs: runs(&|s| series.most_dangerous_at(id, s).map(|(_, v)| v)),
    }];
    let of = |obstacle: i64, color: Color| Curve {
        name: obstacle.to_string(),
        color,
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

/// From the lowest to the highest value, a little wider; the risk score always whole.
fn bounds(measure: &Measure, curves: &[Curve]) -> (f64, f64) {
    if measure.id == "risk" {
        return (-0.2, 5.2);
    }
    let values = curves
        .iter()
        .flat_map(|c| c.runs.iter().flatten())
        .map(|p| p.1);
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return (0.0, 1.0);
    }
    let room = ((high - low) * 0.05).max(1e-3);
    // A measure that is never negative keeps 0 as its floor.
    let floor = if low >= 0.0 {
        (low - room).max(0.0)
    } else {
        low - room
    };
    (floor, high + room)
}

fn labels(low: f64, high: f64, measure: &Measure) -> [String; 3] {
    match measure.id {
        "risk" => ["0".into(), String::new(), "5".into()],
        _ => [number(low), String::new(), number(high)],
    }
}

/// Whose line is which: names in the colours of their lines, and the thresholds. Gives the area that is left.
fn legend(f: &mut Frame<'_>, area: Rect, model: &Model, curves: &[Curve]) -> Rect {
    let (theme, measure) = (&model.theme, model.plot.measure);
    // On a small plot the lines matter more than their names, which the title has in part.
    if area.height < 8 {
        return area;
    }
    let mut line = Line::default();
    for curve in curves.iter().filter(|c| !c.runs.is_empty()) {
        line.push_span(Span::styled(
            format!("━{} ", curve.name),
            Style::new().fg(curve.color),
        ));
    }
    for threshold in model.thresholds.of(measure.id) {
        let words = format!(
            "╌{} {}{} ",
            threshold.name,
            quantity(threshold.value, measure.unit),
            if threshold.own { " (yours)" } else { "" },
        );
        line.push_span(Span::styled(words, Style::new().fg(theme.dim)));
    }
    f.render_widget(line, Rect { height: 1, ..area });
    Rect {
        y: area.y + 1,
        height: area.height - 1,
        ..area
    }
}
