//! The area that a body sweeps in its recording, as convex pieces in a tree of boxes over time.

use crate::geometry::{Bounds, Footprint, Point, Pose, Vector, convex_hull, convex_overlap};

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

/// What a body covers in its recording.
///
/// Between two recorded steps each part sweeps the convex hull of both places.
#[derive(Debug, Clone, Default)]
pub(in crate::metrics) struct Swept {
    stays: Vec<Stay>,
    /// A heap of boxes: node n has the children 2n and 2n + 1, the leaves are the stays.
    tree: Vec<Option<Bounds>>,
}

/// Movements below this are none, metres and radians.
const STILL: f64 = 1e-4;

/// A gap in the recording longer than this is not swept, steps.
const LONGEST_GAP: i64 = 1;

impl Swept {
    /// The area of bodies in order of time; coordinates are taken from `origin`.
    pub fn of<'a>(
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
        let leaves = stays.len().next_power_of_two();
        let mut tree = vec![None; 2 * leaves];
        for (place, stay) in stays.iter().enumerate() {
            tree[leaves + place] = Some(stay.bounds);
        }
        for node in (1..leaves).rev() {
            let (a, b): (Option<Bounds>, Option<Bounds>) = (tree[2 * node], tree[2 * node + 1]);
            tree[node] = match (a, b) {
                (Some(a), Some(b)) => Some(a.union(&b)),
                (a, b) => a.or(b),
            };
        }
        Self { stays, tree }
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

    /// Whether the boxes of both areas meet at all.
    pub fn near(&self, other: &Self) -> bool {
        let root = |s: &Self| s.tree.get(1).copied().flatten();
        root(self)
            .zip(root(other))
            .is_some_and(|(a, b)| a.overlaps(&b))
    }

    fn meets(&self, body: &[Vec<Point>], around: &Bounds) -> bool {
        let leaves = self.tree.len() / 2;
        let mut open = vec![1];
        while let Some(node) = open.pop() {
            let Some(Some(bounds)) = self.tree.get(node) else {
                continue;
            };
            if !bounds.overlaps(around) {
                continue;
            }
            if node < leaves {
                open.extend([2 * node + 1, 2 * node]);
                continue;
            }
            let swept = &self.stays[node - leaves].swept;
            if swept
                .iter()
                .any(|a| body.iter().any(|b| convex_overlap(a, b)))
            {
                return true;
            }
        }
        false
    }
}

fn bounds(rings: &[Vec<Point>]) -> Bounds {
    let none = Bounds {
        min: Point::origin(),
        max: Point::origin(),
    };
    Bounds::of(rings.iter().flatten()).unwrap_or(none)
}
