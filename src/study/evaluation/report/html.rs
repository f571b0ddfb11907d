//! Reports as one self-contained HTML file, light or dark by the reader's preference.

use super::document::{Align, Block, Document, Figure, Table, clean};
use crate::evaluation::AnswerPage;
use crate::evaluation::answer_page::{STYLE as ANSWERS_STYLE, source_hash};

/// The look: colours as variables, so that figures in SVG have them too.
const STYLE: &str = include_str!("report.css");

impl Document {
    /// The report as one file of HTML, with its figures in it, and the answers that it counts where there are any. The
    /// page runs nothing but its own script and asks for nothing.
    #[must_use]
    pub fn html(&self, answers: &AnswerPage) -> String {
        let title = escaped(&self.title);
        let style = if answers.is_empty() {
            format!("\n{STYLE}")
        } else {
            format!("\n{STYLE}{ANSWERS_STYLE}")
        };
        let script = if answers.is_empty() {
            "'none'".to_string()
        } else {
            format!("'{}'", AnswerPage::script_hash())
        };
        let policy = format!(
            "default-src 'none'; style-src '{}'; script-src {script}; img-src data:; base-uri 'none'; form-action 'none'",
            source_hash(&style)
        );
        let mut text = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{policy}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <title>{title}</title>\n<style>{style}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n"
        );
        for block in &self.blocks {
            match block {
                Block::Heading(words) => text += &format!("<h2>{}</h2>\n", escaped(words)),
                Block::Text(words) => text += &format!("<p>{}</p>\n", escaped(words)),
                Block::Table(table) => text += &html(table),
                Block::Figures(title, figures) => {
                    text += &format!("<h3>{}</h3>\n<div class=\"figures\">\n", escaped(title));
                    for figure in figures {
                        text += &html_of(figure);
                    }
                    text += "</div>\n";
                }
            }
        }
        text += "</main>\n";
        if !answers.is_empty() {
            text += &answers.html();
        }
        text + "</body>\n</html>\n"
    }
}

/// A figure, with its caption if it has one.
fn html_of(figure: &Figure) -> String {
    let caption = if figure.caption.is_empty() {
        String::new()
    } else {
        format!("<figcaption>{}</figcaption>\n", escaped(&figure.caption))
    };
    format!("<figure>\n{}{caption}</figure>\n", figure.svg)
}

fn html(table: &Table) -> String {
    // The caption stands still where a wide table is moved to the side; the keyboard can move it, too.
    let name = escaped(&table.name);
    let class = |align: Align| match align {
        Align::Left => "",
        Align::Right => " class=\"n\"",
    };
    let mut text = format!(
        "<p class=\"caption\" id=\"{name}\">{}</p>\n<div class=\"wide\" role=\"region\" aria-labelledby=\"{name}\" \
         tabindex=\"0\">\n<table aria-labelledby=\"{name}\">\n<thead><tr>",
        escaped(&table.caption)
    );
    for (title, align) in &table.columns {
        text += &format!("<th scope=\"col\"{}>{}</th>", class(*align), escaped(title));
    }
    text += "</tr></thead>\n<tbody>\n";
    for row in &table.rows {
        text += "<tr>";
        for (cell, (_, align)) in row.iter().zip(&table.columns) {
            text += &format!("<td{}>{}</td>", class(*align), inside(cell));
        }
        text += "</tr>\n";
    }
    text + "</tbody>\n</table>\n</div>\n"
}

/// A cell; an interval stands beneath its value, so that more columns fit on a page.
fn inside(cell: &str) -> String {
    match cell.split_once(" [") {
        Some((value, interval)) if interval.ends_with(']') => format!(
            "{} <span class=\"ci\">[{}</span>",
            escaped(value),
            escaped(interval)
        ),
        _ => escaped(cell),
    }
}

/// Text that means nothing to HTML and SVG.
pub(super) fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in clean(text).chars() {
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
