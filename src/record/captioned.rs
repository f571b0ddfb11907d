//! Tables for people that stand in a document, with a caption and notes: as HTML, LaTeX and Markdown.

use nearmiss_base::system::{columns, pad_end, pad_start, visible};

use schemars::JsonSchema;
use serde::Serialize;

use super::reflect::{Record, columns as columns_of_type, rows};
use super::table::{Cell, Column, Kind, Row};
use super::text::{heading, lines};

/// A table of a document.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CaptionedTable {
    /// Its caption.
    pub caption: String,
    /// Its name for references.
    pub name: String,
    /// Headings, and whether their cells stand to the right, as numbers do.
    pub columns: Vec<(String, bool)>,
    /// The cells, a row each as long as the columns.
    pub rows: Vec<Vec<String>>,
    /// Explanations of its numbers, for tables that stand alone.
    pub notes: Vec<String>,
}

/// Stands where there is no value.
pub const NONE: &str = "–";

impl CaptionedTable {
    /// A table of the columns that have a heading. A number stands with its interval, where it has columns `…_ci_low` and
    /// `…_ci_high`.
    #[must_use]
    pub fn new(
        caption: impl Into<String>,
        name: impl Into<String>,
        columns: &[Column],
        rows: &[Row],
    ) -> Self {
        let is_shown = |(place, column): &(usize, &Column)| {
            let is_empty = |row: &Row| {
                let cell = &row[*place];
                matches!(cell, Cell::None(_) | Cell::Integer(0))
            };
            !(column.title.is_empty() || column.rare && rows.iter().all(is_empty))
        };
        let shown: Vec<(usize, &Column)> = columns.iter().enumerate().filter(is_shown).collect();
        let end = |row: &Row, column: &Column, which: &str| {
            let name = format!("{}_ci_{which}", column.name);
            let place = columns.iter().position(|one| one.name == name)?;
            row[place].number()
        };
        let cell = |row: &Row, (place, column): &(usize, &Column)| {
            let digits = column.decimals.unwrap_or(2);
            match (
                &row[*place],
                end(row, column, "low"),
                end(row, column, "high"),
            ) {
                (Cell::None(_), ..) => NONE.into(),
                (cell, Some(low), Some(high)) => {
                    let value = cell.shown(column);
                    format!("{value} [{low:.digits$}, {high:.digits$}]")
                }
                (cell, ..) => cell.shown(column).into_owned(),
            }
        };
        let row = |row: &Row| shown.iter().map(|one| cell(row, one)).collect();
        let is_number = |column: &Column| !matches!(column.kind, Kind::Text | Kind::Truth);
        Self {
            caption: caption.into(),
            name: name.into(),
            rows: rows.iter().map(row).collect(),
            columns: shown
                .iter()
                .map(|(_, column)| (heading(column), is_number(column)))
                .collect(),
            notes: Vec::new(),
        }
    }

    /// The table of records, with the columns of their type.
    ///
    /// # Errors
    /// A map in one has keys that JSON does not allow.
    pub fn of<R: Record + JsonSchema + Serialize>(
        caption: &str,
        name: &str,
        records: &[R],
    ) -> serde_json::Result<Self> {
        let rows = rows(records)?;
        Ok(Self::new(caption, name, &columns_of_type::<R>(), &rows))
    }

    /// The table for terminals: a line for each row, numbers to the right, without caption and notes.
    #[must_use]
    pub fn text(&self) -> String {
        let numbers = self.columns.iter().enumerate();
        let numbers = numbers.filter(|(_, (_, is_number))| *is_number);
        let right: Vec<usize> = numbers.map(|(place, _)| place).collect();
        let head = self
            .columns
            .iter()
            .map(|(title, _)| title.clone())
            .collect();
        let all: Vec<Vec<String>> = std::iter::once(head)
            .chain(self.rows.iter().cloned())
            .collect();
        lines(&all, &right).collect()
    }

    /// The same with notes beneath it.
    #[must_use]
    pub fn with_notes(self, notes: impl IntoIterator<Item = String>) -> Self {
        let notes = notes.into_iter().collect();
        Self { notes, ..self }
    }

    /// The same, unless it has no rows.
    #[must_use]
    pub fn filled(self) -> Option<Self> {
        (!self.rows.is_empty()).then_some(self)
    }
}

