//! Risk over time: the lowest score of all obstacles, and that of the picked one.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Chart, Dataset, GraphType, Paragraph, Wrap};

use crate::tui::model::{Model, Pane};
use crate::tui::widgets::frame;

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let theme = &model.theme;
    let opened = model.opened.as_ref();
    let series = opened.and_then(|o| o.series.as_ref());
    let mut title = Line::from("risk");
    if let (Some(opened), Some(series)) = (opened, series) {
        if let Some((id, risk)) = series.lowest_at("risk", model.clock.step()) {
            title.push_span(Span::styled(
                format!(" · now {risk}"),
                Style::new().fg(theme.risk(risk)),
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
        if let Some(lowest) = opened.headline.as_ref().and_then(|h| h.risk) {
            let time = lowest.step as f64 * opened.scenario.dt();
            title.push_span(Span::raw(format!(" · min {} at {time:.1} s", lowest.value)));
        }
    }
    let inner = frame::pane(f, area, model, Pane::Risk, title);
    let (Some(opened), Some(series)) = (opened, series) else {
        let words = Paragraph::new("needs an ego").wrap(Wrap { trim: true });
        f.render_widget(words.style(Style::new().fg(theme.dim)), inner);
        return;
    };
    let dt = opened.scenario.dt();
    let time = |step: i64| step as f64 * dt;
    let steps = series.steps();
    let lowest: Vec<(f64, f64)> = steps
        .clone()
        .filter_map(|s| series.lowest_at("risk", s).map(|(_, risk)| (time(s), risk)))
        .collect();
    let picked: Vec<(f64, f64)> = model.picked.map_or(Vec::new(), |id| {
        steps
            .clone()
            .filter_map(|s| Some((time(s), series.at("risk", id, s).value()?)))
            .collect()
    });
    let now = time(model.clock.step());
    let cursor = [(now, 0.0), (now, 5.0)];
    let line = |data, color| {
        Dataset::default()
            .marker(Marker::Braille)
            .graph_type(GraphType::Line)
            .style(Style::new().fg(color))
            .data(data)
    };
    let (from, to) = (time(steps.start), time(steps.end - 1));
    let dim = Style::new().fg(theme.dim);
    let chart = Chart::new(vec![
        line(&cursor, theme.accent),
        line(&lowest, theme.warning),
        line(&picked, theme.picked),
    ])
    .x_axis(
        Axis::default()
            .style(dim)
            .bounds([from, to.max(from + dt)])
            .labels([format!("{from:.0} s"), format!("{to:.1} s")]),
    )
    .y_axis(
        Axis::default()
            .style(dim)
            .bounds([-0.2, 5.2])
            .labels(["0", "", "5"]),
    );
    f.render_widget(chart, inner);
    let scale = Rect {
        x: inner.x + 2,
        width: inner.width.saturating_sub(2),
        ..inner
    };
    model.drawn.time_scale(scale);
}
