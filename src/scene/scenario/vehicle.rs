//! The vehicles of CommonRoad benchmarks, how their motion is modelled, and what people do at most.
//!
//! Limits of people by kind of road user: what they do in an emergency at most, with sources.

use strum::{IntoStaticStr, VariantArray};

use nearmiss_base::geometry::{Footprint, Shape};

use super::ObstacleType;

/// How a benchmark models the motion of a vehicle; the first part of a vehicle id such as `KS2`.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Hash,
    PartialOrd,
    Ord,
    IntoStaticStr,
    VariantArray,
    strum::Display,
)]
#[strum(serialize_all = "UPPERCASE")]
pub enum VehicleModel {
    /// Point mass.
    Pm,
    /// Kinematic single-track.
    Ks,
    /// Single-track.
    St,
    /// Multi-body.
    Mb,
    /// Kinematic single-track with an on-axle trailer.
    Kst,
}

nearmiss_record::named!(VehicleModel);

impl VehicleModel {
    /// Its name in words.
    #[must_use]
    pub fn full_name(self) -> &'static str {
        match self {
            Self::Pm => "point mass",
            Self::Ks => "kinematic single-track",
            Self::St => "single-track",
            Self::Mb => "multi-body",
            Self::Kst => "kinematic single-track with trailer",
        }
    }
}

/// A vehicle with the parameters of Althoff and Würsching, "CommonRoad: Vehicle Models" (2020), which the
/// package `commonroad-vehicle-models` 3.0.2 holds as data; the number in a vehicle id such as `KS2`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, VariantArray)]
pub enum VehicleType {
    /// Vehicle 1.
    FordEscort,
    /// Vehicle 2, the usual one: recordings of the paper and Frenetix's logs are of it.
    Bmw320i,
    /// Vehicle 3.
    VwVanagon,
    /// Vehicle 4, a tractor unit; its semi-trailer is not part of these numbers.
    Truck,
}

impl VehicleType {
    /// Every vehicle, in the order of their numbers.
    pub const ALL: &'static [Self] = Self::VARIANTS;

    /// Its number in a vehicle id, from 1.
    #[must_use]
    pub fn number(self) -> u8 {
        match self {
            Self::FordEscort => 1,
            Self::Bmw320i => 2,
            Self::VwVanagon => 3,
            Self::Truck => 4,
        }
    }

    /// The vehicle with this number.
    #[must_use]
    pub fn parse(number: &str) -> Option<Self> {
        let number: u8 = number.parse().ok()?;
        Self::ALL.iter().copied().find(|v| v.number() == number)
    }

    /// What it is.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::FordEscort => "Ford Escort",
            Self::Bmw320i => "BMW 320i",
            Self::VwVanagon => "VW Vanagon",
            Self::Truck => "truck",
        }
    }

    /// Length of its body, metres.
    #[must_use]
    pub fn length(self) -> f64 {
        match self {
            Self::FordEscort => 4.298,
            Self::Bmw320i => 4.508,
            Self::VwVanagon => 4.569,
            Self::Truck => 5.1,
        }
    }

    /// Width of its body, metres.
    #[must_use]
    pub fn width(self) -> f64 {
        match self {
            Self::FordEscort => 1.674,
            Self::Bmw320i => 1.610,
            Self::VwVanagon => 1.844,
            Self::Truck => 2.55,
        }
    }

    /// From the centre of gravity forward to the front axle, metres.
    #[must_use]
    pub fn to_front_axle(self) -> f64 {
        match self {
            Self::FordEscort => 0.88392,
            Self::Bmw320i => 1.156_195_706_4,
            Self::VwVanagon => 1.150_791_602_4,
            Self::Truck => 1.8,
        }
    }

    /// From the centre of gravity back to the rear axle, metres.
    ///
    /// The CommonRoad planners take the centre of gravity for the centre of the body, and so does nearmiss.
    #[must_use]
    pub fn to_rear_axle(self) -> f64 {
        match self {
            Self::FordEscort => 1.50876,
            Self::Bmw320i => 1.422_717_093_6,
            Self::VwVanagon => 1.321_136_397_6,
            Self::Truck => 1.8,
        }
    }

    /// Between the axles, metres.
    #[must_use]
    pub fn wheelbase(self) -> f64 {
        self.to_front_axle() + self.to_rear_axle()
    }

    /// The region it covers, about its centre.
    #[must_use]
    pub fn footprint(self) -> Footprint {
        Footprint::new(Shape::rectangle(self.length(), self.width()))
            .expect("the sizes above are positive")
    }
}

impl std::fmt::Display for VehicleType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} (CommonRoad vehicle {}), {} m × {} m",
            self.name(),
            self.number(),
            self.length(),
            self.width()
        )
    }
}

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
    pub fn for_kind(kind: ObstacleType) -> Self {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers_lead_back() {
        for model in VehicleModel::ALL {
            assert_eq!(VehicleModel::parse(model.name()), Some(model));
        }
        for (i, vehicle) in VehicleType::ALL.iter().enumerate() {
            assert_eq!(usize::from(vehicle.number()), i + 1);
            assert_eq!(VehicleType::parse(&(i + 1).to_string()), Some(*vehicle));
            assert!(vehicle.wheelbase() < vehicle.length());
        }
        assert_eq!(VehicleType::parse("5"), None);
        assert_eq!(VehicleModel::parse("ks"), None);
    }

    #[test]
    fn the_bmw_is_the_published_one() {
        let bmw = VehicleType::Bmw320i;
        assert!((bmw.wheelbase() - 2.5789).abs() < 1e-4);
        assert_eq!(
            bmw.to_string(),
            "BMW 320i (CommonRoad vehicle 2), 4.508 m × 1.61 m"
        );
    }
}
