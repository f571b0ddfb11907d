//! The list of scenarios: names with matched letters, and their facts.

use nearmiss_scene::description::visible;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Paragraph, Wrap};
use unicode_segmentation::UnicodeSegmentation;
use unicode_width::UnicodeWidthStr;

use crate::action::Action;
use crate::features::scenarios::columns::{Column, cell, fitting};
use crate::features::scenarios::without_ego;
use crate::model::{
    Extent, Group, Grouping, Line as ShownAnswer, Matching, Model, Order, Pane, Row, TERMS,
    WordMatch,
};
use crate::widgets::window;
use crate::widgets::words::{fit, fit_end, pad};

pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model) {
    let list = &model.list;
    let room = usize::from(area.width).saturating_sub(4);
    let mut inner = window::pane(f, area, model, Pane::Scenarios, title(model, room));
    missing(f, area, model);
    filter(f, &mut inner, model);
    // A row for them, where they hide no scenario or many are shown.
    let heads = inner.height > 5 || list.lines.len() < usize::from(inner.height);
    let columns = fitting(list, names(model), usize::from(inner.width), heads);
    // In a wide pane, the columns stay beside the names.
    let used: usize = columns.iter().map(|c| c.width()).sum();
    let wide = (list.longest + used + EXTRA_COLUMNS).max(WIDE);
    let wide = usize::from(inner.width).min(wide);
    if heads && !list.lines.is_empty() {
        let heads = headings(&columns, wide);
        let style = Style::new().fg(model.theme.dim);
        f.render_widget(heads.style(style), Rect { height: 1, ..inner });
        inner = below(inner, 1);
    }
    let rows = usize::from(inner.height);
    let lines = list.lines.len();
    let last = lines.saturating_sub(rows);
    let top = list.selected.saturating_sub(rows / 2).min(last);
    model
        .drawn
        .text(Pane::Scenarios, Extent { lines, rows, top });
    model.drawn.list(inner);
    if let Some(words) = nothing(model) {
        let text = Paragraph::new(words).wrap(Wrap { trim: true });
        f.render_widget(text.style(Style::new().fg(model.theme.dim)), inner);
        return;
    }
    // Members of a group are indented below its heading.
    let indent = match list.grouping {
        Grouping::None => "",
        _ if inner.width < 30 => " ",
        _ => "  ",
    };
    let mut matching = list.read.has_words().then(Matching::default);
    let shown = list.lines.iter().enumerate().skip(top).take(rows);
    let lines = shown.map(|(i, line)| {
        let chosen = i == list.selected;
        let marked = match line {
            ShownAnswer::Head(_) => false,
            ShownAnswer::Scenario(place, _) => model.marks.has(&list.rows[*place].entry),
        };
        let line = match line {
            ShownAnswer::Head(group) => head(model, &list.groups[*group]),
            ShownAnswer::Scenario(place, _) => {
                let mut line = Line::from(indent);
                let room = wide.saturating_sub(indent.len());
                let row = scenario(model, *place, &columns, room, matching.as_mut());
                line.spans.extend(row.spans);
                line
            }
        };
        let sign = match (chosen, marked) {
            (true, true) => "▸*",
            (true, false) => "▸ ",
            (false, true) => " *",
            (false, false) => "  ",
        };
        let mut whole = Line::from(sign);
        whole.spans.extend(line.spans);
        if chosen {
            let rest = usize::from(inner.width).saturating_sub(whole.width());
            whole.push_span(" ".repeat(rest));
            model.theme.select(whole.style(model.theme.base()))
        } else {
            whole.style(model.theme.base())
        }
    });
    f.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), inner);
}

/// Columns beside the longest name: signs before it, a word on whose values stand there, a gap.
const EXTRA_COLUMNS: usize = 16;

/// Columns of a pane that is not wide.
const WIDE: usize = 60;

/// Columns of a name that are left beside whose values stand there.
const LEAST_NAME: usize = 12;

