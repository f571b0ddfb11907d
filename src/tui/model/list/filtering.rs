//! The list filter while it is typed.

use crate::model::Place;

/// The filter while it is typed.
#[derive(Debug, Clone)]
pub struct Filtering {
    /// Whether the whole text is selected: the first character that is typed replaces it.
    pub selected: bool,
    /// The text before.
    pub before: String,
    /// The selected line before.
    pub line: usize,
    /// The scenario and step that were open before.
    pub place: Option<Place>,
    /// Seconds until the best match is opened; none while it is open.
    pub rest: Option<f64>,
}
