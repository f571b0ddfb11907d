//! The map as an image, for terminals that say that they show images (kitty, sixel, iTerm2).

use std::time::Duration;

use image::{DynamicImage, RgbaImage};
use ratatui::Frame;
use ratatui::layout::{Rect, Size};
use ratatui_image::picker::cap_parser::QueryStdioOptions;
use ratatui_image::picker::{Capability, Picker, ProtocolType};
use ratatui_image::protocol::Protocol;
use ratatui_image::protocol::kitty::Kitty;
use ratatui_image::{Image, Resize};

use super::model::MapChoice;
use nearmiss_render::{Picture, pixels};

/// Ids of the images at kitty, used in turn: the new one is sent while the old one is shown.
const KITTY_IDS: [u32; 2] = [0x6e_6d_01, 0x6e_6d_02];

/// How images are sent to the terminal.
#[derive(Debug, Clone)]
pub struct Encoder {
    picker: Picker,
    /// Whether the terminal takes compressed images: fewer bytes for more work.
    compress: bool,
}

/// The map as it is sent to the terminal.
pub struct MapImage {
    protocol: Protocol,
}

impl std::fmt::Debug for MapImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MapImage")
            .field("size", &self.protocol.size())
            .finish()
    }
}

/// A map to be made an image.
#[derive(Debug)]
pub struct ImageRequest {
    /// What is on it.
    pub picture: Picture,
    /// Its resolution.
    pub dpi: f64,
    /// The cells that it fills.
    pub cells: (u16, u16),
    /// How many there were before: the id at kitty follows from it.
    pub count: u64,
    /// Where it goes.
    pub encoder: Encoder,
}

/// Terminals that show images, by `TERM`, `TERM_PROGRAM` or `LC_TERMINAL`.
const SHOW_IMAGES: [&str; 9] = [
    "kitty", "ghostty", "wezterm", "iterm", "foot", "konsole", "contour", "mlterm", "rio",
];

/// Whether to ask the terminal for images: where they are wanted, or where it is known to show some. Within tmux and
/// screen only where they are wanted, since images have to be let through there.
pub fn is_worth_asking(choice: MapChoice, env: impl Fn(&str) -> Option<String>) -> bool {
    let value = |name: &str| env(name).unwrap_or_default().to_lowercase();
    let names = ["TERM", "TERM_PROGRAM", "LC_TERMINAL"].map(value);
    let is = |known: &str| names.iter().any(|name| name.contains(known));
    let colors = env("NO_COLOR").is_none_or(|set| set.is_empty());
    match choice {
        MapChoice::Pixels => true,
        MapChoice::Auto => {
            let within = is("tmux") || is("screen");
            colors && !within && SHOW_IMAGES.iter().any(|known| is(known))
        }
        MapChoice::Cells | MapChoice::Braille | MapChoice::Ascii => false,
    }
}

impl Encoder {
    /// Asks the terminal what it shows, for at most `patience`; `None` where it shows no images. Nothing else may read
    /// the terminal meanwhile.
    #[must_use]
    pub fn ask(patience: Duration) -> Option<Self> {
        let options = QueryStdioOptions {
            timeout_ms: i32::try_from(patience.as_millis()).unwrap_or(100),
            text_sizing_protocol: false,
            terminal_background_color_osc: false,
            kitty_compression: true,
            ..QueryStdioOptions::default()
        };
        Self::new(Picker::from_query_stdio_with_options(options).ok()?)
    }

    /// Uses what was found out about a terminal; `None` where it shows no images.
    #[must_use]
    pub fn new(picker: Picker) -> Option<Self> {
        let compress = picker
            .capabilities()
            .contains(&Capability::KittyCompression);
        let shows = picker.protocol_type() != ProtocolType::Halfblocks;
        shows.then_some(Self { picker, compress })
    }

    /// As for kitty with cells of so many pixels, without asking a terminal.
    #[must_use]
    pub fn kitty(cell: (u16, u16), compress: bool) -> Self {
        #[expect(deprecated, reason = "no terminal is asked")]
        let mut picker = Picker::from_fontsize(cell.into());
        picker.set_protocol_type(ProtocolType::Kitty);
        Self { picker, compress }
    }

    /// Whether other things can be drawn over an image and taken away again.
    #[must_use]
    pub fn can_be_covered(&self) -> bool {
        self.picker.protocol_type() == ProtocolType::Kitty
    }

    /// How many pixels of the screen one pixel of a picture covers in each direction: kitty enlarges pictures, so while
    /// time passes, a quarter of the pixels is painted and sent.
    #[must_use]
    pub fn coarseness(&self, playing: bool) -> u32 {
        if playing && self.picker.protocol_type() == ProtocolType::Kitty {
            2
        } else {
            1
        }
    }

    /// Width and height of a cell, pixels.
    #[must_use]
    pub fn cell(&self) -> (u32, u32) {
        let size = self.picker.font_size();
        (u32::from(size.width), u32::from(size.height))
    }
}

impl ImageRequest {
    /// Paints the picture and encodes it; takes some milliseconds.
    ///
    /// # Errors
    /// It is too large, or cannot be encoded: in words.
    pub fn run(self) -> Result<MapImage, String> {
        let pixmap = pixels(&self.picture, self.dpi).map_err(|error| error.to_string())?;
        let (width, height) = (pixmap.width(), pixmap.height());
        let image = RgbaImage::from_raw(width, height, pixmap.take());
        let image = DynamicImage::from(image.ok_or("the map has no pixels")?);
        let (columns, rows) = self.cells;
        let size = Size::new(columns, rows);
        let picker = &self.encoder.picker;
        let protocol = match picker.protocol_type() {
            ProtocolType::Kitty => {
                let id = KITTY_IDS[usize::from(!self.count.is_multiple_of(2))];
                let (in_tmux, compress) = (picker.tmux_detected(), self.encoder.compress);
                Kitty::new(image, size, id, in_tmux, compress, false).map(Protocol::Kitty)
            }
            _ => picker.new_protocol(image, size, Resize::Crop(None)),
        };
        let protocol = protocol.map_err(|error| error.to_string())?;
        Ok(MapImage { protocol })
    }
}

