//! A long, growing text: wrapped once; highlighting and claims only as far as it was displayed.

mod outline;

use std::ops::Range;

use nearmiss_study::evaluation::claims::CheckedClaim;
use ratatui::style::Style;
use ratatui::text::Line;
use ratatui::widgets::{Paragraph, Wrap};
use unicode_width::UnicodeWidthStr;

use crate::theme::Theme;
use crate::widgets::claimed::marked;
use crate::widgets::highlight::{AnswerPainter, Language, Painter, is_loaded};
use crate::widgets::markdown::table::{self, Layout};
use crate::widgets::markdown::{self, Piece, pieces_of};
use crate::widgets::unbroken::is_plain;
use crate::widgets::words::fit;
use outline::{Json, Kind, Outline, Row};

pub use outline::folds_at;

/// The claims that are marked in a text.
#[derive(Debug, Clone, Copy, Default)]
pub struct MarkedClaims<'a> {
    /// The claims, in the order of the text.
    pub claims: &'a [CheckedClaim],
    /// The key of the text they were found in.
    pub key: u64,
    /// The picked one.
    pub picked: Option<usize>,
    /// Sentences that were not understood, bytes.
    pub unread: &'a [Range<usize>],
}

/// How an answer is read.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ReadingMode {
    /// As it was sent, with all markup.
    pub raw: bool,
    /// JSON is not folded.
    pub unfold: bool,
    /// What stands behind folded JSON: the key that unfolds it.
    pub hint: String,
}

/// A text as last drawn; the next frame starts from it and costs only what changed.
#[derive(Debug)]
pub struct Reading {
    text: String,
    theme: Option<Theme>,
    loaded: bool,
    width: u16,
    /// Key of the marked claims; `None` if none are marked.
    key: Option<u64>,
    mode: ReadingMode,
    lines: Vec<Placed>,
    /// Of the lines that have ended.
    outline: Outline,
    /// Lines with claims, and the places of those.
    claims: Vec<(usize, usize)>,
    /// Columns of tables, by their first lines, as far as they were displayed.
    tables: Vec<(usize, Layout)>,
    /// From the first line on.
    painting: Painting,
    /// From the first line on that is not painted.
    painter: Painting,
    /// The first lines; only such as have ended.
    painted: Vec<Line<'static>>,
}

/// How lines are highlighted.
#[derive(Debug, Clone)]
enum Painting {
    Answer(AnswerPainter),
    Markdown(Painter),
}

impl Painting {
    fn line(&mut self, line: &str, theme: &Theme) -> Line<'static> {
        match self {
            Self::Answer(painter) => painter.line(line, theme),
            Self::Markdown(painter) => painter.line(line, theme),
        }
    }
}

/// A line of the text.
#[derive(Debug, Clone, Copy)]
struct Placed {
    /// Its first byte, and the one after its last.
    from: usize,
    to: usize,
    /// Rows of the screen down to its end.
    rows: usize,
    kind: Kind,
}

/// Lines that are longer are shown as they are, bytes: to read their markup would take too long.
const MAX_MARKUP_BYTES: usize = 8_000;

impl Reading {
    /// An answer: Markdown, with the JSON in it as JSON.
    #[must_use]
    pub fn answer() -> Self {
        Self::new(Painting::Answer(AnswerPainter::new()))
    }

    /// Markdown, as it is written.
    #[must_use]
    pub fn markdown() -> Self {
        Self::new(Painting::Markdown(Painter::new(Language::Markdown)))
    }

    fn new(painting: Painting) -> Self {
        Self {
            text: String::new(),
            theme: None,
            loaded: false,
            width: 0,
            key: None,
            mode: ReadingMode::default(),
            lines: Vec::new(),
            outline: Outline::default(),
            claims: Vec::new(),
            tables: Vec::new(),
            painter: painting.clone(),
            painting,
            painted: Vec::new(),
        }
    }

