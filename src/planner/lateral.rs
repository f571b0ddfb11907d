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
                let [d, d1, d2] = across.at(t);
                // Planned over time only where the speed is far from 0.
                let slower = s[1].recip();
                let slope = d1 * slower;
                [d, slope, (d2 - slope * s[2]) * slower * slower]
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
