//! The map as an image, for terminals that say that they show images (kitty, sixel, iTerm2).

mod kitty;
mod support;

use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ratatui::Frame;
use ratatui::buffer::CellDiffOption;
use ratatui::layout::Rect;

use super::model::MapChoice;
use nearmiss_render::{Picture, pixels, png, sixel};

/// Ids of the images at kitty, used in turn: the new one is sent while the old one is shown.
const KITTY_IDS: [u32; 2] = [0x6e_6d_01, 0x6e_6d_02];

/// In which form a terminal takes images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Protocol {
    Kitty {
        /// Whether it takes compressed images: fewer bytes for more work.
        compress: bool,
    },
    Sixel,
    Iterm,
}

/// How images are sent to the terminal.
#[derive(Debug, Clone)]
pub struct Encoder {
    protocol: Protocol,
    /// Width and height of a cell, pixels.
    cell: (u16, u16),
    /// Whether tmux stands between.
    in_tmux: bool,
}

/// The map as it is sent to the terminal.
#[derive(Debug)]
pub struct MapImage {
    cells: (u16, u16),
    /// What sends it.
    sequences: String,
    /// Its id at kitty, where it is sent once and then shown by placeholders.
    kitty: Option<u32>,
    is_sent: AtomicBool,
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
    /// Asks the terminal what it shows, for at most `patience`; `None` where it shows no images. `answers` gives what it
    /// answers to a question.
    #[must_use]
    pub fn ask(
        answers: impl FnOnce(&str, Duration) -> Option<String>,
        patience: Duration,
        env: impl Fn(&str) -> Option<String>,
    ) -> Option<Self> {
        let environment = support::Environment::read(env);
        if environment.in_tmux {
            let _ = Command::new("tmux")
                .args(["set", "-p", "allow-passthrough", "on"])
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .status();
        }
        environment.encoder(&answers(&environment.question(), patience)?)
    }

    /// As for kitty with cells of so many pixels, without asking a terminal.
    #[must_use]
    pub fn kitty(cell: (u16, u16), compress: bool) -> Self {
        Self {
            protocol: Protocol::Kitty { compress },
            cell,
            in_tmux: false,
        }
    }

    fn is_kitty(&self) -> bool {
        matches!(self.protocol, Protocol::Kitty { .. })
    }

    /// Whether other things can be drawn over an image and taken away again.
    #[must_use]
    pub fn can_be_covered(&self) -> bool {
        self.is_kitty()
    }

    /// How many pixels of the screen one pixel of a picture covers in each direction: kitty enlarges pictures, so while
    /// time passes, a quarter of the pixels is painted and sent.
    #[must_use]
    pub fn coarseness(&self, playing: bool) -> u32 {
        if playing && self.is_kitty() { 2 } else { 1 }
    }

    /// Width and height of a cell, pixels.
    #[must_use]
    pub fn cell(&self) -> (u32, u32) {
        (u32::from(self.cell.0), u32::from(self.cell.1))
    }
}

impl ImageRequest {
    /// Paints the picture and encodes it; takes some milliseconds.
    ///
    /// # Errors
    /// It is too large, or cannot be encoded: in words.
    pub fn run(self) -> Result<MapImage, String> {
        let (picture, dpi) = (&self.picture, self.dpi);
        let id = KITTY_IDS[usize::from(!self.count.is_multiple_of(2))];
        let encoded = match self.encoder.protocol {
            Protocol::Kitty { compress } => pixels(picture, dpi).map(|pixmap| {
                kitty::sequences(pixmap.data(), pixmap.width(), self.cells, id, compress)
            }),
            Protocol::Sixel => sixel(picture, dpi).map(|sixels| vec![erase(self.cells) + &sixels]),
            Protocol::Iterm => {
                png(picture, dpi).map(|file| vec![erase(self.cells) + &iterm(&file, self.cells)])
            }
        };
        let sequences = encoded.map_err(|error| error.to_string())?;
        let passed = sequences.iter().map(|s| passed(s, self.encoder.in_tmux));
        Ok(MapImage {
            cells: self.cells,
            sequences: passed.collect(),
            kitty: self.encoder.is_kitty().then_some(id),
            is_sent: AtomicBool::new(false),
        })
    }
}

