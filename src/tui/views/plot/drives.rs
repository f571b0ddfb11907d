//! Planned and recorded ego over time: speeds, or the distance between them; for a variant also the attacker's risk
//! before and after.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::Span;
use ratatui::widgets::canvas::{Canvas, Points};

use super::{axes, stroke};
use crate::generation::RiskCurve;
use crate::render::Ticks;
use crate::scenario::Track;
use crate::tui::loaded::{Opened, PlannedEgo};
use crate::tui::model::{Drives, Model, Pane};
use crate::tui::widgets::frame;
use crate::tui::widgets::words::quantity;

/// A line: whose, its sign in the legend, its points.
struct Curve {
    name: &'static str,
    sign: &'static str,
    color: Color,
    /// Drawn as dots, so that colours are not needed.
    dotted: bool,
    points: Vec<(f64, f64)>,
}

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model, what: Drives) {
    let Some((opened, planned)) = model.opened.as_deref().zip(model.planned()) else {
        return;
    };
    let dt = opened.scenario.dt();
    let curves = curves(model, opened, planned, what);
    let now = model.clock.step() as f64 * dt;
    // The short label where room is scarce: the axis names the unit of speeds.
    let (name, unit, short) = match what {
        Drives::Risk => ("attacker's risk", "", ("risk", "")),
        Drives::Speed => ("speed", "m/s", ("", "")),
        Drives::Distance => (
            "from planned to recorded ego",
            "m",
            ("between both egos", "m"),
        ),
    };
    let room = usize::from(area.width).saturating_sub(4);
    let mut title = title(name, unit, &curves, (what, now, dt));
    if title.iter().map(|part| width(part) + 3).sum::<usize>() > room + 3 {
        title = self::title(short.0, short.1, &curves, (what, now, dt));
    }
    let title = super::fitting(title, room);
    let inner = frame::pane(f, area, model, Pane::Plot, title);
    let all = || curves.iter().flat_map(|c| c.points.iter());
    let high = all().map(|p| p.1).fold(1.0, f64::max);
    let low = all().map(|p| p.1).fold(0.0, f64::min);
    let (first, last) = model.clock.range();
    let (from, to) = (first as f64 * dt, last as f64 * dt);
    let to = to.max(from + dt);
    let most = axes::most_upwards(inner);
    let upwards = match what {
        Drives::Risk => super::risk_axis(most),
        _ => Ticks::around(low, high, most),
    };
    let plot = axes::draw(f, inner, (from, to), &upwards, unit, model.theme.dim);
    let (low, high) = upwards.bounds();
    let canvas = Canvas::default()
        .marker(Marker::Braille)
        .x_bounds([from, to])
        .y_bounds([low, high])
        .paint(|ctx| {
            stroke(ctx, &[(now, low), (now, high)], model.theme.accent);
            for curve in &curves {
                if curve.dotted {
                    ctx.draw(&Points {
                        coords: &curve.points,
                        color: curve.color,
                    });
                } else {
                    stroke(ctx, &curve.points, curve.color);
                }
            }
        });
    f.render_widget(canvas, plot);
    model.drawn.time_scale(plot);
}

/// The plot's title with each curve's current value; a curve with an empty name shows only the value.
fn title(
    name: &'static str,
    unit: &str,
    curves: &[Curve],
    (what, now, dt): (Drives, f64, f64),
) -> Vec<Vec<Span<'static>>> {
    let values = curves.iter().map(|curve| {
        let mut points = curve.points.iter();
        let at = points.find(|(t, _)| (t - now).abs() < dt / 2.0);
        let value = at.map_or("–".to_string(), |(_, v)| quantity(*v, unit));
        let words = match what {
            Drives::Risk | Drives::Speed => format!("{}{} {value}", curve.sign, curve.name),
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
            let planned = own.map(|track| Curve {
                name: "planned",
                sign: "━",
                color: theme.ego,
                dotted: false,
                points: speed(track),
            });
            let recorded = recorded.map(|track| Curve {
                name: "recorded",
                sign: "··",
                color: theme.text,
                dotted: true,
                points: speed(track),
            });
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
            vec![Curve {
                name: "distance",
                sign: "━",
                color: theme.warning,
                dotted: false,
                points,
            }]
        }
    }
}

/// The attacker's risk scores: with the changed motion, and against the ego in the original.
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
    let effect = &shown.made.effect;
    let after = Curve {
        name: "after",
        sign: "━",
        color: theme.attacker,
        dotted: false,
        points: points(&effect.after),
    };
    let before = Curve {
        name: "before",
        sign: "··",
        color: theme.text,
        dotted: true,
        points: points(&effect.before),
    };
    vec![after, before]
}
