//! Obstacles: all road users but the ego, and objects on or beside the road; where they are at a step, or may be.

use std::collections::{BTreeMap, BTreeSet};

use nearmiss_base::geometry::{
    Bounds, Footprint, Placed, Point, Pose, Shape, Vector, angle_between,
};
use serde::{Serialize, Serializer};

use super::{
    LONGEST_TRACK, Motion, ObstacleRole, ObstacleType, Position, Quantity, Sample, Signal, State,
    StateField, Steps, Track, in_frame,
};

/// Another participant, or a thing in the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// Unique in the scenario.
    pub id: i64,
    /// Whether it moves, stands, or is only feared.
    pub role: ObstacleRole,
    /// Its type.
    pub kind: ObstacleType,
    /// The region it covers, in its own frame; phantom obstacles have none.
    pub footprint: Option<Footprint>,
    /// Its first state; environment and phantom obstacles have none.
    pub initial: Option<State>,
    /// Its motion afterwards.
    pub prediction: Prediction,
    /// Its signals in order of time; the first may belong to the initial state.
    pub signals: Vec<SignalState>,
    track: Track,
    /// The footprint at the steps where its trailer is turned, by step.
    bent: Vec<(i64, Footprint)>,
    /// Where it may be, of a body that is given as an occupancy set.
    regions: Regions,
}

/// Everything that a file says about an obstacle.
#[derive(Debug, Clone, PartialEq)]
pub struct ObstacleParts {
    /// Unique in the scenario.
    pub id: i64,
    /// Whether it moves, stands, or is only feared.
    pub role: ObstacleRole,
    /// Its type.
    pub kind: ObstacleType,
    /// The region it covers, in its own frame.
    pub footprint: Option<Footprint>,
    /// Its first state.
    pub initial: Option<State>,
    /// Its motion afterwards.
    pub prediction: Prediction,
    /// Its signals.
    pub signals: Vec<SignalState>,
}

/// What an obstacle signals at a time; what is not said is not known.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SignalState {
    /// When.
    #[serde(rename = "time_step")]
    pub time: Steps,
    /// The signals that are said, on or off, in the file's order.
    #[serde(serialize_with = "by_name")]
    pub signals: Vec<(Signal, bool)>,
}

fn by_name<S: Serializer>(signals: &[(Signal, bool)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(signals.iter().copied())
}

/// What an obstacle does after its first state.
#[derive(Debug, Clone, PartialEq)]
pub enum Prediction {
    /// The file gives none.
    None,
    /// It follows these states.
    Trajectory(Vec<State>),
    /// It is somewhere in these regions of the world.
    Occupancies(Vec<Occupancy>),
}

/// A region of the world that an obstacle may cover for a while.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Occupancy {
    /// When.
    #[serde(rename = "time_step")]
    pub time: Steps,
    /// Where, in world coordinates.
    #[serde(rename = "shape")]
    pub region: Shape,
}

impl ObstacleParts {
    /// The uncertainty of its motion, in a sentence: states that give a region instead of a point.
    #[must_use]
    pub fn uncertainty(&self) -> Option<String> {
        let region = |s: &&State| matches!(s.position, Some(Position::Region(_)));
        match self.states().filter(region).count() {
            0 => None,
            count => Some(format!(
                "position is a region in {count} states; its centre is used"
            )),
        }
    }

    /// Where its heading is worked out, in a sentence: states with a place that say no orientation.
    #[must_use]
    pub fn without_orientation(&self) -> Option<String> {
        let is_round = |footprint: &Footprint| matches!(footprint.shape(), Shape::Circle { .. });
        let bare = |s: &&State| {
            s.position.is_some() && s.orientation.is_none() && s.point_mass_velocity().is_none()
        };
        let count = self.states().filter(bare).count();
        let turns = self.footprint.as_ref().is_some_and(|body| !is_round(body));
        (turns && count > 0).then(|| {
            format!(
                "no orientation in {count} states; taken from its motion, else along the x axis"
            )
        })
    }

    fn states(&self) -> impl Iterator<Item = &State> {
        states(self.initial.as_ref(), &self.prediction)
    }
}

impl Obstacle {
    /// An obstacle, with its motion worked out for time steps of `dt` seconds.
    #[must_use]
    pub fn new(parts: ObstacleParts, dt: f64) -> Self {
        let states = || parts.states();
        let bent = parts
            .footprint
            .iter()
            .flat_map(|straight| states().filter_map(|s| bent(straight, s)));
        let track = Track::new(states().filter_map(sample).collect(), dt, None);
        let bodily = matches!(parts.role, ObstacleRole::Static | ObstacleRole::Dynamic);
        let regions = match &parts.prediction {
            Prediction::Occupancies(all) if bodily => {
                Regions::new(all, track.iter().next().map(|(step, _)| step))
            }
            _ => Regions::default(),
        };
        Self {
            bent: bent.collect(),
            track,
            regions,
            id: parts.id,
            role: parts.role,
            kind: parts.kind,
            footprint: parts.footprint,
            initial: parts.initial,
            prediction: parts.prediction,
            signals: parts.signals,
        }
    }

    /// What a file says about it.
    #[must_use]
    pub fn parts(&self) -> ObstacleParts {
        ObstacleParts {
            id: self.id,
            role: self.role,
            kind: self.kind,
            footprint: self.footprint.clone(),
            initial: self.initial.clone(),
            prediction: self.prediction.clone(),
            signals: self.signals.clone(),
        }
    }

    /// Its recorded motion, one entry a time step; what an occupancy set says of it is none.
    ///
    /// A static obstacle has a single entry, which holds at all times: ask [`super::Scene`].
    #[must_use]
    pub fn track(&self) -> &Track {
        &self.track
    }

