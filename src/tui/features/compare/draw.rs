//! Full-screen comparison: fields, texts with their claims, and the map of the picked claim.

use std::borrow::Cow;
use std::sync::Arc;

use nearmiss_scene::judge;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Block, BorderType, Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::action::{Action, Scope};
use crate::features::compare::fields::Field;
use crate::features::map::draw;
use crate::layout::ScreenAreas;
use crate::model::{Column, Document, Extent, Model, Readings, ShownAnswer};
use crate::widgets::claimed;
use crate::widgets::long_text::{MarkedClaims, Reading};
use crate::widgets::window::more_lines;
use crate::widgets::words::{fit_end, whole_parts};

/// Rows of the screen from which on the map has room.
const MAP_FROM: u16 = 34;

/// Rows of the map at least, and of the claims where there is none, their borders included.
const LEAST: (u16, u16) = (12, 5);

/// The fields of the answers in sight.
struct Table {
    fields: Vec<Vec<Field>>,
    /// The rows in which they differ.
    differ: Vec<bool>,
    /// The rows that are the same for all.
    same: Vec<bool>,
    /// What these say.
    common: Option<Line<'static>>,
}

impl Table {
    fn new(model: &Model, width: u16) -> Self {
        let seen = model.compare.shown[model.seen_side_by_side()].iter();
        let fields: Vec<Vec<Field>> = seen.map(|s| super::fields::fields(model, *s)).collect();
        let same = super::fields::equal_rows(&fields);
        Self {
            differ: super::fields::differing(&fields),
            common: super::fields::common(model, &fields, &same, width),
            same,
            fields,
        }
    }

    /// Rows around the texts: borders, fields, a rule, and what is the same for all.
    fn rows(&self) -> usize {
        let fields = self.same.iter().filter(|same| !**same).count();
        3 + fields + usize::from(self.common.is_some())
    }
}

/// Rows of the band below: what the texts leave, within what map and claims need and can use.
fn band_rows(body: Rect, model: &Model, table: &Table) -> u16 {
    let compare = &model.compare;
    let seen = &compare.shown[model.seen_side_by_side()];
    let rows = |rows: usize| u16::try_from(rows).unwrap_or(u16::MAX);
    let claims = seen.iter().filter_map(|shown| {
        let key = model.document(*shown).filter(|_| !compare.hides())?.key;
        // The borders, and what is right, in two lines.
        Some(model.claims.listed(key).len() + model.claims.unread(key).len() + 4)
    });
    let claims = rows(claims.max().unwrap_or(0));
    let (least, most) = if body.height >= MAP_FROM {
        let least = claims.max(LEAST.0).min(body.height / 3);
        (least, body.height / 2)
    } else {
        (LEAST.1, claims.min(body.height / 2).max(LEAST.1))
    };
    // What still arrives needs room.
    if seen.iter().any(|shown| super::is_running(model, *shown)) {
        return least;
    }
    let areas = column_areas(body, seen.len());
    let texts = seen.iter().zip(areas.iter());
    let texts = texts.map(|(shown, area)| text_rows(model, *shown, area.width.saturating_sub(2)));
    let needed = table.rows() + texts.max().unwrap_or(0);
    body.height.saturating_sub(rows(needed)).clamp(least, most)
}

fn column_areas(area: Rect, count: usize) -> std::rc::Rc<[Rect]> {
    let share = Constraint::Ratio(1, u32::try_from(count).unwrap_or(1).max(1));
    Layout::horizontal(vec![share; count]).split(area)
}

pub fn draw(f: &mut Frame<'_>, parts: &ScreenAreas, model: &Model) {
    let compare = &model.compare;
    title(f, parts.header, model);
    let body = Rect {
        y: parts.header.bottom(),
        height: parts.footer.y.saturating_sub(parts.header.bottom()),
        ..parts.header
    };
    let table = Table::new(model, body.width);
    let band = band_rows(body, model, &table);
    let [upper, band] =
        Layout::vertical([Constraint::Min(0), Constraint::Length(band)]).areas(body);
    if compare.shown.is_empty() {
        nothing(f, upper, model);
    } else {
        columns(f, upper, model, &table);
    }
    if body.height >= MAP_FROM {
        let [left, right] =
            Layout::horizontal([Constraint::Percentage(45), Constraint::Min(0)]).areas(band);
        let map = draw::begin(f, left, model);
        super::band::draw(f, right, model);
        map.end(f, model);
    } else {
        super::band::draw(f, band, model);
    }
    if compare.marking.is_some() {
        super::band::marking(f, body, model);
    }
    if compare.ratings.is_some() {
        super::band::ratings(f, body, model);
    }
}

