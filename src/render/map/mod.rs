//! The map of a figure: a scene's roads, traffic and marks as paths on a page, and names beside the bodies.

mod labels;
mod road;

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{Motion, Signal};
use nearmiss_settings::Theme;

use super::Color;
use super::display::{Area, Picture, Spot, Stroke};
use super::palette::Palette;
use super::scene::{
    Body, Contact, GoalArea, LineStyle, MapScene, Outline, Overlay, Owner, RegionKind, Role, Trail,
};
use super::view::View;

/// What a map shows.
pub struct Map<'a> {
    /// What is drawn.
    pub scene: &'a MapScene<'a>,
    /// The time that is shown, seconds.
    pub seconds: f64,
    /// Seconds of a time step.
    pub dt: f64,
    /// The place of each of a variant's attackers among the obstacles that are pointed out.
    pub attackers: Vec<Option<usize>>,
    /// Its colours.
    pub palette: &'a Palette,
    /// How it is drawn in the workbench; `None` for figures.
    pub workbench: Option<WorkbenchMap<'a>>,
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
        if self.workbench.is_some_and(|look| look.cell > 0.0) {
            self.draw_scene(picture);
            picture.group("contact", None, |p| drop(draw_contact(self, p)));
            return picture.group("top", None, |p| draw_overlays(self, p, &self.scene.top));
        }
        let area = self.view.area;
        let clip = Some(area);
        picture.group("map", clip, |p| self.draw_scene(p));
        let mut taken = Vec::new();
        picture.group("furniture", clip, |p| {
            taken = labels::draw_furniture(self, p)
        });
        let mut contacts = Vec::new();
        picture.group("contact", clip, |p| contacts = draw_contact(self, p));
        picture.group("labels", clip, |p| labels::draw(self, p, &taken, &contacts));
        if !self.scene.top.is_empty() {
            picture.group("top", clip, |p| draw_overlays(self, p, &self.scene.top));
        }
        picture.rectangle(&area, None, Some(Stroke::new(self.palette.dim, 0.5)));
    }

    fn draw_scene(&self, picture: &mut Picture) {
        road::draw(self, picture);
        picture.group("goals", None, |p| goals(self, p));
        picture.group("underlays", None, |p| {
            draw_overlays(self, p, &self.scene.underlays)
        });
        picture.group("signs", None, |p| road::draw_posts(self, p));
        picture.group("regions", None, |p| draw_regions(self, p));
        picture.group("trails", None, |p| trails(self, p));
        picture.group("variation", None, |p| {
            draw_overlays(self, p, &self.scene.overlays);
            draw_overlays(self, p, &self.scene.variation);
        });
        let hollow = self.workbench.is_some_and(|look| look.hollow);
        let others = if hollow { "outlines" } else { "obstacles" };
        picture.group(others, None, |p| {
            let bodies = self.scene.bodies.iter();
            bodies.for_each(|body| draw_body(self, p, body));
        });
        picture.group("ego", None, |p| {
            let ego = self.scene.ego.iter();
            ego.for_each(|body| draw_body(self, p, body));
        });
    }

    /// The colour of a role.
    fn color(&self, role: Role) -> Color {
        if let Some(look) = self.workbench {
            return role.color(look.theme);
        }
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

/// Seconds between two marks on the way that the ego is going to take.
const MARKS: f64 = 0.5;

/// Where all participants have been lately, the ego always, and where the ego and those pointed out go.
fn trails(map: &Map<'_>, picture: &mut Picture) {
    if let Some(look) = &map.workbench {
        return look.trails(map, picture);
    }
    for trail in &map.scene.trails {
        match (trail.owner, trail.highlighted) {
            (Owner::Ego, _) => way(map, picture, trail, map.palette.ego),
            (_, Some(place)) => way(map, picture, trail, map.palette.emphasised(place)),
            (_, None) => {
                let stroke = Stroke::new(map.palette.obstacle.at(0.55), 0.6).rounded();
                picture.line(&spots(map, trail.past), stroke);
            }
        }
    }
}

/// The past as a line, the future as a finer one with a mark every half second.
fn way(map: &Map<'_>, picture: &mut Picture, trail: &Trail<'_>, color: Color) {
    let past = spots(map, trail.past);
    picture.line(&past, Stroke::new(color.at(0.75), 0.9).rounded());
    let future = spots(map, trail.future);
    picture.line(&future, Stroke::new(color.at(0.6), 0.5).dashed(&[1.6, 1.2]));
    let every = (MARKS / map.dt).round().max(1.0) as usize;
    for spot in future.iter().step_by(every).skip(1) {
        picture.circle(*spot, 0.8, Some(color.at(0.8)), None);
    }
}

fn spots(map: &Map<'_>, motions: &[(i64, Motion)]) -> Vec<Spot> {
    map.view.all(motions.iter().map(|(_, m)| &m.pose.position))
}

/// A body, with an arrow head at its front where there is room.
fn draw_body(map: &Map<'_>, picture: &mut Picture, body: &Body<'_>) {
    let rings = map.rings(&body.rings);
    if !Area::around(&rings.concat()).is_some_and(|around| map.shows(&around)) {
        return;
    }
    let color = map.color(body.role);
    if let Some(look) = &map.workbench {
        return look.body(map, picture, body, &rings);
    }
    let edge = color.towards(map.palette.text, 0.45);
    for ring in &rings {
        picture.polygon(ring, Some(color), Some(Stroke::new(edge, 0.45).rounded()));
    }
    let (length, width) = body.footprint.shape().size();
    if body.has_front && map.points(length) > 5.0 && map.points(width) > 2.2 {
        arrow(map, picture, body, width);
    }
}

/// An arrow head inside the body, at its front.
fn arrow(map: &Map<'_>, picture: &mut Picture, body: &Body<'_>, width: f64) {
    let deep = (0.62 * width).min(0.4 * body.length());
    let tip = body.along.1 - 0.22 * deep;
    let half = 0.33 * width;
    let ring = [
        (tip, 0.0),
        (tip - deep, half),
        (tip - 0.72 * deep, 0.0),
        (tip - deep, -half),
    ]
    .map(|(ahead, left)| map.view.at(&body.point(ahead, left)));
    picture.polygon(&ring, Some(map.palette.background.at(0.9)), None);
}

/// Marks every contact; gives what the marks cover.
fn draw_contact(map: &Map<'_>, picture: &mut Picture) -> Vec<Area> {
    let contacts = map.scene.contacts.iter();
    if let Some(look) = &map.workbench {
        return contacts
            .filter_map(|contact| look.overlap(map, picture, contact))
            .collect();
    }
    let marks = contacts.map(|contact| mark(map, picture, map.view.at(&contact.at)));
    marks.collect()
}

/// A ring with rays.
fn mark(map: &Map<'_>, picture: &mut Picture, (x, y): Spot) -> Area {
    let (palette, inner, outer) = (map.palette, 4.2, 7.0);
    let ring = Stroke::new(palette.danger, 1.1);
    let halo = Stroke::new(palette.background.at(0.85), 2.4);
    picture.circle((x, y), inner, None, Some(halo.clone()));
    let rays: Vec<[Spot; 2]> = (0..8)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * (f64::from(i) + 0.5) / 8.0).sin_cos();
            [
                (x + 5.2 * cos, y + 5.2 * sin),
                (x + outer * cos, y + outer * sin),
            ]
        })
        .collect();
    for ray in &rays {
        picture.line(ray, halo.clone());
    }
    picture.circle((x, y), inner, None, Some(ring.clone()));
    for ray in &rays {
        picture.line(ray, ring.clone());
    }
    Area {
        x: x - outer,
        y: y - outer,
        width: 2.0 * outer,
        height: 2.0 * outer,
    }
}

