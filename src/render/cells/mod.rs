//! The map in character cells: the same picture as an image of it, sampled finely, and for every cell the character and
//! the two colours that come nearest to it.
//!
//! Terminals with few colours get lines of Braille dots with solid bodies; those without Unicode get ASCII.

mod blocks;
pub mod choice;
pub mod colors;
mod dots;

use std::ops::Deref;

use nearmiss_base::geometry::{Pose, Vector};
use nearmiss_settings::Theme;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;

use super::display::Picture;
use super::raster;
use super::scene::{Role, Viewport};

pub use blocks::Blocks;

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

/// Draws a picture into an area of the buffer, as large as that.
pub fn draw(buffer: &mut Buffer, area: Rect, picture: &Picture, look: &Appearance<'_>) {
    let (across, down) = look.style.samples();
    let columns = u32::from(area.width) * across as u32;
    let rows = u32::from(area.height) * down as u32;
    match look.style {
        MapStyle::Cells(blocks) => {
            if let Some(pixmap) = raster::stretched(picture, columns, rows) {
                let inks = colors::Inks::of(look.theme.map_road);
                choice::write(buffer, area, &pixmap, blocks, inks);
            }
        }
        MapStyle::Braille | MapStyle::Ascii => {
            if let Some(pixmap) = dots::dots(picture, columns, rows) {
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

#[cfg(test)]
mod tests;
