//! Search in the editor: matches, and jumping between them.

use super::Editor;

/// A word that is looked for; small letters stand for capitals too.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Find {
    /// The search text.
    pub text: String,
    /// Line and column where the search began.
    pub from: (usize, usize),
}

impl Find {
    /// Columns in a line where it begins.
    #[must_use]
    pub fn in_line(&self, line: &[char]) -> Vec<usize> {
        let pattern: Vec<char> = self.text.chars().collect();
        if pattern.is_empty() {
            return Vec::new();
        }
        let exact = pattern.iter().any(|c| c.is_uppercase());
        let same =
            |(a, b): (&char, &char)| a == b || !exact && a.to_lowercase().eq(std::iter::once(*b));
        let windows = line.windows(pattern.len()).enumerate();
        windows
            .filter(|(_, window)| window.iter().zip(&pattern).all(same))
            .map(|(at, _)| at)
            .collect()
    }

    /// Lines and columns of a text where it begins.
    #[must_use]
    pub fn places(&self, editor: &Editor) -> Vec<(usize, usize)> {
        let lines = editor.lines().enumerate();
        lines
            .flat_map(|(row, line)| self.in_line(line).into_iter().map(move |col| (row, col)))
            .collect()
    }
}

/// The place in `all` that comes after `from`, or before it; from the end on from the beginning.
#[must_use]
pub fn next(all: &[(usize, usize)], from: (usize, usize), forward: bool) -> Option<usize> {
    if all.is_empty() {
        return None;
    }
    Some(if forward {
        all.iter().position(|&at| at > from).unwrap_or(0)
    } else {
        let before = all.iter().rposition(|&at| at < from);
        before.unwrap_or(all.len() - 1)
    })
}