/// A value with the ends of its interval: `0.83 [0.70, 0.91]`.
#[must_use]
pub fn with_interval(value: Option<f64>, interval: Option<(f64, f64)>) -> String {
    match (value, interval) {
        (None, _) => NONE.into(),
        (Some(value), None) => format!("{value:.2}"),
        (Some(value), Some((low, high))) => format!("{value:.2} [{low:.2}, {high:.2}]"),
    }
}

/// Text on one line, with what terminals and browsers would obey shown instead.
fn one_line(text: &str) -> String {
    visible(text)
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}

impl CaptionedTable {
    /// The table as a part of a page. Its caption stands still where a wide table is moved to the side; the keyboard can
    /// move it, too.
    #[must_use]
    pub fn html(&self) -> String {
        let name = escaped_html(&self.name);
        let class = |is_number: bool| if is_number { " class=\"n\"" } else { "" };
        let mut text = format!(
            "<p class=\"caption\" id=\"{name}\">{}</p>\n<div class=\"wide\" role=\"region\" aria-labelledby=\"{name}\" \
             tabindex=\"0\">\n<table aria-labelledby=\"{name}\">\n<thead><tr>",
            escaped_html(&self.caption)
        );
        for (title, is_number) in &self.columns {
            let class = class(*is_number);
            text += &format!("<th scope=\"col\"{class}>{}</th>", escaped_html(title));
        }
        text += "</tr></thead>\n<tbody>\n";
        for row in &self.rows {
            text += "<tr>";
            for (cell, (_, is_number)) in row.iter().zip(&self.columns) {
                text += &format!("<td{}>{}</td>", class(*is_number), inside_html(cell));
            }
            text += "</tr>\n";
        }
        text + "</tbody>\n</table>\n</div>\n"
    }
}

/// A cell; an interval stands beneath its value, so that more columns fit on a page.
fn inside_html(cell: &str) -> String {
    match cell.split_once(" [") {
        Some((value, interval)) if interval.ends_with(']') => format!(
            "{} <span class=\"ci\">[{}</span>",
            escaped_html(value),
            escaped_html(interval)
        ),
        _ => escaped_html(cell),
    }
}

/// Text on one line that means nothing to HTML and SVG.
#[must_use]
pub fn escaped_html(text: &str) -> String {
    let mut escaped = String::new();
    for c in one_line(text).chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&#39;",
            _ => escaped.push(c),
        }
    }
    escaped
}

impl CaptionedTable {
    /// The table as a float over the whole page, with its notes beneath; it needs booktabs and graphicx.
    #[must_use]
    pub fn latex(&self) -> String {
        let sides = self
            .columns
            .iter()
            .map(|(_, is_number)| if *is_number { 'r' } else { 'l' });
        let line = |cells: &mut dyn Iterator<Item = &String>| {
            let cells: Vec<String> = cells.map(|cell| escaped_latex(cell)).collect();
            format!("  {} \\\\\n", cells.join(" & "))
        };
        let mut text = format!(
            "\n\\begin{{table*}}[t]\n\\centering\n\\caption{{{}}}\n\\label{{tab:{}}}\n{FITTED}{{%\n\
             \\begin{{tabular}}{{@{{}}{}@{{}}}}\n  \\toprule\n",
            escaped_latex(&self.caption),
            self.name,
            sides.collect::<String>()
        );
        text += &line(&mut self.columns.iter().map(|(title, _)| title));
        text += "  \\midrule\n";
        for row in &self.rows {
            text += &line(&mut row.iter());
        }
        text += "  \\bottomrule\n\\end{tabular}}\n";
        text += &latex_notes(&self.notes);
        text + "\\end{table*}\n"
    }
}

