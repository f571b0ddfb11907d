//! The map in character cells: the picture sampled finely, and for every cell the character and the two colours that come
//! nearest to it; over these its lines, as dots of Braille.
//!
//! Terminals with few colours get lines of Braille dots with solid bodies; those without Unicode get ASCII.

pub mod choice;
pub mod colors;
mod dots;

use std::ops::Deref;
use std::sync::LazyLock;
use std::sync::mpsc::{Receiver, sync_channel};

use nearmiss_base::geometry::{Pose, Vector};
use nearmiss_settings::Theme;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::symbols::pixel::{OCTANTS, QUADRANTS, SEXTANTS};
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::display::Picture;
use super::raster;
use super::scene::{Role, Viewport};

/// How the map is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapStyle {
    /// Block characters of two colours.
    Cells(Blocks),
    /// Lines of Braille dots, bodies of blocks, no backgrounds.
    Braille,
    /// The same in ASCII.
    Ascii,
}

impl MapStyle {
    /// Whether surfaces have colours, and not lines alone.
    #[must_use]
    pub fn has_backgrounds(self) -> bool {
        matches!(self, Self::Cells(_))
    }

    /// Samples of a cell, columns and rows, that a picture is drawn with.
    #[must_use]
    pub fn samples(self) -> (usize, usize) {
        match self {
            Self::Cells(_) => choice::SAMPLES,
            Self::Braille | Self::Ascii => dots::DOTS,
        }
    }
}

/// How the map is drawn: the style and its colours.
#[derive(Debug, Clone, Copy)]
pub struct Appearance<'a> {
    /// The style.
    pub style: MapStyle,
    /// The colours.
    pub theme: &'a Theme<Color>,
}

impl Appearance<'_> {
    /// Whether the ego has another colour than others; else its body is filled in another way.
    #[must_use]
    pub fn has_colors(&self) -> bool {
        self.theme.ego != Color::Reset
    }

    /// The colour of a role.
    #[must_use]
    pub fn color(&self, role: Role) -> Color {
        role.color(self.theme)
    }
}

impl Role {
    /// Its colour in a theme.
    #[must_use]
    pub fn color<C: Copy>(self, theme: &Theme<C>) -> C {
        match self {
            Self::Ego => theme.ego,
            Self::Obstacle => theme.obstacle,
            Self::Truck => theme.truck,
            Self::Cycle => theme.cycle,
            Self::Pedestrian => theme.pedestrian,
            Self::StaticObstacle => theme.static_obstacle,
            Self::Highlighted(_) => theme.picked,
            Self::Danger => theme.danger,
            Self::Warning => theme.danger_medium,
            Self::Attacker(place) => attacker_color(theme, place),
            Self::Recorded | Self::Rejected => theme.dim,
            Self::RecordedEgo | Self::ConstantVelocity => theme.text,
            Self::Prediction | Self::Tape => theme.accent,
            Self::PredictedBody => theme.predicted,
            Self::Feasible => theme.safe,
        }
    }
}

/// The colour of an attacker at this place among those of a variant: each is unlike the first in every theme.
#[must_use]
pub fn attacker_color<C: Copy>(theme: &Theme<C>, place: usize) -> C {
    let colors = [theme.attacker, theme.text, theme.accent];
    colors[place % colors.len()]
}

/// Where pictures are painted: threads of its own, as a bulk job may have all others.
static PAINTERS: LazyLock<Option<ThreadPool>> = LazyLock::new(|| {
    let count = std::thread::available_parallelism().map_or(1, |n| n.get().min(4));
    ThreadPoolBuilder::new().num_threads(count).build().ok()
});

/// A picture that is painted while others are drawn.
pub struct Painting {
    area: Rect,
    painted: Receiver<Buffer>,
}

impl Painting {
    /// Begins to paint over what is in an area of the buffer, which stays as it is until [`Painting::show`].
    #[must_use]
    pub fn begin(buffer: &Buffer, area: Rect, picture: Picture, look: &Appearance<'_>) -> Self {
        let mut own = Buffer::empty(area);
        copy(buffer, &mut own, area);
        let (style, theme) = (look.style, look.theme.clone());
        let (give, painted) = sync_channel(1);
        let paint = move || {
            let theme = &theme;
            draw(&mut own, area, &picture, &Appearance { style, theme });
            // Who began it may be gone.
            let _ = give.send(own);
        };
        match &*PAINTERS {
            Some(painters) => painters.spawn(paint),
            None => paint(),
        }
        Self { area, painted }
    }

