//! Predicted bodies by time: oriented boxes at each step of the horizon.

use super::forecast_cache::Hypothesis;
use nearmiss_base::geometry::{Footprint, Pose, Vector};

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
