//! The formats of pictures, by their names and the endings of files.

use std::path::Path;

use super::{Picture, RasterError, png, svg};

/// How a picture is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Shapes and text, for print.
    Svg,
    /// Pixels.
    Png,
    /// Pixels that move.
    Gif,
}

impl Format {
    /// Every one.
    pub const ALL: [Self; 3] = [Self::Svg, Self::Png, Self::Gif];

    /// Its name, which is also the ending of its files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Png => "png",
            Self::Gif => "gif",
        }
    }

    /// The one with this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|f| f.name().eq_ignore_ascii_case(name))
    }

    /// The one that a file's ending asks for.
    #[must_use]
    pub fn of_file(path: &Path) -> Option<Self> {
        Self::parse(path.extension()?.to_str()?)
    }

    /// Pixels of an inch unless something else is asked for: as printers want them, or as screens have them.
    #[must_use]
    pub fn usual_dpi(self) -> f64 {
        match self {
            Self::Svg | Self::Png => 300.0,
            Self::Gif => 150.0,
        }
    }

    /// One picture as a file, SVG or PNG.
    ///
    /// # Errors
    /// It would have too many pixels.
    pub fn encode(self, picture: &Picture, dpi: f64) -> Result<Vec<u8>, RasterError> {
        match self {
            Self::Svg => Ok(svg(picture).into_bytes()),
            Self::Png | Self::Gif => png(picture, dpi),
        }
    }
}
