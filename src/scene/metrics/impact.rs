//! Impact: how hard a contact is: Δv of both bodies, angle, sides, overlap, and the risk of serious injury.
//!
//! Δv is what the impulse at the first touch changes of a body's velocity. Plastic planar impact of two rigid bodies
//! (Kudlich 1966, Slibar 1966; Brach and Brach, Vehicle Accident Analysis and Reconstruction Methods, 2011): where they
//! touch, both have the same velocity afterwards, unless the impulse along the surface exceeds [`FRICTION`] times the one
//! across it; then they slide along each other. So who is hit off its centre turns away, and a scrape of two that pass changes
//! little. A central impact gives m₂ / (m₁ + m₂) · v (Shelby 2011). The impulse is the same for both: m₁Δv₁ = m₂Δv₂.
//! Bodies rebound a little in slow impacts, which adds up to a third to Δv; that is left out.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

use nearmiss_base::geometry::{Bounds, Placed, Point, Shape, Vector, angle_between, ring_within};

use super::injury::{self, People};
use super::{Contact, Danger, Encounter, Measure, NoValue, Reading};
use crate::scenario::ObstacleType;

/// A side of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum ContactSide {
    /// Front.
    Front,
    /// Rear.
    Rear,
    /// Left side.
    Left,
    /// Right side.
    Right,
}

nearmiss_record::named!(ContactSide);

/// How hard two bodies touch; of pairs the ego's is first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// The speed of one relative to the other, m/s.
    pub closing_speed: f64,
    /// The angle between both headings, radians: 0 is the same way, π head-on.
    pub angle: f64,
    /// The sides that touch.
    pub sides: [ContactSide; 2],
    /// The share of the struck width that touches: of the ego's extent along the surface, what the other covers.
    pub overlap: f64,
    /// The change of velocity of each, m/s; nothing where a mass is not known.
    pub delta_v: Option<[f64; 2]>,
    /// The risk of a serious injury (MAIS3+) of the people at most risk, 0 to 1.
    ///
    /// # Errors
    /// No curve is published for them, or the impact is beyond its range.
    pub p_serious: Result<f64, NoValue>,
    /// That risk for comparisons alone, the more the harder: as if the curve of their kind held for every impact.
    pub rank: f64,
}

/// An impact in documents and tables.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ImpactRecord {
    /// Speed of one body relative to the other.
    #[schemars(extend("unit" = "m/s"))]
    pub closing_speed: f64,
    /// Change of the ego's velocity; null where a mass is not known.
    #[schemars(extend("unit" = "m/s"))]
    pub delta_v: Option<f64>,
    /// Change of the other's velocity.
    #[schemars(extend("unit" = "m/s"))]
    pub delta_v_other: Option<f64>,
    /// Risk of a serious injury (MAIS3+) of the people at most risk, 0 to 1; null without a published curve that holds.
    pub p_serious: Option<f64>,
    /// Angle between both headings, 0 to π.
    #[schemars(extend("unit" = "rad"))]
    pub angle: f64,
    /// Share of the ego's width that the other covers, 0 to 1.
    pub overlap: f64,
}

impl From<&Impact> for ImpactRecord {
    fn from(impact: &Impact) -> Self {
        let short = |value: f64| (value * 1e4).round() / 1e4;
        let delta_v = |of: usize| impact.delta_v.map(|both| short(both[of]));
        Self {
            closing_speed: short(impact.closing_speed),
            delta_v: delta_v(0),
            delta_v_other: delta_v(1),
            p_serious: impact.p_serious.ok().map(short),
            angle: short(impact.angle),
            overlap: short(impact.overlap),
        }
    }
}

impl std::fmt::Display for ImpactRecord {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.1} m/s", self.closing_speed)?;
        if let Some((own, other)) = self.delta_v.zip(self.delta_v_other) {
            write!(f, ", Δv {own:.1} and {other:.1} m/s")?;
        }
        match self.p_serious {
            Some(risk) => write!(f, ", serious injury {:.1} %", 100.0 * risk),
            None => Ok(()),
        }
    }
}

