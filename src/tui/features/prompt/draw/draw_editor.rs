//! The template with line numbers, cursor, selection and marks; long lines are wrapped.

use std::hash::{DefaultHasher, Hash, Hasher};

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use crate::features::prompt::front_matter;
use crate::model::{Editor, EntryLine, HEAVY, Model, rows, width_of};
use crate::theme::ROLES;
use crate::widgets::highlight::{self, template};
use nearmiss_scene::description::visible;

/// Lines before the first one of a heavy text that are highlighted too, for what begins there.
const BEFORE: usize = 30;

/// Draws the text; the cursor is in it while it is edited, else it begins with line `top`.
pub fn draw(f: &mut Frame<'_>, area: Rect, model: &Model, top: Option<usize>) {
    let editor = &model.prompt.editor;
    let digits = editor.line_count().to_string().len().max(2);
    let gutter = u16::try_from(digits + 2)
        .unwrap_or(u16::MAX)
        .min(area.width / 2);
    let text = Rect {
        x: area.x + gutter,
        width: area.width - gutter,
        ..area
    };
    let hidden = folded(editor, top.is_none());
    let wrapped = wrapped(editor, text, top, &hidden);
    let last = wrapped.last().map_or(0, |(row, _)| row + 1);
    highlighted(
        editor,
        model,
        wrapped.first().map_or(0, |(row, _)| *row),
        last,
    );
    let styles = editor.styles.borrow();
    let shown: Vec<(usize, &Vec<char>)> = lines_of(editor, &wrapped);
    let mut lines = Vec::with_capacity(wrapped.len());
    for (row, part) in &wrapped {
        let Some((_, line)) = shown.iter().find(|(at, _)| at == row) else {
            continue;
        };
        let mut spans = vec![number(model, *row, part.start == 0, digits)];
        let line_styles = row
            .checked_sub(styles.from)
            .and_then(|at| styles.lines.get(at));
        let marks = Marks::new(model, *row, line, top.is_none());
        let end = part.end.min(line.len());
        for (col, &c) in line.iter().enumerate().take(end).skip(part.start) {
            let base = line_styles.and_then(|s| s.get(col)).copied();
            let style = marks.style(col, base.unwrap_or(model.theme.base()), model);
            spans.push(Span::styled(sign(c), style));
        }
        if *row == 0 && hidden.contains(&1) {
            let words = format!(" … {} lines of settings", hidden.len());
            spans.push(Span::styled(words, Style::new().fg(model.theme.dim)));
        }
        // The cursor behind the last character, and a selected line break.
        let last_part = part.end >= line.len();
        if last_part {
            let style = marks.style(line.len(), model.theme.base(), model);
            spans.push(Span::styled(" ", style));
        }
        lines.push(Line::from(spans));
    }
    drop(styles);
    f.render_widget(Paragraph::new(lines), area);
    let mut drawn = editor.drawn.borrow_mut();
    drawn.area = (text.x, text.y, text.width, text.height);
    drawn.rows = wrapped;
}

/// A visible symbol for a character that must not reach the terminal.
fn sign(c: char) -> String {
    match c {
        '\t' => " ".repeat(width_of(c)),
        _ => visible(c.encode_utf8(&mut [0; 4])).into_owned(),
    }
}

fn number(model: &Model, row: usize, first: bool, digits: usize) -> Span<'static> {
    let theme = &model.theme;
    if !first {
        return Span::raw(" ".repeat(digits + 2));
    }
    let wrong = model.prompt.error_line == Some(row + 1);
    let sign = if wrong { '!' } else { ' ' };
    let style = if wrong {
        Style::new()
            .fg(theme.danger)
            .add_modifier(Modifier::BOLD | Modifier::REVERSED)
    } else {
        Style::new().fg(theme.dim)
    };
    Span::styled(format!("{sign}{:>digits$} ", row + 1), style)
}

/// The lines of the front matter behind its first one, which are folded while the cursor is below them.
fn folded(editor: &Editor, is_edited: bool) -> std::ops::Range<usize> {
    let lines = front_matter(editor.text());
    if is_edited && lines > 0 && editor.cursor().0 >= lines {
        1..lines
    } else {
        0..0
    }
}

