//! Scenes in words: what a language model is given to read.

mod cartesian;
mod ego_centric;
mod options;
mod visible;

use crate::scenario::{Scene, Window};

pub use options::Options;
pub use visible::visible;

/// From where a scene is described.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Frame {
    /// Positions on the map.
    Cartesian,
    /// Gaps and motion seen from the ego.
    Ego,
}

impl Frame {
    /// Every frame.
    pub const ALL: [Self; 2] = [Self::Ego, Self::Cartesian];

    /// The word for it, on the command line and in the store.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cartesian => "cartesian",
            Self::Ego => "ego",
        }
    }

    /// The frame with this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }
}

/// The scene during `window`, in words.
#[must_use]
pub fn describe(scene: &Scene, frame: Frame, window: &Window, options: &Options) -> String {
    match frame {
        Frame::Cartesian => cartesian::describe(scene, window, options),
        Frame::Ego => ego_centric::describe(scene, window, options),
    }
}
