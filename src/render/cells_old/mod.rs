//! The map in character cells: filled areas with background colours, fine lines of Braille dots over them.
//!
//! Terminals with few colours get Braille lines with solid bodies; those without Unicode get ASCII.

mod bodies;
mod canvas;
pub mod compose;
mod road;
mod silhouette;

use std::ops::Deref;

use nearmiss_base::geometry::{Bounds, Point, Pose, Vector, part_within};
use nearmiss_settings::Theme;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Color;

use self::canvas::Canvas;
use super::scene::{MapScene, Role};
use crate::scene::Viewport;

pub use bodies::{Heading, heading_arrow};
pub use canvas::CROSSES;
pub use compose::Blocks;

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
    road::fixed(c, look, scene, view);
    road::markings(c, look, scene, view);
    road::draw_overlays(c, look, &scene.underlays, view);
    c.layer();
    road::occupancies(c, look, scene, view);
    bodies::draw_trails(c, look, scene, view);
    bodies::velocities(c, look, scene, view);
    road::draw_overlays(c, look, &scene.overlays, view);
    road::draw_overlays(c, look, &scene.variation, view);
    c.layer();
    bodies::draw(c, look, scene, view);
    c.layer();
    road::draw_overlays(c, look, &scene.top, view);
    canvas.paint(buffer, area);
}

/// What is seen, in character cells; lengths are metres.
#[derive(Debug, Clone, Copy)]
pub struct CellView {
    /// What is seen.
    pub seen: Viewport,
    /// A column and a row.
    pub cell: (f64, f64),
    /// From one Braille dot to the next, where they are farther apart.
    pub dot: f64,
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
            dot: (cell.0 / 2.0).max(cell.1 / 4.0),
        }
    }

    /// Metres of a part of a block character, the longer way.
    #[must_use]
    pub fn block(&self, style: MapStyle) -> f64 {
        let (across, down) = style.blocks().per_cell();
        (self.cell.0 / across as f64).max(self.cell.1 / down as f64)
    }

    /// The part of a line on the canvas that may be seen, from 0 (its beginning) to 1; with some dots around the map.
    #[must_use]
    pub fn part_seen(&self, from: (f64, f64), to: (f64, f64)) -> Option<(f64, f64)> {
        let half = Vector::new(self.half.0 + 2.0 * self.dot, self.half.1 + 2.0 * self.dot);
        let bounds = Bounds {
            min: Point::from(-half),
            max: Point::from(half),
        };
        part_within(
            &Point::new(from.0, from.1),
            &Point::new(to.0, to.1),
            &bounds,
        )
    }
}