/// How many there are, and in what order.
fn title(model: &Model, room: usize) -> Line<'static> {
    let list = &model.list;
    let all = list.rows.len();
    let searching = if list.found || all == 0 { "" } else { "…" };
    let mut title = if list.filter.is_empty() {
        format!("scenarios {all}{searching}")
    } else {
        format!("scenarios {}/{all}{searching}", list.visible.len())
    };
    let mut parts = Vec::new();
    let mut add = |words: String| parts.push(words);
    match (list.read.wrong.is_empty(), list.read.filters()) {
        (false, false) => add(" · filter has an error: nothing filtered".into()),
        (false, true) => add(" · filter has an error".into()),
        (true, false) if list.read.incomplete => {
            add(" · filter incomplete: nothing filtered".into())
        }
        (true, true) if list.read.incomplete => add(" · filter incomplete".into()),
        _ => {}
    }
    if list.matched == WordMatch::Fuzzy && !list.visible.is_empty() {
        add(" · similar".into());
    }
    match model.marks.count(list) {
        0 => {}
        n => add(format!(" * {n}")),
    }
    let turned = if list.turned { ", reversed" } else { "" };
    match (list.order, list.order.unit()) {
        (Order::Found, _) if !list.turned => {}
        (Order::Found, _) => add(" by path, reversed".into()),
        (Order::Measure(measure), "") => {
            add(format!(" by {}{turned}", measure.axis_name(measure.id)))
        }
        (order, "") => add(format!(" by {}{turned}", order.id())),
        (order, unit) => add(format!(" by {}, {unit}{turned}", order.id())),
    }
    if list.grouping != Grouping::None {
        add(format!(" · {} groups", list.grouping.name()));
    }
    if list.facts_read > 0 && list.facts_read < all {
        add(format!(" · {} read", list.facts_read));
    }
    for words in &parts {
        if title.width() + words.width() <= room {
            title.push_str(words);
        }
    }
    // Which way the numbers go that stand behind the names.
    let ways = [" · sev 0 = contact", " · 0 = contact"];
    let said = usize::from(list.order == Order::Severity);
    // With words, the best match is first; the bundled ones are in an order of their own.
    let is_by_path = list.order == Order::Found && !list.turned && !list.read.has_words();
    let usual = " by path";
    if is_by_path
        && !model.paths.is_empty()
        && title.width() + usual.len() + ways[1].width() <= room
    {
        title.push_str(usual);
    }
    let fits = |words: &&str| title.width() + words.width() <= room;
    let way = ways.into_iter().skip(said).find(fits);
    Line::from(title + way.unwrap_or_default())
}

fn below(area: Rect, rows: u16) -> Rect {
    let rows = rows.min(area.height);
    Rect {
        y: area.y + rows,
        height: area.height - rows,
        ..area
    }
}

/// The line of the filter, and what is wrong with it.
fn filter(f: &mut Frame<'_>, inner: &mut Rect, model: &Model) {
    let list = &model.list;
    if list.filtering.is_none() && list.filter.is_empty() {
        return;
    }
    let filtering = list.filtering.as_ref();
    let selected = filtering.is_some_and(|filtering| filtering.selected);
    let cursor = if filtering.is_some() { "▏" } else { "" };
    let width = usize::from(inner.width);
    let style = Style::new().fg(model.theme.accent);
    let typed = fit_end(&list.filter, width.saturating_sub(2));
    let typed = if selected {
        Span::styled(typed, style.add_modifier(Modifier::REVERSED))
    } else {
        Span::styled(typed, style)
    };
    let slash = Span::styled("/", style);
    f.render_widget(
        Line::from(vec![slash, typed, Span::styled(cursor, style)]),
        Rect {
            height: 1,
            ..*inner
        },
    );
    *inner = below(*inner, 1);
    if let Some(wrong) = list.read.wrong.first() {
        let words = visible(&format!("! {wrong}")).into_owned();
        let text = Paragraph::new(words).wrap(Wrap { trim: true });
        let rows = u16::try_from(text.line_count(inner.width)).unwrap_or(1);
        let height = rows.min(inner.height / 2);
        let style = Style::new().fg(model.theme.warning);
        f.render_widget(text.style(style), Rect { height, ..*inner });
        *inner = below(*inner, height);
    }
}

