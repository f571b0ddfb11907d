//! How far an obstacle gets: an acceleration that fades, and never into reverse.

/// A speed and an acceleration that decays to zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speeds {
    /// m/s at the beginning; negative when reversing.
    pub speed: f64,
    /// m/s² at the beginning.
    pub acceleration: f64,
    /// Time constant of the decay, seconds; `None` for constant acceleration.
    pub fade: Option<f64>,
}

impl Speeds {
    /// Metres along the path after `t` seconds.
    ///
    /// No obstacle changes between forward and reverse: one that comes to a stop stays there, and one that stands only
    /// starts forward.
    #[must_use]
    pub fn distance(&self, t: f64) -> f64 {
        let t = self.stop().map_or(t, |stop| t.min(stop));
        let (v, a) = (self.speed, self.acceleration);
        match self.fade {
            None => v * t + a * t * t / 2.0,
            Some(tau) => v * t + a * tau * (t + tau * (-t / tau).exp_m1()),
        }
    }

    /// Seconds until it stands, if it ever does.
    #[must_use]
    pub fn stop(&self) -> Option<f64> {
        let (v, a) = (self.speed, self.acceleration);
        if v == 0.0 && a <= 0.0 {
            return Some(0.0);
        }
        if v * a >= 0.0 {
            return None;
        }
        match self.fade {
            None => Some(-v / a),
            Some(tau) => {
                let share = -v / (a * tau);
                (share < 1.0).then(|| -tau * (-share).ln_1p())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn speeds(speed: f64, acceleration: f64, fade: Option<f64>) -> Speeds {
        Speeds {
            speed,
            acceleration,
            fade,
        }
    }

    #[test]
    fn braking_ends_at_standstill_and_never_in_reverse() {
        let brakes = speeds(10.0, -5.0, None);
        assert_eq!(brakes.stop(), Some(2.0));
        assert!((brakes.distance(1.0) - 7.5).abs() < 1e-12);
        assert!((brakes.distance(2.0) - 10.0).abs() < 1e-12);
        assert_eq!(brakes.distance(2.0), brakes.distance(9.0));
        let back = speeds(-4.0, 2.0, None);
        assert!((back.distance(9.0) + 4.0).abs() < 1e-12);
        let stands = speeds(0.0, -3.0, Some(2.0));
        assert_eq!(stands.distance(5.0), 0.0);
    }

    #[test]
    fn a_fading_acceleration_is_the_integral_of_its_speed() {
        for s in [speeds(8.0, 3.0, Some(2.0)), speeds(5.0, -6.0, Some(2.0))] {
            let (mut x, mut v, dt) = (0.0, s.speed, 1e-4);
            for k in 0..30_000 {
                let a = s.acceleration * (-f64::from(k) * dt / 2.0).exp();
                x += v * dt;
                v = (v + a * dt).max(0.0);
            }
            assert!((s.distance(3.0) - x).abs() < 5e-3, "{s:?}: {x}");
        }
        // 10 m/s are never lost to 4 m/s² that fade within 2 s: 8 m/s are.
        assert_eq!(speeds(10.0, -4.0, Some(2.0)).stop(), None);
        assert!(speeds(7.9, -4.0, Some(2.0)).stop().is_some());
    }
}
