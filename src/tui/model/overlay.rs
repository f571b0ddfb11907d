//! How what lies over the main screen is scrolled.

use super::Overlay;

impl Overlay {
    /// How far it is scrolled, if it is text.
    pub fn scroll_mut(&mut self) -> Option<&mut usize> {
        match self {
            Self::Help { scroll, .. }
            | Self::About { scroll }
            | Self::Values { scroll }
            | Self::Details(scroll)
            | Self::Cycle(scroll)
            | Self::Variant(scroll)
            | Self::Source { scroll } => Some(scroll),
            Self::Palette(_)
            | Self::Layers(_)
            | Self::Themes(_)
            | Self::Models { .. }
            | Self::Measures { .. }
            | Self::Pictures(_)
            | Self::Templates { .. }
            | Self::Tags { .. }
            | Self::History
            | Self::Jobs
            | Self::Results
            | Self::Batch => None,
        }
    }
}
