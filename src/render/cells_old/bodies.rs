//! Bodies to scale: filled, with windscreen, brake lights and indicators where there is room; where they were and go.

use nearmiss_base::geometry::{Point, Vector};
use nearmiss_scene::scenario::Signal;

use super::canvas::{Canvas, outlines, stroke};
use super::compose::mix;
use super::silhouette::Silhouette;
use super::{Appearance, CellView, MapStyle};
use crate::scene::{Body, MapScene, Owner};

/// Seconds ahead that the velocity line shows.
const VELOCITY_LINE_SECONDS: f64 = 0.5;
/// Slower than this, m/s, there is no velocity line.
const STANDING: f64 = 0.3;
/// A body of fewer dots than this is not hollow: its outline would be a blot.
const OUTLINE: f64 = 9.0;
/// A body of fewer parts of blocks than this has no windscreen.
const SCREENED: f64 = 7.0;
/// A body of fewer dots than this is an arrow: its heading does not show otherwise.
const ARROW: f64 = 5.0;
/// Lengths of cars, metres, and the one that all of them are taken for, so that they show their headings alike.
const CARS: (f64, f64) = (3.0, 6.0);
const CAR: f64 = 4.5;
/// The windscreen, in parts of the length from the rear.
const SCREEN: (f64, f64) = (0.62, 0.80);
/// How dark the windscreen is: the part of the way from the body's colour to the road's.
const GLASS: f64 = 0.55;
/// Bodies narrower than so many parts of blocks are drawn as lines, too: they may fall between all parts.
const NARROW: f64 = 2.0;

/// Arrows by eighths of a turn, from the right to the left.
const ARROWS: [&str; 8] = ["→", "↗", "↑", "↖", "←", "↙", "↓", "↘"];

/// Bodies that are large enough, the ego above all others; those that are too small are [arrows](Heading::Alone).
pub fn draw(canvas: &mut Canvas<'_>, look: &Appearance<'_>, scene: &MapScene<'_>, view: &CellView) {
    let all = scene.bodies.iter().chain(&scene.ego);
    let mut drawn: Vec<Drawn<'_>> = all
        .filter_map(|body| Drawn::new(canvas, look, view, body))
        .collect();
    keep_apart(&mut drawn);
    for body in &drawn {
        if body.body.owner == Owner::Ego {
            canvas.layer();
        }
        body.fill(canvas, look, view);
    }
}

/// A body as it is drawn.
struct Drawn<'a> {
    body: &'a Body<'a>,
    heading: Heading,
    /// How far its silhouette is moved, metres on the canvas.
    by: (f64, f64),
    parts: Silhouette,
}

impl<'a> Drawn<'a> {
    fn new(
        canvas: &Canvas<'_>,
        look: &Appearance<'_>,
        view: &CellView,
        body: &'a Body<'a>,
    ) -> Option<Self> {
        let heading = Heading::new(look, view, body);
        if heading == Heading::Alone {
            return None;
        }
        let rings: Vec<Vec<(f64, f64)>> =
            body.rings.iter().map(|ring| placed(view, ring)).collect();
        let by = canvas.snap(&rings);
        let mut parts = canvas.silhouette(&rings, by);
        let (right, left) = body.across;
        if left - right < NARROW * view.block(look.style) {
            let (rear, front) = body.along;
            let middle = f64::midpoint(left, right);
            let inset = 0.3 * body.length().min(view.block(look.style));
            let ends =
                [rear + inset, front - inset].map(|ahead| view.at(&body.point(ahead, middle)));
            canvas.add_line(&mut parts, ends[0], ends[1], by);
        } else {
            parts.smooth();
        }
        Some(Self {
            body,
            heading,
            by,
            parts,
        })
    }