/// The column headings.
fn headings(columns: &[Column], width: usize) -> Line<'static> {
    let used: usize = columns.iter().map(|c| c.width()).sum();
    let mut line = Line::from(pad("  name", width.saturating_sub(used)));
    for column in columns {
        line.push_span(placed(Span::raw(column.head()), *column));
    }
    line
}

/// A cell in its width: numbers at the right, words at the left.
fn placed(cell: Span<'static>, column: Column) -> Span<'static> {
    let width = column.width() - 1;
    let words = cell.content.as_ref();
    let text = if column.is_number() {
        format!(
            " {}{words}",
            " ".repeat(width.saturating_sub(words.width()))
        )
    } else {
        format!(" {}", pad(words, width))
    };
    Span::styled(text, cell.style)
}

/// The head of a group.
fn head(model: &Model, group: &Group) -> Line<'static> {
    let sign = if group.shut { "+" } else { "-" };
    let words = format!("{sign} {} ({})", visible(&group.name), group.count);
    let style = Style::new().fg(model.theme.title);
    Line::styled(words, style.add_modifier(Modifier::BOLD))
}

fn scenario(
    model: &Model,
    place: usize,
    columns: &[Column],
    width: usize,
    matching: Option<&mut Matching>,
) -> Line<'static> {
    let row = &model.list.rows[place];
    let used: usize = columns.iter().map(|c| c.width()).sum();
    let mut room = width.saturating_sub(used + 2);
    // The name of what is open is cut for it.
    let mut name_kept = row.entry.name.width();
    if model.list.opened == Some(place) {
        name_kept = name_kept.min(LEAST_NAME);
    }
    let whose = whose(model, place).filter(|whose| room >= whose.len() + name_kept);
    room -= whose.as_ref().map_or(0, String::len);
    let mut line = name(model, row, room, matching);
    if let Some(whose) = whose {
        line.push_span(Span::styled(whose, Style::new().fg(model.theme.ego)));
    }
    let taken = model.opened.as_deref();
    let taken = taken.filter(|_| has_other_ego(model, place) && model.opening.is_none());
    for &column in columns {
        line.push_span(placed(cell(model, row, column, taken), column));
    }
    line
}

/// Whether the scenario is open with another ego than the recorded one, or as a variant.
fn has_other_ego(model: &Model, place: usize) -> bool {
    model.list.opened == Some(place)
        && (model.planned().is_some()
            || model.variant().is_some_and(|shown| shown.changed)
            || model.taken.is_some())
}

/// Whose values stand behind a name, in a word, where they are not the recorded ego's.
fn whose(model: &Model, place: usize) -> Option<String> {
    let planned = " planned";
    if !has_other_ego(model, place) {
        let ego = model.list.rows[place].stand_in()?;
        return Some(match ego.obstacle {
            Some(id) => format!(" {id} as ego"),
            None => planned.into(),
        });
    }
    match model.variant() {
        _ if model.opening.is_some() => None,
        Some(shown) if shown.changed => Some(" variant".into()),
        _ => model.planned().map(|_| planned.into()),
    }
}

/// Columns of the longest name with the word behind it.
fn names(model: &Model) -> usize {
    let rows = model.list.rows.iter().enumerate();
    let said =
        rows.filter_map(|(place, row)| Some(row.entry.name.width() + whose(model, place)?.len()));
    said.max().unwrap_or(0).max(model.list.longest)
}