/// Draws them.
fn draw_overlays(map: &Map<'_>, picture: &mut Picture, overlays: &[Overlay]) {
    for overlay in overlays {
        match overlay {
            Overlay::Path(path) => {
                // In the workbench quieter than bodies.
                let (opacity, dash) = match map.workbench {
                    None => (1.0, 1.0),
                    Some(look) => (0.7, look.dash()),
                };
                let color = map.color(path.role).at(opacity * path.opacity);
                let stroke = match path.style {
                    LineStyle::Thick => Stroke::new(color, 1.4).rounded(),
                    LineStyle::Solid => Stroke::new(color, 0.8).rounded(),
                    LineStyle::Dashed => Stroke::new(color, 0.8).dashed(&[2.4 * dash, 1.6 * dash]),
                    LineStyle::Dotted => Stroke::new(color, 0.8).dashed(&[0.8 * dash, 2.4 * dash]),
                };
                picture.line(&map.view.all(&path.points), stroke);
            }
            Overlay::Outline(Outline {
                role, rings, faint, ..
            }) => {
                let opacity = if *faint { 0.45 } else { 1.0 };
                let stroke = Stroke::new(map.color(*role).at(opacity), 0.8).rounded();
                for ring in map.rings(rings) {
                    picture.polygon(&ring, None, Some(stroke.clone()));
                }
            }
        }
    }
}

