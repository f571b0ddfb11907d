//! Measures of the recording: what the bodies do from a step on, as it was recorded, and the areas that they sweep.

pub(super) mod conflict;
pub(super) mod manoeuvre;

pub(super) use conflict::{Closest, Conflict};
pub(super) use manoeuvre::Starts;

use nearmiss_base::geometry::{
    Bounds, BoxTree, Footprint, Placed, Point, Pose, Sweep, Vector, convex_hull, convex_overlap,
};

use crate::scenario::driven_way;

/// A body that stands from one time to another, and its way to where it stands next. Times are in steps.
#[derive(Debug, Clone)]
struct Occupancy {
    from: f64,
    to: f64,
    footprint: Footprint,
    pose: Pose,
    /// The convex hull of each part of the body.
    body: Vec<Vec<Point>>,
    /// Whether it goes from here to the next stay, without a gap.
    goes_on: bool,
    /// The hull of each part here and at the next stay.
    swept: Vec<Vec<Point>>,
    bounds: Bounds,
}

/// The area that a body sweeps in its recording.
///
/// Between two recorded steps it goes evenly, and each part sweeps the convex hull of both places; where it turns, of
/// places in between.
#[derive(Debug, Clone, Default)]
pub(in crate::metrics) struct Swept {
    stays: Vec<Occupancy>,
    /// Boxes around what the stays sweep.
    tree: BoxTree,
    /// Coordinates are taken from here.
    origin: Vector,
}

/// Movements below this are none, metres and radians.
const MIN_MOVEMENT: f64 = 1e-4;

/// A gap in the recording longer than this is not swept, steps.
const LONGEST_GAP: i64 = 1;

/// A hull is of places between which the body turns no more than this, radians.
const TURN: f64 = 0.05;

/// Times are found to this share of the way from one place to the next.
const TIME_TOLERANCE: f64 = 1e-5;

