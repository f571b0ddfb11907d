//! The map of a figure: a scene's roads, traffic and marks as paths on a page, and names beside the bodies.

mod labels;

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{Motion, Sign, SignElement, SignMeaning, SignalColor};

use super::Color;
use super::display::{Anchor, Area, Picture, Spot, Stroke, Text};
use super::palette::Palette;
use super::scene::{
    Body, Border, DASH, GoalArea, LineStyle, MapScene, MarkingLine, Outline, Overlay, Owner, Paint,
    RegionKind, Role, STRIPE, StopLine, Surface, SurfaceKind, Trail, offset,
};
use super::view::View;

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
            draw_road(self, p);
            p.group("goals", None, |p| goals(self, p));
            if !self.scene.underlays.is_empty() {
                p.group("underlays", None, |p| {
                    draw_overlays(self, p, &self.scene.underlays)
                });
            }
            p.group("signs", None, |p| draw_posts(self, p));
            p.group("regions", None, |p| draw_regions(self, p));
            p.group("trails", None, |p| trails(self, p));
            let variation = self.scene.overlays.iter().chain(&self.scene.variation);
            let variation: Vec<Overlay> = variation.cloned().collect();
            p.group("variation", None, |p| draw_overlays(self, p, &variation));
            p.group("obstacles", None, |p| {
                let bodies = self.scene.bodies.iter();
                bodies.for_each(|body| draw_body(self, p, body));
            });
            p.group("ego", None, |p| {
                let ego = self.scene.ego.iter();
                ego.for_each(|body| draw_body(self, p, body));
            });
        });
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

/// Seconds between two marks on the way that the ego is going to take.
const MARKS: f64 = 0.5;