impl CaptionedTable {
    /// The table over as many pages as it needs, for pages so many millimetres wide between their margins; long texts are
    /// broken into lines. It needs booktabs, longtable and array.
    #[must_use]
    pub fn latex_long(&self, width: f64) -> String {
        let natural = |place: usize| {
            let cells = self.rows.iter().map(|row| columns(&row[place]));
            let widest = cells.chain([columns(&self.columns[place].0)]).max();
            widest.unwrap_or(0) as f64 * CHARACTER
        };
        let natural: Vec<f64> = (0..self.columns.len()).map(natural).collect();
        let is_long = |place: usize| !self.columns[place].1 && natural[place] > LONG;
        let sum = |long: bool| -> f64 {
            let places = (0..natural.len()).filter(|place| is_long(*place) == long);
            places.map(|place| natural[place]).sum()
        };
        let room = width - 2.0 * GAP * natural.len() as f64 - sum(false);
        let shrunk = (room / sum(true).max(1.0)).min(1.0);
        let sides = self
            .columns
            .iter()
            .enumerate()
            .map(
                |(place, (_, is_number))| match (is_number, is_long(place) && shrunk < 1.0) {
                    (true, _) => "r".to_string(),
                    (false, false) => "l".into(),
                    (false, true) => {
                        let wide = (natural[place] * shrunk).max(LONG / 2.0);
                        format!(">{{\\raggedright\\arraybackslash}}p{{{wide:.0}mm}}")
                    }
                },
            );
        let line = |cells: &mut dyn Iterator<Item = &String>| {
            let cells: Vec<String> = cells.map(|cell| escaped_latex(cell)).collect();
            format!("  {} \\\\\n", cells.join(" & "))
        };
        let titles = line(&mut self.columns.iter().map(|(title, _)| title));
        let head = format!("  \\toprule\n{titles}  \\midrule\n");
        let rows: String = self.rows.iter().map(|row| line(&mut row.iter())).collect();
        format!(
            "\n{{\\scriptsize\\setlength{{\\tabcolsep}}{{{GAP}mm}}\n\\begin{{longtable}}{{@{{}}{}@{{}}}}\n\
             \\caption*{{\\textbf{{{}}}}} \\\\\n{head}\\endfirsthead\n{head}\\endhead\n  \\bottomrule\n\\endfoot\n{rows}\
             \\end{{longtable}}}}\n",
            sides.collect::<String>(),
            escaped_latex(&self.caption)
        )
    }
}

/// A character of a long table, half the gap between its columns, and texts from which on they may be broken, millimetres.
const CHARACTER: f64 = 1.3;
const GAP: f64 = 0.8;
const LONG: f64 = 40.0;

/// Words as comments.
#[must_use]
pub fn latex_comment(words: &str) -> String {
    let words = one_line(words);
    let lines = textwrap::wrap(&words, 110).into_iter();
    lines.map(|line| format!("% {line}\n")).collect()
}

/// Tables that are wider than the page are made smaller, others stay as they are.
const FITTED: &str = "\\resizebox{\\ifdim\\width>\\textwidth\\textwidth\\else\\width\\fi}{!}";

/// Notes beneath a table, one paragraph each.
fn latex_notes(notes: &[String]) -> String {
    if notes.is_empty() {
        return String::new();
    }
    let mut text =
        String::from("\\par\\medskip\n\\begin{minipage}{\\textwidth}\\footnotesize\\raggedright\n");
    for (i, note) in notes.iter().enumerate() {
        let begin = if i == 0 { "\\emph{Notes.} " } else { "\\par " };
        text += &format!("{begin}{}\n", escaped_latex(note));
    }
    text + "\\end{minipage}\n"
}

/// Text on one line that means nothing to LaTeX; signs that its usual fonts lack are written as mathematics, or by their number.
#[must_use]
pub fn escaped_latex(text: &str) -> String {
    let mut escaped = String::new();
    let text = one_line(text);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            // A sign, not a hyphen.
            '-' if rest.peek().is_some_and(char::is_ascii_digit)
                && (escaped.is_empty() || escaped.ends_with([' ', '['])) =>
            {
                escaped += "$-$";
            }
            // After the end of a row they would be an argument of it.
            '[' | '*' if escaped.is_empty() => escaped += &format!("{{{c}}}"),
            // Two of them would be a dash, as in `--truth`.
            '-' if escaped.ends_with('-') => escaped += "{}-",
            '\\' => escaped += "\\textbackslash{}",
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => {
                escaped.push('\\');
                escaped.push(c);
            }
            '~' => escaped += "\\textasciitilde{}",
            '^' => escaped += "\\textasciicircum{}",
            '`' => escaped += "\\textasciigrave{}",
            '<' => escaped += "$<$",
            '>' => escaped += "$>$",
            '|' => escaped += "$|$",
            '"' => escaped += "''",
            '–' => escaped += "--",
            '·' => escaped += "$\\cdot$",
            'κ' => escaped += "$\\kappa$",
            'χ' => escaped += "$\\chi$",
            '²' => escaped += "$^2$",
            '°' => escaped += "$^\\circ$",
            'Δ' => escaped += "$\\Delta$",
            '≤' => escaped += "$\\leq$",
            '≥' => escaped += "$\\geq$",
            '−' => escaped += "$-$",
            '×' => escaped += "$\\times$",
            '√' => escaped += "$\\surd$",
            '…' => escaped += "\\ldots{}",
            // Those of Latin-1 that are letters can be typeset, and stop no compilation.
            _ if c.is_ascii() || matches!(c, 'À'..='ÿ') => escaped.push(c),
            _ => escaped += &format!("{{\\ttfamily U+{:04X}}}", u32::from(c)),
        }
    }
    escaped
}

