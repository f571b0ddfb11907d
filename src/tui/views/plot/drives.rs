//! Planned and recorded ego over time: speeds, or the distance between them; for a variant also the attacker's risk
//! before and after.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::text::Span;

use super::axes::{self, Drawn, Upwards};
use super::strokes::Dash;
use super::{lines, marks};
use crate::loaded::{Opened, PlannedEgo};
use crate::model::{Drives, Model, Pane};
use crate::widgets::frame;
use crate::widgets::words::quantity;
use nearmiss_drive::generation::RiskCurve;
use nearmiss_render::Ticks;
use nearmiss_render::cells::attacker_color;
use nearmiss_scene::scenario::Track;

use super::Curve;

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
    let inner = frame::pane(f, area, model, Pane::Plot, title);
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
    let window = super::window(model, dt);
    let drawn = Drawn {
        time: (from, to.max(from + dt)),
        upwards: &upwards,
        unit,
        color: model.theme.dim,
    };
    let axes = axes::draw(f, inner, &drawn);
    lines(f, &axes, &curves, levels);
    marks::shade(f, &axes, window, Style::new().bg(model.theme.shade));
    let now = (now, Style::new().fg(model.theme.accent));
    marks::events(f, &axes, inner, &[], now);
    marks::window(f, &axes, inner, window, Style::new().fg(model.theme.dim));
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

fn line(name: &str, color: Color, dash: Dash, points: Vec<(f64, f64)>) -> Curve {
    Curve {
        name: name.into(),
        color,
        dash,
        chosen: true,
        runs: vec![points],
    }
}
