//! An estimate of how many tokens a text is.

/// Roughly how many tokens a text is.
#[must_use]
pub fn estimate_tokens(text: &str) -> usize {
    text.chars().count().div_ceil(4)
}
