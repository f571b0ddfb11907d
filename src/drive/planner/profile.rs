//! Motions between two states: minimum-jerk polynomials, longitudinal over time, lateral over time or arc length.
//!
//! Minimum-jerk polynomials of degree five or less that join two states.
//!
//! Source: Takahashi et al., Local path planning and motion control for AGV in positioning, IROS 1989; Werling et
//! al. 2010, sections III and IV.

use nearmiss_base::geometry::ReferencePath;

use super::pace::Pace;
use super::state::{Offset, Station};

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

/// The offset from the path; after its end the final offset is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Lateral {
    /// By time, as wheels that turn at speed.
    Time {
        across: Polynomial,
        duration: f64,
        elapsed: f64,
        target: f64,
    },
    /// By arc length: an obstacle that stands does not move sideways.
    Length {
        across: Polynomial,
        from: f64,
        length: f64,
        target: f64,
    },
}

/// The offset of the start: by time (m, m/s, m/s²) and by arc length (m, –, 1/m).
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    pub by_time: [f64; 3],
    pub by_length: [f64; 3],
}

/// The shortest way (m) over which an offset is changed.
const MIN_CHANGE_LENGTH: f64 = 6.0;

/// An offset with its derivatives by time as one by arc length, where the inverse of the speed (s/m) and the acceleration
/// (m/s²) are these.
#[inline]
pub(super) fn by_length([d, d1, d2]: [f64; 3], slower: f64, acceleration: f64) -> Offset {
    if d1 == 0.0 && d2 == 0.0 {
        return [d, 0.0, 0.0];
    }
    // Planned over time only where the speed is far from 0.
    let slope = d1 * slower;
    [d, slope, (d2 - slope * acceleration) * slower * slower]
}

impl Lateral {
    pub fn over_time(start: &Start, target: f64, duration: f64) -> Self {
        Self::Time {
            across: Polynomial::quintic(start.by_time, [target, 0.0, 0.0], duration),
            duration,
            elapsed: 0.0,
            target,
        }
    }

    pub fn over_length(start: &Start, target: f64, from: f64, length: f64) -> Self {
        let length = length.max(MIN_CHANGE_LENGTH);
        Self::Length {
            across: Polynomial::quintic(start.by_length, [target, 0.0, 0.0], length),
            from,
            length,
            target,
        }
    }

    /// The offset after `t` seconds from now, at arc length, speed and acceleration `s`.
    #[inline]
    pub fn at(&self, t: f64, s: [f64; 3]) -> Offset {
        match self {
            Self::Time {
                across,
                duration,
                elapsed,
                target,
            } => {
                let t = t + elapsed;
                if t >= *duration {
                    return [*target, 0.0, 0.0];
                }
                by_length(across.at(t), s[1].recip(), s[2])
            }
            Self::Length {
                across,
                from,
                length,
                target,
            } => {
                let along = s[0] - from;
                if along >= *length {
                    return [*target, 0.0, 0.0];
                }
                across.at(along.max(0.0))
            }
        }
    }

    /// The offset after `t` seconds from now (m) with its first and second derivative by time; only where it changes over
    /// time.
    pub fn by_time(&self, t: f64) -> Option<[f64; 3]> {
        let Self::Time {
            across,
            duration,
            elapsed,
            target,
        } = self
        else {
            return None;
        };
        let t = t + elapsed;
        Some(if t >= *duration {
            [*target, 0.0, 0.0]
        } else {
            across.at(t)
        })
    }

    /// The same from `seconds` later.
    pub fn later(mut self, seconds: f64) -> Self {
        if let Self::Time { elapsed, .. } = &mut self {
            *elapsed += seconds;
        }
        self
    }

    /// Bounds of the offset (m) and of its first derivative: by time (m/s), or by arc length.
    pub fn bounds(&self) -> [f64; 2] {
        let (across, end, target) = match self {
            Self::Time {
                across,
                duration,
                target,
                ..
            } => (across, duration, target),
            Self::Length {
                across,
                length,
                target,
                ..
            } => (across, length, target),
        };
        let [offset, slope] = across.bounds(*end);
        [offset.max(target.abs()), slope]
    }

