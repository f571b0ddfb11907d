//! Where an obstacle may be that is given as an occupancy set: a region at each step, and no motion.

use std::collections::{BTreeMap, BTreeSet};

use super::{LONGEST_TRACK, Motion, Occupancy, in_frame};
use nearmiss_base::geometry::{Bounds, Footprint, Point, Pose, Shape};

/// A region that an obstacle may cover at a step.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Region {
    step: i64,
    /// Its middle; its velocity is not known, and stands as 0 here.
    pub motion: Motion,
    /// In the frame of its middle.
    pub footprint: Footprint,
}

/// The regions of an obstacle, one a step; steps without are not there.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Regions(Vec<Region>);

/// As many occupancies of one step become one region; of more the box around them does.
const MOST_UNITED: usize = 64;

impl Regions {
    /// The regions of a set; all that hold at a step are one region. At `known` the obstacle's place itself is known.
    pub fn new(occupancies: &[Occupancy], known: Option<i64>) -> Self {
        let mut changes: BTreeMap<i64, (Vec<usize>, Vec<usize>)> = BTreeMap::new();
        for (i, one) in occupancies.iter().enumerate() {
            changes.entry(one.time.from).or_default().0.push(i);
            let after = one.time.to.saturating_add(1);
            changes.entry(after).or_default().1.push(i);
        }
        let Some(first) = changes.keys().next().copied() else {
            return Self::default();
        };
        let end = first.saturating_add(LONGEST_TRACK).saturating_add(1);
        let ends: Vec<i64> = changes.keys().skip(1).map(|s| (*s).min(end)).collect();
        let (mut found, mut active) = (Vec::new(), BTreeSet::new());
        for ((from, (begin, over)), until) in changes.into_iter().zip(ends) {
            active.extend(begin);
            for i in over {
                active.remove(&i);
            }
            let Some((motion, footprint)) = region(active.iter().map(|i| &occupancies[*i].region))
            else {
                continue;
            };
            let steps = (from..until).filter(|step| Some(*step) != known);
            found.extend(steps.map(|step| Region {
                step,
                motion,
                footprint: footprint.clone(),
            }));
        }
        Self(found)
    }

    pub fn at(&self, step: i64) -> Option<&Region> {
        let place = self.0.binary_search_by_key(&step, |region| region.step);
        Some(&self.0[place.ok()?])
    }

    pub fn first(&self) -> Option<&Region> {
        self.0.first()
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Shapes of the world as one region, and its middle.
fn region<'a>(shapes: impl ExactSizeIterator<Item = &'a Shape>) -> Option<(Motion, Footprint)> {
    let united = match shapes.len() {
        0..=MOST_UNITED => Shape::union(shapes.cloned().collect())?,
        _ => around(shapes)?,
    };
    let heading = match &united {
        Shape::Rectangle { orientation, .. } => *orientation,
        _ => 0.0,
    };
    let pose = Pose {
        position: united.centroid()?,
        heading,
    };
    let footprint = Footprint::new(in_frame(&united, &pose)).ok()?;
    let motion = Motion {
        pose,
        velocity: 0.0,
        acceleration: 0.0,
    };
    Some((motion, footprint))
}

/// The box that holds all shapes.
fn around<'a>(shapes: impl Iterator<Item = &'a Shape>) -> Option<Shape> {
    let corners: Vec<Point> = shapes.flat_map(Shape::outlines).flatten().collect();
    let Bounds { min, max } = Bounds::from_points(&corners)?;
    Some(Shape::Polygon {
        vertices: vec![min, Point::new(max.x, min.y), max, Point::new(min.x, max.y)],
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scenario::Steps;

    fn occupancy(from: i64, to: i64, x: f64) -> Occupancy {
        Occupancy {
            time: Steps { from, to },
            region: Shape::Circle {
                radius: 1.0,
                center: Point::new(x, 0.0),
            },
        }
    }

    #[test]
    fn each_step_has_all_that_holds_at_it() {
        let set = [
            occupancy(1, 2, 0.0),
            occupancy(2, 3, 10.0),
            occupancy(6, 6, 4.0),
        ];
        let regions = Regions::new(&set, Some(1));
        let x = |step| regions.at(step).map(|r| r.motion.pose.position.x);
        assert_eq!(x(1), None, "its place is known then");
        assert!((x(2).unwrap() - 5.0).abs() < 1e-9, "both hold");
        assert!((x(3).unwrap() - 10.0).abs() < 1e-9);
        assert_eq!((x(4), x(5), x(7)), (None, None, None), "gaps stay gaps");
        let holds = |step, x| {
            let region = regions.at(step).unwrap();
            region
                .footprint
                .at(region.motion.pose)
                .holds(&Point::new(x, 0.0))
        };
        assert!(holds(2, 0.0) && holds(2, 10.0) && !holds(2, 5.0));
        assert!(holds(6, 4.5) && !holds(6, 5.5));
    }

    #[test]
    fn open_sets_and_crowds_end() {
        let open = Regions::new(&[occupancy(0, i64::MAX, 0.0)], None);
        assert!(open.at(LONGEST_TRACK).is_some() && open.at(LONGEST_TRACK + 1).is_none());
        let crowd: Vec<_> = (0..200).map(|i| occupancy(0, 0, f64::from(i))).collect();
        let region = Regions::new(&crowd, None);
        let (length, width) = region.first().unwrap().footprint.shape().size();
        assert!((length - 201.0).abs() < 0.1 && (width - 2.0).abs() < 0.1);
    }
}