    /// Shows it in another way from now on.
    pub fn show_as(&mut self, mode: ReadingMode) {
        if self.mode != mode {
            self.mode = mode;
            self.lines.clear();
        }
    }

    /// Whether markup is shown as it is written.
    fn is_raw(&self) -> bool {
        self.mode.raw || matches!(self.painting, Painting::Markdown(_))
    }

    /// Takes the text as it is now.
    pub fn follow(&mut self, text: &str, marks: &MarkedClaims<'_>, width: u16, theme: &Theme) {
        let key = (!marks.claims.is_empty()).then_some(marks.key);
        let grown = text.starts_with(&self.text);
        if !grown || self.loaded != is_loaded() || self.theme.as_ref() != Some(theme) {
            self.loaded = is_loaded();
            self.theme = Some(theme.clone());
            self.painter = self.painting.clone();
            self.painted.clear();
        }
        if !grown || (self.width, self.key) != (width, key) {
            (self.width, self.key) = (width, key);
            self.lines.clear();
        } else if text.len() == self.text.len() && !self.lines.is_empty() {
            return;
        } else if !self.text.ends_with('\n') {
            // It may have gone on.
            self.lines.pop();
        }
        let from = if self.lines.is_empty() {
            self.outline = Outline::default();
            0
        } else if self.text.ends_with('\n') {
            self.text.len()
        } else {
            self.text.rfind('\n').map_or(0, |at| at + 1)
        };
        if grown {
            self.text.push_str(&text[self.text.len()..]);
        } else {
            self.text = text.to_string();
        }
        self.wrap(from, marks, theme);
    }

    /// Breaks the lines from this byte on.
    fn wrap(&mut self, mut from: usize, marks: &MarkedClaims<'_>, theme: &Theme) {
        let mut rows = self.rows();
        let first = self.lines.len();
        for line in self.text[from..].split_inclusive('\n') {
            let to = from + ended(line).len();
            let words = &self.text[from..to];
            let kind = if line.ends_with('\n') {
                self.outline.next(words)
            } else {
                // It may go on.
                self.outline.clone().next(words)
            };
            let placed = Placed {
                from,
                to,
                rows: 0,
                kind,
            };
            self.lines.push(placed);
            from += line.len();
        }
        self.tables.clear();
        self.claims.clear();
        for (place, checked) in marks.claims.iter().enumerate() {
            let span = &checked.claim.span;
            let line = self
                .lines
                .partition_point(|l| l.from <= span.start)
                .saturating_sub(1);
            if self.lines.get(line).is_some_and(|l| span.end <= l.to) {
                self.claims.push((line, place));
            }
        }
        self.claims.sort_unstable();
        for at in first..self.lines.len() {
            rows += self.height(at, marks, theme);
            self.lines[at].rows = rows;
        }
    }

    /// Rows that a line takes; none for what is folded away.
    fn height(&self, at: usize, marks: &MarkedClaims<'_>, theme: &Theme) -> usize {
        let Placed { to, kind, .. } = self.lines[at];
        if !self.is_raw() {
            match kind {
                Kind::Fence => return 0,
                Kind::Json(json) if self.folds(json) => return usize::from(json.before == 0),
                Kind::Row(row) if self.aligns(row) => return 1,
                _ => {}
            }
        }
        self.height_to(at, to, marks, theme)
    }

    /// Rows that a line takes down to a byte of the text.
    fn height_to(&self, at: usize, end: usize, marks: &MarkedClaims<'_>, theme: &Theme) -> usize {
        let Placed { from, to, kind, .. } = self.lines[at];
        let line = &self.text[from..to];
        let plain = || pieces_of(Line::raw(line.to_string()));
        let pieces = self.rendered(line, kind, theme).unwrap_or_else(plain);
        let above = pieces
            .into_iter()
            .take_while(|piece| piece.at.is_none_or(|at| from + at < end))
            .map(|piece| piece.until(end.saturating_sub(from)))
            .collect();
        // A sign beside a claim takes room too.
        let here = self.claims_in(at, marks);
        height(marked(above, &here, from, marks, theme), self.width)
    }

