//! A measure over time: the most dangerous of all obstacles, the picked one, the marked ones, and thresholds.

pub mod axes;
pub mod gaps;
pub mod marks;

use std::collections::BTreeSet;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::Canvas;
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::features::answers::obstacles::{bare, color};
use crate::loaded::Opened;
use crate::model::{Model, Pane};
use crate::theme::Theme;
use crate::widgets::window;
use crate::widgets::words::quantity;
use axes::{Axes, Dash, Drawn, Upwards, stroke};
use marks::{Event, Stated};
use nearmiss_render::{Ticks, runs, steps, value_range};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::{Measure, Series, Threshold};

/// A line of the plot: what it is called, how it looks, its points.
struct Curve {
    name: String,
    color: Color,
    dash: Dash,
    /// Whether it is of an obstacle that was picked or marked.
    chosen: bool,
    /// A run of points for every stretch without gaps, so that nothing is drawn where there is no value.
    runs: Vec<Vec<(f64, f64)>>,
}

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let ended = ended_at_once(model);
    if let (Some(what), Some(_), None) = (model.plot.drives, model.planned(), &ended) {
        return marks::draw(f, area, model, what);
    }
    let theme = &model.theme;
    let opened = model.opened.as_ref();
    let (Some(opened), Some(series), None) = (opened, &model.plot.series, &ended) else {
        let title = Line::from(model.plot.measure.id);
        let inner = window::pane(f, area, model, Pane::Plot, title);
        let words = ended.unwrap_or_else(|| match model.scene() {
            Some(_) => "computing…".to_string(),
            None if model.awaits_ego() => model.without_ego(),
            None => "no values without an ego".into(),
        });
        let words = Paragraph::new(words).wrap(Wrap { trim: true });
        f.render_widget(words.style(Style::new().fg(theme.dim)), inner);
        return;
    };
    let room = usize::from(area.width).saturating_sub(4);
    let title = fitting(title(model, opened, series), room);
    let pane = window::pane(f, area, model, Pane::Plot, title);
    let curves = curves(model, opened, series);
    let (inner, key) = apart(area, pane);
    let dt = opened.scenario.dt();
    let steps = series.steps();
    let (from, to) = (steps.start as f64 * dt, (steps.end - 1) as f64 * dt);
    let measure = model.plot.measure;
    let values: Vec<f64> = model
        .thresholds
        .for_measure(measure.id)
        .map(|t| t.value)
        .collect();
    let upwards = upwards(measure, &curves, &values, inner);
    let window = window(model, dt);
    let drawn = Drawn {
        time: (from, to.max(from + dt)),
        upwards: &upwards,
        unit: measure.unit,
        color: theme.dim,
    };
    let axes = axes::draw(f, inner, &drawn);
    lines(f, &axes, &curves, measure.is_ordinal());
    marks::shade(f, &axes, window, Style::new().bg(theme.shade));
    let answers = marks::answers(f, &axes, model, dt);
    let now = model.clock.step() as f64 * dt;
    let now = (now, Style::new().fg(theme.accent));
    marks::events(f, &axes, inner, &events(model, opened, series), now);
    marks::window(f, &axes, inner, window, Style::new().fg(theme.dim));
    // Names of thresholds keep away from the letters and from lines down.
    let unnamed = marks::thresholds(f, &axes, model);
    legend(f, key, model, &curves, &unnamed, &answers);
    model.drawn.time_scale(axes.plot);
}

/// A planned drive that is shorter has no course to plot, seconds.
const SHORTEST: f64 = 0.5;

/// How a planned drive ended that is too short to be plotted.
fn ended_at_once(model: &Model) -> Option<String> {
    let seconds = model.opened.as_ref()?.seconds();
    let outcome = &model.planned()?.outcome;
    (seconds < SHORTEST).then(|| format!("the drive ends after {seconds:.1} s: {outcome}"))
}

/// The window that is shown, in seconds.
fn window(model: &Model, dt: f64) -> Option<(f64, f64)> {
    let (first, last) = model.shown_window()?;
    Some((first as f64 * dt, last as f64 * dt))
}