impl MapImage {
    /// Whether it fills an area.
    #[must_use]
    pub fn fits(&self, area: Rect) -> bool {
        self.protocol.size() == Size::new(area.width, area.height)
    }

    /// Draws it.
    pub fn draw(&self, f: &mut Frame<'_>, area: Rect) {
        f.render_widget(Image::new(&self.protocol), area);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use base64::Engine;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    use super::*;
    use nearmiss_render::{Color, Stroke};

    /// A picture of 40 × 40 pixels: red above, blue below.
    fn picture() -> Picture {
        let mut picture = Picture::new((40.0, 40.0), Color::rgb(255, 0, 0));
        let below = [(0.0, 20.0), (40.0, 20.0), (40.0, 40.0), (0.0, 40.0)];
        picture.polygon(&below, Some(Color::rgb(0, 0, 255)), None::<Stroke>);
        picture
    }

    /// What is sent to a terminal with cells of 10 × 20 pixels.
    fn sent(protocol: ProtocolType) -> String {
        #[expect(deprecated, reason = "no terminal answers here")]
        let mut picker = Picker::from_fontsize((10, 20).into());
        picker.set_protocol_type(protocol);
        let request = ImageRequest {
            picture: picture(),
            dpi: 72.0,
            cells: (4, 2),
            count: 1,
            encoder: Encoder::new(picker).unwrap(),
        };
        let image = request.run().unwrap();
        let area = Rect::new(0, 0, 4, 2);
        assert!(image.fits(area) && !image.fits(Rect::new(0, 0, 5, 2)));
        let mut terminal = Terminal::new(TestBackend::new(6, 3)).unwrap();
        terminal.draw(|f| image.draw(f, area)).unwrap();
        terminal.backend().buffer()[(0, 0)].symbol().to_string()
    }

    #[test]
    fn kitty_gets_the_pixels_of_the_picture() {
        let sent = sent(ProtocolType::Kitty);
        let mut data = String::new();
        for chunk in sent.split("\x1b_G").skip(1) {
            let body = chunk.split("\x1b\\").next().unwrap();
            let (keys, payload) = body.split_once(';').unwrap();
            if data.is_empty() {
                assert!(
                    keys.contains("s=40") && keys.contains("v=40") && keys.contains("f=32"),
                    "{keys}"
                );
            }
            data.push_str(payload);
        }
        let pixels_sent = base64::engine::general_purpose::STANDARD
            .decode(data)
            .unwrap();
        let rendered = pixels(&picture(), 72.0).unwrap().take();
        assert_eq!(pixels_sent, rendered);
    }

    #[test]
    fn playback_is_coarser_where_the_terminal_enlarges_pictures() {
        let kitty = Encoder::kitty((10, 20), true);
        assert_eq!((kitty.coarseness(true), kitty.coarseness(false)), (2, 1));
        let mut sixel = kitty.clone();
        sixel.picker.set_protocol_type(ProtocolType::Sixel);
        assert_eq!(sixel.coarseness(true), 1);
        let mut images = crate::model::Tools::default().images;
        images.encoder = Some(kitty);
        let mut ask = |dpi| {
            images
                .request(picture(), dpi, (4, 2))
                .map(|asked| asked.run())
        };
        let coarse = ask(36.0).unwrap();
        assert!(ask(72.0).is_none(), "one after the other");
        images.take(coarse).unwrap();
        let sharp = images.request(picture(), 72.0, (4, 2));
        images
            .take(sharp.expect("at rest it is sharp").run())
            .unwrap();
        assert!(images.request(picture(), 72.0, (4, 2)).is_none());
    }

    #[test]
    fn sixel_shows_the_colours_of_the_picture() {
        let sent = sent(ProtocolType::Sixel);
        let body = sent
            .split("\x1bP")
            .nth(1)
            .unwrap()
            .split("\x1b\\")
            .next()
            .unwrap();
        // Raster attributes: 40 × 40 pixels. Colours are percent: 100 is 255.
        assert!(body.contains(";40;40"), "{body}");
        assert!(
            body.contains("2;100;0;0") && body.contains("2;0;0;100"),
            "{body}"
        );
    }

    #[test]
    fn only_terminals_that_are_known_are_asked() {
        let of = |choice, pairs: &[(&str, &str)]| {
            is_worth_asking(choice, |name| {
                let pair = pairs.iter().find(|(n, _)| *n == name);
                pair.map(|(_, value)| (*value).to_string())
            })
        };
        use MapChoice::{Auto, Cells, Pixels};
        assert!(of(Auto, &[("TERM", "xterm-kitty")]));
        assert!(!of(Auto, &[("TERM", "xterm-256color")]));
        assert!(!of(Auto, &[("TERM", "xterm-kitty"), ("NO_COLOR", "1")]));
        assert!(!of(
            Auto,
            &[("TERM", "tmux-256color"), ("LC_TERMINAL", "iTerm2")]
        ));
        assert!(of(Pixels, &[("TERM", "tmux-256color")]));
        assert!(!of(Cells, &[("TERM", "xterm-kitty")]));
    }
}