    fn folds(&self, json: Json) -> bool {
        json.folds && !self.mode.unfold && !self.is_raw()
    }

    /// A line with its markup as style; nothing for what is only highlighted.
    fn rendered(&self, line: &str, kind: Kind, theme: &Theme) -> Option<Vec<Piece>> {
        if self.is_raw() || line.len() > MAX_MARKUP_BYTES {
            return None;
        }
        match kind {
            Kind::Text | Kind::Row(_) => Some(markdown::line(line, theme)),
            Kind::Code => Some(markdown::code(line, theme)),
            Kind::Fence | Kind::Json(_) => None,
        }
    }

    fn claims_in<'m>(
        &self,
        line: usize,
        marks: &MarkedClaims<'m>,
    ) -> Vec<(usize, &'m CheckedClaim)> {
        let first = self.claims.partition_point(|(l, _)| *l < line);
        let here = self.claims[first..].iter().take_while(|(l, _)| *l == line);
        here.filter_map(|(_, place)| Some((*place, marks.claims.get(*place)?)))
            .collect()
    }

    /// Rows of the screen that all of it takes.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.lines.last().map_or(0, |line| line.rows)
    }

    /// The row that what ends at a byte ends in; of what is folded away that of the line it is folded to. Nothing where
    /// another text was drawn.
    #[must_use]
    pub fn row_of(
        &mut self,
        byte: usize,
        marks: &MarkedClaims<'_>,
        theme: &Theme,
    ) -> Option<usize> {
        if self.key != Some(marks.key) {
            return None;
        }
        if self.lines.is_empty() {
            // It is shown in another way than it was drawn.
            self.outline = Outline::default();
            self.wrap(0, marks, theme);
        }
        let line = self.lines.iter().position(|line| byte <= line.to)?;
        let before = self.row_before(line);
        Some(match self.lines[line].rows - before {
            0 => before.saturating_sub(1),
            1 => before,
            _ => before + self.height_to(line, byte, marks, theme).saturating_sub(1),
        })
    }

    /// Rows above a line.
    fn row_before(&self, line: usize) -> usize {
        let before = line.checked_sub(1).and_then(|l| self.lines.get(l));
        before.map_or(0, |l| l.rows)
    }

    fn is_hidden(&self, line: usize) -> bool {
        self.lines[line].rows == self.row_before(line)
    }

    /// The lines that so many rows from row `top` on show, and how many rows of the first one are above.
    pub fn seen(
        &mut self,
        top: usize,
        rows: usize,
        marks: &MarkedClaims<'_>,
        theme: &Theme,
    ) -> (Vec<Line<'static>>, usize) {
        let first = self.lines.partition_point(|line| line.rows <= top);
        let before = self.row_before(first);
        let after = self.lines.partition_point(|line| line.rows < top + rows);
        let end = (after + 1).min(self.lines.len());
        let shown: Vec<usize> = (first..end).filter(|at| !self.is_hidden(*at)).collect();
        let seen = shown.into_iter().map(|at| {
            let Placed { from, to, kind, .. } = self.lines[at];
            if let Kind::Json(json) = kind
                && self.folds(json)
            {
                return self.fold(at, theme);
            }
            if let Kind::Row(row) = kind
                && self.aligns(row)
            {
                return self.aligned(at, row, marks, theme);
            }
            let here = self.claims_in(at, marks);
            let rendered = self.rendered(&self.text[from..to], kind, theme);
            let pieces = rendered.unwrap_or_else(|| pieces_of(self.painted(at, theme)));
            marked(pieces, &here, from, marks, theme)
        });
        (seen.collect(), top.saturating_sub(before))
    }

    /// The line that the JSON from a line on is folded to.
    fn fold(&self, at: usize, theme: &Theme) -> Line<'static> {
        let more = self.lines[at + 1..]
            .iter()
            .take_while(|l| matches!(l.kind, Kind::Json(json) if json.before > 0));
        let count = 1 + more.count();
        let later = self.lines[at + count..].iter();
        let last = !later.into_iter().any(|l| matches!(l.kind, Kind::Json(_)));
        let name = if last { "verdict JSON" } else { "JSON" };
        let lines = if count == 1 { "line" } else { "lines" };
        let claims = self
            .claims
            .iter()
            .filter(|(line, _)| (at..at + count).contains(line));
        let claims = match claims.count() {
            0 => String::new(),
            1 => ", 1 claim".into(),
            n => format!(", {n} claims"),
        };
        let width = usize::from(self.width);
        let words = format!("▸ {name}, {count} {lines}{claims}");
        let whole = format!("{words}{}", self.mode.hint);
        let words = if whole.width() <= width { whole } else { words };
        Line::styled(fit(&words, width), Style::new().fg(theme.dim))
    }

    /// A line, highlighted; those before it as well.
    fn painted(&mut self, at: usize, theme: &Theme) -> Line<'static> {
        while self.painted.len() <= at {
            let next = self.painted.len();
            let Some(&Placed { from, to, .. }) = self.lines.get(next) else {
                return Line::default();
            };
            let line = &self.text[from..to];
            if self.text.len() == to {
                // It has not ended: it is not what later lines go on from.
                return self.painter.clone().line(line, theme);
            }
            let line = self.painter.line(line, theme);
            self.painted.push(line);
        }
        self.painted[at].clone()
    }
}

