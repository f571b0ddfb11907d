//! Assumed capabilities of vehicles and drivers: parameters of the measures.

/// Parameters of the measures; [`super::LIMITS`] has a line for each, with its unit and what it may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Reference deceleration of the brake-threat number, m/s².
    pub brake_threat: f64,
    /// Reference lateral acceleration of the steer-threat number, m/s².
    pub steer_threat: f64,
    /// Full braking, m/s².
    pub full_braking: f64,
    /// Full acceleration, m/s².
    pub kick_down: f64,
    /// Lateral acceleration of an evasive manoeuvre, m/s².
    pub evasion: f64,
    /// The tightest curve that can be steered, 1/m: at low speed it limits the evasive manoeuvre.
    pub tightest: f64,
    /// Worst-case acceleration of a road user in any direction, m/s² (worst-case time to collision).
    pub worst_case: f64,
    /// Threshold of the time-exposed and time-integrated time to collision, seconds.
    pub tau: f64,
    /// Maximum available deceleration.
    pub madr: Madr,
    /// Responsibility-sensitive safety.
    pub rss: Rss,
}

/// A truncated normal distribution, m/s².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Madr {
    /// Mean before truncation.
    pub mean: f64,
    /// Standard deviation before truncation.
    pub deviation: f64,
    /// Lower bound.
    pub least: f64,
    /// Upper bound.
    pub most: f64,
}

/// Parameters of responsibility-sensitive safety, the same for all road users.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rss {
    /// Response time ρ, seconds.
    pub response: f64,
    /// Largest acceleration during the response time, m/s².
    pub accelerate: f64,
    /// Deceleration that the one behind brakes with at least, m/s².
    pub brake_least: f64,
    /// Deceleration that the one in front brakes with at most, m/s².
    pub brake_most: f64,
    /// Least deceleration of a vehicle in its own lane before oncoming traffic, m/s².
    pub brake_correct: f64,
    /// Largest lateral acceleration during the response time, m/s².
    pub lateral_accelerate: f64,
    /// Minimum lateral deceleration of all road users, m/s².
    pub lateral_brake: f64,
    /// Margin μ for lateral fluctuations, metres.
    pub lateral_margin: f64,
}

impl Limits {
    /// The shipped limits; [`super::LIMITS`] gives their sources.
    pub const SHIPPED: Self = Self {
        brake_threat: 11.5,
        steer_threat: 8.0,
        full_braking: 8.0,
        kick_down: 3.5,
        evasion: 8.0,
        tightest: 0.2,
        worst_case: 11.5,
        tau: 2.0,
        madr: Madr {
            mean: 8.45,
            deviation: 1.40,
            least: 4.23,
            most: 12.68,
        },
        rss: Rss {
            response: 1.0,
            accelerate: 3.5,
            brake_least: 4.0,
            brake_most: 8.0,
            brake_correct: 3.0,
            lateral_accelerate: 0.2,
            lateral_brake: 0.8,
            lateral_margin: 0.1,
        },
    };

    /// An order that does not hold, in words.
    #[must_use]
    pub fn mistake(&self) -> Option<&'static str> {
        let (madr, rss) = (&self.madr, &self.rss);
        if !(madr.least < madr.mean && madr.mean < madr.most) {
            Some("madr_least < madr_mean < madr_most must hold")
        } else if !(rss.brake_correct <= rss.brake_least && rss.brake_least <= rss.brake_most) {
            Some("rss_brake_correct ≤ rss_brake_least ≤ rss_brake_most must hold")
        } else {
            None
        }
    }
}