/// The contact or else the moment that matters, and the most dangerous value of all.
fn events(model: &Model, opened: &Opened, series: &Series) -> Vec<Event> {
    let (theme, measure) = (&model.theme, model.plot.measure);
    let event = |step: i64, sign, words: &str, color| Event {
        time: step as f64 * opened.scenario.dt(),
        sign,
        label: words.into(),
        style: Style::new().fg(color).add_modifier(Modifier::BOLD),
    };
    let contact = opened
        .contact()
        .map(|contact| event(contact.step, 'X', contact.name(), theme.danger));
    let extreme = series
        .most_dangerous(measure.id)
        .map(|(step, _)| event(step, '▾', measure.extreme(), theme.text));
    let worst = opened
        .worst_untouched()
        .map(|moment| event(moment.step, '▼', "most severe", theme.text));
    contact.into_iter().chain(worst).chain(extreme).collect()
}

/// Draws the curves between the axes, levels as steps.
fn lines(f: &mut Frame<'_>, axes: &Axes, curves: &[Curve], levels: bool) {
    let (right, top) = axes.last_dot();
    let canvas = Canvas::default()
        .marker(Marker::Braille)
        .x_bounds([0.0, right])
        .y_bounds([0.0, top])
        .paint(|ctx| {
            for curve in curves {
                for run in &curve.runs {
                    let run = if levels { steps(run) } else { run.clone() };
                    let dots: Vec<_> = run.iter().map(|point| axes.dots(*point)).collect();
                    stroke(ctx, &dots, curve.dash, curve.color);
                }
            }
        });
    f.render_widget(canvas, axes.plot);
}

/// The measure with its most dangerous value now, the most dangerous of all, what 0 means, and who is picked: the most
/// telling first.
fn title(model: &Model, opened: &Opened, series: &Series) -> Vec<Vec<Span<'static>>> {
    let (theme, measure) = (&model.theme, model.plot.measure);
    let mut parts = vec![vec![Span::raw(measure.id)]];
    let colored = |value: f64| match measure.id {
        "risk" => theme.risk(value),
        _ => theme.text,
    };
    if let Some((id, value)) = series.most_dangerous_at(measure.id, model.clock.step()) {
        let words = format!(" now {}", quantity(value, measure.unit));
        parts[0].extend([
            Span::styled(words, Style::new().fg(colored(value))),
            Span::raw(format!(" ({id})")),
        ]);
    }
    if let Some((step, value)) = series.most_dangerous(measure.id) {
        let time = step as f64 * opened.scenario.dt();
        let (word, value) = (measure.extreme(), quantity(value, measure.unit));
        parts.push(vec![Span::raw(format!("{word} {value} at {time:.1} s"))]);
    }
    if measure.is_ordinal() {
        parts.push(vec![Span::raw("0 = collision")]);
    }
    if let Some(id) = model.picked {
        let style = Style::new().fg(theme.picked);
        parts.push(vec![Span::styled(format!("picked {id}"), style)]);
    }
    parts
}

