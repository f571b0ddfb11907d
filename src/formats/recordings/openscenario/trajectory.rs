//! Trajectories with times, and positions: in the world, on roads and lanes, and relative to entities.

use std::collections::HashMap;

use nearmiss_base::geometry::{Point, Pose, Vector, angle_between};

use super::motion::Motions;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::Report;
use crate::recordings::opendrive::Network;
use crate::recordings::opendrive::tree::Node;

/// Moments nearer to each other are the same, seconds.
pub const SAME_TIME: f64 = 1e-6;

/// Vertices nearer to each other are at one place, metres.
const SAME_PLACE: f64 = 1e-3;

/// A vertex as a file tells it.
#[derive(Debug, Clone, Copy)]
pub struct TimedVertex {
    /// Seconds from the beginning of the scenario.
    pub time: f64,
    pub pose: Pose,
    /// Whether the heading of its pose was told.
    pub has_heading: bool,
}

/// A trajectory that an entity follows.
#[derive(Debug, Clone)]
pub struct Followed {
    /// When it begins to follow it at the earliest, seconds.
    triggered: f64,
    vertices: Vec<Vertex>,
}

#[derive(Debug, Clone, Copy)]
struct Vertex {
    time: f64,
    position: Point,
    /// Headings at the end of the segment before it, and at the beginning of the one behind it.
    headings: [f64; 2],
}

impl Followed {
    /// A trajectory through some vertices in order of time, from a moment on; `None` of no vertex.
    ///
    /// A vertex that tells no heading looks along each of its segments; where the entity stands, it looks as it did before.
    pub fn through(told: Vec<TimedVertex>, triggered: f64) -> Option<Self> {
        let along = |a: &TimedVertex, b: &TimedVertex| {
            let way: Vector = b.pose.position - a.pose.position;
            (way.norm() > SAME_PLACE).then(|| way.y.atan2(way.x))
        };
        let ways: Vec<Option<f64>> = told.windows(2).map(|p| along(&p[0], &p[1])).collect();
        let first = told.first()?;
        let mut held = if first.has_heading {
            first.pose.heading
        } else {
            ways.iter()
                .flatten()
                .next()
                .copied()
                .unwrap_or(first.pose.heading)
        };
        let mut vertices = Vec::with_capacity(told.len());
        for (i, vertex) in told.iter().enumerate() {
            let before = i.checked_sub(1).and_then(|b| ways[b]).unwrap_or(held);
            let behind = ways.get(i).copied().flatten().unwrap_or(before);
            let headings = if vertex.has_heading {
                [vertex.pose.heading; 2]
            } else {
                [before, behind]
            };
            held = headings[1];
            vertices.push(Vertex {
                time: vertex.time,
                position: vertex.pose.position,
                headings,
            });
        }
        Some(Self {
            triggered,
            vertices,
        })
    }

    /// When it begins to be on it, seconds.
    pub fn begins(&self) -> f64 {
        let first = self.vertices.first().map_or(0.0, |v| v.time);
        first.max(self.triggered)
    }

    /// When it has arrived at its end, seconds.
    pub fn ends(&self) -> f64 {
        self.vertices.last().map_or(0.0, |v| v.time)
    }

    /// How fast it is at its end, m/s.
    pub fn last_speed(&self) -> f64 {
        let Some([a, b]) = self.vertices.last_chunk() else {
            return 0.0;
        };
        let seconds = (b.time - a.time).max(SAME_TIME);
        (b.position - a.position).norm() / seconds
    }

    /// The pose at a moment: at its ends before the first vertex and after the last.
    pub fn at(&self, time: f64) -> Option<Pose> {
        let next = self
            .vertices
            .partition_point(|v| v.time <= time + SAME_TIME);
        let Some(place) = next.checked_sub(1) else {
            let first = self.vertices.first()?;
            return Some(pose(first.position, first.headings[1]));
        };
        let from = self.vertices[place];
        let Some(to) = self.vertices.get(next) else {
            return Some(pose(from.position, from.headings[0]));
        };
        let share = if time - from.time < SAME_TIME {
            0.0
        } else {
            (time - from.time) / (to.time - from.time)
        };
        let turn = angle_between(from.headings[1], to.headings[0]);
        Some(pose(
            from.position + (to.position - from.position) * share,
            from.headings[1] + turn * share,
        ))
    }
}

