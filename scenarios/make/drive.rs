//! Driving: a speed over time with bounded jerk, along a path with smooth shifts sideways, integrated.

use nearmiss::geometry::{Pose, normalize_angle};

use super::path::Path;

/// Seconds between two time steps.
pub const DT: f64 = 0.1;

/// Steps of integration within a time step.
const SUBSTEPS: usize = 10;

/// Change of acceleration of a driver who takes it easy, m/s³.
const GENTLE: f64 = 4.0;

/// Change of acceleration in an emergency, m/s³.
const URGENT: f64 = 30.0;

/// Accelerations beyond this are an emergency, m/s².
const COMFORTABLE: f64 = 4.0;

/// A speed over time: acceleration is linear between knots and never jumps.
#[derive(Debug, Clone)]
pub struct Speed {
    knots: Vec<Knot>,
}

#[derive(Debug, Clone, Copy)]
struct Knot {
    time: f64,
    velocity: f64,
    acceleration: f64,
}

impl Speed {
    /// Begins at `velocity` m/s.
    pub fn of(velocity: f64) -> Self {
        let first = Knot {
            time: 0.0,
            velocity,
            acceleration: 0.0,
        };
        Self { knots: vec![first] }
    }

    /// Keeps the speed for some seconds.
    pub fn hold(self, seconds: f64) -> Self {
        let last = self.last();
        self.knot(seconds, last.velocity, 0.0)
    }

    /// Changes to `velocity` m/s with at most `peak` m/s².
    pub fn to(self, velocity: f64, peak: f64) -> Self {
        let change = velocity - self.last().velocity;
        let jerk = if peak > COMFORTABLE { URGENT } else { GENTLE };
        let peak = peak.min((change.abs() * jerk).sqrt());
        if peak <= 0.0 {
            return self;
        }
        let (ramp, signed) = (peak / jerk, peak * change.signum());
        let middle = (change.abs() / peak - ramp).max(0.0);
        let after_ramp = self.last().velocity + signed * ramp / 2.0;
        self.knot(ramp, after_ramp, signed)
            .knot(middle, velocity - signed * ramp / 2.0, signed)
            .knot(ramp, velocity, 0.0)
    }

    fn last(&self) -> Knot {
        self.knots[self.knots.len() - 1]
    }

    fn knot(mut self, seconds: f64, velocity: f64, acceleration: f64) -> Self {
        self.knots.push(Knot {
            time: self.last().time + seconds,
            velocity,
            acceleration,
        });
        self
    }

    /// Velocity and acceleration at a time.
    fn at(&self, time: f64) -> (f64, f64) {
        let next = self.knots.partition_point(|k| k.time <= time);
        let Some(to) = self.knots.get(next) else {
            return (self.last().velocity, self.last().acceleration);
        };
        let from = self.knots[next.saturating_sub(1)];
        let (passed, whole) = (time - from.time, to.time - from.time);
        let growth = (to.acceleration - from.acceleration) / whole;
        let velocity = from.velocity + passed * (from.acceleration + growth * passed / 2.0);
        (velocity.max(0.0), from.acceleration + growth * passed)
    }
}

/// A shift to another offset from the path, a quintic in arc length.
#[derive(Debug, Clone, Copy)]
struct Shift {
    at: f64,
    over: f64,
    to: f64,
}

/// How a participant moves.
#[derive(Debug, Clone)]
pub struct Drive {
    path: Path,
    start: f64,
    offset: f64,
    speed: Speed,
    shifts: Vec<Shift>,
}

/// One moment of a motion.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// Where, and the direction of motion.
    pub pose: Pose,
    /// m/s.
    pub velocity: f64,
    /// m/s².
    pub acceleration: f64,
    /// rad/s.
    pub yaw_rate: f64,
}

impl Drive {
    /// Along `path` from arc length `start`, `offset` metres to the left of it.
    pub fn along(path: &Path, start: f64, offset: f64, speed: Speed) -> Self {
        Self {
            path: path.clone(),
            start,
            offset,
            speed,
            shifts: Vec::new(),
        }
    }

    /// Shifts to the offset `to` between arc lengths `at` and `at + over`; shifts come in order.
    pub fn shift(mut self, at: f64, over: f64, to: f64) -> Self {
        self.shifts.push(Shift { at, over, to });
        self
    }

    /// The motion at time steps 0 to `last`.
    pub fn moments(&self, last: usize) -> Vec<Moment> {
        let fine = DT / SUBSTEPS as f64;
        let mut s = self.start;
        let mut moments = Vec::with_capacity(last + 1);
        for step in 0..=last {
            let time = step as f64 * DT;
            moments.push(self.moment(s, time));
            for part in 0..SUBSTEPS {
                // Midpoint rule: the stretch of arc length is taken half a step ahead.
                let middle = time + (part as f64 + 0.5) * fine;
                let velocity = self.speed.at(middle).0;
                let half = s + velocity / self.stretch(s) * fine / 2.0;
                s += velocity / self.stretch(half) * fine;
            }
        }
        moments
    }

    fn moment(&self, s: f64, time: f64) -> Moment {
        const H: f64 = 0.05;
        let (velocity, acceleration) = self.speed.at(time);
        let turned = self.heading(s + H) - self.heading(s - H);
        let along = 2.0 * H * self.stretch(s);
        let heading = normalize_angle(self.heading(s));
        Moment {
            pose: Pose {
                heading,
                ..self.path.pose(s, self.offset(s).0)
            },
            velocity,
            acceleration,
            yaw_rate: velocity * turned / along,
        }
    }

    /// Metres driven per metre of the path.
    fn stretch(&self, s: f64) -> f64 {
        let (offset, slope) = self.offset(s);
        (1.0 - self.path.curvature(s) * offset).hypot(slope)
    }

    fn heading(&self, s: f64) -> f64 {
        let (offset, slope) = self.offset(s);
        let forward = 1.0 - self.path.curvature(s) * offset;
        self.path.pose(s, 0.0).heading + slope.atan2(forward)
    }

    /// The offset at `s` and its change per metre.
    fn offset(&self, s: f64) -> (f64, f64) {
        let mut from = self.offset;
        for shift in &self.shifts {
            let u = (s - shift.at) / shift.over;
            if u <= 0.0 {
                break;
            }
            if u < 1.0 {
                let change = shift.to - from;
                let part = u * u * u * (10.0 + u * (6.0 * u - 15.0));
                let slope = 30.0 * u * u * (1.0 - u) * (1.0 - u) / shift.over;
                return (from + change * part, change * slope);
            }
            from = shift.to;
        }
        (from, 0.0)
    }
}