fn title(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let compare = &model.compare;
    let theme = &model.theme;
    let bold = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let name = model.opened.as_ref().map_or("", |o| o.name.as_str());
    let mode = match (&compare.blind, compare.choice) {
        (Some(_), None) => " blind ",
        (Some(_), Some(_)) => " blind, rated ",
        (None, _) => " side by side ",
    };
    let scrolling = if compare.free {
        "scroll unlinked"
    } else {
        "scroll linked"
    };
    let (shown, seen) = (compare.shown.len(), model.seen_side_by_side());
    let columns = if seen.len() < shown {
        format!("columns {}–{} of {shown}", seen.start + 1, seen.end)
    } else {
        String::new()
    };
    let all = match compare.blind {
        Some(_) => complete(model).count(),
        None => model.answers.columns.len(),
    };
    let has_judge = compare.shown.contains(&ShownAnswer::Reference);
    let answers = match shown - usize::from(has_judge) {
        0 => String::new(),
        1 if all == 1 => "1 answer".into(),
        n if n == all => format!("{all} answers"),
        n => format!("{n} of {all} answers"),
    };
    let judge = if has_judge { judge::NAME } else { "" };
    let step = format!("step {}", model.clock.step());
    let room = usize::from(area.width).saturating_sub(mode.len());
    let parts = [
        name,
        model.task.name(),
        &columns,
        &answers,
        judge,
        &step,
        scrolling,
    ];
    let words = whole_parts(parts, room);
    let line = Line::from(vec![
        Span::styled(mode, bold),
        Span::styled(words, theme.base()),
    ]);
    f.render_widget(line, area);
}

fn nothing(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let key = |action| model.look.keymap.key_in(action, Scope::Compare);
    let next = key(Action::NextRound);
    let words = match (&model.compare.blind, &model.open_error) {
        (Some(_), Some(error)) => {
            format!(
                "{}; {next} next scenario",
                nearmiss_scene::description::visible(error)
            )
        }
        (Some(blind), None) if blind.waiting => {
            format!("no stored answers on this scenario; {next} next scenario")
        }
        (Some(blind), None) => format!(
            "{}. {next} goes to the next scenario, {} shows all answers",
            too_few(model, blind.size.unwrap_or(2)),
            key(Action::BlindMode)
        ),
        (None, _) => format!("no answer shown; {} adds one", key(Action::MoreColumns)),
    };
    let text = Paragraph::new(Text::styled(words, Style::new().fg(model.theme.dim)));
    f.render_widget(text.wrap(Wrap { trim: true }), area);
}

/// The complete answers of models.
fn complete(model: &Model) -> impl Iterator<Item = &Column> {
    let columns = model.answers.columns.iter();
    columns.filter(|c| c.answer().is_some() && !c.failed())
}

/// Why there is nothing to rate.
fn too_few(model: &Model, wanted: usize) -> String {
    let answers = |n: usize| match n {
        1 => "1 complete answer".to_string(),
        n => format!("{n} complete answers"),
    };
    let complete = complete(model).count();
    let rated = match complete - model.to_rate().len().min(complete) {
        0 => String::new(),
        n if n == complete => ", all rated by you".into(),
        n => format!(", {n} of them rated by you"),
    };
    let counts = match complete {
        0 | 1 => " (answers of the built-in judge do not count, imported ones do)",
        _ => "",
    };
    format!(
        "Nothing to rate: needs {wanted} unrated answers; this scenario has {}{rated}{counts}",
        answers(complete)
    )
}

/// As many columns as fit, the one that has the keys among them.
fn columns(f: &mut Frame<'_>, area: Rect, model: &Model, table: &Table) {
    let common = &table.common;
    let [above, area] = Layout::vertical([
        Constraint::Length(u16::from(common.is_some())),
        Constraint::Min(0),
    ])
    .areas(area);
    f.render_widget(common.clone().unwrap_or_default(), above);
    let seen = model.seen_side_by_side();
    let areas = column_areas(area, seen.len());
    for place in 0..model.compare.shown.len() {
        let in_sight = place.checked_sub(seen.start);
        match in_sight.and_then(|i| Some((areas.get(i)?, table.fields.get(i)?))) {
            Some((area, fields)) => {
                // The first one in sight has the names of the rows, and the legend.
                let named = place == seen.start;
                let (differ, same) = (&table.differ, &table.same);
                let rows = super::fields::lines(model, fields, named, differ, same);
                let legend = named.then(|| super::fields::legend(&table.fields, differ));
                column(f, *area, model, place, rows, &legend.unwrap_or_default());
            }
            // Those beside the screen keep their places.
            None => model.drawn.next_column(Extent::default()),
        }
    }
}