/// Where all participants have been lately, the ego always, and where the ego and those pointed out go.
fn trails(map: &Map<'_>, picture: &mut Picture) {
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
                let color = map.color(path.role);
                let stroke = match path.style {
                    LineStyle::Thick => Stroke::new(color, 1.4).rounded(),
                    LineStyle::Solid => Stroke::new(color, 0.8).rounded(),
                    LineStyle::Dashed => Stroke::new(color, 0.8).dashed(&[2.4, 1.6]),
                    LineStyle::Dotted | LineStyle::Crossed => {
                        Stroke::new(color, 0.8).dashed(&[0.8, 2.4])
                    }
                };
                picture.line(&map.view.all(&path.points), stroke);
            }
            Overlay::Outline(Outline { role, rings, .. }) => {
                let stroke = Stroke::new(map.color(*role), 0.8).rounded();
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
                picture.polygon(&ring, Some(color.at(0.22)), None);
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
            RegionKind::Occupancy => (map.color_of(region.highlighted, map.palette.obstacle), 0.25),
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

/// Width of a painted line, metres.
const LINE: f64 = 0.15;

fn draw_road(map: &Map<'_>, picture: &mut Picture) {
    let surfaces = || map.scene.surfaces.iter();
    picture.group("road", None, |p| {
        let roads = surfaces().filter(|s| s.kind != SurfaceKind::Crossing);
        roads.for_each(|road| surface(map, p, road));
    });
    picture.group("crossings", None, |p| {
        let crossings = surfaces().filter(|s| s.kind == SurfaceKind::Crossing);
        crossings.for_each(|s| crossing(map, p, s));
    });
    picture.group("markings", None, |p| {
        map.scene.borders.iter().for_each(|b| border(map, p, b));
        let stop_lines = map.scene.stop_lines.iter();
        stop_lines.for_each(|line| stop_line(map, p, line));
    });
}

fn surface(map: &Map<'_>, picture: &mut Picture, surface: &Surface) {
    let color = match surface.kind {
        SurfaceKind::Sidewalk | SurfaceKind::Bicycle => map.palette.path,
        _ => map.palette.road,
    };
    let ring = map.view.all(&surface.ring);
    // A thin line of the same colour closes the seams between neighbours.
    picture.polygon(&ring, Some(color), Some(Stroke::new(color, 0.5).rounded()));
}

/// Stripes along the way of those who drive, as they are painted on the road.
fn crossing(map: &Map<'_>, picture: &mut Picture, crossing: &Surface) {
    let shade = map.palette.road.towards(map.palette.lane, 0.35);
    picture.polygon(&map.view.all(&crossing.ring), Some(shade), None);
    // Stripes that would be finer than a hair become a surface.
    if map.points(STRIPE) < 0.5 {
        return;
    }
    for stripe in crossing.stripes() {
        picture.polygon(&map.view.all(&stripe), Some(map.palette.crosswalk), None);
    }
}

fn border(map: &Map<'_>, picture: &mut Picture, border: &Border) {
    let width = map.points(LINE).clamp(0.35, 1.6);
    for line in border.lines {
        let stroke = stroke(map, line, width);
        let points = match line.offset {
            0.0 => map.view.all(&border.points),
            aside => map
                .view
                .all(&offset(&border.points, aside * width / map.view.scale)),
        };
        picture.line(&points, stroke);
    }
}

/// A line of a marking; `width` is that of a painted line, points.
fn stroke(map: &Map<'_>, line: &MarkingLine, width: f64) -> Stroke {
    let palette = map.palette;
    let (wide, dash) = (line.width * width, map.points(DASH));
    let faded = |by: f64| palette.lane.towards(palette.road, by);
    match line.paint {
        Paint::Solid | Paint::Curb => Stroke::new(palette.lane, wide).rounded(),
        Paint::LoweredCurb => Stroke::new(faded(0.4), wide).rounded(),
        Paint::Dashed if dash >= 1.2 => {
            Stroke::new(palette.lane_dashed, wide).dashed(&[dash, dash])
        }
        // Dashes that would run together are a lighter line.
        Paint::Dashed => Stroke::new(palette.lane_dashed.towards(palette.road, 0.5), wide),
        Paint::None => Stroke::new(faded(0.7), 0.25),
        Paint::Unknown => Stroke::new(faded(0.4), 0.35),
    }
}

fn stop_line(map: &Map<'_>, picture: &mut Picture, line: &StopLine) {
    let width = map.points(0.4).clamp(0.8, 2.4);
    let mut stroke = Stroke::new(map.palette.lane, width);
    let dash = map.points(0.6);
    if line.dashed && dash > 0.8 {
        stroke = stroke.dashed(&[dash, dash * 0.6]);
    }
    picture.line(&map.view.all(&line.ends), stroke);
}

/// On a map that is wider than this, metres, posts would lie over each other.
const MAX_WIDTH_WITH_POSTS: f64 = 120.0;

fn draw_posts(map: &Map<'_>, picture: &mut Picture) {
    if map.view.width() > MAX_WIDTH_WITH_POSTS {
        return;
    }
    let mut taken: Vec<Area> = Vec::new();
    // Posts at the same place would hide each other: the first one stands for all.
    let mut free = |(x, y): Spot| {
        let area = Area {
            x: x - 4.0,
            y: y - 4.0,
            width: 8.0,
            height: 8.0,
        };
        let free = map.shows(&area) && !taken.iter().any(|t| t.meets(&area));
        if free {
            taken.push(area);
        }
        free
    };
    for light in &map.scene.lights {
        let at = map.view.at(&light.at);
        if free(at) {
            lamp(map, picture, at, light.color);
        }
    }
    for post in map.scene.signs.iter().filter(|post| !post.sign.is_virtual) {
        let at = map.view.at(&post.at);
        if free(at) {
            plate(map, picture, at, post.sign);
        }
    }
}

/// Three lamps; those that are on have their colour and their place.
fn lamp(map: &Map<'_>, picture: &mut Picture, (x, y): Spot, color: SignalColor) {
    let housing = Area {
        x: x - 1.7,
        y: y - 4.3,
        width: 3.4,
        height: 8.6,
    };
    let edge = Stroke::new(map.palette.background, 0.4);
    picture.rectangle(&housing, Some(Color::hex(0x222222)), Some(edge));
    let red = matches!(color, SignalColor::Red | SignalColor::RedYellow);
    let yellow = matches!(color, SignalColor::Yellow | SignalColor::RedYellow);
    let green = color == SignalColor::Green;
    let lamps = [
        (red, Color::hex(0xff4030)),
        (yellow, Color::hex(0xffc400)),
        (green, Color::hex(0x20d060)),
    ];
    for (i, (on, lit)) in lamps.into_iter().enumerate() {
        let at = (x, y + (i as f64 - 1.0) * 2.7);
        let fill = if on { lit } else { Color::hex(0x4a4a4a) };
        picture.circle(at, 1.15, Some(fill), None);
    }
}

const RED: Color = Color::hex(0xc1121f);

const WHITE: Color = Color::hex(0xffffff);

const BLACK: Color = Color::hex(0x111111);

/// A sign in its own shape where that is known, else a small square.
fn plate(map: &Map<'_>, picture: &mut Picture, (x, y): Spot, sign: &Sign) {
    let ring = |corners: u8, turn: f64, r: f64| -> Vec<Spot> {
        let corner = |i: u8| {
            let angle = std::f64::consts::TAU * (f64::from(i) + turn) / f64::from(corners);
            (x + r * angle.sin(), y - r * angle.cos())
        };
        (0..corners).map(corner).collect()
    };
    let red = || Some(Stroke::new(RED, 0.7));
    let known = sign
        .elements
        .iter()
        .find_map(|e| Some((e, Kind::from_sign(e)?)));
    match known {
        Some((_, Kind::Stop)) => {
            picture.polygon(&ring(8, 0.5, 3.0), Some(RED), Some(Stroke::new(WHITE, 0.4)));
        }
        Some((_, Kind::Yield)) => picture.polygon(&ring(3, 0.5, 3.2), Some(WHITE), red()),
        Some((_, Kind::Priority)) => {
            let edge = Some(Stroke::new(BLACK, 0.3));
            picture.polygon(&ring(4, 0.0, 3.2), Some(WHITE), edge);
            picture.polygon(&ring(4, 0.0, 2.0), Some(Color::hex(0xf2b705)), None);
        }
        Some((element, Kind::Limit)) => {
            picture.circle((x, y), 3.3, Some(WHITE), red());
            if let Some(SignMeaning::SpeedLimit(speed)) = element.meaning()
                && speed < 100.0
            {
                let words = format!("{:.0}", sign.speed_shown(speed).0);
                let text = Text::new((x, y + 1.1), words, 3.0, BLACK);
                picture.text(text.in_bold(true).anchored(Anchor::Middle));
            }
        }
        None => {
            let edge = Some(Stroke::new(map.palette.dim, 0.4));
            picture.polygon(&ring(4, 0.5, 2.2), Some(map.palette.background), edge);
        }
    }
}

enum Kind {
    Stop,
    Yield,
    Priority,
    Limit,
}

impl Kind {
    /// By the German number, which most files use, or the American one.
    fn from_sign(element: &SignElement) -> Option<Self> {
        match element.id.as_str() {
            "206" | "R1-1" => Some(Self::Stop),
            "205" | "R1-2" => Some(Self::Yield),
            "301" | "306" => Some(Self::Priority),
            "274" | "R2-1" => Some(Self::Limit),
            _ => {
                matches!(element.meaning(), Some(SignMeaning::SpeedLimit(_))).then_some(Self::Limit)
            }
        }
    }
}
