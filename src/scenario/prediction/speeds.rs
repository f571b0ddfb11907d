//! How far somebody gets: an acceleration that fades, and never into reverse.

/// A speed and an acceleration that fades to nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speeds {
    /// m/s at the beginning; negative when reversing.
    pub speed: f64,
    /// m/s² at the beginning.
    pub acceleration: f64,
    /// Seconds after which 1/e of the acceleration is left; nothing for an acceleration that stays.
    pub fade: Option<f64>,
}

impl Speeds {
    /// Metres along the path after `t` seconds.
    ///
    /// Nobody changes between forward and reverse: whoever comes to a stop stays there.
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
