//! Danger over time: strips for all obstacles together and for the most dangerous ones.

use nearmiss_base::system::pad_end;
use nearmiss_drive::driver::DRIVERS;
use nearmiss_scene::metrics::{Danger, Measure, Series};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use unicode_width::UnicodeWidthStr;

use crate::clock::PlayRange;
use crate::loaded::Opened;
use crate::model::{Model, Pane, heat};
use crate::widgets::line_placer::LinePlacer;
use crate::widgets::window;
use crate::widgets::words::{pad, quantity};

/// Columns of the names.
const LABEL: u16 = 8;

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let room = usize::from(area.width).saturating_sub(4);
    let inner = window::pane(f, area, model, Pane::Timeline, title(model, room));
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
    // Marks have a row of their own where strips keep enough, and drivers where they still do.
    let apart = height >= ROOMY;
    let drivers = DriverMarks::new(model, &column);
    let own_row = height >= ROOMIER && !drivers.is_empty();
    let mut lines = Vec::new();
    if let Some((measure, series)) = model.heat_series() {
        let strips = height - (1 + usize::from(apart) + usize::from(own_row)).min(height);
        let scale = Scale::new(model, measure, series);
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
    let marks = marks(model, opened, &column);
    if own_row {
        let mut row = LinePlacer::new(width);
        drivers.place(&mut row, model);
        lines.push(named_row("drivers", row, model));
    }
    let beside = if own_row {
        &DriverMarks::default()
    } else {
        &drivers
    };
    if apart {
        lines.push(marks_row(model, &marks, beside, width, &column));
    }
    let beside = (!apart).then_some((&marks[..], beside));
    lines.push(ruler(model, opened, width, &column, beside));
    f.render_widget(Paragraph::new(lines), inner);
}

/// Rows from which on marks have one of their own.
const ROOMY: usize = 3;

/// Rows from which on drivers have one of their own.
const ROOMIER: usize = 5;

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
    let dim = Style::new().fg(model.theme.dim);
    if let Some(found) = model.judged_here() {
        // Who disagrees is said where there is room for it.
        let whole = found.disagreement().map(|_| found.words());
        let parts = whole.into_iter().chain([found.short()]);
        let mut parts = parts.map(|words| format!(" · {words}"));
        let fits = |words: &String| title.width() + words.width() <= room;
        if let Some(words) = parts.find(fits) {
            title.push_span(Span::styled(words, dim));
        }
    }
    let Some((measure, _)) = model.heat_series() else {
        return title;
    };
    let whole = format!(" · bars grow with danger: full = {}", full(model, measure));
    let short = format!(" · bars: danger by {}", measure.id);
    let words = [whole, short]
        .into_iter()
        .find(|words| title.width() + words.width() <= room);
    if let Some(words) = words {
        title.push_span(Span::styled(words, dim));
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
        None => format!("{} {id} here", extreme(measure.danger)),
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
    fn new(model: &Model, measure: &'static Measure, series: &Series) -> Self {
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

/// A sign at a column, and what it means where there is room for words.
struct Mark {
    at: usize,
    sign: char,
    words: String,
    style: Style,
}

/// The contact, answers that differ, the second map's moment, the moment that matters, what is looped and the
/// window: the most important first.
fn marks(model: &Model, opened: &Opened, column: &dyn Fn(i64) -> usize) -> Vec<Mark> {
    let theme = &model.theme;
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    let mark = |step: i64, sign, words: &str, color| Mark {
        at: column(step),
        sign,
        words: words.into(),
        style: bold(color),
    };
    let mut marks = Vec::new();
    let contact = opened.contact();
    marks.extend(contact.map(|contact| mark(contact.step, 'X', contact.name(), theme.danger)));
    let differing = model.disagreements().into_iter();
    marks.extend(differing.map(|d| mark(d.step, '≠', "", theme.disagree)));
    let second = model
        .second_moment()
        .filter(|then| model.drawn.has_second_map() && then.step != model.clock.step());
    marks.extend(second.map(|then| mark(then.step, '◆', "second map", theme.accent)));
    let worst = opened.worst_untouched();
    marks.extend(worst.map(|moment| mark(moment.step, '▼', "most severe", theme.text)));
    if let PlayRange::Part(first, last) = model.clock.lap() {
        marks.push(mark(first, '(', "", theme.accent));
        marks.push(mark(last, ')', "", theme.accent));
    }
    if let Some((first, last)) = model.shown_window() {
        marks.push(mark(first, '[', "", theme.title));
        marks.push(mark(last, ']', "", theme.title));
    }
    marks
}

/// The most dangerous value of a measure, in a word.
fn extreme(danger: Danger) -> &'static str {
    match danger {
        Danger::High => "highest",
        Danger::Low | Danger::Neutral => "lowest",
    }
}

/// A row of their own for the marks, in words where there is room, with a line along the window.
fn marks_row(
    model: &Model,
    marks: &[Mark],
    drivers: &DriverMarks,
    width: usize,
    column: &dyn Fn(i64) -> usize,
) -> Line<'static> {
    let dim = Style::new().fg(model.theme.dim);
    let mut row = LinePlacer::new(width);
    cursor(&mut row, model, marks, column);
    let placed: Vec<&Mark> = marks
        .iter()
        .filter(|mark| row.sign(mark.at, mark.sign, mark.style))
        .collect();
    for mark in placed {
        row.words_beside(mark.at, &mark.words, mark.style);
    }
    drivers.place(&mut row, model);
    if let Some((from, to)) = model.shown_window() {
        let (first, last) = (column(from), column(to));
        let words = "window";
        // Inside it, or nowhere.
        let most = (last + 1).saturating_sub(first + words.len() + 2);
        row.words((first + 2..).take(most.saturating_sub(1)), words, dim);
        row.fill(first..last + 1, '─', dim);
    }
    named_row("marks", row, model)
}

