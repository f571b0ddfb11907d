//! What vehicles and drivers are taken to be able to do: the parameters of the measures that need any.

/// Deceleration that the brake-threat number is held against, m/s²: the longitudinal limit of every vehicle of
/// Althoff and Würsching, "CommonRoad: Vehicle Models" (2020), as commonroad-crime takes it.
pub const BRAKE_THREAT: f64 = 11.5;

/// Lateral acceleration that the steer-threat number is held against, m/s² (commonroad-crime's default).
pub const STEER_THREAT: f64 = 8.0;

/// Full braking on a dry road, m/s².
pub const FULL_BRAKING: f64 = 8.0;

/// Full acceleration, m/s².
pub const KICK_DOWN: f64 = 3.5;

/// Lateral acceleration of an evasive manoeuvre on a dry road, m/s².
pub const EVASION: f64 = 8.0;

/// The tightest curve that can be steered, 1/m: at low speed it limits the evasive manoeuvre.
pub const TIGHTEST: f64 = 0.2;

/// Acceleration in any direction that is feared of everyone who moves, m/s² (worst-case time to collision).
/// The longitudinal limit of the CommonRoad vehicles.
pub const WORST_CASE: f64 = 11.5;

/// Threshold of the time-exposed and time-integrated time to collision, seconds.
pub const TAU: f64 = 2.0;

/// Maximum available deceleration, m/s²: mean, standard deviation and bounds of a truncated normal
/// distribution (Cunto and Saccomanno 2008).
pub const MADR: Madr = Madr {
    mean: 8.45,
    deviation: 1.40,
    least: 4.23,
    most: 12.68,
};

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

/// Parameters of responsibility-sensitive safety. The paper leaves them open; these are the ones that the
/// examples of the library ad-rss-lib use.
pub const RSS: Rss = Rss {
    response: 1.0,
    accelerate: 3.5,
    brake_least: 4.0,
    brake_most: 8.0,
    brake_correct: 3.0,
    lateral_accelerate: 0.2,
    lateral_brake: 0.8,
    lateral_margin: 0.1,
};

/// Parameters of responsibility-sensitive safety, the same for everyone.
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
    /// Deceleration that somebody in his correct lane brakes with at least before oncoming traffic, m/s².
    pub brake_correct: f64,
    /// Largest lateral acceleration during the response time, m/s².
    pub lateral_accelerate: f64,
    /// Lateral deceleration that everyone brakes with at least, m/s².
    pub lateral_brake: f64,
    /// Margin μ for lateral fluctuations, metres.
    pub lateral_margin: f64,
}
