//! Limits of people by kind of road user: what they do in an emergency at most, with sources.

use super::ObstacleType;

/// What people do in an emergency at most, by kind of road user. Their vehicles can do more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HumanLimits {
    /// Speeding up, m/s².
    pub speeding_up: f64,
    /// Braking, m/s².
    pub braking: f64,
    /// Acceleration across the heading, m/s².
    pub lateral: f64,
    /// Change of the acceleration along the heading, m/s³. Changing from the throttle to full braking takes
    /// (`speeding_up` + `braking`) / `jerk` seconds: the foot has to move, too.
    pub jerk: f64,
    /// Smallest radius of the rear axle's way, metres.
    pub radius: f64,
    /// Speed on foot or by bicycle, m/s; infinite where the vehicle's counts.
    pub speed: f64,
}

/// Braking and jerk of the competent and careful human driver of UN Regulation 157 (2021), annex 4, appendix 3: 0.774 g,
/// reached within 0.6 s.
const BRAKING: f64 = 7.59;
const JERK: f64 = 12.65;

/// Cars respond evenly up to this lateral acceleration, m/s², and most drivers keep below it (Mitschke and Wallentowitz,
/// Dynamik der Kraftfahrzeuge, 2014).
const LATERAL: f64 = 4.0;

/// Those of cars. Speeding up: a brisk start, 0 to 100 km/h in 8 s. Radius: the passenger car of AASHTO's Green Book
/// (2018), which turns on 6.4 m at the middle of the front axle.
const CAR: HumanLimits = HumanLimits {
    speeding_up: 3.5,
    braking: BRAKING,
    lateral: LATERAL,
    jerk: JERK,
    radius: 5.9,
    speed: f64::INFINITY,
};

impl HumanLimits {
    /// Those of a kind of road user that moves by itself.
    #[must_use]
    pub fn of(kind: ObstacleType) -> Self {
        match kind {
            // Speeding up: loaded lorries (Bokare and Maurya, Transportation Research Procedia 25, 2017). Braking: more
            // than the 5 m/s² that UN Regulation 13 demands. Lateral: loaded lorries roll over from 4 m/s² on (Winkler and
            // Ervin, UMTRI-99-19). Radius: single-unit truck and city bus of AASHTO's Green Book.
            ObstacleType::Truck | ObstacleType::Bus => Self {
                speeding_up: 1.5,
                braking: 6.5,
                lateral: 3.0,
                radius: 10.0,
                ..CAR
            },
            // Braking: what UN Regulation 78 demands of both brakes together, 6.43 m/s². Lateral: leaning by 22°.
            ObstacleType::Motorcycle => Self {
                braking: 6.43,
                radius: 4.1,
                ..CAR
            },
            // Braking before the rider goes over the bars, with a margin; lateral: leaning by 14°.
            ObstacleType::Bicycle => Self {
                speeding_up: 1.5,
                braking: 4.5,
                lateral: 2.5,
                jerk: 10.0,
                radius: 4.1,
                speed: 10.0,
            },
            // Walking and running adults (Fugger et al., Transportation Research Record 1705, 2000); they turn wide while
            // they hurry.
            ObstacleType::Pedestrian => Self {
                speeding_up: 2.0,
                braking: 3.0,
                lateral: 2.0,
                jerk: 10.0,
                radius: 4.1,
                speed: 4.0,
            },
            _ => CAR,
        }
    }
}
