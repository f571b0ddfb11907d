//! What is in the way: predicted bodies by time, those near a profile, occupancy sets, and the edge of the road.

use nearmiss_base::geometry::{Footprint, Pose, Shape, Vector};
use nearmiss_scene::scenario::{DrivableArea, LaneletNetwork, Scenario};

use super::evaluate::CLEAR;
use super::forecast::Hypothesis;
use super::state::Station;
use super::{Limits, Settings, VehicleState};

/// One hypothesis about an obstacle's motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Whose, the obstacle's id.
    pub id: i64,
    /// How likely, 0 to 1.
    pub likelihood: f64,
    /// Whether contact with it is ruled out; else it only costs.
    pub avoided: bool,
}

/// The box that covers a body at one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Occupied {
    /// Place of its hypothesis in [`Traffic::bodies`].
    pub body: usize,
    /// Middle of the box, metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Cosine and sine of its heading.
    pub cos: f64,
    /// See `cos`.
    pub sin: f64,
    /// Metres.
    pub half_length: f64,
    /// Metres.
    pub half_width: f64,
    /// Half of its diagonal, metres.
    pub reach: f64,
    /// m/s along the heading.
    pub velocity: f64,
}

/// The predicted bodies of all obstacles at each step from now, each covered by a rectangle.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Traffic {
    /// The hypotheses.
    pub bodies: Vec<Body>,
    steps: Vec<Vec<Occupied>>,
}

/// The box of a footprint in its own frame: middle and half sizes, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    middle: Vector,
    half: Vector,
}

impl Extent {
    pub fn from_footprint(footprint: &Footprint) -> Self {
        let mut corners = footprint.corners().iter();
        let first = corners.next().map_or(Vector::zeros(), |p| p.coords);
        let (min, max) = corners.fold((first, first), |(min, max), p| {
            (min.inf(&p.coords), max.sup(&p.coords))
        });
        Self {
            middle: (min + max) / 2.0,
            half: (max - min) / 2.0,
        }
    }

    /// The box at `pose` with `velocity` m/s, of no body yet.
    pub fn at(&self, pose: &Pose, velocity: f64) -> Occupied {
        let (sin, cos) = pose.heading.sin_cos();
        let (m, half) = (self.middle, self.half);
        Occupied {
            body: 0,
            x: pose.position.x + cos * m.x - sin * m.y,
            y: pose.position.y + sin * m.x + cos * m.y,
            cos,
            sin,
            half_length: half.x,
            half_width: half.y,
            reach: half.norm(),
            velocity,
        }
    }
}

impl Traffic {
    /// No obstacle, for `steps` steps after now.
    #[must_use]
    pub fn new(steps: usize) -> Self {
        Self {
            bodies: Vec::new(),
            steps: vec![Vec::new(); steps + 1],
        }
    }

    /// Steps after now.
    #[must_use]
    pub fn horizon(&self) -> usize {
        self.steps.len().saturating_sub(1)
    }

    /// The occupied boxes `step` steps from now; beyond the horizon those at its end.
    #[must_use]
    pub fn at(&self, step: usize) -> &[Occupied] {
        let last = self.steps.len().saturating_sub(1);
        self.steps.get(step.min(last)).map_or(&[], Vec::as_slice)
    }

    /// Becomes those of `all` that are within `reach(step)` metres of (`x`, `y`) at each step; what it held is
    /// forgotten, its memory is used again.
    pub(super) fn keep_near(&mut self, all: &Self, x: f64, y: f64, reach: impl Fn(usize) -> f64) {
        self.bodies.clear();
        self.bodies.extend_from_slice(&all.bodies);
        self.steps.resize_with(all.steps.len(), Vec::new);
        for (step, (kept, there)) in self.steps.iter_mut().zip(&all.steps).enumerate() {
            let most = reach(step);
            kept.clear();
            kept.extend(
                there
                    .iter()
                    .filter(|o| (o.x - x).hypot(o.y - y) <= most + o.reach),
            );
        }
    }

