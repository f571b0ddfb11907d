//! The map of the workbench: in all colours of its theme, bodies with windscreens and lamps, what is not a body quieter.

use nearmiss_scene::scenario::Signal;
use nearmiss_settings::Theme;

use super::{Map, spots};
use crate::Color;
use crate::display::{Area, Picture, Spot, Stroke};
use crate::scene::{Body, Contact, Owner, Trail};

/// How a map is drawn in the workbench.
#[derive(Debug, Clone, Copy)]
pub struct WorkbenchMap<'a> {
    /// The colours.
    pub theme: &'a Theme<Color>,
    /// Whether surfaces have colours, and not lines alone.
    pub filled: bool,
    /// Whether lanes have their markings, or borders alone.
    pub markings: bool,
    /// Metres a character is wide; 0 for an image. On a map of characters the caller writes words, and an arrow in place
    /// of what is too small.
    pub cell: f64,
}

/// Seconds ahead that the line at the front of a body shows.
const VELOCITY: f64 = 0.5;
/// Slower than this, m/s, a body has no such line.
const STANDING: f64 = 0.3;
/// The windscreen, in parts of the length from the rear.
const SCREEN: (f64, f64) = (0.62, 0.8);
/// How dark it is: the part of the way from the body's colour to the ground's.
const GLASS: f64 = 0.4;
/// Lamps: how long and how wide they are, in parts of the body, and the least, metres.
const LAMP: (f64, f64, f64) = (0.1, 0.3, 0.4);
/// Characters along a body that has room for a windscreen.
const ROOM: f64 = 3.0;

impl WorkbenchMap<'_> {
    /// Where everybody was and goes, and how fast.
    pub(super) fn trails(&self, map: &Map<'_>, picture: &mut Picture) {
        let trails = map.scene.trails.iter();
        trails.for_each(|trail| self.way(map, picture, trail));
        let all = map.scene.bodies.iter().chain(&map.scene.ego);
        all.for_each(|body| self.velocity(map, picture, body));
    }

    /// A fine line where a body was, dashes where it goes.
    fn way(&self, map: &Map<'_>, picture: &mut Picture, trail: &Trail<'_>) {
        let color = match trail.owner {
            Owner::Ego => self.theme.ego_trail,
            Owner::Obstacle(_) => self.theme.trail,
        };
        picture.line(&spots(map, trail.past), Stroke::new(color, 0.9));
        let ahead = Stroke::new(color.at(0.7), 0.8).dashed(&[4.0, 4.0]);
        picture.line(&spots(map, trail.future), ahead);
    }

    /// A line from the front of the ego, of those who are pointed out and of those with trails, as long as the way of the next
    /// half second.
    fn velocity(&self, map: &Map<'_>, picture: &mut Picture, body: &Body<'_>) {
        let motion = body.motion;
        let mut trails = map.scene.trails.iter();
        let has_trail = trails.any(|trail| trail.owner == body.owner);
        if !(has_trail || body.highlighted.is_some()) || motion.velocity.abs() <= STANDING {
            return;
        }
        let color = match body.owner {
            Owner::Ego => self.theme.ego,
            Owner::Obstacle(_) => self.theme.static_obstacle,
        };
        let (rear, front) = body.along;
        let nose = body.point(if motion.velocity > 0.0 { front } else { rear }, 0.0);
        let end = nose + motion.velocity_vector() * VELOCITY;
        picture.line(
            &map.view.all([&nose, &end]),
            Stroke::new(color.at(0.7), 0.9),
        );
    }

    /// A body with a windscreen, and lamps that are on.
    pub(super) fn body(
        &self,
        map: &Map<'_>,
        picture: &mut Picture,
        body: &Body<'_>,
        rings: &[Vec<Spot>],
    ) {
        if body.is_tiny(self.cell) {
            return;
        }
        let color = map.color(body.role);
        for ring in rings {
            picture.polygon(ring, Some(color), None);
        }
        if !body.has_front || body.length() < ROOM * self.cell {
            return;
        }
        let (rear, front) = body.along;
        let (right, left) = body.across;
        let mut band = |ahead: (f64, f64), aside: (f64, f64), color| {
            let corners = [
                (ahead.0, aside.0),
                (ahead.1, aside.0),
                (ahead.1, aside.1),
                (ahead.0, aside.1),
            ];
            let corners = corners.map(|(ahead, left)| map.view.at(&body.point(ahead, left)));
            picture.polygon(&corners, Some(color), None);
        };
        let is_box = rings.iter().all(|ring| ring.len() == 4);
        if self.filled && !body.stands && is_box {
            let glass = color.towards(self.theme.map_ground, GLASS);
            let inset = 0.1 * (left - right);
            let screen = (body.part(SCREEN.0), body.part(SCREEN.1));
            band(screen, (right + inset, left - inset), glass);
        }
        let Some(signals) = body.signals else { return };
        let on = |signal: Signal| signals.signals.contains(&(signal, true));
        let (length, width) = (
            (LAMP.0 * (front - rear)).max(LAMP.2),
            (LAMP.1 * (left - right)).max(LAMP.2),
        );
        if on(Signal::BrakingLights) {
            band((rear, rear + length), (right, left), self.theme.brake_light);
        }
        let hazard = on(Signal::HazardWarningLights);
        let sides = [
            (Signal::IndicatorLeft, (left - width, left)),
            (Signal::IndicatorRight, (right, right + width)),
        ];
        for (_, side) in sides
            .into_iter()
            .filter(|(signal, _)| hazard || on(*signal))
        {
            band((rear, rear + length), side, self.theme.indicator);
            band((front - length, front), side, self.theme.indicator);
        }
    }

    /// What both bodies of a contact cover.
    pub(super) fn overlap(
        &self,
        map: &Map<'_>,
        picture: &mut Picture,
        contact: &Contact,
    ) -> Option<Area> {
        let ring = map.view.all(&contact.overlap);
        let edge = Stroke::new(self.theme.danger, 1.6).rounded();
        picture.polygon(&ring, Some(self.theme.text), Some(edge));
        Area::around(&ring)
    }
}
