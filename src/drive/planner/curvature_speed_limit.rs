//! The curvature speed limit: how fast a path can be driven, with room to brake for curves ahead.

use nearmiss_base::geometry::ReferencePath;

/// The speed at each metre of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvatureSpeedLimit {
    /// m/s at 0, 1, 2, … m.
    speeds: Vec<f64>,
}

/// The lateral acceleration that is driven in a bend, m/s².
const LATERAL: f64 = 6.0;

/// Deceleration towards a bend, m/s².
const BRAKING: f64 = 4.0;

/// The ego drives no faster than this for the bends' sake, m/s.
const FASTEST: f64 = 100.0;

impl CurvatureSpeedLimit {
    /// Those of `path`.
    #[must_use]
    pub fn new(path: &ReferencePath) -> Self {
        let metres = path.length().ceil().max(1.0) as usize;
        let curvature = |s: usize| path.at(s as f64).curvature.abs();
        let mut speeds: Vec<f64> = (0..=metres)
            .map(|s| (LATERAL / curvature(s).max(1e-9)).sqrt().min(FASTEST))
            .collect();
        for s in (0..metres).rev() {
            let reached = (speeds[s + 1].powi(2) + 2.0 * BRAKING).sqrt();
            speeds[s] = speeds[s].min(reached);
        }
        Self { speeds }
    }

    /// The speed at arc length `s` (m), m/s; beyond the ends that of the end.
    #[must_use]
    #[inline]
    pub fn speed(&self, s: f64) -> f64 {
        let place = s.max(0.0) as usize;
        self.speeds[place.min(self.speeds.len() - 1)]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_base::geometry::Point;

    #[test]
    fn bends_slow_down_before_they_begin() {
        // Straight for 60 m, then a quarter of a circle of 10 m.
        let straight = (0..60).map(|x| Point::new(f64::from(x), 0.0));
        let turn = (0..=20).map(|i| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::FRAC_PI_2 / 20.0).sin_cos();
            Point::new(60.0 + 10.0 * sin, 10.0 - 10.0 * cos)
        });
        let path = ReferencePath::new(straight.chain(turn)).unwrap();
        let bends = CurvatureSpeedLimit::new(&path);
        let in_it = bends.speed(68.0);
        assert!((in_it - (LATERAL * 10.0_f64).sqrt()).abs() < 0.3, "{in_it}");
        let before = bends.speed(30.0);
        let room = (before.powi(2) - in_it.powi(2)) / (2.0 * BRAKING);
        assert!((28.0..=33.0).contains(&room), "{room}");
        assert!(bends.speed(0.0) > before);
        assert_eq!(bends.speed(-5.0), bends.speed(0.0));
    }
}