fn named_row(name: &str, row: LinePlacer, model: &Model) -> Line<'static> {
    let dim = Style::new().fg(model.theme.dim);
    let mut line = Line::from(Span::styled(pad_end(name, usize::from(LABEL)), dim));
    line.spans.extend(row.spans());
    line
}

/// The last moments of drivers, and where the one that is shown reacts, by columns.
#[derive(Default)]
struct DriverMarks {
    /// In the order of time; drivers of one column together.
    last: Vec<(usize, Vec<&'static str>)>,
    reacts: Option<usize>,
}

/// Names that would not fit between two signs stand before the first of them.
const NAME: usize = 7;

impl DriverMarks {
    fn new(model: &Model, column: &dyn Fn(i64) -> usize) -> Self {
        let Some(found) = model.judged_here() else {
            return Self::default();
        };
        let mut all: Vec<(i64, &'static str)> = { DRIVERS.iter() }
            .filter_map(|driver| Some((found.by(driver.id)?.last_moment_step?, driver.id)))
            .collect();
        all.sort_by_key(|(step, _)| *step);
        let mut last: Vec<(usize, Vec<&'static str>)> = Vec::new();
        for (step, id) in all {
            let at = column(step);
            match last.last_mut().filter(|(before, _)| *before == at) {
                Some((_, ids)) => ids.push(id),
                None => last.push((at, vec![id])),
            }
        }
        // The ideal driver always does at once.
        let shown = model.verdict_shown();
        let reacts =
            shown.and_then(|shown| shown.reacts_step.filter(|step| *step > found.from_step));
        Self {
            last,
            reacts: reacts.map(column),
        }
    }

    fn is_empty(&self) -> bool {
        self.last.is_empty() && self.reacts.is_none()
    }

    /// A sign for each last moment with the names of the drivers, where there is room, then the reaction.
    fn place(&self, row: &mut LinePlacer, model: &Model) {
        let shown = model.driver_shown().id;
        let color = Style::new().fg(model.theme.ego);
        let bold = Style::new()
            .fg(model.theme.accent)
            .add_modifier(Modifier::BOLD);
        let mut placed = self.last.clone();
        placed.retain(|(at, ids)| {
            let style = if ids.contains(&shown) { bold } else { color };
            row.sign(*at, '┤', style)
        });
        for near in placed.chunk_by(|(a, _), (b, _)| b - a <= NAME) {
            let [(first, of_first), .., (last, of_last)] = near else {
                row.words_beside(near[0].0, &near[0].1.join(" "), color);
                continue;
            };
            let mut place = |ids: &[&str], before: bool, behind: bool| {
                let words = ids.join(" ");
                let before = first.checked_sub(words.len() + 1).filter(|_| before);
                let behind = behind.then_some(last + 2);
                row.words(before.into_iter().chain(behind), &words, color)
            };
            let ids: Vec<&str> = near.iter().flat_map(|(_, ids)| ids.clone()).collect();
            if near.len() == 2 || !place(&ids, true, true) {
                place(of_first, true, false);
                place(of_last, false, true);
            }
        }
        if let Some(at) = self.reacts.filter(|at| row.sign(*at, '○', bold)) {
            row.words_beside(at, &format!("{shown} reacts"), bold);
        }
    }
}

/// Columns that a label and the gap behind it take.
const ROOM: f64 = 7.0;

/// Round seconds from `from` to `to`, no more of them than there is room for in `width` columns.
fn ticks(from: f64, to: f64, width: usize) -> impl Iterator<Item = f64> {
    let least = (to - from) * ROOM / width.max(1) as f64;
    let usual = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];
    let every = usual
        .into_iter()
        .find(|every| *every >= least)
        .unwrap_or_else(|| 200.0 * 10_f64.powf((least / 200.0).log10().ceil()));
    // Counted: a number of seconds that is large enough does not change by adding to it.
    let first = (from / every).ceil();
    let count = ((to + 1e-9) / every - first)
        .floor()
        .clamp(-1.0, width as f64);
    let counted = (0_u32..).map(f64::from).take_while(move |i| *i <= count);
    counted
        .map(move |i| (first + i) * every)
        .filter(|tick| tick.is_finite())
}

/// The cursor, which turns the most important mark under it around.
fn cursor(row: &mut LinePlacer, model: &Model, marks: &[Mark], column: &dyn Fn(i64) -> usize) {
    let at = column(model.clock.step());
    match marks.iter().find(|mark| mark.at == at) {
        Some(mark) => row.sign(at, mark.sign, mark.style.add_modifier(Modifier::REVERSED)),
        None => row.sign(at, '▲', Style::new().fg(model.theme.accent)),
    };
}

/// Seconds; the cursor and `marks` too, where they have no row of their own.
fn ruler(
    model: &Model,
    opened: &Opened,
    width: usize,
    column: &dyn Fn(i64) -> usize,
    marks: Option<(&[Mark], &DriverMarks)>,
) -> Line<'static> {
    let (first, last) = model.clock.range();
    let dt = opened.scenario.dt();
    let (from, to) = (first as f64 * dt, last as f64 * dt);
    let theme = &model.theme;
    let mut row = LinePlacer::new(width);
    if let Some((marks, drivers)) = marks {
        cursor(&mut row, model, marks, column);
        for mark in marks {
            row.sign(mark.at, mark.sign, mark.style);
        }
        drivers.place(&mut row, model);
    }
    for tick in ticks(from, to, width) {
        let label = if tick.fract() == 0.0 {
            format!("{tick:.0}s")
        } else {
            format!("{tick:.1}s")
        };
        let at = column((tick / dt).round() as i64);
        // A label steps aside by its length and a gap, or is left out.
        let behind = at..=at + label.len() + 2;
        let before = at.checked_sub(label.len() + 1);
        row.words(behind.chain(before), &label, Style::new().fg(theme.dim));
    }
    let mut line = Line::from(" ".repeat(usize::from(LABEL)));
    line.spans.extend(row.spans());
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_have_room() {
        let of = |from, to, width| ticks(from, to, width).collect::<Vec<_>>();
        assert_eq!(of(0.0, 8.0, 40), [0.0, 2.0, 4.0, 6.0, 8.0]);
        assert_eq!(of(1.2, 3.9, 60), [1.5, 2.0, 2.5, 3.0, 3.5]);
        assert_eq!(of(-4.0, 5.0, 20), [0.0, 5.0]);
        assert_eq!(of(0.0, 0.0, 40), [0.0]);
        assert_eq!(of(0.1, 0.2, 40), [0.0; 0]);
        let long = of(0.0, 5000.0, 40);
        assert_eq!(long, [0.0, 2000.0, 4000.0]);
    }

    #[test]
    fn ticks_end_whatever_the_seconds() {
        for seconds in [
            1e9,
            9e15,
            1e18,
            9.2e27,
            1e308,
            f64::MAX,
            f64::INFINITY,
            f64::NAN,
        ] {
            for from in [-seconds, 0.0, seconds / 2.0, seconds - 1.0, seconds] {
                for width in [0, 1, 40, 500] {
                    let count = ticks(from, seconds, width).count();
                    assert!(
                        count <= width + 1,
                        "{count} from {from} to {seconds} in {width}"
                    );
                }
            }
        }
    }
}