impl CaptionedTable {
    /// The table with its caption; notes are left out.
    #[must_use]
    pub fn markdown(&self) -> String {
        let titles: Vec<String> = self
            .columns
            .iter()
            .map(|(t, _)| escaped_markdown(t))
            .collect();
        let rows: Vec<Vec<String>> = self
            .rows
            .iter()
            .map(|row| row.iter().map(|cell| escaped_markdown(cell)).collect())
            .collect();
        let width = |column: usize| {
            let cells = rows.iter().map(|row| &row[column]).chain([&titles[column]]);
            cells.map(|c| columns(c)).max().unwrap_or(0).max(3)
        };
        let widths: Vec<usize> = (0..titles.len()).map(width).collect();
        let line = |cells: &[String]| {
            let mut line = String::from("|");
            for ((cell, width), (_, is_number)) in cells.iter().zip(&widths).zip(&self.columns) {
                let padded = if *is_number {
                    pad_start(cell, *width)
                } else {
                    pad_end(cell, *width)
                };
                line += &format!(" {padded} |");
            }
            line + "\n"
        };
        let mut text = format!(
            "\n**{}**\n\n{}|",
            escaped_markdown(&self.caption),
            line(&titles)
        );
        for (width, (_, is_number)) in widths.iter().zip(&self.columns) {
            let dashes = "-".repeat(*width);
            text += &if *is_number {
                format!(" {dashes}:|")
            } else {
                format!(":{dashes} |")
            };
        }
        text.push('\n');
        rows.iter().for_each(|row| text += &line(row));
        text
    }
}

/// Text on one line that means nothing to Markdown.
#[must_use]
pub fn escaped_markdown(text: &str) -> String {
    let mut escaped = String::new();
    for c in one_line(text).chars() {
        if matches!(
            c,
            '\\' | '|' | '`' | '*' | '<' | '>' | '#' | '~' | '[' | ']' | '_'
        ) {
            // Intervals and names of models stay readable: brackets without a link and single `_` mean nothing.
            if !matches!(c, '[' | ']' | '_' | '>' | '#') {
                escaped.push('\\');
            }
        }
        escaped.push(c);
    }
    escaped.replace("](", "]\\(").replace("__", "\\_\\_")
}

#[cfg(test)]
mod tests {
    use super::escaped_latex;

    #[test]
    fn nothing_is_obeyed() {
        assert_eq!(
            escaped_latex("a_b & 5% of $x^2$ {\\input{/etc}} ~#"),
            "a\\_b \\& 5\\% of \\$x\\textasciicircum{}2\\$ \\{\\textbackslash{}input\\{/etc\\}\\} \\textasciitilde{}\\#"
        );
        assert_eq!(escaped_latex("[5cm] *"), "{[}5cm] *");
        assert_eq!(
            escaped_latex("`--truth` é 中 ␛"),
            "\\textasciigrave{}-{}-truth\\textasciigrave{} é {\\ttfamily U+4E2D} {\\ttfamily U+241B}"
        );
        assert_eq!(
            escaped_latex("-0.12 [-0.20, −0.03] b-1"),
            "$-$0.12 [$-$0.20, $-$0.03] b-1"
        );
        assert_eq!(
            escaped_latex("κ ≤ 1 – χ²"),
            "$\\kappa$ $\\leq$ 1 -- $\\chi$$^2$"
        );
    }
}
