//! Tables as HTML; the page that they stand in has their look.

use crate::captioned::{CaptionedTable, one_line};

impl CaptionedTable {
    /// The table as a part of a page. Its caption stands still where a wide table is moved to the side; the keyboard can
    /// move it, too.
    #[must_use]
    pub fn html(&self) -> String {
        let name = escaped(&self.name);
        let class = |is_number: bool| if is_number { " class=\"n\"" } else { "" };
        let mut text = format!(
            "<p class=\"caption\" id=\"{name}\">{}</p>\n<div class=\"wide\" role=\"region\" aria-labelledby=\"{name}\" \
             tabindex=\"0\">\n<table aria-labelledby=\"{name}\">\n<thead><tr>",
            escaped(&self.caption)
        );
        for (title, is_number) in &self.columns {
            let class = class(*is_number);
            text += &format!("<th scope=\"col\"{class}>{}</th>", escaped(title));
        }
        text += "</tr></thead>\n<tbody>\n";
        for row in &self.rows {
            text += "<tr>";
            for (cell, (_, is_number)) in row.iter().zip(&self.columns) {
                text += &format!("<td{}>{}</td>", class(*is_number), inside(cell));
            }
            text += "</tr>\n";
        }
        text + "</tbody>\n</table>\n</div>\n"
    }
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

/// Text on one line that means nothing to HTML and SVG.
#[must_use]
pub fn escaped(text: &str) -> String {
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
