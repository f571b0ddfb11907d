//! The map of a figure: a scene's roads, traffic and marks as paths on a page, and names beside the bodies.

mod bodies;
mod contact;
mod furniture;
mod labels;
mod overlays;
mod posts;
mod regions;
mod road;

use super::Color;
use super::display::{Area, Picture, Spot, Stroke};
use super::palette::Palette;
use super::scene::{MapScene, Overlay, Role};
use super::view::View;
use nearmiss_base::geometry::Point;

/// What a map shows.
pub struct Map<'a> {
    /// What is drawn.
    pub scene: MapScene<'a>,
    /// The time that is shown, seconds.
    pub seconds: f64,
    /// Seconds of a time step.
    pub dt: f64,
    /// The place of each of a variant's attackers among the obstacles that are pointed out.
    pub attackers: Vec<Option<usize>>,
    /// Its colours.
    pub palette: &'a Palette,
    /// How the world lies on the page.
    pub view: View,
    /// Size of the letters, points.
    pub letters: f64,
    /// Whether it has a scale bar.
    pub scale_bar: bool,
    /// What stands on it in place of the time and of north: it is a panel of a storyboard.
    pub title: Option<String>,
}

impl Map<'_> {
    /// Draws it.
    pub fn draw(&self, picture: &mut Picture) {
        let area = self.view.area;
        let clip = Some(area);
        picture.group("map", clip, |p| {
            road::draw(self, p);
            p.group("goals", None, |p| regions::goals(self, p));
            if !self.scene.underlays.is_empty() {
                p.group("underlays", None, |p| {
                    overlays::draw(self, p, &self.scene.underlays)
                });
            }
            p.group("signs", None, |p| posts::draw(self, p));
            p.group("regions", None, |p| regions::draw(self, p));
            p.group("trails", None, |p| bodies::trails(self, p));
            let variation = self.scene.overlays.iter().chain(&self.scene.variation);
            let variation: Vec<Overlay> = variation.cloned().collect();
            p.group("variation", None, |p| overlays::draw(self, p, &variation));
            p.group("obstacles", None, |p| {
                let bodies = self.scene.bodies.iter();
                bodies.for_each(|body| bodies::draw(self, p, body));
            });
            p.group("ego", None, |p| {
                let ego = self.scene.ego.iter();
                ego.for_each(|body| bodies::draw(self, p, body));
            });
        });
        let mut taken = Vec::new();
        picture.group("furniture", clip, |p| taken = furniture::draw(self, p));
        let mut contacts = Vec::new();
        picture.group("contact", clip, |p| contacts = contact::draw(self, p));
        picture.group("labels", clip, |p| labels::draw(self, p, &taken, &contacts));
        if !self.scene.top.is_empty() {
            picture.group("top", clip, |p| overlays::draw(self, p, &self.scene.top));
        }
        picture.rectangle(&area, None, Some(Stroke::new(self.palette.dim, 0.5)));
    }

    /// The colour of a role.
    fn color(&self, role: Role) -> Color {
        let palette = self.palette;
        match role {
            Role::Ego => palette.ego,
            Role::Obstacle | Role::Truck | Role::Cycle | Role::Pedestrian | Role::PredictedBody => {
                palette.obstacle
            }
            Role::StaticObstacle => palette.static_obstacle,
            Role::Highlighted(place) => palette.emphasised(place),
            Role::Attacker(among) => { self.attackers[..].get(among).copied().flatten() }
                .map_or(palette.text, |place| palette.emphasised(place)),
            Role::Danger | Role::Warning => palette.danger,
            Role::Recorded | Role::Rejected => palette.dim,
            Role::RecordedEgo | Role::ConstantVelocity => palette.text,
            Role::Feasible => palette.goal,
            Role::Prediction | Role::Tape => palette.accent,
        }
    }

    /// The colour of something of an obstacle that may be pointed out.
    fn color_of(&self, highlighted: Option<usize>, otherwise: Color) -> Color {
        highlighted.map_or(otherwise, |place| self.palette.emphasised(place))
    }

    /// A length on the page, points.
    fn points(&self, metres: f64) -> f64 {
        metres * self.view.scale
    }

    /// Outlines on the page.
    fn rings(&self, rings: &[Vec<Point>]) -> Vec<Vec<Spot>> {
        rings.iter().map(|ring| self.view.all(ring)).collect()
    }

    /// Whether an area is on the map.
    fn shows(&self, area: &Area) -> bool {
        self.view.area.meets(area)
    }
}