/// A sequence as it reaches the terminal: tmux passes on what is wrapped for it.
fn passed(sequence: &str, in_tmux: bool) -> String {
    if in_tmux {
        format!("\x1bPtmux;{}\x1b\\", sequence.replace('\x1b', "\x1b\x1b"))
    } else {
        sequence.into()
    }
}

/// Erases cells, from the cursor on to the right and down, as what stood there would show where it is not drawn anew.
fn erase((columns, rows): (u16, u16)) -> String {
    let lines = vec![format!("\x1b[{columns}X"); usize::from(rows)];
    match rows {
        0 | 1 => lines.concat(),
        _ => format!("{}\x1b[{}A", lines.join("\x1b[1B"), rows - 1),
    }
}

/// A PNG file as an inline image of iTerm2, over so many columns and rows.
fn iterm(png: &[u8], (columns, rows): (u16, u16)) -> String {
    let size = png.len();
    let mut sequence = format!(
        "\x1b]1337;File=inline=1;size={size};width={columns};height={rows};preserveAspectRatio=0;doNotMoveCursor=1:"
    );
    STANDARD.encode_string(png, &mut sequence);
    sequence + "\x07"
}

impl MapImage {
    /// Whether it fills an area.
    #[must_use]
    pub fn fits(&self, area: Rect) -> bool {
        self.cells == (area.width, area.height)
    }

    /// Draws it.
    pub fn draw(&self, f: &mut Frame<'_>, area: Rect) {
        let buffer = f.buffer_mut();
        if let Some(id) = self.kitty {
            let is_sent = self.is_sent.swap(true, Ordering::Relaxed);
            let send = (!is_sent).then_some(self.sequences.as_str());
            kitty::place(buffer, area, id, send);
            return;
        }
        // The first cell paints all; the others are left alone.
        for position in area.positions() {
            if let Some(cell) = buffer.cell_mut(position) {
                cell.set_diff_option(CellDiffOption::Skip);
            }
        }
        if let Some(cell) = buffer.cell_mut(area.as_position()) {
            cell.set_symbol(&self.sequences)
                .set_diff_option(kitty::ONE_COLUMN);
        }
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
    fn sent(protocol: Protocol) -> String {
        let request = ImageRequest {
            picture: picture(),
            dpi: 72.0,
            cells: (4, 2),
            count: 1,
            encoder: Encoder {
                protocol,
                cell: (10, 20),
                in_tmux: false,
            },
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
        let sent = sent(Protocol::Kitty { compress: false });
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
        sixel.protocol = Protocol::Sixel;
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
        let sent = sent(Protocol::Sixel);
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
    fn iterm_gets_the_picture_as_a_file() {
        let sent = sent(Protocol::Iterm);
        let (erased, file) = sent.split_once("\x1b]1337;File=").unwrap();
        assert_eq!(erased, "\x1b[4X\x1b[1B\x1b[4X\x1b[1A");
        let (keys, data) = file.strip_suffix('\x07').unwrap().split_once(':').unwrap();
        assert!(
            keys.contains("inline=1") && keys.contains("width=4;height=2"),
            "{keys}"
        );
        let data = base64::engine::general_purpose::STANDARD.decode(data);
        assert_eq!(data.unwrap(), png(&picture(), 72.0).unwrap());
    }

    #[test]
    fn an_image_at_kitty_is_sent_once_and_then_shown() {
        let encoder = Encoder::kitty((10, 20), true);
        let request = ImageRequest {
            picture: picture(),
            dpi: 72.0,
            cells: (4, 2),
            count: 1,
            encoder: Encoder {
                in_tmux: true,
                ..encoder
            },
        };
        let image = request.run().unwrap();
        let mut terminal = Terminal::new(TestBackend::new(4, 2)).unwrap();
        let mut drawn = || {
            terminal.draw(|f| image.draw(f, f.area())).unwrap();
            terminal.backend().buffer()[(0, 0)].symbol().to_string()
        };
        assert!(drawn().starts_with("\x1bPtmux;\x1b\x1b_Gq=2,"));
        assert!(drawn().starts_with('\u{10eeee}'));
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