    /// Waits for the picture and shows it.
    pub fn show(self, buffer: &mut Buffer) {
        if let Ok(painted) = self.painted.recv() {
            copy(&painted, buffer, self.area);
        }
    }
}

/// Copies the cells of an area.
fn copy(from: &Buffer, to: &mut Buffer, area: Rect) {
    for position in area.positions() {
        if let (Some(from), Some(to)) = (from.cell(position), to.cell_mut(position)) {
            to.clone_from(from);
        }
    }
}

/// Draws a picture into an area of the buffer, as large as that.
fn draw(buffer: &mut Buffer, area: Rect, picture: &Picture, look: &Appearance<'_>) {
    let (across, down) = look.style.samples();
    let columns = u32::from(area.width) * across as u32;
    let rows = u32::from(area.height) * down as u32;
    match look.style {
        MapStyle::Cells(blocks) => {
            let size = dots::size(area);
            let inks = colors::Inks::of(look.theme.map_road);
            // The fine picture takes as long as all else.
            let (whole, (surfaces, lines)) = rayon::join(
                || {
                    let is_block =
                        |group: &str, stroke: &_| !dots::is_dots(picture, area, group, stroke);
                    raster::stretched(picture, columns, rows, &is_block)
                },
                || {
                    let surfaces = raster::stretched(picture, size.0, size.1, &|_, _| false);
                    (surfaces, dots::dots(picture, area, look.style))
                },
            );
            let Some(whole) = whole else {
                return;
            };
            choice::write(buffer, area, &whole, blocks, inks);
            if let (Some(lines), Some(surfaces)) = (lines, surfaces) {
                dots::write_over(buffer, area, &lines, &surfaces, inks);
            }
        }
        MapStyle::Braille | MapStyle::Ascii => {
            if let Some(pixmap) = dots::dots(picture, area, look.style) {
                dots::write(buffer, area, &pixmap, look);
            }
        }
    }
}

/// Arrows by eighths of a turn, from the right to the left.
const ARROWS: [&str; 8] = ["→", "↗", "↑", "↖", "←", "↙", "↓", "↘"];

/// The arrow along a direction of the canvas.
#[must_use]
pub fn heading_arrow(direction: &Vector) -> &'static str {
    let eighths = direction.y.atan2(direction.x) / std::f64::consts::FRAC_PI_4;
    ARROWS[(eighths.round() as i64).rem_euclid(8).unsigned_abs() as usize % 8]
}

/// What is seen, in character cells; lengths are metres.
#[derive(Debug, Clone, Copy)]
pub struct CellView {
    /// What is seen.
    pub seen: Viewport,
    /// A column and a row.
    pub cell: (f64, f64),
}

impl Deref for CellView {
    type Target = Viewport;

    fn deref(&self) -> &Viewport {
        &self.seen
    }
}

impl CellView {
    /// The view around a frame; `half` is half its width and height, `cell` a column and a row.
    #[must_use]
    pub fn new(frame: Pose, half: (f64, f64), cell: (f64, f64)) -> Self {
        Self {
            seen: Viewport::new(frame, half),
            cell,
        }
    }
}

/// How finely a character divides its cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blocks {
    /// 2 × 2, which every font has.
    Quadrants,
    /// 2 × 3, Unicode 13.
    Sextants,
    /// 2 × 4, Unicode 16.
    Octants,
}

impl Blocks {
    /// All with their names in the configuration.
    pub const NAMED: [(&str, Self); 3] = [
        ("quadrants", Self::Quadrants),
        ("sextants", Self::Sextants),
        ("octants", Self::Octants),
    ];

