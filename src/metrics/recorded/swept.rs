//! The area that a body sweeps in its recording, as convex pieces in a tree of boxes over time.

use crate::geometry::{
    Bounds, BoxTree, Footprint, Point, Pose, Vector, convex_hull, convex_overlap,
};

/// A body that stands from one step to another.
#[derive(Debug, Clone)]
struct Stay {
    from: i64,
    to: i64,
    /// The convex hull of each part of the body.
    body: Vec<Vec<Point>>,
    /// The hull of each part here and at the next stay.
    swept: Vec<Vec<Point>>,
    bounds: Bounds,
}

/// The area that a body sweeps in its recording.
///
/// Between two recorded steps each part sweeps the convex hull of both places.
#[derive(Debug, Clone, Default)]
pub(in crate::metrics) struct Swept {
    stays: Vec<Stay>,
    /// Boxes around what the stays sweep.
    tree: BoxTree,
    /// Coordinates are taken from here.
    origin: Vector,
}

/// Movements below this are none, metres and radians.
const STILL: f64 = 1e-4;

/// A gap in the recording longer than this is not swept, steps.
const LONGEST_GAP: i64 = 1;

impl Swept {
    /// The area of bodies in order of time; coordinates are taken from `origin`.
    pub fn from_poses<'a>(
        bodies: impl Iterator<Item = (i64, Pose, &'a Footprint)>,
        origin: Vector,
    ) -> Self {
        let mut stays: Vec<Stay> = Vec::new();
        let mut last: Option<Pose> = None;
        for (step, mut pose, footprint) in bodies {
            pose.position -= origin;
            let stands = last.is_some_and(|l| {
                (l.position - pose.position).norm() < STILL
                    && (l.heading - pose.heading).abs() < STILL
            });
            if let (true, Some(stay)) = (stands, stays.last_mut()) {
                stay.to = step;
                continue;
            }
            last = Some(pose);
            let rings = footprint.at(pose).outlines();
            let body: Vec<_> = rings.iter().map(|ring| convex_hull(ring)).collect();
            if let Some(before) = stays.last_mut()
                && step - before.to <= LONGEST_GAP
                && before.body.len() == body.len()
            {
                let parts = before.body.iter().zip(&body);
                before.swept = parts
                    .map(|(a, b)| convex_hull(&[&a[..], &b[..]].concat()))
                    .collect();
                before.bounds = bounds(&before.swept);
            }
            stays.push(Stay {
                from: step,
                to: step,
                bounds: bounds(&body),
                swept: body.clone(),
                body,
            });
        }
        let tree = BoxTree::new(stays.iter().map(|stay| stay.bounds));
        Self {
            stays,
            tree,
            origin,
        }
    }

    /// The first and the last step at which this body is where the other sweeps.
    pub fn inside(&self, other: &Self) -> Option<(i64, i64)> {
        let meets = |stay: &&Stay| other.meets(&stay.body, &bounds(&stay.body));
        let first = self.stays.iter().find(meets)?;
        let last = self.stays.iter().rev().find(meets)?;
        Some((first.from, last.to))
    }

    /// Whether both move at all.
    pub fn moves(&self) -> bool {
        self.stays.len() > 1
    }

    /// The first and the last recorded step.
    pub fn steps(&self) -> Option<(i64, i64)> {
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
