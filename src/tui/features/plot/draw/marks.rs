//! Draws marks and both egos' drives into the plot.

use nearmiss_drive::generation::RiskCurve;
use nearmiss_render::Ticks;
use nearmiss_render::cells::attacker_color;
use nearmiss_scene::metrics::Threshold;
use nearmiss_scene::scenario::Track;
use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::{Position, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use unicode_width::UnicodeWidthStr;

use crate::features::answers::obstacles::letter;
use crate::features::plot::draw::axes::{self, Axes, Dash, Drawn, Range, Upwards};
use crate::features::plot::draw::{Curve, lines};
use crate::loaded::{Opened, PlannedEgo};
use crate::model::{Drives, Model, Pane};
use crate::widgets::line_placer::LinePlacer;
use crate::widgets::window;
use crate::widgets::words::{fit, quantity};

/// Signs of lines.
const THRESHOLD: char = '┄';
const NOW: char = '│';
const EVENT: char = '╎';

/// A time that something happens at.
pub struct Event {
    /// When.
    pub time: f64,
    /// Its sign.
    pub sign: char,
    /// What it is, where there is room.
    pub label: String,
    /// How it looks.
    pub style: Style,
}

/// Shades the window.
pub fn shade(f: &mut Frame<'_>, axes: &Axes, window: Option<Range>, style: Style) {
    let Some((from, to)) = window else { return };
    let (from, to) = (axes.column(from), axes.column(to));
    let shaded = Rect {
        x: from,
        width: (to + 1).saturating_sub(from),
        ..axes.plot
    };
    f.buffer_mut()
        .set_style(shaded.intersection(axes.plot), style);
}

/// The current step, and events with a line down from their signs: in the row above the plot if it is free.
pub fn events(f: &mut Frame<'_>, axes: &Axes, area: Rect, events: &[Event], now: (f64, Style)) {
    let buffer = f.buffer_mut();
    upright(buffer, axes, axes.column(now.0), NOW, now.1);
    if axes.plot.y > area.y {
        let mut row = LinePlacer::new(usize::from(axes.plot.width));
        let at = |event: &Event| usize::from(axes.column(event.time) - axes.plot.x);
        let placed: Vec<&Event> = events
            .iter()
            .filter(|event| row.sign(at(event), event.sign, event.style))
            .collect();
        for event in placed {
            row.words_beside(at(event), &event.label, event.style);
        }
        let above = Rect {
            y: axes.plot.y - 1,
            height: 1,
            ..axes.plot
        };
        f.render_widget(Line::from_iter(row.spans()), above);
        for event in events {
            let column = axes.column(event.time);
            upright(f.buffer_mut(), axes, column, EVENT, event.style);
        }
        return;
    }
    // The most important one is drawn last.
    for event in events.iter().rev() {
        let column = axes.column(event.time);
        upright(buffer, axes, column, EVENT, event.style);
        if let Some(cell) = buffer.cell_mut(Position::new(column, axes.plot.y)) {
            cell.set_char(event.sign).set_style(event.style);
        }
    }
}

/// Brackets around the window, in the row of the events, or in the highest one of the plot.
pub fn window(f: &mut Frame<'_>, axes: &Axes, area: Rect, window: Option<Range>, style: Style) {
    let Some((from, to)) = window.filter(|_| axes.plot.height > 0) else {
        return;
    };
    let y = if axes.plot.y > area.y {
        axes.plot.y - 1
    } else {
        axes.plot.y
    };
    let buffer = f.buffer_mut();
    for (time, sign) in [(from, '['), (to, ']')] {
        let column = axes.column(time);
        if is_free(buffer, column, y) {
            buffer[(column, y)].set_char(sign).set_style(style);
        }
    }
}

/// A letter in the plot: the answer in this place, and the risk score that it states.
pub struct Stated {
    /// The letter.
    pub sign: char,
    /// The place of the answer.
    pub place: usize,
    /// What it states.
    pub score: u8,
}

/// What each answer says of the risk of the picked obstacle: a letter in its colour at the end of its window, those at
/// the same place beside each other in their order. Gives the letters.
pub fn answers(f: &mut Frame<'_>, axes: &Axes, model: &Model, dt: f64) -> Vec<Stated> {
    if model.plot.measure.id != "risk" {
        return Vec::new();
    }
    let (_, end) = model.clock.range();
    let mut placed = Vec::new();
    let mut taken: Vec<Position> = Vec::new();
    let columns = model.answers.columns.iter().enumerate();
    // The last one stands at the end, those before it to its left.
    for (place, column) in columns.rev() {
        let (Some(sign), Some(score)) = (letter(place), model.stated_risk(column)) else {
            continue;
        };
        let Some(row) = axes.row(f64::from(score)) else {
            continue;
        };
        let step = column.steps.map_or(end, |(_, last)| last);
        let there = axes.column(step as f64 * dt);
        let left = (axes.plot.left()..=there).rev();
        let mut places = left.chain(there + 1..axes.plot.right());
        let free = places.find(|x| !taken.contains(&Position::new(*x, row)));
        let at = Position::new(free.unwrap_or(there), row);
        taken.push(at);
        let color = crate::features::answers::obstacles::color(&model.theme, place);
        let style = Style::new()
            .fg(color)
            .add_modifier(Modifier::BOLD | Modifier::REVERSED);
        if let Some(cell) = f.buffer_mut().cell_mut(at) {
            cell.set_char(sign).set_style(style);
            placed.push(Stated { sign, place, score });
        }
    }
    placed.reverse();
    placed
}

/// A line from top to bottom where nothing is drawn.
fn upright(buffer: &mut Buffer, axes: &Axes, column: u16, sign: char, style: Style) {
    for y in axes.plot.top()..axes.plot.bottom() {
        if is_free(buffer, column, y) {
            buffer[(column, y)].set_char(sign).set_style(style);
        }
    }
}

/// Thresholds as lines with their names, or as arrows with their values where the axis does not reach them. Gives those
/// whose names found no room.
pub fn thresholds<'a>(f: &mut Frame<'_>, axes: &Axes, model: &'a Model) -> Vec<&'a Threshold> {
    let (measure, plot) = (model.plot.measure, axes.plot);
    let style = Style::new().fg(model.theme.dim);
    let all: Vec<&Threshold> = model.thresholds.for_measure(measure.id).collect();
    let buffer = f.buffer_mut();
    let mut unnamed = Vec::new();
    for threshold in &all {
        let Some(y) = axes.row(threshold.value) else {
            continue;
        };
        for x in plot.left()..plot.right() {
            if is_free(buffer, x, y) {
                buffer[(x, y)].set_char(THRESHOLD).set_style(style);
            }
        }
        if !write(
            buffer,
            plot,
            y,
            &threshold_label(threshold, measure.unit),
            style,
        ) {
            unnamed.push(*threshold);
        }
    }
    let (top, bottom) = (plot.top(), plot.bottom().saturating_sub(1));
    for threshold in all.iter().filter(|t| axes.row(t.value).is_none()) {
        let above = threshold.value > axes.values().1;
        let (sign, y) = if above { ("↑", top) } else { ("↓", bottom) };
        let words = format!("{sign} {}", threshold_label(threshold, measure.unit));
        if !write(buffer, plot, y, &words, style) {
            unnamed.push(*threshold);
        }
    }
    unnamed
}

/// A threshold with its value.
pub fn threshold_label(threshold: &Threshold, unit: &str) -> String {
    let own = if threshold.own { " (yours)" } else { "" };
    format!(
        "{} {}{own}",
        threshold.name,
        quantity(threshold.value, unit)
    )
}

/// Writes words into a row of the plot, on the left if that is free, as scenes end with what matters.
fn write(buffer: &mut Buffer, plot: Rect, y: u16, words: &str, style: Style) -> bool {
    let words = fit(words, usize::from(plot.width));
    let width = u16::try_from(words.width()).unwrap_or(u16::MAX);
    let last = plot.right().saturating_sub(width);
    let place = (plot.left()..=last).find(|&x| {
        let around = x.saturating_sub(1).max(plot.left())..(x + width + 1).min(plot.right());
        around.into_iter().all(|x| is_behind(buffer, x, y))
    });
    let Some(x) = place.filter(|_| width > 0) else {
        return false;
    };
    buffer.set_string(x, y, words, style.remove_modifier(Modifier::BOLD));
    true
}

fn sign_at(buffer: &Buffer, x: u16, y: u16) -> Option<char> {
    buffer.cell(Position::new(x, y))?.symbol().chars().next()
}

/// Whether nothing is drawn in a cell.
pub(super) fn is_free(buffer: &Buffer, x: u16, y: u16) -> bool {
    matches!(sign_at(buffer, x, y), Some(' ' | '\u{2800}'))
}

/// Whether words may stand here: nothing is drawn, or a line that goes on beside them.
fn is_behind(buffer: &Buffer, x: u16, y: u16) -> bool {
    let sign = sign_at(buffer, x, y);
    is_free(buffer, x, y) || sign == Some(THRESHOLD)
}

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model, what: Drives) {
    let Some((opened, planned)) = model.opened.as_deref().zip(model.planned()) else {
        return;
    };
    let dt = opened.scenario.dt();
    let curves = curves(model, opened, planned, what);
    let now = model.clock.step() as f64 * dt;
    // The shorter labels where room is scarce: the axis names the unit of speeds.
    let labels: &[(&str, &str)] = match what {
        Drives::Risk => &[
            ("attacker's risk now, 0 = collision", ""),
            ("risk now, 0 = collision", ""),
            ("risk now", ""),
            ("risk", ""),
        ],
        Drives::Speed => &[("speed", "m/s"), ("", "")],
        Drives::Distance => &[
            ("from planned to recorded ego", "m"),
            ("between both egos", "m"),
        ],
    };
    let (_, unit) = labels[0];
    let room = usize::from(area.width).saturating_sub(4);
    let mut titles = labels
        .iter()
        .map(|(name, unit)| title(name, unit, &curves, what, now, dt));
    let fits = |title: &Vec<Vec<Span<'static>>>| {
        title.iter().map(|part| width(part) + 3).sum::<usize>() <= room + 3
    };
    let shortest = titles.clone().next_back();
    let title = titles.find(fits).or(shortest).unwrap_or_default();
    let title = super::fitting(title, room);
    let inner = window::pane(f, area, model, Pane::Plot, title);
    let all = || curves.iter().flat_map(|c| c.runs.iter().flatten());
    let high = all().map(|p| p.1).fold(1.0, f64::max);
    let low = all().map(|p| p.1).fold(0.0, f64::min);
    let (first, last) = model.clock.range();
    let (from, to) = (first as f64 * dt, last as f64 * dt);
    let levels = what == Drives::Risk;
    let upwards = if levels {
        Upwards::of_risk(inner)
    } else {
        Upwards::fitting(inner, |most| Ticks::around(low, high, most))
    };
    let shown = super::window(model, dt);
    let drawn = Drawn {
        time: (from, to.max(from + dt)),
        upwards: &upwards,
        unit,
        color: model.theme.dim,
    };
    let axes = axes::draw(f, inner, &drawn);
    lines(f, &axes, &curves, levels);
    shade(f, &axes, shown, Style::new().bg(model.theme.shade));
    let now = (now, Style::new().fg(model.theme.accent));
    events(f, &axes, inner, &[], now);
    window(f, &axes, inner, shown, Style::new().fg(model.theme.dim));
    model.drawn.time_scale(axes.plot);
}

