//! What a terminal says of itself, cells as wide as their column, and keys of the workbench as data.

use serde::Serialize;
use unicode_width::UnicodeWidthStr;

/// Detected capabilities of the terminal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Terminal {
    /// Columns and rows; `None` if there is no terminal.
    pub size: Option<(u16, u16)>,
    /// Columns and rows that the workbench needs.
    pub least: (u16, u16),
    /// How many colours it has: `true`, `256`, `16` or `none`.
    pub colours: &'static str,
    /// Whether it shows more than ASCII.
    pub unicode: bool,
    /// Whether its background is dark; `None` if it did not tell.
    pub dark: Option<bool>,
}

/// Columns that cells are filled to at most. A longer text stands whole, and pushes what follows it.
const MAX_COLUMNS: usize = 256;

/// The columns of a terminal that a column of a table has for this text, at most 256.
#[must_use]
pub fn columns(text: &str) -> usize {
    text.width().min(MAX_COLUMNS)
}

/// `text` with spaces behind it, up to so many columns of a terminal, at most 256.
#[must_use]
pub fn pad_end(text: &str, columns: usize) -> String {
    let missing = columns.min(MAX_COLUMNS).saturating_sub(text.width());
    format!("{text}{}", " ".repeat(missing))
}

/// The same with the spaces before it.
#[must_use]
pub fn pad_start(text: &str, columns: usize) -> String {
    let missing = columns.min(MAX_COLUMNS).saturating_sub(text.width());
    format!("{}{text}", " ".repeat(missing))
}

/// An action with its keys.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct KeyBinding {
    /// Where the keys work.
    pub scope: &'static str,
    /// The action, as in keymap.toml.
    pub action: &'static str,
    /// Its keys, the first one first.
    pub keys: Vec<String>,
    /// What it does.
    pub summary: &'static str,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_filled_to_columns_and_no_length_is_too_long() {
        assert_eq!(pad_end("a", 3) + "|", "a  |");
        assert_eq!(pad_start("a", 3), "  a");
        // Two columns each.
        assert_eq!(pad_end("車", 3), "車 ");
        assert_eq!(pad_end("wider", 3), "wider");
        let long = "x".repeat(70_000);
        assert_eq!(columns(&long), MAX_COLUMNS);
        assert_eq!(pad_end(&long, long.len()), long);
        assert_eq!(pad_start("a", usize::MAX).len(), MAX_COLUMNS);
    }
}
