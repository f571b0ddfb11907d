//! Danger over time: strips for all obstacles together and for the most dangerous ones.

mod ruler;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use unicode_width::UnicodeWidthStr;

use crate::clock::PlayRange;
use crate::loaded::Opened;
use crate::model::{Model, Pane, heat};
use crate::widgets::frame;
use crate::widgets::words::{pad, quantity};
use nearmiss_scene::metrics::{Danger, Measure, Series};

/// Columns of the names.
const LABEL: u16 = 8;

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let room = usize::from(area.width).saturating_sub(4);
    let inner = frame::pane(f, area, model, Pane::Timeline, title(model, room));
    let Some(opened) = &model.opened else { return };
    let (first, last) = model.clock.range();
    let scale = Rect {
        x: inner.x + LABEL,
        width: inner.width.saturating_sub(LABEL + 1),
        ..inner
    };
    model.drawn.time_scale(scale);
    let width = usize::from(scale.width);
    let column = |step: i64| {
        let part = (step as f64 - first as f64) / (last as f64 - first as f64).max(1.0);
        (part * (width.saturating_sub(1)) as f64).round() as usize
    };
    let height = usize::from(inner.height);
    // Marks have a row of their own where strips keep enough.
    let apart = height >= ROOMY;
    let mut lines = Vec::new();
    if let Some((measure, series)) = model.heat_series() {
        let strips = height.saturating_sub(if apart { 2 } else { 1 });
        let scale = Scale::of(model, measure, series);
        for id in rows(opened, model.picked, strips) {
            lines.push(strip(
                model,
                &scale,
                series,
                id,
                width,
                column(model.clock.step()),
            ));
        }
    }
    let marks = ruler::marks(model, opened, &column);
    if apart {
        lines.push(ruler::marks_row(model, &marks, width, &column));
    }
    let beside = if apart { &[][..] } else { &marks };
    lines.push(ruler::ruler(model, opened, width, &column, beside));
    f.render_widget(Paragraph::new(lines), inner);
}

/// Rows from which on marks have one of their own.
const ROOMY: usize = 5;

/// The step, how fast it plays, and what the strips show.
fn title(model: &Model, room: usize) -> Line<'static> {
    let clock = &model.clock;
    let (_, last) = clock.range();
    let playing = if clock.playing { "playing " } else { "" };
    let lap = match clock.lap() {
        PlayRange::Once => String::new(),
        PlayRange::Whole => " · loop".into(),
        PlayRange::Part(first, last) => format!(" · loop {first}–{last}"),
    };
    let step = format!("{:.1} s · step {}/{last}", clock.time(), clock.step());
    let mut title = Line::from(format!("{step} · {playing}{}×{lap}", clock.speed()));
    let Some((measure, _)) = model.heat_series() else {
        return title;
    };
    let whole = format!(" · bars grow with danger: full = {}", full(model, measure));
    let short = format!(" · bars: danger by {}", measure.id);
    let words = [whole, short]
        .into_iter()
        .find(|words| title.width() + words.width() <= room);
    if let Some(words) = words {
        title.push_span(Span::styled(words, Style::new().fg(model.theme.dim)));
    }
    title
}

/// The value at which a bar is full.
fn full(model: &Model, measure: &Measure) -> String {
    let id = measure.id;
    if measure.is_ordinal() {
        return format!("{id} 0 (collision)");
    }
    let sign = match measure.danger {
        Danger::High => "≥",
        Danger::Low | Danger::Neutral => "≤",
    };
    match model.thresholds.for_measure(id).next() {
        Some(t) => format!("{id} {sign} {}", quantity(t.value, measure.unit)),
        None => format!("{} {id} here", ruler::extreme(measure.danger)),
    }
}

/// All obstacles together, then the picked one, then the most dangerous ones.
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

/// How a measure becomes signs.
struct Scale {
    measure: &'static Measure,
    threshold: Option<f64>,
    /// The least and the most dangerous value, where there is no threshold.
    range: (f64, f64),
}

impl Scale {
    fn of(model: &Model, measure: &'static Measure, series: &Series) -> Self {
        let threshold = model
            .thresholds
            .for_measure(measure.id)
            .next()
            .map(|t| t.value);
        let mut range = (0.0, 0.0);
        if threshold.is_none() && !measure.is_ordinal() {
            let ids = series.obstacles().iter();
            let all = ids.flat_map(|&id| series.row(measure.id, id));
            let values: Vec<f64> = all.filter_map(|reading| reading.value()).collect();
            let by_danger = |a: &&f64, b: &&f64| measure.danger.compare(**a, **b);
            let (most, least) = (
                values.iter().min_by(by_danger),
                values.iter().max_by(by_danger),
            );
            range = (least.copied().unwrap_or(0.0), most.copied().unwrap_or(0.0));
        }
        Self {
            measure,
            threshold,
            range,
        }
    }

    /// The higher, the more dangerous.
    fn sign(&self, model: &Model, value: f64) -> (char, Color) {
        let theme = &model.theme;
        if self.measure.is_ordinal() {
            return (bar(value), theme.risk(value));
        }
        let level = heat(value, self.measure.danger, self.threshold, self.range);
        let color = match (self.threshold, level) {
            (None, _) => theme.obstacle,
            (Some(_), 6..) => theme.danger,
            (Some(_), 3..) => theme.danger_medium,
            (Some(_), _) => theme.danger_low,
        };
        (LEVELS[usize::from(level).min(LEVELS.len() - 1)], color)
    }
}

const LEVELS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

fn strip(
    model: &Model,
    scale: &Scale,
    series: &Series,
    id: Option<i64>,
    width: usize,
    cursor: usize,
) -> Line<'static> {
    let theme = &model.theme;
    let measure = scale.measure;
    let name = id.map_or("all".to_string(), |id| id.to_string());
    let picked = id.is_some() && id == model.picked;
    let color = if picked { theme.picked } else { theme.dim };
    let mut line = Line::from(Span::styled(
        pad(&name, usize::from(LABEL)),
        Style::new().fg(color),
    ));
    let steps = series.steps();
    let count = (steps.end - steps.start).max(1) as usize;
    let value_at = |place: usize| {
        let step = steps.start + place as i64;
        match id {
            Some(id) => series.at(measure.id, id, step).value(),
            None => series.most_dangerous_at(measure.id, step).map(|(_, v)| v),
        }
    };
    for column in 0..width {
        // A column stands for all of its steps: the most dangerous one counts.
        let from = column * count / width;
        let to = ((column + 1) * count / width).max(from + 1).min(count);
        let values = (from..to).filter_map(value_at);
        let (sign, color) = match values.min_by(|a, b| measure.danger.compare(*a, *b)) {
            Some(value) => scale.sign(model, value),
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
