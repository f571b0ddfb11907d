//! The numbers of a row of `relative_metrics.csv`, from the states of ego and obstacle, and the direction in its terms.

use super::{AcrossMotion, AlongMotion};
use crate::scenario::Motion;

/// The length of every participant, metres.
pub const LENGTH: f64 = 4.508;

/// The width of every participant, metres.
pub const WIDTH: f64 = 1.610;

/// Position and motion of an obstacle relative to the ego: forward and to the left are positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relation {
    /// The position of its centre.
    pub direction: Direction,
    /// Its centre ahead of the ego's, metres.
    pub d_long: f64,
    /// Its centre to the left of the ego's, metres.
    pub d_lat: f64,
    /// `d_long` less one length, towards 0, metres; 0 within a length.
    pub adjusted_d_long: f64,
    /// `d_lat` less one width, towards 0, metres; 0 within a width.
    pub adjusted_d_lat: f64,
    /// Its velocity along the ego's heading minus the ego's, m/s.
    pub v_rel_long: f64,
    /// Its velocity across the ego's heading, m/s.
    pub v_rel_lat: f64,
    /// Its acceleration minus the ego's along the x axis of the map, m/s².
    pub a_rel_long: f64,
    /// Its acceleration minus the ego's along the y axis of the map, m/s².
    pub a_rel_lat: f64,
    /// Seconds until `adjusted_d_long` is closed, 0 within a length; `None` if it does not come closer.
    pub ttc_long: Option<f64>,
    /// Seconds until `adjusted_d_lat` is closed, 0 within a width; `None` if it does not come closer.
    pub ttc_lat: Option<f64>,
    /// Its relative motion along the ego's heading.
    pub motion_long: AlongMotion,
    /// Its relative motion across the ego's heading.
    pub motion_lat: AcrossMotion,
}

impl Relation {
    /// The relation at one step, not yet rounded; `None` if the numbers are too large to be told apart.
    #[must_use]
    pub fn new(ego: &Motion, other: &Motion) -> Option<Self> {
        let apart = other.pose.position - ego.pose.position;
        let (sin, cos) = (ego.pose.heading.sin(), ego.pose.heading.cos());
        let d_long = apart.x * cos + apart.y * sin;
        let d_lat = -apart.x * sin + apart.y * cos;
        let (adjusted_d_long, adjusted_d_lat) = (adjusted(d_long, LENGTH), adjusted(d_lat, WIDTH));
        let turned = other.pose.heading - ego.pose.heading;
        let v_rel_long = other.velocity * turned.cos() - ego.velocity;
        let v_rel_lat = other.velocity * turned.sin();
        let a_rel_long = other.acceleration * other.pose.heading.cos() - ego.acceleration * cos;
        let a_rel_lat = other.acceleration * other.pose.heading.sin() - ego.acceleration * sin;
        let numbers = [d_long, d_lat, v_rel_long, v_rel_lat, a_rel_long, a_rel_lat];
        if !numbers.iter().all(|n| n.is_finite()) {
            return None;
        }
        let direction = Direction::from_offsets(d_long, d_lat);
        let motion_long = AlongMotion::classify(direction.along, v_rel_long);
        let motion_lat = AcrossMotion::classify(direction.across, v_rel_lat);
        Some(Self {
            direction,
            d_long,
            d_lat,
            adjusted_d_long,
            adjusted_d_lat,
            v_rel_long,
            v_rel_lat,
            a_rel_long,
            a_rel_lat,
            ttc_long: match motion_long {
                AlongMotion::Beside => Some(0.0),
                AlongMotion::ClosingAhead | AlongMotion::ClosingBehind => {
                    time(adjusted_d_long, v_rel_long)
                }
                AlongMotion::Receding | AlongMotion::Steady => None,
            },
            ttc_lat: match motion_lat {
                AcrossMotion::Aligned => Some(0.0),
                AcrossMotion::ClosingLeft | AcrossMotion::ClosingRight => {
                    time(adjusted_d_lat, v_rel_lat)
                }
                _ => None,
            },
            motion_long,
            motion_lat,
        })
    }

    /// Every number with two decimals, as published.
    #[must_use]
    pub fn rounded(self) -> Self {
        Self {
            d_long: rounded(self.d_long),
            d_lat: rounded(self.d_lat),
            adjusted_d_long: rounded(self.adjusted_d_long),
            adjusted_d_lat: rounded(self.adjusted_d_lat),
            v_rel_long: rounded(self.v_rel_long),
            v_rel_lat: rounded(self.v_rel_lat),
            a_rel_long: rounded(self.a_rel_long),
            a_rel_lat: rounded(self.a_rel_lat),
            ttc_long: self.ttc_long.map(rounded),
            ttc_lat: self.ttc_lat.map(rounded),
            ..self
        }
    }
}