/// As many whole parts as there is room for.
pub fn fitting(parts: Vec<Vec<Span<'static>>>, room: usize) -> Line<'static> {
    let mut line = Line::default();
    for (i, part) in parts.into_iter().enumerate() {
        let separator = if i == 0 { "" } else { " · " };
        let width: usize = part.iter().map(Span::width).sum();
        if i > 0 && line.width() + separator.width() + width > room {
            continue;
        }
        line.push_span(Span::raw(separator));
        line.spans.extend(part);
    }
    line
}

fn curves(model: &Model, opened: &Opened, series: &Series) -> Vec<Curve> {
    let (theme, id) = (&model.theme, model.plot.measure.id);
    let dt = opened.scenario.dt();
    let runs = |value: &dyn Fn(i64) -> Option<f64>| runs(series, dt, value);
    let mut curves = vec![Curve {
        name: model.plot.measure.extreme().into(),
        color: theme.text,
        dash: Dash::Solid,
        chosen: false,
        runs: runs(&|s| series.most_dangerous_at(id, s).map(|(_, v)| v)),
    }];
    let of = |obstacle: i64, color: Color, dash: Dash| Curve {
        name: obstacle.to_string(),
        color,
        dash,
        chosen: true,
        runs: runs(&|s| series.at(id, obstacle, s).value()),
    };
    let colors = [theme.sign, theme.truck, theme.cycle, theme.pedestrian];
    let looks = colors.into_iter().zip(Dash::MARKED.into_iter().cycle());
    let marked = model
        .plot
        .marked
        .iter()
        .filter(|m| Some(**m) != model.picked);
    curves.extend(
        marked
            .zip(looks.cycle())
            .map(|(&m, (color, dash))| of(m, color, dash)),
    );
    let picked = model.picked.map(|id| of(id, theme.picked, Dash::Dashed));
    curves.extend(picked);
    curves
}

/// The axis upwards: from the lowest to the highest value, and to thresholds near them; the risk score always whole.
fn upwards(measure: &Measure, curves: &[Curve], thresholds: &[f64], area: Rect) -> Upwards {
    if measure.is_ordinal() {
        return Upwards::of_risk(area);
    }
    let points = curves.iter().flat_map(|c| c.runs.iter().flatten());
    match value_range(points.map(|p| p.1), thresholds.iter().copied()) {
        None => Upwards::fitting(area, |_| Ticks::ends(0.0, 1.0)),
        Some((low, high)) => Upwards::fitting(area, |most| Ticks::around(low, high, most)),
    }
}

/// The area of the plot, and the line of its legend: the first one, or on a small plot a part of the lower border.
fn apart(pane: Rect, inner: Rect) -> (Rect, Rect) {
    if inner.height < 8 {
        let border = Rect::new(inner.x, pane.bottom().saturating_sub(1), inner.width, 1);
        let height = u16::from(pane.height > 2);
        return (inner, Rect { height, ..border });
    }
    let rest = Rect {
        y: inner.y + 1,
        height: inner.height - 1,
        ..inner
    };
    (rest, Rect { height: 1, ..inner })
}

/// The letters of answers before the score that they state, the lowest first.
fn by_score(theme: &Theme, answers: &[Stated]) -> Vec<Line<'static>> {
    let scores: BTreeSet<u8> = answers.iter().map(|answer| answer.score).collect();
    let of = |score: u8| {
        let all = answers.iter().filter(|answer| answer.score == score);
        let letters = all.map(|answer| {
            let style = Style::new().fg(color(theme, answer.place));
            Span::styled(answer.sign.to_string(), style)
        });
        let words = Span::styled(format!(" {score}"), Style::new().fg(theme.dim));
        Line::from_iter(letters.chain([words]))
    };
    scores.into_iter().map(of).collect()
}

/// Whose line is which, by sign and colour, and thresholds whose names are not at their lines.
fn legend(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    curves: &[Curve],
    unnamed: &[&Threshold],
    answers: &[Stated],
) {
    let theme = &model.theme;
    let part = |words: String, color| Line::from(Span::styled(words, Style::new().fg(color)));
    // Lines the user chose are named first, even without values.
    let chosen = curves.iter().filter(|c| c.chosen);
    let all = curves.iter().filter(|c| !c.chosen && !c.runs.is_empty());
    let named = chosen.chain(all).map(|c| {
        if c.runs.is_empty() {
            part(format!("{} –", c.name), theme.dim)
        } else {
            part(format!("{} {}", c.dash.sign(), c.name), c.color)
        }
    });
    let thresholds = unnamed.iter().map(|threshold| {
        let words = marks::threshold_label(threshold, model.plot.measure.unit);
        part(format!("┄{words}"), theme.dim)
    });
    let with_name = |stated: &Stated| {
        let name = bare(&model.answers.columns[stated.place].model);
        let words = format!("{} {}", stated.sign, visible(name));
        part(words, color(theme, stated.place))
    };
    let named: Vec<Line<'static>> = named.collect();
    let whole = named.iter().cloned().chain(answers.iter().map(with_name));
    let whole: Vec<Line<'static>> = whole.collect();
    let columns: usize = whole.iter().map(|part| part.width() + 2).sum();
    // Every letter is explained: where there is no room for names by its score, beside the others of the same.
    let shown = if columns <= usize::from(area.width) {
        whole
    } else {
        named.into_iter().chain(by_score(theme, answers)).collect()
    };
    let mut line = Line::default();
    for part in shown.into_iter().chain(thresholds) {
        if line.width() + part.width() + 3 > usize::from(area.width) {
            break;
        }
        line.push_span(Span::raw(if line.spans.is_empty() { " " } else { "  " }));
        line.spans.extend(part.spans);
    }
    if line.width() > 0 {
        line.push_span(Span::raw(" "));
        let width = u16::try_from(line.width())
            .unwrap_or(area.width)
            .min(area.width);
        f.render_widget(line, Rect { width, ..area });
    }
}
