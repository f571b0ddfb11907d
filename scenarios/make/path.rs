//! Centre lines: straights and arcs with clothoids between them, so that curvature never jumps.

use nearmiss::geometry::{Point, Pose, Vector, angle_between};

/// A line along which something is built or driven, by arc length from its start, metres.
#[derive(Debug, Clone)]
pub struct Path {
    pieces: Vec<Piece>,
    end: Pose,
    length: f64,
}

/// A stretch on which curvature is linear in arc length.
#[derive(Debug, Clone, Copy)]
struct Piece {
    start: f64,
    pose: Pose,
    length: f64,
    /// Curvature at both ends, 1/m, positive to the left.
    from: f64,
    to: f64,
}

/// Longer stretches are cut, to keep the integration short and exact.
const LONGEST_PIECE: f64 = 20.0;

/// Nodes and weights of Gauss-Legendre integration with five points on (−1, 1).
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

impl Piece {
    fn curvature(&self, along: f64) -> f64 {
        self.from + (self.to - self.from) * along / self.length
    }

    fn heading(&self, along: f64) -> f64 {
        let growth = (self.to - self.from) / self.length;
        self.pose.heading + along * (self.from + growth * along / 2.0)
    }

    fn pose(&self, along: f64) -> Pose {
        let half = along / 2.0;
        let moved = GAUSS.iter().fold(Vector::zeros(), |sum, (node, weight)| {
            let (sin, cos) = self.heading(half + half * node).sin_cos();
            sum + Vector::new(cos, sin) * (weight * half)
        });
        Pose {
            position: self.pose.position + moved,
            heading: self.heading(along),
        }
    }
}

impl Path {
    /// A path that begins at a pose and has no length yet.
    pub fn from(start: Pose) -> Self {
        Self {
            pieces: Vec::new(),
            end: start,
            length: 0.0,
        }
    }

    /// Goes straight on for `length` metres.
    pub fn straight(self, length: f64) -> Self {
        self.ramp(length, 0.0, 0.0)
    }

    /// Turns by `angle` (radians, positive to the left) on an arc of `radius` metres, with a
    /// clothoid of `spiral` metres into it and out of it; shorter clothoids if the turn is too small.
    pub fn bend(self, radius: f64, angle: f64, spiral: f64) -> Self {
        let turning = angle.abs() * radius;
        let spiral = spiral.min(turning);
        let curvature = angle.signum() / radius;
        self.ramp(spiral, 0.0, curvature)
            .ramp(turning - spiral, curvature, curvature)
            .ramp(spiral, curvature, 0.0)
    }

    /// The path from one pose to another over the corner where their lines meet.
    ///
    /// Nothing if the lines do not meet between the two or leave too little room for the bend.
    pub fn between(from: Pose, to: Pose, radius: f64, spiral: f64) -> Option<Self> {
        let angle = angle_between(from.heading, to.heading);
        let apart = to.position - from.position;
        if angle.abs() < 1e-3 {
            let aside = apart.dot(&from.left()).abs();
            return (aside < 1e-3).then(|| Self::from(from).straight(apart.norm()));
        }
        let bend = Self::from(Pose::new(0.0, 0.0, 0.0)).bend(radius, angle, spiral);
        let tangent = bend.end.position.y / angle.sin();
        let across = from.forward().perp(&to.forward());
        let before = apart.perp(&to.forward()) / across - tangent;
        let after = from.forward().perp(&apart) / across - tangent;
        let path = Self::from(from)
            .straight(before)
            .bend(radius, angle, spiral);
        (before >= 0.0 && after >= 0.0).then(|| path.straight(after))
    }

    fn ramp(mut self, length: f64, from: f64, to: f64) -> Self {
        if length <= 1e-9 {
            return self;
        }
        let count = (length / LONGEST_PIECE).ceil();
        for i in 0..count as usize {
            let at = |part: f64| from + (to - from) * part / count;
            let piece = Piece {
                start: self.length,
                pose: self.end,
                length: length / count,
                from: at(i as f64),
                to: at(i as f64 + 1.0),
            };
            self.end = piece.pose(piece.length);
            self.length += piece.length;
            self.pieces.push(piece);
        }
        self
    }

    /// The same line driven the other way.
    pub fn reversed(&self) -> Self {
        let start = Pose {
            heading: self.end.heading + std::f64::consts::PI,
            ..self.end
        };
        let pieces = self.pieces.iter().rev();
        pieces.fold(Self::from(start), |path, piece| {
            path.ramp(piece.length, -piece.to, -piece.from)
        })
    }

    /// Metres from its start to its end.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The pose `offset` metres to the left of the path at `s`; straight on beyond both ends.
    pub fn pose(&self, s: f64, offset: f64) -> Pose {
        let on = match self.piece(s) {
            Some(piece) => piece.pose(s - piece.start),
            None => {
                let (from, beyond) = match self.pieces.first() {
                    Some(first) if s < 0.0 => (first.pose, s),
                    _ => (self.end, s - self.length),
                };
                Pose {
                    position: from.position + from.forward() * beyond,
                    heading: from.heading,
                }
            }
        };
        Pose {
            position: on.position + on.left() * offset,
            heading: on.heading,
        }
    }

    /// The point `offset` metres to the left of the path at `s`.
    pub fn point(&self, s: f64, offset: f64) -> Point {
        self.pose(s, offset).position
    }

    /// Curvature at `s`, 1/m, positive to the left.
    pub fn curvature(&self, s: f64) -> f64 {
        self.piece(s).map_or(0.0, |p| p.curvature(s - p.start))
    }

    fn piece(&self, s: f64) -> Option<&Piece> {
        if s < 0.0 || s > self.length {
            return None;
        }
        let next = self.pieces.partition_point(|p| p.start <= s);
        self.pieces.get(next.checked_sub(1)?)
    }
}