fn adjusted(distance: f64, size: f64) -> f64 {
    if distance.abs() < size {
        0.0
    } else {
        (distance.abs() - size).copysign(distance)
    }
}

/// Never, where the velocity is so small that the time is beyond all numbers.
fn time(gap: f64, velocity: f64) -> Option<f64> {
    Some((gap / velocity).abs()).filter(|time| time.is_finite())
}

/// Two decimals as numpy rounds: the nearest whole number of hundredths, to the even one from half-way, after a
/// multiplication that may itself have rounded (1.005 is 1.0, since 1.005 · 100 is below 100.5; 2.675 is 2.68).
fn rounded(value: f64) -> f64 {
    let hundredths = value * 100.0;
    if hundredths.is_finite() {
        hundredths.round_ties_even() / 100.0
    } else {
        value
    }
}

/// Position along the ego's heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Along {
    /// More than a length ahead.
    Front,
    /// Within a length.
    Beside,
    /// More than a length behind.
    Behind,
}

/// Position across the ego's heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Across {
    /// More than a width to the left.
    Left,
    /// Within a width.
    Aligned,
    /// More than a width to the right.
    Right,
}

/// Both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Direction {
    /// Along the ego's heading.
    pub along: Along,
    /// Across it.
    pub across: Across,
}

impl Direction {
    /// The direction of a centre, metres forward and to the left of the ego's.
    #[must_use]
    pub fn from_offsets(d_long: f64, d_lat: f64) -> Self {
        let along = if d_long > LENGTH {
            Along::Front
        } else if d_long < -LENGTH {
            Along::Behind
        } else {
            Along::Beside
        };
        let across = if d_lat > WIDTH {
            Across::Left
        } else if d_lat < -WIDTH {
            Across::Right
        } else {
            Across::Aligned
        };
        Self { along, across }
    }