/// A line without its end.
fn ended(line: &str) -> &str {
    let line = line.strip_suffix('\n').unwrap_or(line);
    line.strip_suffix('\r').unwrap_or(line)
}

/// Rows that a line takes.
pub fn height(line: Line<'_>, width: u16) -> usize {
    // Most lines are short and plain, and need no wrapping to be counted.
    let bytes: usize = line.spans.iter().map(|span| span.content.len()).sum();
    let mut spans = line.spans.iter();
    if bytes <= usize::from(width) && spans.all(|span| span.content.chars().all(is_plain)) {
        return 1;
    }
    let wrapped = Paragraph::new(line).wrap(Wrap { trim: false });
    wrapped.line_count(width)
}

impl Reading {
    /// Whether the table of a row has its columns side by side.
    fn aligns(&self, row: Row) -> bool {
        !self.is_raw() && Layout::fits(row.columns, usize::from(self.width))
    }

    /// A row as it is written, and drawn without its columns.
    fn drawn(&self, at: usize, marks: &MarkedClaims<'_>, theme: &Theme) -> (&str, Line<'static>) {
        let Placed { from, to, .. } = self.lines[at];
        let written = &self.text[from..to];
        let here = self.claims_in(at, marks);
        let pieces = table::pieces(written, theme);
        (written, marked(pieces, &here, from, marks, theme))
    }

    /// A row in the columns of its table.
    fn aligned(
        &mut self,
        at: usize,
        row: Row,
        marks: &MarkedClaims<'_>,
        theme: &Theme,
    ) -> Line<'static> {
        let first = at - row.before;
        if !self.tables.iter().any(|(line, _)| *line == first) {
            let rows = self.lines[first..]
                .iter()
                .enumerate()
                .take_while(|(i, l)| matches!(l.kind, Kind::Row(r) if r.before == *i))
                .map(|(i, _)| self.drawn(first + i, marks, theme));
            let layout = Layout::new(rows, usize::from(self.width));
            self.tables.push((first, layout));
        }
        let (written, drawn) = self.drawn(at, marks, theme);
        let found = self.tables.iter().find(|(line, _)| *line == first);
        match found {
            Some((_, layout)) => layout.row(written, drawn, row.before == 0, theme),
            None => drawn,
        }
    }
}

#[cfg(test)]
mod tests;