    /// The mean squared jerk across the path over `horizon` seconds at about `speed` m/s, (m/s³)².
    pub fn squared_jerk(&self, horizon: f64, speed: f64) -> f64 {
        match self {
            Self::Time {
                across,
                duration,
                elapsed,
                ..
            } => {
                let end = duration.min(horizon + elapsed);
                (across.squared_jerk(end) - across.squared_jerk(elapsed.min(end))) / horizon
            }
            Self::Length { across, length, .. } => {
                across.squared_jerk(*length) / length * speed.powi(6)
            }
        }
    }
}

/// c₀ + c₁t + … + c₅t⁵ over time (s), or over length (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Polynomial([f64; 6]);

impl Polynomial {
    /// From position, velocity and acceleration `from` to those of `to` after `duration` (above 0).
    #[must_use]
    pub fn quintic(from: [f64; 3], to: [f64; 3], duration: f64) -> Self {
        let t = duration;
        let (c0, c1, c2) = (from[0], from[1], from[2] / 2.0);
        let gap = to[0] - (c0 + (c1 + c2 * t) * t);
        let speed = to[1] - (c1 + 2.0 * c2 * t);
        let acceleration = to[2] - 2.0 * c2;
        let (t2, t3) = (t * t, t * t * t);
        let c3 = (10.0 * gap - 4.0 * speed * t + 0.5 * acceleration * t2) / t3;
        let c4 = (-15.0 * gap + 7.0 * speed * t - acceleration * t2) / (t3 * t);
        let c5 = (6.0 * gap - 3.0 * speed * t + 0.5 * acceleration * t2) / (t3 * t2);
        Self([c0, c1, c2, c3, c4, c5])
    }

    /// From position, velocity and acceleration `from` to velocity and acceleration `to` after `duration` (above 0),
    /// wherever that is.
    #[must_use]
    pub fn quartic(from: [f64; 3], to: [f64; 2], duration: f64) -> Self {
        let t = duration;
        let (c0, c1, c2) = (from[0], from[1], from[2] / 2.0);
        let speed = to[0] - (c1 + 2.0 * c2 * t);
        let acceleration = to[1] - 2.0 * c2;
        let c3 = (speed - acceleration * t / 3.0) / (t * t);
        let c4 = (acceleration * t - 2.0 * speed) / (4.0 * t * t * t);
        Self([c0, c1, c2, c3, c4, 0.0])
    }

    /// Value, first and second derivative at `t`.
    #[must_use]
    pub fn at(&self, t: f64) -> [f64; 3] {
        let [c0, c1, c2, c3, c4, c5] = self.0;
        [
            c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * c5)))),
            c1 + t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5))),
            2.0 * c2 + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5)),
        ]
    }

    /// Bounds of the size of its value and of its first derivative between 0 and `t`.
    ///
    /// Between its ends a polynomial stays within the hull of its Bernstein coefficients (Farouki, The Bernstein
    /// polynomial basis: a centennial retrospective, 2012).
    #[must_use]
    pub fn bounds(&self, t: f64) -> [f64; 2] {
        let [c0, c1, c2, c3, c4, c5] = self.0;
        [
            bernstein_bound([c0, c1, c2, c3, c4, c5], t),
            bernstein_bound([c1, 2.0 * c2, 3.0 * c3, 4.0 * c4, 5.0 * c5], t),
        ]
    }

    /// The integral of the squared third derivative from 0 to `t`.
    #[must_use]
    pub fn squared_jerk(&self, t: f64) -> f64 {
        let [.., c3, c4, c5] = self.0;
        let (a, b, c) = (6.0 * c3, 24.0 * c4, 60.0 * c5);
        t * (a * a
            + t * (a * b + t * ((b * b + 2.0 * a * c) / 3.0 + t * (b * c / 2.0 + t * c * c / 5.0))))
    }
}

