//! The map in character cells: filled areas with background colours, fine lines of Braille dots over them.
//!
//! Terminals with few colours get Braille lines with solid bodies; those without Unicode get ASCII.

mod blocks;
mod bodies;
mod canvas;
pub mod color;
mod compose;
mod lines;
mod overlays;
mod regions;
mod road;
mod silhouette;
#[cfg(test)]
mod tests;
mod trails;
mod view;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;

use self::canvas::Canvas;
use super::scene::{MapScene, Role};
use nearmiss_settings::Theme;

pub use blocks::Blocks;
pub use bodies::{Heading, heading_arrow};
pub use lines::CROSSES;
pub use view::CellView;

/// How the map is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapStyle {
    /// Areas with background colours, of these characters.
    Cells(Blocks),
    /// Lines of Braille dots, bodies of blocks, no backgrounds.
    Braille,
    /// The same in ASCII.
    Ascii,
}

impl MapStyle {
    /// Whether the road has a colour of its own behind what is on it.
    #[must_use]
    pub fn has_backgrounds(self) -> bool {
        matches!(self, Self::Cells(_))
    }

    fn blocks(self) -> Blocks {
        match self {
            Self::Cells(blocks) => blocks,
            Self::Braille | Self::Ascii => Blocks::Quadrants,
        }
    }
}

/// How the painters draw: the style, its colours, and whether lanes have their markings.
#[derive(Debug, Clone, Copy)]
pub struct Appearance<'a> {
    /// The style.
    pub style: MapStyle,
    /// The colours.
    pub theme: &'a Theme<Color>,
    /// Whether lane markings are drawn, or borders alone.
    pub markings: bool,
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
        let theme = self.theme;
        match role {
            Role::Ego => theme.ego,
            Role::Obstacle => theme.obstacle,
            Role::Truck => theme.truck,
            Role::Cycle => theme.cycle,
            Role::Pedestrian => theme.pedestrian,
            Role::StaticObstacle => theme.static_obstacle,
            Role::Highlighted(_) => theme.picked,
            Role::Danger => theme.danger,
            Role::Warning => theme.danger_medium,
            Role::Attacker(place) => attacker_color(theme, place),
            Role::Recorded | Role::Rejected => theme.dim,
            Role::RecordedEgo | Role::ConstantVelocity => theme.text,
            Role::Prediction | Role::Tape => theme.accent,
            Role::PredictedBody => theme.predicted,
            Role::Feasible => theme.safe,
        }
    }
}

/// The colour of an attacker at this place among those of a variant: each is unlike the first in every theme.
#[must_use]
pub fn attacker_color(theme: &Theme<Color>, place: usize) -> Color {
    let colors = [theme.attacker, theme.text, theme.accent];
    colors[place % colors.len()]
}

/// Draws a scene into an area of the buffer.
pub fn draw(
    buffer: &mut Buffer,
    area: Rect,
    scene: &MapScene<'_>,
    view: &CellView,
    look: &Appearance<'_>,
) {
    let mut canvas = Canvas::new(view, area, look.style, look.theme.map_ground);
    let c = &mut canvas;
    road::surfaces(c, look, scene, view);
    regions::fixed(c, look, scene, view);
    road::markings(c, look, scene, view);
    overlays::draw(c, look, &scene.underlays, view);
    c.layer();
    regions::occupancies(c, look, scene, view);
    trails::draw(c, look, scene, view);
    bodies::velocities(c, look, scene, view);
    overlays::draw(c, look, &scene.overlays, view);
    overlays::draw(c, look, &scene.variation, view);
    c.layer();
    bodies::draw(c, look, scene, view);
    c.layer();
    overlays::draw(c, look, &scene.top, view);
    canvas.paint(buffer, area);
}
