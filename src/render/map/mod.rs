//! The map: the road, goals, trails, bodies of real size, and names beside them.

mod bodies;
mod contact;
mod furniture;
mod labels;
mod posts;
mod regions;
mod road;
mod variation;

use super::display::{Area, Picture, Stroke};
use super::palette::Palette;
use super::view::{Subject, Variation, View};

/// What a map shows.
pub struct Map<'a> {
    /// What is drawn.
    pub subject: Subject<'a>,
    /// Both motions of a variant's attacker, where they are known.
    pub variation: Option<Variation<'a>>,
    /// The time step.
    pub step: i64,
    /// Obstacles that are pointed out.
    pub emphasised: &'a [i64],
    /// Its colours.
    pub palette: &'a Palette,
    /// How the world lies on the page.
    pub view: View,
    /// Size of the letters, points.
    pub letters: f64,
}

impl Map<'_> {
    /// Draws it.
    pub fn draw(&self, picture: &mut Picture) {
        let area = self.view.area;
        let clip = Some(area);
        picture.group("map", clip, |p| {
            road::draw(self, p);
            p.group("goals", None, |p| regions::goals(self, p));
            p.group("signs", None, |p| posts::draw(self, p));
            p.group("regions", None, |p| regions::draw(self, p));
            p.group("trails", None, |p| bodies::trails(self, p));
            if self.variation.is_some() {
                p.group("variation", None, |p| {
                    variation::ways(self, p);
                    variation::body(self, p);
                });
            }
            p.group("obstacles", None, |p| bodies::obstacles(self, p));
            p.group("ego", None, |p| bodies::ego(self, p));
        });
        let mut taken = Vec::new();
        picture.group("furniture", clip, |p| taken = furniture::draw(self, p));
        let mut contacts = Vec::new();
        picture.group("contact", clip, |p| contacts = contact::draw(self, p));
        picture.group("labels", clip, |p| labels::draw(self, p, &taken, &contacts));
        picture.rectangle(&area, None, Some(Stroke::new(self.palette.dim, 0.5)));
    }

    /// The place of an obstacle among those that are pointed out.
    fn emphasis(&self, id: i64) -> Option<usize> {
        self.emphasised.iter().position(|&e| e == id)
    }

    /// A length on the page, points.
    fn points(&self, metres: f64) -> f64 {
        metres * self.view.scale
    }

    /// Whether an area is on the map.
    fn shows(&self, area: &Area) -> bool {
        self.view.area.meets(area)
    }
}
