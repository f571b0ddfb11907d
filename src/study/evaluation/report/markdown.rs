//! Reports as Markdown with GitHub tables, aligned to be readable as plain text.

use super::document::{Align, Block, Document, Table, clean};
use nearmiss_base::system::{columns, pad_end, pad_start};

impl Document {
    /// The report as Markdown; figures are left out.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!("# {}\n", escaped(&self.title));
        for block in &self.blocks {
            match block {
                Block::Heading(words) => text += &format!("\n## {}\n", escaped(words)),
                Block::Text(words) => text += &format!("\n{}\n", escaped(words)),
                Block::Table(table) => text += &markdown(table),
                Block::Figures(..) => {}
            }
        }
        text
    }
}

fn markdown(table: &Table) -> String {
    let titles: Vec<String> = table.columns.iter().map(|(t, _)| escaped(t)).collect();
    let rows: Vec<Vec<String>> = table
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
        for ((cell, width), (_, align)) in cells.iter().zip(&widths).zip(&table.columns) {
            line += &match align {
                Align::Left => format!(" {} |", pad_end(cell, *width)),
                Align::Right => format!(" {} |", pad_start(cell, *width)),
            };
        }
        line + "\n"
    };
    let mut text = format!("\n**{}**\n\n{}|", escaped(&table.caption), line(&titles));
    for (width, (_, align)) in widths.iter().zip(&table.columns) {
        text += &match align {
            Align::Left => format!(":{} |", "-".repeat(*width)),
            Align::Right => format!(" {}:|", "-".repeat(*width)),
        };
    }
    text.push('\n');
    rows.iter().for_each(|row| text += &line(row));
    text
}

/// Text that means nothing to Markdown.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in clean(text).chars() {
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