    /// Adds a hypothesis; its boxes follow by [`Self::occupy`].
    pub fn add(&mut self, body: Body) -> usize {
        self.bodies.push(body);
        self.bodies.len() - 1
    }

    /// Puts a body's footprint at `pose` with `velocity` m/s, `step` steps from now; later steps are left out.
    pub fn occupy(
        &mut self,
        body: usize,
        step: usize,
        footprint: &Footprint,
        pose: &Pose,
        velocity: f64,
    ) {
        if let Some(there) = self.steps.get_mut(step) {
            let occupied = Extent::from_footprint(footprint).at(pose, velocity);
            there.push(Occupied { body, ..occupied });
        }
    }

    /// Adds a hypothesis with a box for each step.
    pub(super) fn add_all(&mut self, one: &Hypothesis) {
        let body = self.add(one.body);
        for (there, occupied) in self.steps.iter_mut().zip(&one.boxes) {
            there.push(Occupied { body, ..*occupied });
        }
    }
}

/// The box of the planned vehicle at one step.
#[derive(Debug, Clone, Copy)]
pub(super) struct EgoBox {
    pub x: f64,
    pub y: f64,
    pub cos: f64,
    pub sin: f64,
    pub half_length: f64,
    pub half_width: f64,
}

impl Occupied {
    /// The largest distance (m) between the two boxes' shadows on any of their four axes: below 0 exactly where they
    /// overlap, and never more than their distance.
    #[inline]
    pub(super) fn separation(&self, own: &EgoBox) -> f64 {
        let (dx, dy) = (self.x - own.x, self.y - own.y);
        let cos = (own.cos * self.cos + own.sin * self.sin).abs();
        let sin = (own.cos * self.sin - own.sin * self.cos).abs();
        let (al, aw, bl, bw) = (
            own.half_length,
            own.half_width,
            self.half_length,
            self.half_width,
        );
        let forward = (dx * own.cos + dy * own.sin).abs() - al - bl * cos - bw * sin;
        let left = (dy * own.cos - dx * own.sin).abs() - aw - bl * sin - bw * cos;
        let theirs = (dx * self.cos + dy * self.sin).abs() - bl - al * cos - aw * sin;
        let beside = (dy * self.cos - dx * self.sin).abs() - bw - al * sin - aw * cos;
        forward.max(left).max(theirs).max(beside)
    }
}

/// Bodies near the stations of a profile, step by step.
#[derive(Debug, Default)]
pub(super) struct CloseTraffic {
    boxes: Vec<Occupied>,
    /// Where the boxes of each step end.
    ends: Vec<usize>,
    /// Candidates faster than this at a step (m/s), or farther beside the path (m), have to look at all.
    fastest: Vec<f64>,
    widest: f64,
}

/// A candidate beside the path is faster than its profile by no more than this share and speed (m/s) but in sharp bends.
const SPEED_TOLERANCE: (f64, f64) = (1.1, 0.5);

/// Offsets go beyond the widest one by no more than this but for steep ones, metres.
const OFFSET_MARGIN: f64 = 0.5;

impl CloseTraffic {
    /// Takes from `traffic` what candidates along `stations` can meet; what it held is forgotten, its memory is used
    /// again.
    ///
    /// A body is left out if it is too far away to cost a candidate anything wherever that is beside its station, see
    /// `Judge::meet`: farther behind than bodies that are near, or farther away than one that is followed.
    pub fn take(
        &mut self,
        traffic: &Traffic,
        stations: &[Station],
        settings: &Settings,
        limits: &Limits,
    ) {
        self.boxes.clear();
        self.ends.clear();
        self.fastest.clear();
        self.widest = settings.sampling.widest + OFFSET_MARGIN;
        let aside = self.widest + limits.rear_to_centre;
        let own = (limits.length / 2.0).hypot(limits.width / 2.0);
        for (step, at) in stations.iter().enumerate() {
            let fastest = at.s[1] * SPEED_TOLERANCE.0 + SPEED_TOLERANCE.1;
            let stopping = settings.stopping(fastest);
            for other in traffic.at(step) {
                let (dx, dy) = (other.x - at.position.x, other.y - at.position.y);
                let near = own + other.reach + CLEAR;
                let ahead = stopping + near;
                let far = (ahead * ahead + near * near).sqrt() + aside;
                let along = dx * at.cos + dy * at.sin;
                if along > -(near + aside) && dx * dx + dy * dy < far * far {
                    self.boxes.push(*other);
                }
            }
            self.ends.push(self.boxes.len());
            self.fastest.push(fastest);
        }
    }

