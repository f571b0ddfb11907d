//! Which keys the template editor understands.

use serde::Deserialize;

/// Keys of the template editor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Keys {
    /// Those of most programs: Ctrl-Z, Ctrl-X, Ctrl-V, selecting with Shift.
    #[default]
    Plain,
    /// Modes, as in vim.
    Vim,
    /// Ctrl-A, Ctrl-E, Ctrl-K, as in Emacs and shells.
    Emacs,
}

impl Keys {
    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Vim => "vim",
            Self::Emacs => "emacs",
        }
    }
}