    fn fill(&self, canvas: &mut Canvas<'_>, look: &Appearance<'_>, view: &CellView) {
        let body = self.body;
        let color = look.color(body.role);
        let dots = body.length() / view.dot;
        if body.stands && !look.style.has_backgrounds() && dots >= OUTLINE {
            // Without backgrounds standing bodies are hollow, moving ones filled.
            outlines(canvas, view, &body.rings, color);
            let front = [body.motion.pose.position, body.point(body.along.1, 0.0)];
            return stroke(canvas, view, &front, color);
        }
        let shaded = !look.has_colors() && body.owner != Owner::Ego;
        canvas.fill(&self.parts, color, shaded);
        if self.heading == Heading::Windscreen {
            let rings = body.rings.iter();
            let rings: Vec<Vec<(f64, f64)>> = rings
                .map(|ring| placed(view, &between(body, ring, SCREEN)))
                .collect();
            let mut glass = canvas.silhouette(&rings, self.by);
            glass.only_in(&self.parts);
            canvas.fill(&glass, mix(color, look.theme.map_ground, GLASS), shaded);
        }
        if body.has_front {
            self.lamps(canvas, look, view);
        }
    }

    /// Brake lights across the rear, indicators at the corners of their side.
    fn lamps(&self, canvas: &mut Canvas<'_>, look: &Appearance<'_>, view: &CellView) {
        let body = self.body;
        let Some(signals) = body.signals else { return };
        let on = |signal: Signal| signals.signals.contains(&(signal, true));
        let (rear, front) = body.along;
        let (right, left) = body.across;
        let inset = view.dot / 2.0;
        let mut lamp = |from: (f64, f64), to: (f64, f64), color| {
            let at = |(ahead, left)| view.at(&body.point(ahead, left));
            let mut parts = self.parts.emptied();
            canvas.add_line(&mut parts, at(from), at(to), self.by);
            parts.only_in(&self.parts);
            canvas.fill(&parts, color, false);
        };
        if on(Signal::BrakingLights) {
            let behind = rear + inset;
            lamp(
                (behind, right + inset),
                (behind, left - inset),
                look.theme.brake_light,
            );
        }
        let hazard = on(Signal::HazardWarningLights);
        let sides = [
            (Signal::IndicatorLeft, left - inset),
            (Signal::IndicatorRight, right + inset),
        ];
        for (signal, side) in sides {
            if hazard || on(signal) {
                for ahead in [rear + inset, front - inset] {
                    lamp((ahead, side), (ahead, side), look.theme.indicator);
                }
            }
        }
    }
}

/// A part stays free between bodies that do not touch: who matters less gives way, unless too little of it would be left.
fn keep_apart(drawn: &mut [Drawn<'_>]) {
    for later in 1..drawn.len() {
        let (before, rest) = drawn.split_at_mut(later);
        let Some(upper) = rest.first_mut() else {
            continue;
        };
        for lower in before {
            let touching = lower.parts.touching(&upper.parts);
            if touching.is_empty() {
                continue;
            }
            let [a, b] = [lower.body, upper.body].map(|body| body.footprint.at(body.motion.pose));
            if a.distance(&b) <= 0.0 {
                continue;
            }
            if 2 * touching.len() <= lower.parts.count() {
                lower.parts.without(&touching)
            } else {
                let touching = upper.parts.touching(&lower.parts);
                if 2 * touching.len() <= upper.parts.count() {
                    upper.parts.without(&touching);
                }
            }
        }
    }
}

/// The arrow along a direction of the canvas.
#[must_use]
pub fn heading_arrow(direction: &Vector) -> &'static str {
    let eighths = direction.y.atan2(direction.x) / std::f64::consts::FRAC_PI_4;
    ARROWS[(eighths.round() as i64).rem_euclid(8).unsigned_abs() as usize % 8]
}

/// What shows where a body is headed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heading {
    /// An arrow in place of the body, which is too small.
    Alone,
    /// An arrow on the body.
    OnBody,
    /// Its windscreen.
    Windscreen,
    /// Nothing: it stands, or has no front.
    None,
}