    /// The bodies at a step that a candidate with this speed (m/s) and offset (m) can meet; `None` where it has to look
    /// at all.
    #[inline]
    pub fn at(&self, step: usize, velocity: f64, offset: f64) -> Option<&[Occupied]> {
        if velocity > *self.fastest.get(step)? || offset.abs() > self.widest {
            return None;
        }
        let from = match step {
            0 => 0,
            _ => self.ends[step - 1],
        };
        self.boxes.get(from..self.ends[step])
    }
}

/// The area of all lanelets, and the body that has to stay on it.
#[derive(Debug, Clone)]
pub struct Road {
    area: DrivableArea,
    body: Footprint,
}

impl Road {
    /// The road of `network` for a body of these limits' size.
    ///
    /// All lanelets count, for whichever users: a pavement that is drawn as a lanelet is road here.
    #[must_use]
    pub fn new(network: &LaneletNetwork, limits: &Limits) -> Self {
        Self {
            area: network.drivable_area(None),
            body: Self::body_of(limits),
        }
    }

    /// The body of a vehicle of these limits' size, about its centre.
    #[must_use]
    pub fn body_of(limits: &Limits) -> Footprint {
        Footprint::new(Shape::rectangle(limits.length, limits.width))
            .expect("vehicles have a positive size")
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> &Footprint {
        &self.body
    }

    /// Whether all of the body is on the road.
    #[must_use]
    pub fn holds(&self, state: &VehicleState, limits: &Limits) -> bool {
        self.area.covers(&self.body.at(state.centre(limits).pose))
    }

    /// The first step at which the body leaves the road after it was on it.
    pub(super) fn left_at(
        &self,
        states: impl Iterator<Item = VehicleState>,
        limits: &Limits,
    ) -> Option<usize> {
        let mut on = false;
        for (step, state) in states.enumerate() {
            let holds = self.holds(&state, limits);
            if on && !holds {
                return Some(step);
            }
            on |= holds;
        }
        None
    }
}

/// Obstacles that are named; of more the rest is counted.
const MAX_LISTED: usize = 4;

/// Which obstacles of a scenario are given as regions that they may cover (set-based predictions), and what planner and
/// closed loop make of these, in a sentence; `None` if there is no such obstacle.
#[must_use]
pub fn occupancy_sets(scenario: &Scenario) -> Option<String> {
    let found = scenario.obstacles.iter().filter(|o| o.is_set_based());
    let found: Vec<i64> = found.map(|o| o.id).collect();
    let named: Vec<String> = found.iter().take(MAX_LISTED).map(i64::to_string).collect();
    let (who, is) = match (found.len(), named.split_last()) {
        (_, None) => return None,
        (1, Some((only, _))) => (format!("obstacle {only}"), "is"),
        (n, _) if n > MAX_LISTED => {
            let more = n - MAX_LISTED;
            (
                format!("obstacles {} and {more} more", named.join(", ")),
                "are",
            )
        }
        (_, Some((last, others))) => (format!("obstacles {} and {last}", others.join(", ")), "are"),
    };
    Some(format!(
        "{who} {is} given as regions (occupancy sets): the planner avoids the whole of every region; external planners are not told of them, and contact with one is a possible contact"
    ))
}
