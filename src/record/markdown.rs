//! Tables as Markdown of GitHub, aligned to be readable as plain text.

use crate::captioned::{CaptionedTable, one_line};
use nearmiss_base::system::{columns, pad_end, pad_start};

impl CaptionedTable {
    /// The table with its caption; notes are left out.
    #[must_use]
    pub fn markdown(&self) -> String {
        let titles: Vec<String> = self.columns.iter().map(|(t, _)| escaped(t)).collect();
        let rows: Vec<Vec<String>> = self
            .rows
            .iter()
            .map(|row| row.iter().map(|cell| escaped(cell)).collect())
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
        let mut text = format!("\n**{}**\n\n{}|", escaped(&self.caption), line(&titles));
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
pub fn escaped(text: &str) -> String {
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
