//! The map as an image: what was requested last, and what is there.

use crate::pixels::{Encoder, ImageRequest, MapImage};
use nearmiss_render::Picture;

/// The map as an image, where the terminal shows images.
#[derive(Debug, Default)]
pub struct Images {
    /// How images are sent; `None` where the terminal shows none.
    pub encoder: Option<Encoder>,
    /// What is shown.
    pub shown: Option<MapImage>,
    requested: Option<(Picture, f64, (u16, u16))>,
    is_pending: bool,
    count: u64,
}

impl Images {
    /// The request for a picture, unless it is that of the last one, or one is being made: the next frame asks anew.
    pub fn request(
        &mut self,
        picture: Picture,
        dpi: f64,
        cells: (u16, u16),
    ) -> Option<ImageRequest> {
        let encoder = self.encoder.clone()?;
        let last = self.requested.as_ref();
        let known =
            last.is_some_and(|(last, at, size)| (last, at, size) == (&picture, &dpi, &cells));
        if self.is_pending || known {
            return None;
        }
        self.is_pending = true;
        self.count += 1;
        self.requested = Some((picture.clone(), dpi, cells));
        Some(ImageRequest {
            picture,
            dpi,
            cells,
            count: self.count,
            encoder,
        })
    }

    /// Takes an image; the first one that cannot be made ends them.
    ///
    /// # Errors
    /// It could not be made.
    pub fn take(&mut self, image: Result<MapImage, String>) -> Result<(), String> {
        self.is_pending = false;
        match image {
            Ok(image) => self.shown = Some(image),
            Err(why) => {
                self.forget();
                self.encoder = None;
                return Err(why);
            }
        }
        Ok(())
    }

    /// The terminal has lost its images, or the map is drawn in another way.
    pub fn forget(&mut self) {
        self.shown = None;
        self.requested = None;
    }
}
