//! Intersections: turns between the ends of roads, and the roads that lead in.

use std::error::Error;

use nearmiss::geometry::{Pose, angle_between};
use nearmiss::scenario::{Incoming, Intersection, LineMarking};

use super::map::{Kind, Lane, Map, back, taper};
use super::path::Path;

/// A road that ends at an intersection.
#[derive(Debug)]
pub struct Arm<'a> {
    /// The road's centre line.
    pub path: &'a Path,
    /// Where the intersection cuts it off.
    pub s: f64,
    /// Whether one enters the intersection along the centre line.
    pub along: bool,
    /// Lanelets in, from right to left.
    pub entering: &'a [i64],
    /// Lanelets out, from right to left as seen when leaving.
    pub leaving: &'a [i64],
    /// Lane centres beside the centre line, from the outermost, and their width.
    pub centres: &'a [f64],
    /// Width of the lanes.
    pub width: f64,
}

impl Arm<'_> {
    /// Where a lane enters, from right to left.
    pub fn entry(&self, lane: usize) -> Pose {
        let pose = self.path.pose(
            self.s,
            if self.along { -1.0 } else { 1.0 } * self.centres[lane],
        );
        if self.along { pose } else { back(pose) }
    }

    /// Where a lane leaves, from right to left.
    pub fn exit(&self, lane: usize) -> Pose {
        let pose = self.path.pose(
            self.s,
            if self.along { 1.0 } else { -1.0 } * self.centres[lane],
        );
        if self.along { back(pose) } else { pose }
    }
}

/// Radius and clothoid of turns to the right.
pub const RIGHT: (f64, f64) = (6.5, 3.5);

/// Radius and clothoid of turns to the left.
pub const LEFT: (f64, f64) = (9.5, 5.0);

/// Lays turns between all arms, given counter-clockwise; the intersection gets the id `id`, its
/// incomings those that follow, the lanelets those from `first` on.
pub fn lay(map: &mut Map, id: i64, first: i64, arms: &[Arm<'_>]) -> Result<(), Box<dyn Error>> {
    let mut next = first;
    let mut incomings = Vec::new();
    for (i, arm) in arms.iter().enumerate() {
        let number = |place: usize| id + 1 + place as i64;
        let mut incoming = Incoming {
            id: number(i),
            lanelets: arm.entering.to_vec(),
            // Only with four arms is everybody's neighbour on the left the next one.
            is_left_of: (arms.len() == 4).then(|| number((i + 1) % 4)),
            ..Incoming::default()
        };
        for (j, target) in arms.iter().enumerate().filter(|(j, _)| *j != i) {
            let angle = angle_between(arm.entry(0).heading, target.exit(0).heading);
            let (leftmost_in, leftmost_out) = (arm.entering.len() - 1, target.leaving.len() - 1);
            let (list, (radius, spiral), pairs) = match angle {
                ..-0.5 => (&mut incoming.right, RIGHT, vec![(0, 0)]),
                0.5.. => (&mut incoming.left, LEFT, vec![(leftmost_in, leftmost_out)]),
                _ => {
                    let lanes = 0..arm.entering.len().min(target.leaving.len());
                    (
                        &mut incoming.straight,
                        RIGHT,
                        lanes.map(|k| (k, k)).collect(),
                    )
                }
            };
            for (from, to) in pairs {
                let turn = Path::between(arm.entry(from), target.exit(to), radius, spiral);
                let turn = turn.ok_or(format!("no room to turn from arm {i} to arm {j}"))?;
                let edge = |side: f64| {
                    taper(
                        side * arm.width / 2.0,
                        side * target.width / 2.0,
                        LineMarking::NoMarking,
                    )
                };
                let lanes = [Lane::Along(Kind::Junction)];
                map.road(
                    &turn,
                    (0.0, turn.length()),
                    next,
                    &[edge(-1.0), edge(1.0)],
                    &lanes,
                );
                list.push(next);
                next += 1;
            }
        }
        incomings.push(incoming);
    }
    map.intersection(Intersection {
        id,
        incomings,
        crossings: Vec::new(),
    });
    Ok(())
}
