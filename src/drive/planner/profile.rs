//! Longitudinal motion: a polynomial of time, and the path at each of its steps.

use super::Polynomial;
use super::motion::Station;
use super::pace::Pace;
use nearmiss_base::geometry::ReferencePath;

/// Longitudinal motion over time, shared by all candidates with the same profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Profile {
    pub along: Polynomial,
    /// Seconds until its final speed, which is kept afterwards.
    pub duration: f64,
    /// Seconds of it that are over already.
    pub elapsed: f64,
    /// The slowest it is at any step, m/s.
    pub slowest: f64,
}

/// So little of driving backwards is rounding, m/s.
const ROUNDING: f64 = 1e-3;

impl Profile {
    pub fn new(along: Polynomial, duration: f64, elapsed: f64) -> Self {
        Self {
            along,
            duration,
            elapsed,
            slowest: 0.0,
        }
    }

    /// Arc length, speed and acceleration after `t` seconds from now.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let t = t + self.elapsed;
        if t <= self.duration {
            return self.along.at(t);
        }
        let [s, v, _] = self.along.at(self.duration);
        [s + v * (t - self.duration), v, 0.0]
    }

    /// Writes its stations at `steps` + 1 moments that are `dt` seconds apart behind the others; nothing, and not a
    /// station, where it would drive backwards.
    pub fn lay(
        mut self,
        path: &ReferencePath,
        pace: &Pace<'_>,
        steps: usize,
        dt: f64,
        stations: &mut Vec<Station>,
    ) -> Option<Self> {
        let first = stations.len();
        self.slowest = f64::MAX;
        for i in 0..=steps {
            let [s, v, a] = self.at(i as f64 * dt);
            if v < -ROUNDING {
                stations.truncate(first);
                return None;
            }
            let v = v.max(0.0);
            self.slowest = self.slowest.min(v);
            let t = i as f64 * dt;
            let speeds = (pace.wanted_at(s, t), pace.allowed_at(s, t));
            stations.push(Station::new([s, v, a], &path.frame_at(s), speeds));
        }
        Some(self)
    }
}