/// A name, with the letters that the filter matches underlined.
fn name(model: &Model, row: &Row, width: usize, matching: Option<&mut Matching>) -> Line<'static> {
    let whole = pad(&row.entry.name, width);
    let Some(matching) = matching else {
        return Line::from(whole);
    };
    let matched = model
        .list
        .read
        .matched(&row.entry.name, model.list.matched, matching);
    let mark = Style::new()
        .fg(model.theme.accent)
        .add_modifier(Modifier::UNDERLINED | Modifier::BOLD);
    let letters = whole.graphemes(true).enumerate().map(|(at, letter)| {
        let style = match matched.binary_search(&at) {
            Ok(_) => mark,
            Err(_) => Style::new(),
        };
        Span::styled(letter.to_string(), style)
    });
    letters.collect::<Vec<_>>().into()
}

/// In the lower border, where it takes no row: what is not in the list or lacks an ego, and the keys that help.
fn missing(f: &mut Frame<'_>, area: Rect, model: &Model) {
    if area.height < 2 {
        return;
    }
    let key = model.look.key(Action::About);
    let skipped = match model.list.passed_over.len() {
        0 => None,
        count => Some(format!("{count} skipped: {key}")),
    };
    let parts = skipped.into_iter().chain(without_ego(model));
    let words = parts.collect::<Vec<_>>().join(" · ");
    if words.is_empty() {
        return;
    }
    let width = usize::from(area.width).saturating_sub(4);
    let words = format!(" {} ", fit(&words, width));
    let below = Rect {
        x: area.x + 1,
        y: area.bottom() - 1,
        width: area.width.saturating_sub(2),
        height: 1,
    };
    f.render_widget(
        Span::styled(words, Style::new().fg(model.theme.warning)),
        below,
    );
}

fn nothing(model: &Model) -> Option<String> {
    let list = &model.list;
    if list.rows.is_empty() && !list.found {
        Some("looking for scenarios…".into())
    } else if list.rows.is_empty() {
        Some("no scenarios".into())
    } else if list.visible.is_empty()
        && list.facts_read < list.rows.len()
        && list.read.needs_facts()
    {
        let open = model
            .opened
            .as_ref()
            .map_or(String::new(), |o| format!("; showing {}", o.name));
        Some(format!("no match so far; still reading{open}"))
    } else if list.visible.is_empty() {
        let key = model.look.key(Action::Cancel);
        let open = model
            .opened
            .as_ref()
            .map_or(String::new(), |o| format!("; still showing {}", o.name));
        Some(format!("no match; {key} clears the filter{open}"))
    } else {
        None
    }
}

/// Columns of the box at most, its borders included, and of a term.
const COLUMNS: u16 = 96;
const TERM: usize = 16;

pub fn draw_filter_terms(frame: &mut Frame<'_>, screen: Rect, model: &Model) {
    if model.list.filtering.is_none() {
        return;
    }
    let theme = &model.theme;
    let key = Style::new().fg(theme.accent).add_modifier(Modifier::BOLD);
    let width = COLUMNS.min(screen.width);
    let room = usize::from(width).saturating_sub(TERM + 4);
    let mut text = Text::default();
    for (term, words) in TERMS {
        let mut term = *term;
        for words in textwrap::wrap(words, room) {
            text.push_line(Line::from(vec![
                Span::styled(format!(" {}", pad(term, TERM)), key),
                Span::raw(words.into_owned()),
            ]));
            term = "";
        }
    }
    let height = u16::try_from(text.lines.len() + 2).unwrap_or(u16::MAX);
    let area = Rect {
        x: screen.x,
        y: screen.bottom().saturating_sub(height + 1),
        width,
        height,
    };
    // The list stays in sight: it is narrowed down while one types.
    let list = model.drawn.area(Pane::Scenarios).unwrap_or_default();
    let hidden = list.intersection(area).height;
    if height + 2 > screen.height || hidden * 2 > list.height {
        return;
    }
    let title = "filter: words, and these terms";
    let inner = window::window_at(frame, area, model, title);
    frame.render_widget(Paragraph::new(text), inner);
}
