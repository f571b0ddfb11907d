//! Which keys the template editor understands.

use strum::{IntoStaticStr, VariantArray};

/// Keys of the template editor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Keys {
    /// Those of most programs: Ctrl-Z, Ctrl-X, Ctrl-V, selecting with Shift.
    #[default]
    Plain,
    /// Modes, as in vim.
    Vim,
    /// Ctrl-A, Ctrl-E, Ctrl-K, as in Emacs and shells.
    Emacs,
}

nearmiss_record::named!(Keys, "editor");