/// Goals: lanelets and regions, tinted, with a dashed edge.
fn goals(map: &Map<'_>, picture: &mut Picture) {
    let color = map.palette.goal;
    for goal in &map.scene.goals {
        match goal {
            GoalArea::Region(rings) => outlined(map, picture, rings, color, 0.22),
            GoalArea::Lanelet(place) => {
                let ring = map.view.all(&map.scene.basemap.surfaces[*place].ring);
                let lines = map.workbench.is_some_and(|look| !look.filled);
                let edge = lines.then(|| Stroke::new(color, 0.6).dashed(&[2.0, 6.0]));
                picture.polygon(&ring, Some(color.at(0.22)), edge);
            }
            GoalArea::Point(at) => {
                let edge = Stroke::new(color, 0.8).dashed(&[2.0, 1.5]);
                picture.circle(map.view.at(at), 4.0, Some(color.at(0.22)), Some(edge));
            }
        }
    }
}

/// What stands for ever, and where phantom obstacles and those with occupancy sets may be.
fn draw_regions(map: &Map<'_>, picture: &mut Picture) {
    for region in &map.scene.regions {
        let (color, opacity) = match region.kind {
            RegionKind::Environment => (map.palette.static_obstacle, 0.6),
            RegionKind::Occupancy => {
                let themed = map.workbench.map(|look| look.theme.occupancy);
                let usual = themed.unwrap_or(map.palette.obstacle);
                (map.color_of(region.highlighted, usual), 0.25)
            }
        };
        outlined(map, picture, &region.rings, color, opacity);
    }
}

fn outlined(
    map: &Map<'_>,
    picture: &mut Picture,
    rings: &[Vec<Point>],
    color: Color,
    opacity: f64,
) {
    for ring in map.rings(rings) {
        let stroke = Stroke::new(color, 0.6).dashed(&[2.0, 1.5]);
        picture.polygon(&ring, Some(color.at(opacity)), Some(stroke));
    }
}

/// How a map is drawn in the workbench.
#[derive(Debug, Clone, Copy)]
pub struct WorkbenchMap<'a> {
    /// The colours.
    pub theme: &'a Theme<Color>,
    /// Whether surfaces have colours, and not lines alone.
    pub filled: bool,
    /// Whether lanes have their markings, or borders alone.
    pub markings: bool,
    /// Whether bodies are outlined and hatched, so that they are told from the ego where there are no colours.
    pub hollow: bool,
    /// Metres a character is wide; 0 for an image. On a map of characters the caller writes words, and an arrow in place
    /// of what is too small, and a box around it in place of what is too small for an outline.
    pub cell: f64,
}

/// Seconds ahead that the line at the front of a body shows.
const VELOCITY: f64 = 0.5;

/// Slower than this, m/s, a body has no such line.
const STANDING: f64 = 0.3;

/// The windscreen, in parts of the length from the rear.
const SCREEN: (f64, f64) = (0.62, 0.8);

/// How dark it is: the part of the way from the body's colour to the ground's; of sixteen colours neither the body's nor
/// the road's.
const GLASS: f64 = 0.28;

/// Lamps: how long and how wide they are, in parts of the body, and the least, metres.
const LAMP: (f64, f64, f64) = (0.1, 0.3, 0.4);

/// How opaque what two bodies cover is.
const VEIL: f64 = 0.4;

/// Characters along a body that has room for lamps.
const ROOM: f64 = 3.0;

impl WorkbenchMap<'_> {
    /// How much longer dashes are than those of figures: in characters finer ones would be a line.
    fn dash(&self) -> f64 {
        if self.cell > 0.0 { 4.0 } else { 1.0 }
    }

    /// Where everybody was and goes, and how fast.
    fn trails(&self, map: &Map<'_>, picture: &mut Picture) {
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
        let dash = 4.0 * self.dash();
        let ahead = Stroke::new(color.at(0.7), 0.8).dashed(&[dash, dash]);
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
    fn body(&self, map: &Map<'_>, picture: &mut Picture, body: &Body<'_>, rings: &[Vec<Spot>]) {
        if body.is_tiny(self.cell) || self.hollow && body.is_small(self.cell) {
            return;
        }
        let color = map.color(body.role);
        let hollow = self.hollow && body.owner != Owner::Ego;
        for ring in rings {
            let edge = hollow.then(|| Stroke::new(color, 0.5));
            picture.polygon(ring, Some(color), edge);
        }
        if hollow || !body.has_front || body.length() < ROOM * self.cell {
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
        // In few characters its shades would blur the outline.
        if self.filled && !body.stands && is_box && !body.is_small(self.cell) {
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

    /// What both bodies of a contact cover: the edges of both are seen, and the ego's colour through it, as it may be all
    /// of a body.
    fn overlap(&self, map: &Map<'_>, picture: &mut Picture, contact: &Contact) -> Option<Area> {
        let ring = map.view.all(&contact.overlap);
        let edge = Stroke::new(self.theme.danger, 1.6).rounded();
        picture.polygon(&ring, Some(self.theme.text.at(VEIL)), Some(edge));
        Area::around(&ring)
    }
}
