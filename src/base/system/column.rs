//! Cells of tables for people: as many columns of a terminal as their column has, however long a text is.

use unicode_width::UnicodeWidthStr;

/// Columns that cells are filled to at most. A longer text stands whole, and pushes what follows it.
const WIDEST: usize = 256;

/// The columns of a terminal that a column of a table has for this text, at most 256.
#[must_use]
pub fn columns(text: &str) -> usize {
    text.width().min(WIDEST)
}

/// `text` with spaces behind it, up to so many columns of a terminal, at most 256.
#[must_use]
pub fn pad_end(text: &str, columns: usize) -> String {
    let missing = columns.min(WIDEST).saturating_sub(text.width());
    format!("{text}{}", " ".repeat(missing))
}

/// The same with the spaces before it.
#[must_use]
pub fn pad_start(text: &str, columns: usize) -> String {
    let missing = columns.min(WIDEST).saturating_sub(text.width());
    format!("{}{text}", " ".repeat(missing))
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
        assert_eq!(columns(&long), WIDEST);
        assert_eq!(pad_end(&long, long.len()), long);
        assert_eq!(pad_start("a", usize::MAX).len(), WIDEST);
    }
}
