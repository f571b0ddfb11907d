//! Files of the user that are not in use, and what is in their place.

use std::path::PathBuf;

/// A file of the user that is not in use, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Which file.
    pub path: PathBuf,
    /// What is wrong, with the line.
    pub message: String,
    /// What is in use in its place.
    pub instead: Fallback,
}

/// Replacement in use for a broken file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fallback {
    /// The shipped file of the same name.
    Shipped,
    /// The user's own file, as it was when it could last be read.
    LastGood,
    /// Nothing: there is no other file of that name.
    Nothing,
    /// The template that is used where none is chosen.
    Usual,
}

impl Problem {
    /// Whether another template would be sent in place of the file.
    #[must_use]
    pub fn stops(&self) -> bool {
        matches!(self.instead, Fallback::Shipped | Fallback::Usual)
    }
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let instead = match self.instead {
            Fallback::Shipped | Fallback::Usual => {
                "mend or remove it; nothing is sent in its place"
            }
            Fallback::LastGood => "its last good version stays in use",
            Fallback::Nothing => "the file is not used",
        };
        write!(f, "{}: {} ({instead})", self.path.display(), self.message)
    }
}