/// The rows that are seen: a line, and which of its characters.
fn wrapped(
    editor: &Editor,
    area: Rect,
    top: Option<usize>,
    hidden: &std::ops::Range<usize>,
) -> Vec<(usize, std::ops::Range<usize>)> {
    let (width, height) = (usize::from(area.width), usize::from(area.height));
    let (row, col) = editor.cursor();
    let from = match top {
        Some(top) => top.min(editor.line_count() - 1),
        None => editor.top.get().min(row),
    };
    let mut seen = Vec::new();
    let mut cursor = None;
    for (at, line) in (from..).zip(editor.lines().skip(from)) {
        let follows = top.is_none() && at <= row;
        if seen.len() >= height && !follows {
            break;
        }
        if hidden.contains(&at) {
            continue;
        }
        for part in rows(line, width) {
            if at == row && part.start <= col {
                cursor = Some(seen.len());
            }
            seen.push((at, part));
        }
    }
    if top.is_none() {
        // As many rows are left out at the top as the cursor is below the last one.
        let below = cursor.unwrap_or(0) + 1;
        let skip = below.saturating_sub(height);
        seen.drain(..skip.min(seen.len()));
        // The beginning of a line stays where it is seen from its beginning.
        let first = seen.first().map_or(0, |(row, _)| *row);
        editor.top.set(first);
    }
    seen.truncate(height);
    seen
}

fn lines_of<'e>(
    editor: &'e Editor,
    wrapped: &[(usize, std::ops::Range<usize>)],
) -> Vec<(usize, &'e Vec<char>)> {
    let first = wrapped.first().map_or(0, |(row, _)| *row);
    let last = wrapped.last().map_or(0, |(row, _)| *row);
    let lines = editor.lines().enumerate().skip(first);
    lines.take(last + 1 - first).collect()
}

/// Works the styles out again, if text or colours changed.
fn highlighted(editor: &Editor, model: &Model, first: usize, last: usize) {
    let heavy = editor.text().len() > HEAVY;
    let (from, to) = if heavy {
        (first.saturating_sub(BEFORE), last)
    } else {
        (0, editor.line_count())
    };
    let mut hasher = DefaultHasher::new();
    // A theme's file may be changed meanwhile: its name does not stand for its colours.
    let colors: Vec<_> = ROLES.iter().map(|role| model.theme.role(role)).collect();
    (editor.text(), colors, from, to, highlight::is_loaded()).hash(&mut hasher);
    let of = hasher.finish();
    let mut styles = editor.styles.borrow_mut();
    if styles.of == of && !styles.lines.is_empty() {
        return;
    }
    let text: Vec<&str> = editor
        .text()
        .split('\n')
        .skip(from)
        .take(to - from)
        .collect();
    styles.lines = template(&text, from, &model.theme);
    styles.from = from;
    styles.of = of;
}

/// Marked ranges of a line.
struct Marks {
    /// The selected characters.
    selected: std::ops::Range<usize>,
    /// Where what is looked for begins and ends.
    found: Vec<std::ops::Range<usize>>,
    cursor: Option<usize>,
}

impl Marks {
    fn new(model: &Model, row: usize, line: &[char], edited: bool) -> Self {
        let editor = &model.prompt.editor;
        let selected = editor
            .selection()
            .filter(|_| edited)
            .map_or(0..0, |(a, b)| {
                let from = if a.row < row { 0 } else { a.col };
                let to = if b.row > row { line.len() + 1 } else { b.col };
                if a.row <= row && row <= b.row {
                    from..to
                } else {
                    0..0
                }
            });
        let found = match &model.prompt.entry {
            Some(EntryLine::Find(find)) => {
                let length = find.text.chars().count();
                let places = find.in_line(line).into_iter();
                places.map(|at| at..at + length).collect()
            }
            _ => Vec::new(),
        };
        let cursor = editor.cursor();
        Self {
            selected,
            found,
            cursor: (edited && cursor.0 == row).then_some(cursor.1),
        }
    }

    fn style(&self, col: usize, base: Style, model: &Model) -> Style {
        let theme = &model.theme;
        if self.cursor == Some(col) {
            return base.add_modifier(Modifier::REVERSED);
        }
        if self.selected.contains(&col) {
            return theme.selected();
        }
        if self.found.iter().any(|found| found.contains(&col)) {
            let mark = Modifier::BOLD | Modifier::UNDERLINED;
            return Style::new().fg(theme.warning).add_modifier(mark);
        }
        base
    }
}