    /// The published word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match (self.along, self.across) {
            (Along::Front, Across::Aligned) => "Front",
            (Along::Front, Across::Left) => "Front-left",
            (Along::Front, Across::Right) => "Front-right",
            (Along::Behind, Across::Aligned) => "Behind",
            (Along::Behind, Across::Left) => "Rear-left",
            (Along::Behind, Across::Right) => "Rear-right",
            (Along::Beside, Across::Left) => "Left",
            (Along::Beside, Across::Right) => "Right",
            (Along::Beside, Across::Aligned) => "Collision",
        }
    }

    /// How much the longitudinal grade counts against the lateral one: all of it straight ahead, nothing
    /// beside, half everywhere else, also straight behind.
    #[must_use]
    pub fn longitudinal_weight(self) -> f64 {
        match (self.along, self.across) {
            (Along::Front, Across::Aligned) => 1.0,
            (Along::Beside, Across::Left | Across::Right) => 0.0,
            _ => 0.5,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;
    use nearmiss_base::geometry::{Point, Pose};

    fn motion(x: f64, y: f64, heading: f64, velocity: f64, acceleration: f64) -> Motion {
        let position = Point::new(x, y);
        Motion {
            pose: Pose { position, heading },
            velocity,
            acceleration,
        }
    }

    /// An obstacle with the ego's heading, seen by an ego at the origin at 10 m/s.
    fn seen(x: f64, y: f64, velocity: f64) -> Relation {
        let ego = motion(0.0, 0.0, 0.0, 10.0, 0.0);
        Relation::new(&ego, &motion(x, y, 0.0, velocity, 0.0)).unwrap()
    }

    #[test]
    fn gaps_are_those_of_fixed_boxes() {
        let ahead = seen(10.0, -3.0, 10.0);
        assert_eq!((ahead.d_long, ahead.d_lat), (10.0, -3.0));
        assert_eq!(ahead.adjusted_d_long, 10.0 - LENGTH);
        assert_eq!(ahead.adjusted_d_lat, -(3.0 - WIDTH));
        let beside = seen(-4.5, 1.6, 10.0);
        assert_eq!((beside.adjusted_d_long, beside.adjusted_d_lat), (0.0, 0.0));
        assert_eq!(seen(LENGTH, WIDTH, 10.0).adjusted_d_long, 0.0);
    }

    #[test]
    fn the_ego_frame_turns_positions_and_velocities_but_not_accelerations() {
        let ego = motion(5.0, 5.0, FRAC_PI_2, 10.0, 2.0);
        let r = Relation::new(&ego, &motion(5.0, 25.0, PI, 4.0, 1.0)).unwrap();
        assert!((r.d_long - 20.0).abs() < 1e-9 && r.d_lat.abs() < 1e-9);
        // It drives to the left across the ego's way.
        assert!((r.v_rel_long + 10.0).abs() < 1e-9 && (r.v_rel_lat - 4.0).abs() < 1e-9);
        // Along the axes of the map: −1 − 0 and 0 − 2.
        assert!((r.a_rel_long + 1.0).abs() < 1e-9 && (r.a_rel_lat + 2.0).abs() < 1e-9);
    }

    #[test]
    fn times_along() {
        let near = |time: Option<f64>, expected: f64| (time.unwrap() - expected).abs() < 1e-12;
        assert!(near(seen(14.508, 0.0, 5.0).ttc_long, 2.0), "ahead, slower");
        assert_eq!(seen(14.508, 0.0, 15.0).ttc_long, None, "ahead, faster");
        assert!(
            near(seen(-14.508, 0.0, 15.0).ttc_long, 2.0),
            "behind, faster"
        );
        assert_eq!(seen(-14.508, 0.0, 5.0).ttc_long, None, "behind, slower");
        assert_eq!(seen(14.508, 0.0, 10.0).ttc_long, None, "as fast");
        for velocity in [5.0, 10.0, 15.0] {
            assert_eq!(seen(4.0, 9.0, velocity).ttc_long, Some(0.0), "beside");
        }
    }

    #[test]
    fn times_across() {
        let ego = motion(0.0, 0.0, 0.0, 10.0, 0.0);
        let crossing = |y, heading| {
            let other = motion(0.0, y, heading, 2.0, 0.0);
            Relation::new(&ego, &other).unwrap().ttc_lat
        };
        assert_eq!(crossing(5.61, -FRAC_PI_2), Some(2.0), "from the left");
        assert_eq!(crossing(5.61, FRAC_PI_2), None, "off to the left");
        assert_eq!(crossing(-5.61, FRAC_PI_2), Some(2.0), "from the right");
        assert_eq!(crossing(-5.61, -FRAC_PI_2), None, "off to the right");
        assert_eq!(crossing(5.61, 0.0), None, "as it is");
        assert_eq!(crossing(1.0, FRAC_PI_2), Some(0.0), "in line");
    }

    #[test]
    fn nothing_is_infinite() {
        let ego = motion(0.0, 0.0, 0.0, 0.0, 0.0);
        let crawling = Relation::new(&ego, &motion(1e9, 0.0, 0.0, -1e-310, 0.0)).unwrap();
        assert_eq!(crawling.motion_long, AlongMotion::ClosingAhead);
        assert_eq!(crawling.ttc_long, None);
        let (far, back) = (
            motion(1.5e308, 0.0, 0.0, 0.0, 0.0),
            motion(-1.5e308, 0.0, 0.0, 0.0, 0.0),
        );
        assert_eq!(Relation::new(&back, &far), None);
        assert!(
            Relation::new(&ego, &far)
                .unwrap()
                .rounded()
                .d_long
                .is_finite()
        );
    }

    #[test]
    fn rounds_as_numpy_does() {
        // What numpy.round(x, 2) gives, among them halves that Python's round() takes the other way.
        for (value, expected) in [
            (0.125, 0.12),
            (0.375, 0.38),
            (-0.125, -0.12),
            (2.675, 2.68),
            (1.005, 1.0),
            (0.285, 0.28),
            (1.115, 1.12),
            (-0.001, 0.0),
            (1e300, 1e300),
        ] {
            assert_eq!(rounded(value), expected, "{value}");
        }
        assert!(rounded(-0.001).is_sign_negative());
    }

    #[test]
    fn every_direction_has_its_word_and_weight() {
        let expected = [
            (9.0, 0.0, "Front", 1.0),
            (9.0, 3.0, "Front-left", 0.5),
            (9.0, -3.0, "Front-right", 0.5),
            (-9.0, 0.0, "Behind", 0.5),
            (-9.0, 3.0, "Rear-left", 0.5),
            (-9.0, -3.0, "Rear-right", 0.5),
            (1.0, 3.0, "Left", 0.0),
            (1.0, -3.0, "Right", 0.0),
            (1.0, 1.0, "Collision", 0.5),
        ];
        for (d_long, d_lat, name, weight) in expected {
            let direction = Direction::from_offsets(d_long, d_lat);
            assert_eq!(direction.name(), name);
            assert_eq!(direction.longitudinal_weight(), weight, "{name}");
        }
    }

    #[test]
    fn exactly_a_length_or_a_width_away_is_not_outside() {
        assert_eq!(Direction::from_offsets(LENGTH, WIDTH).name(), "Collision");
        assert_eq!(Direction::from_offsets(-LENGTH, -WIDTH).name(), "Collision");
        assert_eq!(
            Direction::from_offsets(LENGTH.next_up(), WIDTH.next_up()).name(),
            "Front-left"
        );
    }
}