impl Heading {
    /// That of a body, by how many dots and parts of blocks it is long.
    #[must_use]
    pub fn new(look: &Appearance<'_>, view: &CellView, body: &Body<'_>) -> Self {
        let length = body.length();
        let is_car = (CARS.0..CARS.1).contains(&length);
        let (length, reach) = if is_car {
            (CAR, CAR)
        } else {
            (length, 2.0 * body.footprint.reach())
        };
        if reach < ARROW * view.dot {
            return Self::Alone;
        }
        let parts = length / view.block(look.style);
        match look.style {
            _ if body.stands || !body.has_front => Self::None,
            // A gap would cut the body in two.
            MapStyle::Ascii | MapStyle::Braille => Self::OnBody,
            MapStyle::Cells(_) if parts >= SCREENED => Self::Windscreen,
            MapStyle::Cells(_) => Self::OnBody,
        }
    }
}

/// Lines from the fronts of those who are pointed out, have trails or are the ego, as long as the way of the next half
/// second; under the bodies they cross.
pub fn velocities(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    let has_trail = |owner: Owner| scene.trails.iter().any(|trail| trail.owner == owner);
    for body in scene.bodies.iter().chain(&scene.ego) {
        let motion = body.motion;
        let shown = body.owner == Owner::Ego || body.highlighted.is_some();
        if !shown && !has_trail(body.owner) {
            continue;
        }
        if motion.velocity.abs() > STANDING && view.sees_point(&motion.pose.position) {
            let (rear, front) = body.along;
            let reach = if motion.velocity > 0.0 { front } else { rear };
            let nose = motion.pose.position + motion.pose.forward() * reach;
            let color = match body.owner {
                Owner::Ego => look.theme.ego,
                Owner::Obstacle(_) => look.theme.static_obstacle,
            };
            let end = nose + motion.velocity_vector() * VELOCITY_LINE_SECONDS;
            stroke(canvas, view, &[nose, end], color);
        }
    }
}

/// The part of a body between two parts of its length.
fn between(body: &Body<'_>, ring: &[Point], (from, to): (f64, f64)) -> Vec<Point> {
    let pose = body.motion.pose;
    let stretch = (body.part(from), body.part(to));
    cut(ring, &pose.position, &pose.forward(), stretch)
}

fn placed(view: &CellView, ring: &[Point]) -> Vec<(f64, f64)> {
    ring.iter().map(|p| view.at(p)).collect()
}

/// The part of a ring that lies between two distances along a direction.
fn cut(ring: &[Point], origin: &Point, along: &Vector, (from, to): (f64, f64)) -> Vec<Point> {
    let place = |p: &Point| (p - origin).dot(along);
    let after = |ring: &[Point], limit: f64, sign: f64| {
        let mut kept = Vec::with_capacity(ring.len() + 2);
        for (i, p) in ring.iter().enumerate() {
            let q = &ring[(i + 1) % ring.len()];
            let (a, b) = (sign * (place(p) - limit), sign * (place(q) - limit));
            if a >= 0.0 {
                kept.push(*p);
            }
            if (a >= 0.0) != (b >= 0.0) {
                kept.push(p + (q - p) * (a / (a - b)));
            }
        }
        kept
    };
    after(&after(ring, from, 1.0), to, -1.0)
}

/// Lines behind them, thick for the ego and those pointed out; ahead, as far as it is recorded, a dot for every other
/// step.
pub fn draw_trails(
    canvas: &mut Canvas<'_>,
    look: &Appearance<'_>,
    scene: &MapScene<'_>,
    view: &CellView,
) {
    let theme = look.theme;
    for trail in &scene.trails {
        let (past, future) = match (trail.owner, trail.highlighted) {
            (Owner::Ego, _) => (theme.ego_trail, theme.ego_trail),
            (_, Some(_)) => (theme.trail, theme.picked),
            (_, None) => (theme.trail, theme.trail),
        };
        let thick = trail.owner == Owner::Ego || trail.highlighted.is_some();
        for pair in trail.past.windows(2) {
            let ends = [pair[0].1.pose.position, pair[1].1.pose.position];
            if thick {
                canvas.thick(view.at(&ends[0]), view.at(&ends[1]), past)
            } else {
                stroke(canvas, view, &ends, past)
            }
        }
        for (_, motion) in trail.future.iter().step_by(2) {
            canvas.point(view.at(&motion.pose.position), future);
        }
    }
}

