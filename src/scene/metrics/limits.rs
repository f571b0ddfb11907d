//! Assumed capabilities of vehicles and drivers: parameters of the measures, and what a file calls them.

use std::ops::RangeInclusive;

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

/// A parameter of measures.
#[derive(Debug)]
pub struct Limit {
    /// Its name in a file of thresholds.
    pub id: &'static str,
    /// Its description.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its allowed range, in its unit.
    pub allowed: RangeInclusive<f64>,
    /// Ids of the measures that take it.
    pub measures: &'static [&'static str],
    /// The source of the shipped value.
    pub source: &'static str,
    get: fn(&Limits) -> f64,
    place: fn(&mut Limits) -> &mut f64,
}

impl Limit {
    /// Its value, in its unit.
    #[must_use]
    pub fn value(&self, limits: &Limits) -> f64 {
        (self.get)(limits)
    }

    pub(super) fn set(&self, limits: &mut Limits, value: f64) {
        *(self.place)(limits) = value;
    }
}

macro_rules! limits {
    ($($id:literal, $($field:ident).+, $unit:literal, $allowed:expr, [$($measure:literal),+], $name:literal, $source:literal;)+) => {
        /// Every limit.
        pub const LIMITS: &[Limit] = &[$(Limit {
            id: $id, name: $name, unit: $unit, allowed: $allowed, measures: &[$($measure),+], source: $source,
            get: |limits| limits.$($field).+, place: |limits| &mut limits.$($field).+,
        }),+];
    };
}

limits! {
    "brake_threat", brake_threat, "m/s²", 0.1..=100.0, ["btn"],
        "deceleration that btn is compared with", "longitudinal limit of every vehicle of Althoff and Würsching, CommonRoad: Vehicle Models, 2020";
    "steer_threat", steer_threat, "m/s²", 0.1..=100.0, ["stn"],
        "lateral acceleration that stn is compared with", "default of commonroad-crime";
    "full_braking", full_braking, "m/s²", 0.1..=100.0, ["ttb", "ttr"],
        "full braking", "dry road";
    "kick_down", kick_down, "m/s²", 0.1..=100.0, ["ttk", "ttr"],
        "full acceleration", "passenger car";
    "evasion", evasion, "m/s²", 0.1..=100.0, ["tts", "ttr"],
        "lateral acceleration of evasive steering", "dry road";
    "tightest", tightest, "1/m", 0.001..=10.0, ["tts", "ttr"],
        "tightest curve that can be steered", "turning circle of a passenger car";
    "worst_case", worst_case, "m/s²", 0.1..=100.0, ["wttc"],
        "worst-case acceleration of all moving road users", "longitudinal limit of the CommonRoad vehicles";
    "tau", tau, "s", 0.01..=100.0, ["tet", "tit"],
        "ttc_lane below which tet and tit count", "Minderhoud and Bovy 2001";
    "madr_mean", madr.mean, "m/s²", 0.1..=100.0, ["cpi"],
        "available deceleration, mean", "Cunto and Saccomanno 2008";
    "madr_deviation", madr.deviation, "m/s²", 0.01..=100.0, ["cpi"],
        "available deceleration, standard deviation", "Cunto and Saccomanno 2008";
    "madr_least", madr.least, "m/s²", 0.0..=100.0, ["cpi"],
        "available deceleration, lower bound", "Cunto and Saccomanno 2008";
    "madr_most", madr.most, "m/s²", 0.1..=100.0, ["cpi"],
        "available deceleration, upper bound", "Cunto and Saccomanno 2008";
    "rss_response", rss.response, "s", 0.0..=10.0, ["rss_long", "rss_long_margin", "rss_lat", "rss_lat_margin", "rss_margin"],
        "response time", "examples of ad-rss-lib";
    "rss_accelerate", rss.accelerate, "m/s²", 0.0..=100.0, ["rss_long", "rss_long_margin", "rss_margin"],
        "largest acceleration during the response", "examples of ad-rss-lib";
    "rss_brake_least", rss.brake_least, "m/s²", 0.1..=100.0, ["rss_long", "rss_long_margin", "rss_margin"],
        "least braking of the one behind", "examples of ad-rss-lib";
    "rss_brake_most", rss.brake_most, "m/s²", 0.1..=100.0, ["rss_long", "rss_long_margin", "rss_margin"],
        "strongest braking of the one in front", "examples of ad-rss-lib";
    "rss_brake_correct", rss.brake_correct, "m/s²", 0.1..=100.0, ["rss_long", "rss_long_margin", "rss_margin"],
        "least braking before oncoming traffic, in the right lane", "examples of ad-rss-lib";
    "rss_lateral_accelerate", rss.lateral_accelerate, "m/s²", 0.0..=100.0, ["rss_lat", "rss_lat_margin", "rss_margin"],
        "largest lateral acceleration during the response", "examples of ad-rss-lib";
    "rss_lateral_brake", rss.lateral_brake, "m/s²", 0.1..=100.0, ["rss_lat", "rss_lat_margin", "rss_margin"],
        "least lateral braking", "examples of ad-rss-lib";
    "rss_lateral_margin", rss.lateral_margin, "m", 0.0..=10.0, ["rss_lat", "rss_lat_margin", "rss_margin"],
        "margin for lateral fluctuations", "examples of ad-rss-lib";
}

#[cfg(test)]
mod tests {
    use super::super::MEASURES;
    use super::*;

    #[test]
    fn every_limit_is_one_of_its_own_and_may_be_what_is_shipped() {
        assert_eq!(Limits::SHIPPED.mistake(), None);
        let mut limits = Limits::SHIPPED;
        for (place, limit) in LIMITS.iter().enumerate() {
            assert!(
                limit.allowed.contains(&limit.value(&limits)),
                "{}",
                limit.id
            );
            for id in limit.measures {
                assert!(MEASURES.iter().any(|m| m.id == *id), "{id}");
            }
            // Set to a value that no other has, it is read back, and no other changes.
            limit.set(&mut limits, 1000.0 + place as f64);
        }
        for (place, limit) in LIMITS.iter().enumerate() {
            assert_eq!(limit.value(&limits), 1000.0 + place as f64, "{}", limit.id);
        }
    }
}