/// The largest Bernstein coefficient, by size, of Σ cₖxᵏ between 0 and `t`.
fn bernstein_bound<const N: usize>(coefficients: [f64; N], t: f64) -> f64 {
    // Differences of the Bernstein coefficients are cₖtᵏ by the binomial coefficient of the degree.
    let mut differences = coefficients;
    let (mut power, mut binomial) = (1.0, 1.0);
    for (k, c) in differences.iter_mut().enumerate() {
        *c *= power / binomial;
        power *= t;
        binomial *= (N - 1 - k) as f64 / (k + 1) as f64;
    }
    let mut most = differences[0].abs();
    for left in (1..N).rev() {
        for k in 0..left {
            differences[k] += differences[k + 1];
        }
        most = most.max(differences[0].abs());
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9 * (1.0 + a.abs() + b.abs())
    }

    #[test]
    fn both_ends_are_met() {
        let (from, to) = ([3.0, 12.0, -1.5], [40.0, 7.0, 0.5]);
        let quintic = Polynomial::quintic(from, to, 3.5);
        let quartic = Polynomial::quartic(from, [to[1], to[2]], 3.5);
        for (k, (a, b)) in quintic.at(3.5).into_iter().zip(to).enumerate() {
            assert!(near(a, b), "derivative {k}: {a} for {b}");
        }
        for (a, b) in quintic.at(0.0).into_iter().zip(from) {
            assert!(near(a, b));
        }
        let [_, velocity, acceleration] = quartic.at(3.5);
        assert!(near(velocity, 7.0) && near(acceleration, 0.5));
        assert_eq!(quartic.at(0.0), from);
    }

    #[test]
    fn bounds_are_the_largest_bernstein_coefficients() {
        // 4x(1 − x) has the coefficients 0, 2, 0 on [0, 1]; (1 − 2x)³ has 1, −1, 1, −1.
        assert!(near(bernstein_bound([0.0, 4.0, -4.0], 1.0), 2.0));
        assert!(near(bernstein_bound([1.0, -6.0, 12.0, -8.0], 1.0), 1.0));
        // The same over [0, 2] of x/2.
        assert!(near(bernstein_bound([0.0, 2.0, -1.0], 2.0), 2.0));
    }

    #[test]
    fn bounds_hold_and_are_met_by_lines() {
        let line = Polynomial::quintic([1.0, -2.0, 0.0], [-3.0, -2.0, 0.0], 2.0);
        let [value, slope] = line.bounds(2.0);
        assert!(near(value, 3.0) && near(slope, 2.0), "{value}, {slope}");
        let mut random = fastrand::Rng::with_seed(5);
        for _ in 0..200 {
            let mut some = || [4.0, 3.0, 2.0].map(|most| most * (2.0 * random.f64() - 1.0));
            let p = Polynomial::quintic(some(), some(), 3.0);
            let [value, slope] = p.bounds(3.0);
            for i in 0..=300 {
                let [x, v, _] = p.at(f64::from(i) / 100.0);
                let rounding = 1.0 + 1e-12;
                assert!(x.abs() <= value * rounding, "{x} beyond {value}");
                assert!(v.abs() <= slope * rounding, "{v} beyond {slope}");
            }
        }
    }

    #[test]
    fn the_jerk_is_what_a_sum_gives() {
        let p = Polynomial::quintic([0.0, 10.0, 1.0], [25.0, 4.0, -0.5], 2.0);
        let (n, dt) = (200_000, 2.0 / 200_000.0);
        let jerk = |t: f64| (p.at(t + 1e-5)[2] - p.at(t - 1e-5)[2]) / 2e-5;
        let sum: f64 = (0..n)
            .map(|i| jerk((f64::from(i) + 0.5) * dt).powi(2) * dt)
            .sum();
        assert!((p.squared_jerk(2.0) - sum).abs() < 1e-4 * sum, "{sum}");
    }
}