/// A body at the moment of a contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Striking<'a> {
    /// Where it is, a little into the other.
    pub body: Placed<'a>,
    /// Its velocity, m/s.
    pub velocity: Vector,
    /// How fast it turns, rad/s.
    pub turning: f64,
    /// What it is.
    pub kind: ObstacleType,
}

/// Bodies are so much further on their way, a share of it, when it is told how they touch: in each other by a little.
pub const DEEP: f64 = 1e-4;

/// Vehicles that slide along each other hold on to each other with this share of what presses them together: within the
/// 0.3 to 0.6 of reconstructions (Brach and Brach 2011).
const FRICTION: f64 = 0.5;

/// Mass with its people, kg; infinite of what is fixed to the ground, nothing where a kind says nothing of it.
///
/// Round numbers of ours. Cars: about that of new cars in the EU in running order (ICCT, European Vehicle Market Statistics). Truck and bus: half
/// loaded, at most 40 t and 19.5 t (Directives 96/53/EC and 2015/719); a car's Δv is within 8 % for trucks of 8 to 40 t.
/// People: 75 kg (Regulation (EU) 1230/2012), with the weight of usual motorcycles and bicycles. Train: a tram.
fn mass(kind: ObstacleType) -> Option<f64> {
    Some(match kind {
        ObstacleType::Car
        | ObstacleType::Taxi
        | ObstacleType::PriorityVehicle
        | ObstacleType::ParkedVehicle => 1500.0,
        ObstacleType::Truck => 15_000.0,
        ObstacleType::Bus => 14_000.0,
        ObstacleType::Train => 40_000.0,
        ObstacleType::Motorcycle => 275.0,
        ObstacleType::Bicycle => 90.0,
        ObstacleType::Pedestrian => 75.0,
        ObstacleType::Building
        | ObstacleType::Pillar
        | ObstacleType::RoadBoundary
        | ObstacleType::MedianStrip => f64::INFINITY,
        ObstacleType::Unknown | ObstacleType::ConstructionZone => return None,
    })
}

