//! Lateral motion: over time at speed, over arc length when slow.

use super::Polynomial;
use super::motion::Offset;

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
const SHORTEST: f64 = 6.0;

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
        let length = length.max(SHORTEST);
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