fn column(
    f: &mut Frame<'_>,
    area: Rect,
    model: &Model,
    place: usize,
    rows: Vec<Line<'static>>,
    legend: &str,
) {
    let (compare, theme) = (&model.compare, &model.theme);
    let shown = compare.shown[place];
    let focused = place == compare.focus;
    let room = usize::from(area.width).saturating_sub(6);
    let mut style = Style::new().fg(theme.title);
    let (mut kind, mut border) = (BorderType::Plain, theme.border);
    if focused {
        style = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
        (kind, border) = (BorderType::Thick, theme.border_focused);
    }
    let name = format!(" {} {} ", place + 1, fit_end(&name(model, shown), room));
    let mut block = Block::bordered()
        .border_type(kind)
        .border_style(Style::new().fg(border))
        .title(Line::styled(name, style));
    if let Some(words) = super::fields::outcome(model, place) {
        block = block.title_bottom(words);
    }
    let inner = block.inner(area);
    f.render_widget(block, area);
    let height = u16::try_from(rows.len()).unwrap_or(0).min(inner.height / 2);
    let [upper, rule, lower] = Layout::vertical([
        Constraint::Length(height),
        Constraint::Length(1),
        Constraint::Min(0),
    ])
    .areas(inner);
    f.render_widget(Text::from(rows), upper);
    let line = "─".repeat(usize::from(rule.width));
    f.render_widget(Line::styled(line, Style::new().fg(border)), rule);
    if !legend.is_empty() {
        let words = Line::styled(format!(" {legend} "), Style::new().fg(theme.dim));
        let width = u16::try_from(words.width()).unwrap_or(u16::MAX);
        let row = Rect {
            x: rule.x + 1,
            width: width.min(rule.width.saturating_sub(1)),
            ..rule
        };
        f.render_widget(words, row.intersection(rule));
    }
    body(f, lower, model, place, shown);
}

/// An answer as it is read, once it says something.
fn said(model: &Model, shown: ShownAnswer) -> Option<Arc<Document>> {
    let document = model.document(shown);
    document.filter(|d| !d.text.trim().is_empty())
}

/// What is marked in an answer: until it is rated, no claims and their checks.
fn marks<'m>(model: &'m Model, document: &Document) -> MarkedClaims<'m> {
    if model.compare.hides() {
        MarkedClaims::default()
    } else {
        model.claims.marks(document.key)
    }
}

/// An answer laid out in so many columns of the terminal.
fn laid_out<'r>(
    model: &Model,
    readings: &'r mut Readings,
    shown: ShownAnswer,
    document: &Document,
    width: u16,
) -> &'r mut Reading {
    let reading = readings.answer(shown);
    reading.show_as(model.reading_mode());
    let safe = text(model, shown, &document.text);
    reading.follow(&safe, &marks(model, document), width, &model.theme);
    reading
}

/// Rows of an answer in so many columns of the terminal.
fn text_rows(model: &Model, shown: ShownAnswer, width: u16) -> usize {
    let mut readings = model.drawn.readings.borrow_mut();
    said(model, shown).map_or(1, |document| {
        laid_out(model, &mut readings, shown, &document, width).rows()
    })
}

/// The text of an answer, from its line or at its end, with a word about what is below.
fn body(f: &mut Frame<'_>, area: Rect, model: &Model, place: usize, shown: ShownAnswer) {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let Some(document) = said(model, shown) else {
        f.render_widget(Line::styled("no answer yet", dim), area);
        let extent = Extent {
            lines: 1,
            rows: usize::from(area.height),
            top: 0,
        };
        return model.drawn.next_column(extent);
    };
    let marks = marks(model, &document);
    let mut readings = model.drawn.readings.borrow_mut();
    let reading = laid_out(model, &mut readings, shown, &document, area.width);
    let lines = reading.rows();
    let height = usize::from(area.height);
    let last = lines.saturating_sub(height);
    let top = model
        .compare
        .tops
        .get(place)
        .copied()
        .flatten()
        .unwrap_or(last)
        .min(last);
    let (mut seen, above) = reading.seen(top, height, &marks, theme);
    if let Some(id) = model.picked {
        let style = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
        for line in &mut seen {
            let spans = std::mem::take(&mut line.spans).into_iter();
            let marked = spans.flat_map(|span| with_mentions(span, id, style));
            line.spans = marked.collect();
        }
    }
    claimed::render(f, area, seen, above);
    model.drawn.next_column(Extent {
        lines,
        rows: height,
        top,
    });
    let running = matches!(shown, ShownAnswer::Column(i) if model.answers.columns.get(i).is_some_and(Column::is_running));
    let below = lines.saturating_sub(top + height);
    if below > 0 && area.height > 1 {
        let words = if running {
            format!(" {below} new lines below, G follows ")
        } else {
            more_lines(below)
        };
        // In the border, where it covers no text; what was made of the answer stands on its left.
        let width = u16::try_from(words.width()).unwrap_or(area.width);
        let row = Rect {
            x: area.right().saturating_sub(width).max(area.x),
            y: area.bottom(),
            width: width.min(area.width),
            height: 1,
        };
        let style = if running {
            Style::new()
                .fg(theme.accent)
                .add_modifier(Modifier::REVERSED)
        } else {
            dim
        };
        f.render_widget(Line::styled(words, style), row);
    }
}