impl Swept {
    /// The area of bodies in order of time, with steps `dt` seconds apart; coordinates are taken from `origin`.
    pub fn from_poses<'a>(
        bodies: impl Iterator<Item = (i64, Pose, &'a Footprint)>,
        dt: f64,
        origin: Vector,
    ) -> Self {
        let mut stays: Vec<Occupancy> = Vec::new();
        let mut before: Option<(i64, Placed<'a>)> = None;
        for (step, mut pose, footprint) in bodies {
            pose.position -= origin;
            let here = footprint.at(pose);
            let (last, time) = (before.replace((step, here)), step as f64);
            let stands = stays.last().is_some_and(|stay| {
                (stay.pose.position - pose.position).norm() < MIN_MOVEMENT
                    && (stay.pose.heading - pose.heading).abs() < MIN_MOVEMENT
                    && stay.footprint == *footprint
            });
            if let (true, Some(stay)) = (stands, stays.last_mut()) {
                stay.to = time;
                continue;
            }
            let way = last
                .filter(|(earlier, _)| step - earlier <= LONGEST_GAP)
                .and_then(|(earlier, place)| Some((earlier as f64, driven_way(place, here, dt)?)));
            if let Some((earlier, way)) = way {
                let parts = (way.turn().abs() / TURN).ceil().max(1.0);
                let shares = (1..parts as u32).map(|part| f64::from(part) / parts);
                for share in shares {
                    let time = earlier + (time - earlier) * share;
                    Occupancy::after(&mut stays, time, &way.at(share), true);
                }
            }
            Occupancy::after(&mut stays, time, &here, way.is_some());
        }
        let tree = BoxTree::new(stays.iter().map(|stay| stay.bounds));
        Self {
            stays,
            tree,
            origin,
        }
    }

    /// The first and the last time at which this body is where the other sweeps, in steps.
    pub fn inside(&self, other: &Self) -> Option<(f64, f64)> {
        let stands = |stay: &Occupancy| other.meets(&stay.body, &bounds(&stay.body));
        let first = (0..self.stays.len()).find_map(|place| {
            let stay = other.met_near(&self.stays[place])?;
            if stands(stay) {
                Some(stay.from)
            } else {
                self.met_on(place, other, false)
            }
        })?;
        let last = (0..self.stays.len()).rev().find_map(|place| {
            let stay = other.met_near(&self.stays[place])?;
            let on_the_way = self.met_on(place, other, true);
            on_the_way.or_else(|| stands(stay).then_some(stay.to))
        })?;
        Some((first, last))
    }

    /// A stay of another body that sweeps something of this area.
    fn met_near<'s>(&self, stay: &'s Occupancy) -> Option<&'s Occupancy> {
        self.meets(&stay.swept, &stay.bounds).then_some(stay)
    }

    /// The first time on the way from the stay at a place to the next one at which this body is where the other sweeps,
    /// or the last one.
    fn met_on(&self, place: usize, other: &Self, last: bool) -> Option<f64> {
        let stay = self.stays.get(place).filter(|stay| stay.goes_on)?;
        let next = self.stays.get(place + 1)?;
        let way = Sweep::new(stay.place(), next.place());
        let mut open = vec![(0.0, 1.0)];
        while let Some((from, to)) = open.pop() {
            let swept = hulls(&hull_parts(&way.at(from)), &hull_parts(&way.at(to)));
            if !other.meets(&swept, &bounds(&swept)) {
                continue;
            }
            if to - from <= TIME_TOLERANCE {
                let share = if last { to } else { from };
                return Some(stay.to + (next.from - stay.to) * share);
            }
            let middle = f64::midpoint(from, to);
            let mut halves = [(middle, to), (from, middle)];
            if last {
                halves.reverse();
            }
            open.extend(halves);
        }
        None
    }

    /// Whether both move at all.
    pub fn moves(&self) -> bool {
        self.stays.len() > 1
    }

    /// The first and the last recorded time, in steps.
    pub fn times(&self) -> Option<(f64, f64)> {
        Some((self.stays.first()?.from, self.stays.last()?.to))
    }

    /// Whether a box meets that of any part of the area; both in the world.
    pub fn near(&self, around: &Bounds) -> bool {
        let local = Bounds {
            min: around.min - self.origin,
            max: around.max - self.origin,
        };
        self.tree.any_meeting(&local, |_| true)
    }

    fn meets(&self, body: &[Vec<Point>], around: &Bounds) -> bool {
        self.tree.any_meeting(around, |place| {
            let swept = &self.stays[place].swept;
            swept
                .iter()
                .any(|a| body.iter().any(|b| convex_overlap(a, b)))
        })
    }
}

impl Occupancy {
    fn place(&self) -> Placed<'_> {
        self.footprint.at(self.pose)
    }

    /// Adds a stay after the others, with a way there from the last one if it is swept.
    fn after(stays: &mut Vec<Self>, time: f64, place: &Placed<'_>, swept: bool) {
        let body = hull_parts(place);
        if let Some(before) = stays.last_mut().filter(|_| swept)
            && before.body.len() == body.len()
        {
            before.goes_on = true;
            before.swept = hulls(&before.body, &body);
            before.bounds = bounds(&before.swept);
        }
        stays.push(Self {
            from: time,
            to: time,
            footprint: place.footprint.clone(),
            pose: place.pose,
            goes_on: false,
            bounds: bounds(&body),
            swept: body.clone(),
            body,
        });
    }
}

fn hull_parts(place: &Placed<'_>) -> Vec<Vec<Point>> {
    let rings = place.outlines();
    rings.iter().map(|ring| convex_hull(ring)).collect()
}

/// The hull of each part of a body at both places.
fn hulls(a: &[Vec<Point>], b: &[Vec<Point>]) -> Vec<Vec<Point>> {
    let parts = a.iter().zip(b);
    parts
        .map(|(a, b)| convex_hull(&[&a[..], &b[..]].concat()))
        .collect()
}

/// Boxes are wider by this, metres, so that they hold what touches.
const BORDER: f64 = 1e-6;

fn bounds(rings: &[Vec<Point>]) -> Bounds {
    let none = Bounds {
        min: Point::origin(),
        max: Point::origin(),
    };
    let tight = Bounds::from_points(rings.iter().flatten()).unwrap_or(none);
    let border = Vector::repeat(BORDER);
    Bounds {
        min: tight.min - border,
        max: tight.max + border,
    }
}