/// The plot's title with each curve's current value; a curve with an empty name shows only the value.
fn title(
    name: &'static str,
    unit: &str,
    curves: &[Curve],
    what: Drives,
    now: f64,
    dt: f64,
) -> Vec<Vec<Span<'static>>> {
    let values = curves.iter().map(|curve| {
        let mut points = curve.runs.iter().flatten();
        let at = points.find(|(t, _)| (t - now).abs() < dt / 2.0);
        let value = at.map_or("–".to_string(), |(_, v)| quantity(*v, unit));
        let words = match what {
            Drives::Risk | Drives::Speed => {
                format!("{}{} {value}", curve.dash.sign(), curve.name)
            }
            Drives::Distance => format!("now {value}"),
        };
        vec![Span::styled(words, Style::new().fg(curve.color))]
    });
    let name = (!name.is_empty()).then(|| vec![Span::raw(name)]);
    name.into_iter().chain(values).collect()
}

fn width(part: &[Span<'_>]) -> usize {
    part.iter().map(Span::width).sum()
}

fn curves(model: &Model, opened: &Opened, planned: &PlannedEgo, what: Drives) -> Vec<Curve> {
    let theme = &model.theme;
    let dt = opened.scenario.dt();
    let own = opened.scene.as_ref().map(|scene| &scene.ego.track);
    let recorded = planned.recorded.as_ref().map(|scene| &scene.ego.track);
    let speed = |track: &Track| -> Vec<(f64, f64)> {
        let samples = track.iter();
        samples
            .map(|(step, m)| (step as f64 * dt, m.velocity))
            .collect()
    };
    match what {
        Drives::Risk => risks(model, dt),
        Drives::Speed => {
            let planned = own.map(|track| line("planned", theme.ego, Dash::Solid, speed(track)));
            let recorded =
                recorded.map(|track| line("recorded", theme.text, Dash::Dotted, speed(track)));
            planned.into_iter().chain(recorded).collect()
        }
        Drives::Distance => {
            let both = own.zip(recorded);
            let points = both.map_or_else(Vec::new, |(own, recorded)| {
                let apart = own.iter().filter_map(|(step, m)| {
                    let other = recorded.at(step)?.pose.position;
                    Some((step as f64 * dt, (m.pose.position - other).norm()))
                });
                apart.collect()
            });
            vec![line("distance", theme.text, Dash::Solid, points)]
        }
    }
}

/// The attackers' risk scores: with the changed motions, and against the ego in the original.
fn risks(model: &Model, dt: f64) -> Vec<Curve> {
    let Some(shown) = model.variant() else {
        return Vec::new();
    };
    let theme = &model.theme;
    let points = |curve: &RiskCurve| -> Vec<(f64, f64)> {
        let points = curve.iter();
        points
            .map(|&(step, score)| (step as f64 * dt, f64::from(score)))
            .collect()
    };
    let all = &shown.made.effect.attackers;
    let curves = all.iter().enumerate().flat_map(|(place, attacker)| {
        let whose = match all.len() {
            1 => String::new(),
            _ => format!("{} ", attacker.obstacle),
        };
        let (after, before) = (points(&attacker.after), points(&attacker.before));
        let color = attacker_color(theme, place);
        let recorded = if all.len() == 1 { theme.text } else { color };
        [
            line(&format!("{whose}after"), color, Dash::Solid, after),
            line(&format!("{whose}before"), recorded, Dash::Dotted, before),
        ]
    });
    curves.collect()
}

/// A line without gaps.
pub(super) fn line(name: &str, color: Color, dash: Dash, points: Vec<(f64, f64)>) -> Curve {
    Curve {
        name: name.into(),
        color,
        dash,
        chosen: true,
        runs: vec![points],
    }
}