impl Impact {
    /// Of the ego and another.
    pub(super) fn between(both: &[Striking<'_>; 2]) -> Self {
        let [ego, other] = both;
        let bodies = both.map(|one| one.body);
        let normal = normal(&bodies);
        let at = pressed(&bodies, normal);
        let along = Vector::new(-normal.y, normal.x);
        let relative = ego.velocity - other.velocity;
        let closing_speed = relative.norm();
        let [a, b] = bodies.map(|body| body.extent(&at, &along));
        let shared = (a.1.min(b.1) - a.0.max(b.0)).max(0.0);
        let sides = bodies.map(|body| face(&body, &at));
        let delta_v = mass(ego.kind).zip(mass(other.kind)).map(|(m, n)| {
            let masses = [m, n];
            let levers = bodies.map(|body| at - centre(&body));
            let turns = [0, 1].map(|i| masses[i] * gyration_squared(&bodies[i]));
            let turned = |i: usize| Vector::new(-levers[i].y, levers[i].x) * both[i].turning;
            let relative = relative + turned(0) - turned(1);
            let impulse = impulse(masses, turns, levers, normal, relative);
            masses.map(|mass| impulse / mass)
        });
        let people = [0, 1].map(|i| People {
            of: both[i].kind,
            side: sides[i],
            hit_by: (both[1 - i].kind, sides[1 - i]),
            closing_speed,
            delta_v: delta_v.map(|both| both[i]),
        });
        Self {
            closing_speed,
            angle: angle_between(ego.body.pose.heading, other.body.pose.heading).abs(),
            sides,
            overlap: (shared / (a.1 - a.0)).clamp(0.0, 1.0),
            delta_v,
            p_serious: injury::highest(&people),
            rank: injury::rank(&people),
        }
    }
}

/// The impulse between two bodies that touch, kg m/s: masses in kg, moments of inertia in kg m², from the centres to where
/// they touch in metres, the direction from the first into the second, and the velocity of the first relative to the second
/// there.
fn impulse(
    masses: [f64; 2],
    turns: [f64; 2],
    levers: [Vector; 2],
    normal: Vector,
    relative: Vector,
) -> f64 {
    let approach = relative.dot(&normal);
    if approach <= 0.0 {
        return 0.0;
    }
    // The velocity that an impulse of 1 along one axis gives where they touch, along another.
    let gives = |axis: &Vector, to: &Vector| -> f64 {
        let of = |i: usize| {
            let turned = Vector::new(-levers[i].y, levers[i].x);
            axis.dot(to) / masses[i] + turned.dot(axis) * turned.dot(to) / turns[i]
        };
        of(0) + of(1)
    };
    let along = Vector::new(-normal.y, normal.x);
    let slip = relative.dot(&along);
    let (nn, nt, tt) = (
        gives(&normal, &normal),
        gives(&normal, &along),
        gives(&along, &along),
    );
    let determinant = nn * tt - nt * nt;
    let (across, surface) = (
        (approach * tt - slip * nt) / determinant,
        (slip * nn - approach * nt) / determinant,
    );
    if across > 0.0 && surface.abs() <= FRICTION * across {
        return across.hypot(surface);
    }
    // They slide: only the approach ends.
    let held = FRICTION * slip.signum();
    let across = approach / (nn + held * nt).max(nn / 2.0);
    across * (1.0 + FRICTION * FRICTION).sqrt()
}

/// The direction across the surface at which two bodies touch, from the first into the second: that of their own axes, or of
/// the line between them where one is round, along which they are least in each other.
fn normal([a, b]: &[Placed<'_>; 2]) -> Vector {
    let between = centre(b) - centre(a);
    let origin = a.pose.position;
    let round = [a, b].iter().any(|body| is_round(body));
    let own = [a, b].map(|body| [body.pose.forward(), body.pose.left()]);
    let line = round.then(|| between.try_normalize(1e-9)).flatten();
    let axes = own.into_iter().flatten().chain(line);
    let gap = |axis: Vector| {
        let [a, b] = [a, b].map(|body| body.extent(&origin, &axis));
        [(b.0 - a.1, axis), (a.0 - b.1, -axis)]
    };
    let widest = axes.flat_map(gap).max_by(|a, b| a.0.total_cmp(&b.0));
    widest.map_or(a.pose.forward(), |(_, axis)| axis)
}

fn is_round(body: &Placed<'_>) -> bool {
    matches!(body.footprint.shape(), Shape::Circle { .. })
}

/// Where the impulse acts: the middle of the area that two bodies share once they have crushed each other by [`CRUSH`]; what
/// they touch first may be a corner of a front that then is pressed together over its whole width.
fn pressed([a, b]: &[Placed<'_>; 2], normal: Vector) -> Point {
    // One of both is taken for its box, the round one for its outline.
    let (frame, ring, push) = if is_round(a) {
        (b, a, normal * CRUSH)
    } else {
        (a, b, normal * -CRUSH)
    };
    let local = |outlines: Vec<Vec<Point>>, push: Vector| -> Vec<Point> {
        let points = outlines.into_iter().flatten();
        points.map(|p| frame.pose.to_local(&(p + push))).collect()
    };
    let outline = local(ring.outlines(), push);
    let corners = local(frame.outlines(), Vector::zeros());
    let shared = Bounds::from_points(&corners).map(|bounds| ring_within(&outline, &bounds));
    let at = shared.and_then(|shared| centroid(&shared));
    at.map_or_else(
        || nalgebra::center(&centre(a), &centre(b)),
        |at| frame.pose.to_world(&at) - push / 2.0,
    )
}

/// Bodies are pressed so far into each other when the impulse acts, metres.
const CRUSH: f64 = 0.2;

/// The middle of the area of a polygon; nothing where it has none.
fn centroid(ring: &[Point]) -> Option<Point> {
    let first = ring.first()?;
    let next = ring.iter().cycle().skip(1);
    let (mut area, mut sum) = (0.0, Vector::zeros());
    for (p, q) in ring.iter().zip(next).map(|(p, q)| (p - first, q - first)) {
        let twice = p.perp(&q);
        area += twice;
        sum += (p + q) * (twice / 3.0);
    }
    (area.abs() > 1e-9).then(|| first + sum / area)
}

/// The middle of a body's own box.
fn centre(body: &Placed<'_>) -> Point {
    let (forward, left) = (body.pose.forward(), body.pose.left());
    let middle = |axis: &Vector| {
        let (from, to) = body.extent(&body.pose.position, axis);
        f64::midpoint(from, to)
    };
    body.pose.position + forward * middle(&forward) + left * middle(&left)
}

/// The square of the radius of gyration of an even rectangle of a body's size, m².
fn gyration_squared(body: &Placed<'_>) -> f64 {
    let (length, width) = body.footprint.shape().size();
    (length * length + width * width) / 12.0
}

/// The sides with which two bodies touch.
#[must_use]
pub fn sides(a: &Placed<'_>, b: &Placed<'_>) -> [ContactSide; 2] {
    let both = [*a, *b];
    let at = pressed(&both, normal(&both));
    both.map(|body| face(&body, &at))
}

/// The side of a body that is nearest to a point on or in it.
fn face(body: &Placed<'_>, at: &Point) -> ContactSide {
    let local = body.pose.to_local(at);
    let (length, width) = body.footprint.shape().size();
    let (x, y) = (local.x * 2.0 / length, local.y * 2.0 / width);
    // Depth below each side, metres: the least one is that side.
    let sides = [
        ((1.0 - x) * length, ContactSide::Front),
        ((1.0 + x) * length, ContactSide::Rear),
        ((1.0 - y) * width, ContactSide::Left),
        ((1.0 + y) * width, ContactSide::Right),
    ];
    let nearest = sides.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(ContactSide::Front, |(_, face)| face)
}

/// What the first contact of the recording gives; one value for the pair, the same at every step.
fn of_first(
    encounter: &Encounter<'_>,
    value: impl FnOnce(&Impact) -> Result<f64, NoValue>,
) -> Reading {
    let found = encounter.ask(|context, other, _| {
        let first: Option<&Contact> = context.contacts(other).first();
        value(&first.ok_or(NoValue::NeverTouched)?.impact)
    });
    found.into()
}

fn delta_v(encounter: &Encounter<'_>, of: usize) -> Reading {
    of_first(encounter, |impact| {
        let both = impact.delta_v.ok_or(NoValue::NoMass)?;
        Ok(both[of])
    })
}

pub(super) const CONTACT_SPEED: Measure = Measure::new(
    "contact_speed",
    "closing speed at contact",
    "m/s",
    Danger::High,
    "relative speed at the first recorded contact (Shelby 2011)",
    |encounter| of_first(encounter, |impact| Ok(impact.closing_speed)),
)
.reading_ahead();

pub(super) const DELTA_V: Measure = Measure::new(
    "delta_v",
    "change of the ego's velocity by the contact",
    "m/s",
    Danger::High,
    "plastic planar impact with friction (Kudlich 1966, Slibar 1966)",
    |encounter| delta_v(encounter, 0),
)
.reading_ahead();

pub(super) const DELTA_V_OTHER: Measure = Measure::new(
    "delta_v_other",
    "change of the other's velocity by the contact",
    "m/s",
    Danger::High,
    "plastic planar impact with friction (Kudlich 1966, Slibar 1966)",
    |encounter| delta_v(encounter, 1),
)
.reading_ahead();

pub(super) const P_SERIOUS: Measure = Measure::new(
    "p_serious",
    "risk of a serious injury by the contact",
    "",
    Danger::High,
    "MAIS3+ of the people at most risk (Lubbe et al. 2022, Wang 2022)",
    |encounter| of_first(encounter, |impact| impact.p_serious),
)
.reading_ahead();

pub(super) const IMPACT_ANGLE: Measure = Measure::new(
    "impact_angle",
    "angle between the headings at contact",
    "rad",
    Danger::Neutral,
    "0 is the same way, π head-on",
    |encounter| of_first(encounter, |impact| Ok(impact.angle)),
)
.reading_ahead();

pub(super) const IMPACT_OVERLAP: Measure = Measure::new(
    "impact_overlap",
    "share of the ego's width that the contact covers",
    "",
    Danger::Neutral,
    "1 is full overlap, less an offset",
    |encounter| of_first(encounter, |impact| Ok(impact.overlap)),
)
.reading_ahead();
