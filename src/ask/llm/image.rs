//! Images in questions: their bytes, what names them, and how many tokens they are taken for.

use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// An image of a [`super::Message`].
///
/// Two images are the same if their bytes are: the hash stands for them, and only it is written where messages are
/// stored or make up the key of a request.
#[derive(Clone, Serialize, Deserialize)]
pub struct Image {
    /// Its media type, such as `image/png`.
    pub media_type: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Pixels from left to right.
    pub width: u32,
    /// Pixels from top to bottom.
    pub height: u32,
    /// The bytes of the file; empty where a stored message was read.
    #[serde(skip)]
    pub bytes: Arc<[u8]>,
}

impl Image {
    /// A PNG of so many pixels.
    #[must_use]
    pub fn png(bytes: Vec<u8>, (width, height): (u32, u32)) -> Self {
        Self {
            media_type: "image/png".into(),
            sha256: sha256(&bytes),
            width,
            height,
            bytes: bytes.into(),
        }
    }

    /// The bytes in base64, as every API takes them.
    #[must_use]
    pub fn base64(&self) -> String {
        STANDARD.encode(&self.bytes)
    }

    /// The image as an address that holds it.
    #[must_use]
    pub(super) fn data_url(&self) -> String {
        format!("data:{};base64,{}", self.media_type, self.base64())
    }
}

/// SHA-256 of some bytes, hexadecimal.
fn sha256(bytes: &[u8]) -> String {
    let digest = Sha256::digest(bytes);
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

impl PartialEq for Image {
    fn eq(&self, other: &Self) -> bool {
        (&self.sha256, &self.media_type) == (&other.sha256, &other.media_type)
    }
}

impl Eq for Image {}

impl std::hash::Hash for Image {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.sha256.hash(state);
    }
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (width, height) = (self.width, self.height);
        write!(f, "{} {width}×{height} {}", self.media_type, self.sha256)
    }
}

/// How a server turns an image into tokens, as its documentation says: an estimate, which the usage in the answer
/// replaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ImageTokens {
    /// So many, and so many for each tile of 512 pixels: after the image is made to fit 2048 × 2048 and its shorter side
    /// 768 pixels (OpenAI, models up to GPT-5).
    Tiles([u32; 2]),
    /// A patch of 32 × 32 pixels is so many hundredths of a token, of at most 1536 patches (OpenAI, later models).
    Patches(u32),
    /// A token for each patch of so many pixels squared (Anthropic: 28).
    Squares(u32),
    /// 258 for an image of up to 384 × 384, else for each crop of it: crops are two thirds of the shorter side wide and
    /// high, and 256 to 768 pixels (Gemini 2).
    Crops(u32),
    /// The same number for any image (Gemini 3).
    Each(u32),
}

impl Default for ImageTokens {
    /// Patches of 28 pixels: what is documented of most models that see, those with open weights included.
    fn default() -> Self {
        Self::Squares(28)
    }
}

/// Patches of an image that are counted at most, by [`ImageTokens::Patches`].
const MOST_PATCHES: u32 = 1536;

impl ImageTokens {
    /// Tokens of an image of so many pixels.
    #[must_use]
    pub fn of(self, width: u32, height: u32) -> u32 {
        let (width, height) = (width.max(1), height.max(1));
        match self {
            Self::Tiles([base, tile]) => {
                let (mut w, mut h) = (f64::from(width), f64::from(height));
                let fit = (2048.0 / w.max(h)).min(1.0);
                (w, h) = (w * fit, h * fit);
                let fit = (768.0 / w.min(h)).min(1.0);
                let tiles = (w * fit / 512.0).ceil() * (h * fit / 512.0).ceil();
                base + tile * tiles as u32
            }
            Self::Patches(hundredths) => {
                let patches = width.div_ceil(32) * height.div_ceil(32);
                (patches.min(MOST_PATCHES) * hundredths).div_ceil(100)
            }
            Self::Squares(side) => width.div_ceil(side.max(1)) * height.div_ceil(side.max(1)),
            Self::Crops(each) => {
                if width <= 384 && height <= 384 {
                    return each;
                }
                let crop = (width.min(height) * 2 / 3).clamp(256, 768);
                each * width.div_ceil(crop) * height.div_ceil(crop)
            }
            Self::Each(tokens) => tokens,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn tokens_as_the_documentation_counts_them() {
        // OpenAI's own examples: 1024 × 1024 and 2048 × 4096 in high detail.
        assert_eq!(ImageTokens::Tiles([85, 170]).of(1024, 1024), 765);
        assert_eq!(ImageTokens::Tiles([85, 170]).of(2048, 4096), 1105);
        assert_eq!(ImageTokens::Patches(100).of(1024, 1024), 1024);
        assert_eq!(ImageTokens::Patches(162).of(32, 33), 4);
        assert_eq!(ImageTokens::Squares(28).of(1152, 768), 42 * 28);
        assert_eq!(ImageTokens::Crops(258).of(384, 384), 258);
        // Google's example: 960 × 540 has crops of 360 pixels, three by two.
        assert_eq!(ImageTokens::Crops(258).of(960, 540), 6 * 258);
        assert_eq!(ImageTokens::Each(1120).of(10, 10), 1120);
    }

    #[test]
    fn the_hash_stands_for_the_bytes() {
        let image = Image::png(b"abc".to_vec(), (2, 1));
        let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(image.sha256, known);
        assert_eq!(image.data_url(), "data:image/png;base64,YWJj");
        let stored = serde_json::to_value(&image).unwrap();
        let wanted = serde_json::json!({
            "media_type": "image/png", "sha256": known, "width": 2, "height": 1,
        });
        assert_eq!(stored, wanted, "no bytes");
        let read: Image = serde_json::from_value(stored).unwrap();
        assert_eq!(read, image);
        assert_ne!(read, Image::png(b"abd".to_vec(), (2, 1)));
    }
}