fn pose(position: Point, heading: f64) -> Pose {
    Pose { position, heading }
}

/// Positions that are read.
const POSITIONS: [&str; 5] = [
    "WorldPosition",
    "RelativeWorldPosition",
    "RelativeObjectPosition",
    "LanePosition",
    "RoadPosition",
];

/// A place further than this beyond an end of its road is told, metres.
const MAX_OVERSHOOT: f64 = 0.1;

/// The kind of a position that only a player works out: of a kind that is not read, or told from an entity that begins
/// at such a one.
pub fn unread_position(position: &Node, all: &HashMap<String, Motions>) -> Option<String> {
    let of = position.children().next()?;
    let base = of.text("entityRef").and_then(|name| all.get(name));
    let unread = !POSITIONS.contains(&of.name.as_str());
    let from_unread = base.is_some_and(|m| m.start.is_none() && m.other.is_some());
    (unread || from_unread).then(|| of.name.clone())
}

/// Whether a position tells a heading.
pub fn has_heading(position: &Node) -> bool {
    let Some(of) = position.children().next() else {
        return false;
    };
    of.text("h").is_some()
        || of
            .child("Orientation")
            .is_some_and(|o| o.text("h").is_some())
}

/// The pose of a position; `known` tells where entities are.
pub fn position_of(
    node: &Node,
    known: &dyn Fn(&str) -> Option<Pose>,
    network: Option<&Network>,
    report: &Report,
) -> Result<Pose, ReadError> {
    let Some(of) = node.children().next() else {
        return Err(node.fail("no position in it"));
    };
    let other = || -> Result<Pose, ReadError> {
        let name = of.needed("entityRef")?;
        known(name).ok_or_else(|| of.fail(format!("entityRef=\"{name}\" has no known position")))
    };
    let turn = |base: f64, along: f64| -> Result<f64, ReadError> {
        let Some(orientation) = of.child("Orientation") else {
            return Ok(along);
        };
        let h = orientation.or_zero("h")?;
        Ok(match orientation.text("type") {
            Some("relative") => base + h,
            _ => h,
        })
    };
    let road = || {
        network.ok_or_else(|| {
            of.fail("a position on a road, but the scenario names no road file that is there")
        })
    };
    // Players go no further than the end of a road.
    let along = |id: &str, s: f64| {
        let length = network.and_then(|network| network.length(id));
        if let Some(length) =
            length.filter(|length| !(-MAX_OVERSHOOT..=length + MAX_OVERSHOOT).contains(&s))
        {
            let at = report.row(of.line, of.name.as_str());
            at.warn(format!(
                "s={s} is not on road `{id}`, which is {length:.2} m long; taken as its {}",
                if s < 0.0 { "beginning" } else { "end" }
            ));
        }
        s
    };
    let missing = |id: &str| of.fail(format!("road `{id}` or its lane is not in the road file"));
    match of.name.as_str() {
        "WorldPosition" => {
            let (x, y) = (of.needed_number("x")?, of.needed_number("y")?);
            let pose = Pose::new(x, y, of.or_zero("h")?);
            Ok(network.map_or(pose, |network| network.in_world(pose)))
        }
        "RelativeWorldPosition" => {
            let base = other()?;
            let heading = turn(base.heading, base.heading)?;
            Ok(Pose::new(
                base.position.x + of.or_zero("dx")?,
                base.position.y + of.or_zero("dy")?,
                heading,
            ))
        }
        "RelativeObjectPosition" => {
            let base = other()?;
            let at = base.to_world(&Point::new(of.or_zero("dx")?, of.or_zero("dy")?));
            let heading = turn(base.heading, base.heading)?;
            Ok(Pose { position: at, heading })
        }
        "LanePosition" => {
            let (id, lane) = (of.needed("roadId")?, of.needed_number("laneId")? as i64);
            let (s, offset) = (of.needed_number("s")?, of.or_zero("offset")?);
            let pose = road()?.on_lane(id, lane, along(id, s), offset).ok_or_else(|| missing(id))?;
            let heading = turn(pose.heading, pose.heading)?;
            Ok(Pose { heading, ..pose })
        }
        "RoadPosition" => {
            let (id, s) = (of.needed("roadId")?, of.needed_number("s")?);
            let pose = road()?.pose_beside(id, along(id, s), of.or_zero("t")?).ok_or_else(|| missing(id))?;
            let heading = turn(pose.heading, pose.heading)?;
            Ok(Pose { heading, ..pose })
        }
        name => Err(of.fail(format!(
            "<{name}> is not read; positions are read in the world, on roads and lanes, and relative to entities"
        ))),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn told(time: f64, x: f64, y: f64, heading: Option<f64>) -> TimedVertex {
        TimedVertex {
            time,
            pose: Pose::new(x, y, heading.unwrap_or(7.0)),
            has_heading: heading.is_some(),
        }
    }

    fn headings(vertices: &[TimedVertex], times: &[f64]) -> Vec<f64> {
        let followed = Followed::through(vertices.to_vec(), 0.0).unwrap();
        let at = |t: &f64| followed.at(*t).unwrap().heading;
        times.iter().map(at).collect()
    }

    #[test]
    fn vertices_without_heading_look_along_their_own_segments() {
        let corner = [
            told(0.0, 0.0, 0.0, None),
            told(2.0, 20.0, 0.0, None),
            told(4.0, 20.0, 20.0, None),
        ];
        assert_eq!(
            headings(&corner, &[0.0, 0.5, 1.999, 2.0, 3.0, 4.0]),
            [0.0, 0.0, 0.0, FRAC_PI_2, FRAC_PI_2, FRAC_PI_2]
        );
        // It stands for two seconds, looking as it came.
        let halt = [
            told(0.0, 0.0, 0.0, None),
            told(2.0, 0.0, 20.0, None),
            told(4.0, 0.0, 20.0, None),
            told(6.0, 20.0, 20.0, None),
        ];
        assert_eq!(
            headings(&halt, &[1.0, 3.0, 5.0]),
            [FRAC_PI_2, FRAC_PI_2, 0.0]
        );
        // One that stands first looks where it will go.
        let waits = [
            told(0.0, 0.0, 0.0, None),
            told(2.0, 0.0, 0.0, None),
            told(4.0, -9.0, 0.0, None),
        ];
        assert_eq!(headings(&waits, &[0.0, 1.0, 3.0]), [PI, PI, PI]);
        assert_eq!(headings(&[told(0.0, 0.0, 0.0, None)], &[5.0]), [7.0]);
    }

    #[test]
    fn told_headings_change_evenly_also_over_the_half_turn() {
        let wraps = [
            told(0.0, 0.0, 0.0, Some(3.0)),
            told(2.0, 9.0, 0.0, Some(-3.0)),
        ];
        let middle = headings(&wraps, &[1.0])[0];
        assert!((middle - PI).abs() < 1e-9, "{middle}");
        // It drives backwards along x.
        let back = [
            told(0.0, 9.0, 0.0, Some(0.0)),
            told(2.0, 0.0, 0.0, Some(0.0)),
        ];
        assert_eq!(headings(&back, &[0.0, 1.0, 2.0]), [0.0; 3]);
        // From a told heading to the direction of the segment.
        let mixed = [told(0.0, 0.0, 0.0, Some(1.0)), told(2.0, 9.0, 0.0, None)];
        assert_eq!(headings(&mixed, &[0.0, 1.0, 2.0]), [1.0, 0.5, 0.0]);
    }

    #[test]
    fn it_is_at_its_ends_outside_of_its_times() {
        let line = vec![told(1.0, 0.0, 0.0, None), told(3.0, 4.0, 0.0, None)];
        let followed = Followed::through(line, 2.0).unwrap();
        let x = |t: f64| followed.at(t).unwrap().position.x;
        assert_eq!([0.0, 1.0, 2.0, 3.0, 9.0].map(x), [0.0, 0.0, 2.0, 4.0, 4.0]);
        assert_eq!((followed.begins(), followed.ends()), (2.0, 3.0));
        assert_eq!(followed.last_speed(), 2.0);
        assert!(Followed::through(Vec::new(), 0.0).is_none());
    }
}
