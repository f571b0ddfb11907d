//! What a terminal says of itself, or its environment of it.

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
