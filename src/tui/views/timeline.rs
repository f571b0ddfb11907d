//! Danger over time: a strip for everyone together and for the most dangerous obstacles.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use unicode_width::UnicodeWidthStr;

use crate::metrics::Series;
use crate::tui::loaded::Opened;
use crate::tui::model::{Model, Pane};
use crate::tui::widgets::frame;
use crate::tui::widgets::words::pad;

/// Columns of the names.
const LABEL: u16 = 8;

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let clock = &model.clock;
    let (first, last) = clock.range();
    let mut title = format!("{:.1} s · step {}/{last}", clock.time(), clock.step());
    if clock.playing {
        title.push_str(&format!(" · playing {}×", clock.speed()));
    } else if (clock.speed() - 1.0).abs() > f64::EPSILON {
        title.push_str(&format!(" · {}×", clock.speed()));
    }
    let mut title = Line::from(title);
    let bars = " · bars: lowest risk score";
    let room = usize::from(area.width).saturating_sub(4);
    if model.opened.as_ref().is_some_and(|o| o.series.is_some())
        && title.width() + bars.width() <= room
    {
        title.push_span(Span::styled(bars, Style::new().fg(model.theme.dim)));
    }
    let inner = frame::pane(f, area, model, Pane::Timeline, title);
    let Some(opened) = &model.opened else { return };
    let scale = Rect {
        x: inner.x + LABEL,
        width: inner.width.saturating_sub(LABEL + 1),
        ..inner
    };
    model.drawn.time_scale(scale);
    let width = usize::from(scale.width);
    let column = |step: i64| {
        let part = (step - first) as f64 / (last - first).max(1) as f64;
        (part * (width.saturating_sub(1)) as f64).round() as usize
    };
    let mut lines = Vec::new();
    if let Some(series) = &opened.series {
        let strips = usize::from(inner.height).saturating_sub(1);
        for id in rows(opened, model.picked, strips) {
            lines.push(strip(model, series, id, width, column(clock.step())));
        }
    }
    lines.push(ruler(model, opened, width, &column));
    f.render_widget(Paragraph::new(lines), inner);
}

/// Everyone together, then the picked obstacle, then the most dangerous ones.
fn rows(opened: &Opened, picked: Option<i64>, count: usize) -> Vec<Option<i64>> {
    let mut rows = vec![None];
    rows.extend(picked.map(Some));
    rows.extend(
        opened
            .ranking
            .iter()
            .map(|&id| Some(id))
            .filter(|id| *id != picked),
    );
    rows.truncate(count);
    rows
}

fn strip(
    model: &Model,
    series: &Series,
    id: Option<i64>,
    width: usize,
    cursor: usize,
) -> Line<'static> {
    let theme = &model.theme;
    let name = id.map_or("lowest".to_string(), |id| id.to_string());
    let picked = id.is_some() && id == model.picked;
    let color = if picked { theme.picked } else { theme.dim };
    let mut line = Line::from(Span::styled(
        pad(&name, usize::from(LABEL)),
        Style::new().fg(color),
    ));
    let steps = series.steps();
    let count = (steps.end - steps.start).max(1) as usize;
    let risk_at = |place: usize| {
        let step = steps.start + place as i64;
        match id {
            Some(id) => series.at("risk", id, step).value(),
            None => series.lowest_at("risk", step).map(|(_, risk)| risk),
        }
    };
    for column in 0..width {
        // A column stands for all of its steps: the most dangerous one counts.
        let from = column * count / width;
        let to = ((column + 1) * count / width).max(from + 1).min(count);
        let lowest = (from..to).filter_map(risk_at).reduce(f64::min);
        let (sign, color) = match lowest {
            Some(risk) => (bar(risk), theme.risk(risk)),
            None => (' ', theme.dim),
        };
        let mut style = Style::new().fg(color);
        if column == cursor {
            style = style.bg(theme.selection).add_modifier(Modifier::UNDERLINED);
        }
        line.push_span(Span::styled(sign.to_string(), style));
    }
    line
}

/// The higher, the more dangerous.
fn bar(risk: f64) -> char {
    match risk as u8 {
        0 => '█',
        1 => '▇',
        2 => '▅',
        3 => '▃',
        4 => '▂',
        _ => '▁',
    }
}

fn ruler(
    model: &Model,
    opened: &Opened,
    width: usize,
    column: &dyn Fn(i64) -> usize,
) -> Line<'static> {
    let (first, last) = model.clock.range();
    let dt = opened.scenario.dt();
    let mut cells = vec![' '; width];
    let seconds = (last - first) as f64 * dt;
    let every = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]
        .into_iter()
        .find(|e| seconds / e * 7.0 <= width as f64)
        .unwrap_or(200.0);
    let contact = opened
        .collision
        .as_ref()
        .and_then(|c| c.decisive_step)
        .map(column);
    let cursor = column(model.clock.step());
    let marked = |place: usize| place == cursor || Some(place) == contact;
    let mut tick = (first as f64 * dt / every).ceil() * every;
    while tick <= last as f64 * dt + 1e-9 {
        let at = column((tick / dt).round() as i64);
        let label = if tick.fract() == 0.0 {
            format!("{tick:.0}s")
        } else {
            format!("{tick:.1}")
        };
        // Marks come first: a label steps aside, or is left out where it cannot.
        let free = |from: usize| {
            let to = from + label.len();
            to < width && !(from..to).any(|i| marked(i) || cells[i] != ' ')
        };
        let beside = at.saturating_sub(label.len());
        let place = (at..=at + label.len()).find(|&from| free(from));
        if let Some(from) = place.or_else(|| Some(beside).filter(|&from| free(from))) {
            cells.splice(from..from + label.len(), label.chars());
        }
        tick += every;
    }
    let mut line = Line::from(Span::raw(" ".repeat(usize::from(LABEL))));
    for (i, cell) in cells.into_iter().enumerate() {
        let dim = Style::new().fg(model.theme.dim);
        let danger = Style::new()
            .fg(model.theme.danger)
            .add_modifier(Modifier::BOLD);
        let span = match (Some(i) == contact, i == cursor) {
            (true, true) => Span::styled("X", danger.add_modifier(Modifier::REVERSED)),
            (true, false) => Span::styled("X", danger),
            (false, true) => Span::styled("▲", Style::new().fg(model.theme.accent)),
            _ => Span::styled(cell.to_string(), dim),
        };
        line.push_span(span);
    }
    line
}
