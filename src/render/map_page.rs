//! A map alone on a page of any size, for screens that show images.

use super::display::{Area, Picture};
use super::map::Map;
use super::palette::Palette;
use super::scene::{MapRequest, MapScene, Viewport};
use super::view::View;
use nearmiss_base::geometry::Pose;

/// Size of the letters, points.
const LETTERS: f64 = 8.0;

/// A page that a map fills.
#[derive(Debug, Clone, Copy)]
pub struct MapPage {
    /// Width and height, pixels.
    pub pixels: (u32, u32),
    /// Height of a line of text beside the map, pixels: its letters are about as large.
    pub line: f64,
    /// What is in the middle, and the direction that is up.
    pub frame: Pose,
    /// Metres from left to right.
    pub width: f64,
}

impl MapPage {
    /// Pixels of a point.
    #[must_use]
    pub fn scale(&self) -> f64 {
        (self.line * 0.6 / LETTERS).max(0.5)
    }

    /// Dots per inch at which the page has its size in pixels.
    #[must_use]
    pub fn dpi(&self) -> f64 {
        72.0 * self.scale()
    }

    fn view(&self) -> View {
        let points = |pixels: u32| f64::from(pixels) / self.scale();
        let area = Area {
            x: 0.0,
            y: 0.0,
            width: points(self.pixels.0),
            height: points(self.pixels.1),
        };
        View {
            frame: self.frame,
            scale: area.width / self.width,
            area,
        }
    }

    /// The part of the world that is seen.
    #[must_use]
    pub fn viewport(&self) -> Viewport {
        self.view().viewport()
    }

    /// Draws the scene that was made for [`MapPage::viewport`].
    #[must_use]
    pub fn draw(
        &self,
        request: &MapRequest<'_>,
        scene: MapScene<'_>,
        palette: &Palette,
    ) -> Picture {
        let view = self.view();
        let dt = request.subject.scenario.dt();
        let attackers = request.variations.iter().map(|both| both.changed.id);
        let place = |id: i64| request.highlighted.iter().position(|&e| e == id);
        let map = Map {
            scene,
            seconds: request.step as f64 * dt,
            dt,
            attackers: attackers.map(place).collect(),
            palette,
            view,
            letters: LETTERS,
            scale_bar: true,
            title: None,
        };
        let mut picture = Picture::new((view.area.width, view.area.height), palette.background);
        map.draw(&mut picture);
        picture
    }
}
