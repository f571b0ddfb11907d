//! State of the map: layers, the second moment, predicted paths, measuring tape, and what the mouse drags.

mod details;
mod foresight;
mod framing;
mod halves;
mod image;
mod layers;
mod moment;
mod tape;

use ratatui::layout::Position;

pub use details::{Detail, as_text};
pub use foresight::{Foresight, Future, PathRequest};
pub use halves::Halves;
pub use image::Images;
pub use layers::{Foreseen, Layers, Trails};
pub use moment::{Moment, SecondMap};
pub use tape::{End, Measurement, On, Tape};

use super::Model;

/// The tools of the map.
#[derive(Debug, Default)]
pub struct Tools {
    /// Visible layers; saved with the session.
    pub layers: Layers,
    /// Paths into the future, as far as they are shown.
    pub foresight: Foresight,
    /// The second map.
    pub second: SecondMap,
    /// The map as an image.
    pub images: Images,
    /// The measuring tape, if it is out.
    pub tape: Option<Tape>,
    /// Where the mouse took hold of the map, and whether it moved since.
    pub held: Option<(Position, bool)>,
}