    /// What the terminal draws itself, whatever the font has: by `TERM` and `TERM_PROGRAM`. Within tmux and screen the
    /// outer terminal is not known, so quadrants are used.
    #[must_use]
    pub fn of_environment(env: impl Fn(&str) -> Option<String>) -> Self {
        let value = |name: &str| env(name).unwrap_or_default().to_lowercase();
        let (term, program) = (value("TERM"), value("TERM_PROGRAM"));
        let is = |names: &[&str]| {
            let said = |name: &&str| term.contains(*name) || program.contains(*name);
            names.iter().any(said)
        };
        if is(&["tmux", "screen"]) {
            return Self::Quadrants;
        }
        // Ghostty draws octants since its first release.
        if is(&["ghostty"]) {
            return Self::Octants;
        }
        let vte = value("VTE_VERSION").parse::<u32>().unwrap_or(0);
        let known = is(&["kitty", "foot", "wezterm", "alacritty", "contour", "iterm"]);
        // VTE (GNOME Terminal and others) draws sextants since 0.62, Windows Terminal since 1.22, which WT_SESSION does
        // not tell.
        if known || vte >= 6200 {
            Self::Sextants
        } else {
            Self::Quadrants
        }
    }

    /// Columns and rows of a cell.
    #[must_use]
    pub fn per_cell(self) -> (usize, usize) {
        match self {
            Self::Quadrants => (2, 2),
            Self::Sextants => (2, 3),
            Self::Octants => (2, 4),
        }
    }

    /// Which parts of its cell a character fills: a bit each, row by row; `None` for one that is no block.
    #[must_use]
    pub fn of_symbol(symbol: char) -> Option<(Self, usize)> {
        let mut named = Self::NAMED.into_iter();
        named.find_map(|(_, blocks)| {
            let parts = blocks.symbols().iter().position(|c| *c == symbol)?;
            (parts > 0).then_some((blocks, parts))
        })
    }

    fn symbols(self) -> &'static [char] {
        match self {
            Self::Quadrants => &QUADRANTS,
            Self::Sextants => &SEXTANTS,
            Self::Octants => &OCTANTS,
        }
    }

    /// The character in which these parts are filled: a bit each, row by row.
    #[must_use]
    pub fn symbol(self, parts: usize) -> char {
        self.symbols().get(parts).copied().unwrap_or('█')
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod block_tests {
    use super::*;

    #[test]
    fn characters_by_their_parts() {
        assert_eq!(Blocks::Quadrants.symbol(0b0101), '▌');
        assert_eq!(Blocks::Sextants.symbol(0b01_0101), '▌');
        assert_eq!(Blocks::Octants.symbol(0b0000_1111), '▀');
        assert_eq!(Blocks::of_symbol('▚'), Some((Blocks::Quadrants, 0b1001)));
        assert_eq!(Blocks::of_symbol('a').or(Blocks::of_symbol(' ')), None);
        for (_, blocks) in Blocks::NAMED {
            let (across, down) = blocks.per_cell();
            let full = (1 << (across * down)) - 1;
            assert_eq!((blocks.symbol(0), blocks.symbol(full)), (' ', '█'));
            // Every character is read as what it fills, by the coarsest division that has it.
            for parts in 1..=full {
                let symbol = blocks.symbol(parts);
                let read = Blocks::of_symbol(symbol).map(|(read, parts)| read.symbol(parts));
                assert_eq!(read, Some(symbol));
            }
        }
    }

    #[test]
    fn the_terminal_says_what_it_draws() {
        let of = |pairs: &[(&str, &str)]| {
            Blocks::of_environment(|name| {
                let pair = pairs.iter().find(|(n, _)| *n == name);
                pair.map(|(_, value)| (*value).to_string())
            })
        };
        assert_eq!(of(&[("TERM", "xterm-256color")]), Blocks::Quadrants);
        assert_eq!(of(&[("TERM", "xterm-kitty")]), Blocks::Sextants);
        assert_eq!(of(&[("TERM_PROGRAM", "ghostty")]), Blocks::Octants);
        let vte = [("TERM", "xterm-256color"), ("VTE_VERSION", "7600")];
        assert_eq!(of(&vte), Blocks::Sextants);
        let tmux = [("TERM", "tmux-256color"), ("VTE_VERSION", "7600")];
        assert_eq!(of(&tmux), Blocks::Quadrants);
    }
}
