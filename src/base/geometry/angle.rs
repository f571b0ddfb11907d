//! Angles on the circle.

use std::f64::consts::{PI, TAU};

/// `angle` brought into (−π, π].
#[must_use]
pub fn normalize_angle(angle: f64) -> f64 {
    let wrapped = angle.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// The signed turn from `from` to `to`, in (−π, π].
#[must_use]
pub fn angle_between(from: f64, to: f64) -> f64 {
    normalize_angle(to - from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wraps_to_the_half_open_circle() {
        assert!((normalize_angle(3.0 * PI) - PI).abs() < 1e-12);
        assert!((normalize_angle(-PI) - PI).abs() < 1e-12);
        assert!((angle_between(3.0, -3.0) - (TAU - 6.0)).abs() < 1e-12);
    }
}