/// A span with the id of an obstacle in the style of a picked one.
fn with_mentions(span: Span<'static>, id: i64, picked: Style) -> Vec<Span<'static>> {
    let mut parts = Vec::new();
    let mut rest = span.content.as_ref();
    while let Some(at) = super::mention(rest, id) {
        let (before, behind) = rest.split_at(at);
        let (id, behind) = behind.split_at(id.to_string().len());
        parts.push(Span::styled(before.to_string(), span.style));
        parts.push(Span::styled(id.to_string(), span.style.patch(picked)));
        rest = behind;
    }
    parts.push(Span::styled(rest.to_string(), span.style));
    parts
}

/// The displayed name of an answer.
pub fn name(model: &Model, shown: ShownAnswer) -> String {
    match shown {
        _ if model.compare.hides() => "answer".into(),
        ShownAnswer::Reference => judge::NAME.into(),
        ShownAnswer::Column(place) => model
            .answers
            .columns
            .get(place)
            .map_or(String::new(), |c| c.model.clone()),
    }
}

/// The text of an answer without the names of its model. Every place in it stays where it was.
fn text<'t>(model: &Model, shown: ShownAnswer, text: &'t str) -> Cow<'t, str> {
    let mut text = Cow::Borrowed(text);
    let ShownAnswer::Column(place) = shown else {
        return text;
    };
    let Some(column) = model
        .answers
        .columns
        .get(place)
        .filter(|_| model.compare.hides())
    else {
        return text;
    };
    let returned = column.answer().and_then(|a| a.model_returned.as_deref());
    for id in [Some(column.model.as_str()), returned]
        .into_iter()
        .flatten()
    {
        let bare = id.rsplit('/').next().unwrap_or(id);
        // "gemini" of "gemini-1.5-pro"; short beginnings occur in other words.
        let family = bare
            .split(['-', ':', '.', ' '])
            .next()
            .filter(|f| f.len() >= 3);
        for name in [Some(id), Some(bare), family].into_iter().flatten() {
            text = without(text, name);
        }
    }
    text
}

/// `text` with every occurrence of a name, in any case, blotted out.
fn without<'t>(text: Cow<'t, str>, name: &str) -> Cow<'t, str> {
    let (lower, name) = (text.to_ascii_lowercase(), name.to_ascii_lowercase());
    if name.is_empty() || !name.is_ascii() || !lower.contains(&name) {
        return text;
    }
    let mut blotted = String::with_capacity(text.len());
    let mut from = 0;
    for (at, found) in lower.match_indices(&name) {
        blotted.push_str(&text[from..at]);
        blotted.extend(std::iter::repeat_n('*', found.len()));
        from = at + found.len();
    }
    blotted.push_str(&text[from..]);
    Cow::Owned(blotted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picked_obstacle_is_marked_where_it_is_named() {
        let picked = Style::new().add_modifier(Modifier::BOLD);
        let parts = with_mentions("car 301, 3012 and 301's".into(), 301, picked);
        let marked = parts.iter().filter(|part| part.style == picked).count();
        let words: String = parts.iter().map(|part| part.content.as_ref()).collect();
        assert_eq!((marked, words.as_str()), (2, "car 301, 3012 and 301's"));
    }

    #[test]
    fn names_are_blotted_out_in_their_places() {
        let text = without("As GPT-4o, I (gpt-4o) say ü.".into(), "gpt-4o");
        assert_eq!(text, "As ******, I (******) say ü.");
        assert_eq!(without("plain".into(), ""), "plain");
    }
}