    /// The region it covers at a step, in its own frame: that of a semi-trailer truck turns at the hitch.
    #[must_use]
    pub fn footprint_at(&self, step: i64) -> Option<&Footprint> {
        if let Some(region) = self.region_at(step) {
            return Some(&region.footprint);
        }
        // One that stands has the body of its first state for ever.
        let step = match self.role {
            ObstacleRole::Static => self.track.steps().start,
            _ => step,
        };
        let bent = self.bent.iter().find(|(at, _)| *at == step);
        bent.map(|(_, footprint)| footprint)
            .or(self.footprint.as_ref())
    }

    /// The region it covers in its own frame, or the first one of an occupancy set.
    #[must_use]
    pub fn any_footprint(&self) -> Option<&Footprint> {
        let set = || self.regions.first().map(|region| &region.footprint);
        self.footprint.as_ref().or_else(set)
    }

    /// Whether an occupancy set says where it may be: then its motion is not known.
    #[must_use]
    pub fn is_set_based(&self) -> bool {
        !self.regions.is_empty()
    }

    /// Whether its body at a step is a region that it may cover, of an occupancy set: it has a place there, and no
    /// heading or velocity.
    #[must_use]
    pub fn is_occupancy_at(&self, step: i64) -> bool {
        self.region_at(step).is_some()
    }

    /// The region of its occupancy set at a step, where nothing better is known.
    pub(super) fn region_at(&self, step: i64) -> Option<&Region> {
        match self.role {
            ObstacleRole::Static => {
                let is_known = !self.track.steps().is_empty();
                self.regions.first().filter(|_| !is_known)
            }
            _ => self.regions.at(step),
        }
    }

    /// Its recorded states, the first included.
    pub fn states(&self) -> impl Iterator<Item = &State> {
        states(self.initial.as_ref(), &self.prediction)
    }
}

/// All states, the first included.
fn states<'a>(
    initial: Option<&'a State>,
    prediction: &'a Prediction,
) -> impl Iterator<Item = &'a State> {
    let later: &[State] = match prediction {
        Prediction::Trajectory(states) => states,
        _ => &[],
    };
    initial.into_iter().chain(later)
}

/// The footprint with the trailer turned as in the state; `None` without a trailer that turns.
fn bent(straight: &Footprint, state: &State) -> Option<(i64, Footprint)> {
    let angle = state.quantity(StateField::HitchAngle)?;
    let shape = straight.shape().hitched_at(angle.middle())?;
    Some((state.time.from, Footprint::new(shape).ok()?))
}

/// A point mass slower than this has no heading, m/s.
const STANDSTILL: f64 = 1e-3;

/// The motion in a state; `None` if it gives no position.
pub(super) fn sample(state: &State) -> Option<Sample> {
    let vector = state.point_mass_velocity();
    let direction = vector.filter(|v| v.norm() > STANDSTILL);
    let said = |quantity: Option<Quantity>| quantity.map(|q| q.middle());
    // A point mass may also give its velocity along the world's two axes.
    let across = vector.and(state.quantity(StateField::AccelerationY));
    let acceleration = match (said(state.acceleration), across) {
        (Some(x), Some(y)) => {
            let vector = Vector::new(x, y.middle());
            direction.map(|v| v.normalize().dot(&vector))
        }
        (along, _) => along,
    };
    Some(Sample {
        step: state.time.from,
        position: state.middle()?,
        heading: direction
            .map(|v| v.y.atan2(v.x))
            .or(said(state.orientation)),
        velocity: vector.map(|v| v.norm()).or(said(state.velocity)),
        acceleration,
    })
}

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
        _ => enclosing_shape(shapes)?,
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
fn enclosing_shape<'a>(shapes: impl Iterator<Item = &'a Shape>) -> Option<Shape> {
    let corners: Vec<Point> = shapes.flat_map(Shape::outlines).flatten().collect();
    let Bounds { min, max } = Bounds::from_points(&corners)?;
    Some(Shape::Polygon {
        vertices: vec![min, Point::new(max.x, min.y), max, Point::new(min.x, max.y)],
    })
}

impl Obstacle {
    /// Its motion at a step; static obstacles are present at all steps. Of a region of an occupancy set the place of its
    /// middle, and nothing else: see [`Self::is_occupancy_at`].
    #[must_use]
    pub fn motion_at(&self, step: i64) -> Option<&Motion> {
        if let Some(region) = self.region_at(step) {
            return Some(&region.motion);
        }
        match self.role {
            ObstacleRole::Static => self.track().iter().next().map(|(_, motion)| motion),
            _ => self.track().at(step),
        }
    }

    /// Its body at a step.
    #[must_use]
    pub fn placed_at(&self, step: i64) -> Option<Placed<'_>> {
        Some(self.footprint_at(step)?.at(self.motion_at(step)?.pose))
    }

    /// Its signals at a step; `None` if the file gives none.
    #[must_use]
    pub fn signals_at(&self, step: i64) -> Option<&SignalState> {
        let covers = |time: &Steps| (time.from..=time.to).contains(&step);
        self.signals.iter().find(|state| covers(&state.time))
    }

    /// Its yaw rate at a step, rad/s, and whether the file says it; else it is the change of the heading since the
    /// step before.
    #[must_use]
    pub fn yaw_rate_at(&self, step: i64, dt: f64) -> Option<(f64, bool)> {
        let said = self.states().find(|s| s.time == Steps::exact(step));
        if let Some(rate) = said.and_then(|s| s.quantity(StateField::YawRate)) {
            return Some((rate.middle(), true));
        }
        let heading = |step| self.track().at(step).map(|m| m.pose.heading);
        let turned = angle_between(heading(step.checked_sub(1)?)?, heading(step)?);
        Some((turned / dt, false))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

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
