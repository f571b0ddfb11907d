//! Position and motion of another participant in the ego's frame: x forward, y left; gaps and relative velocities.

use nearmiss_base::geometry::Vector;

use super::{Danger, Encounter, Measure, NoValue, Reading};

/// The position of another participant relative to the ego's body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// Ahead, overlapping sideways.
    Front,
    /// Ahead and to the left.
    FrontLeft,
    /// Ahead and to the right.
    FrontRight,
    /// Behind, overlapping sideways.
    Behind,
    /// Behind and to the left.
    RearLeft,
    /// Behind and to the right.
    RearRight,
    /// Beside, on the left.
    Left,
    /// Beside, on the right.
    Right,
    /// Touching or overlapping.
    Contact,
}

impl Direction {
    /// Whether that is on the left, ahead or behind too.
    #[must_use]
    pub fn is_left(self) -> bool {
        matches!(self, Self::Left | Self::FrontLeft | Self::RearLeft)
    }

    /// Whether that is on the right, ahead or behind too.
    #[must_use]
    pub fn is_right(self) -> bool {
        matches!(self, Self::Right | Self::FrontRight | Self::RearRight)
    }

    /// Whether that is behind, on whatever side.
    #[must_use]
    pub fn is_behind(self) -> bool {
        matches!(self, Self::Behind | Self::RearLeft | Self::RearRight)
    }

    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "Front",
            Self::FrontLeft => "Front-left",
            Self::FrontRight => "Front-right",
            Self::Behind => "Behind",
            Self::RearLeft => "Rear-left",
            Self::RearRight => "Rear-right",
            Self::Left => "Left",
            Self::Right => "Right",
            Self::Contact => "Contact",
        }
    }

    /// How much the longitudinal gap counts against the lateral one, 0 to 1: all of it straight
    /// ahead and behind, none of it beside, half diagonally (From Words to Collisions, risk score).
    #[must_use]
    pub fn longitudinal_weight(self) -> f64 {
        match self {
            Self::Front | Self::Behind => 1.0,
            Self::Left | Self::Right => 0.0,
            _ => 0.5,
        }
    }
}

/// The relation of another participant to the ego at one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relation {
    /// Its position.
    pub direction: Direction,
    /// Free distance along the ego's heading, metres; negative behind, 0 where the bodies overlap along it.
    pub gap_long: f64,
    /// Free distance across the ego's heading, metres; positive left, 0 where the bodies overlap across it.
    pub gap_lat: f64,
    /// Velocity of the other minus the ego's, in the ego's frame, m/s.
    pub velocity: Vector,
    /// Acceleration of the other minus the ego's, in the ego's frame, m/s².
    pub acceleration: Vector,
}

impl Relation {
    /// The relation in an encounter.
    #[must_use]
    pub fn new(encounter: &Encounter<'_>) -> Self {
        let frame = encounter.ego.pose;
        let gap = |axis: &Vector| {
            let (ego_from, ego_to) = encounter.ego_placed().extent(&frame.position, axis);
            let (from, to) = encounter.other_placed().extent(&frame.position, axis);
            if from > ego_to {
                from - ego_to
            } else if to < ego_from {
                to - ego_from
            } else {
                0.0
            }
        };
        let (gap_long, gap_lat) = (gap(&frame.forward()), gap(&frame.left()));
        let velocity = encounter.other.velocity_vector() - encounter.ego.velocity_vector();
        let acceleration =
            encounter.other.acceleration_vector() - encounter.ego.acceleration_vector();
        Self {
            direction: direction(gap_long, gap_lat).unwrap_or_else(|| close(encounter)),
            gap_long,
            gap_lat,
            velocity: frame.vector_to_local(&velocity),
            acceleration: frame.vector_to_local(&acceleration),
        }
    }

    /// Seconds until the longitudinal gap is closed at the present relative velocity.
    #[must_use]
    pub fn time_long(&self) -> Option<f64> {
        time_to_close(self.gap_long, self.velocity.x)
    }

    /// Seconds until the lateral gap is closed at the present relative velocity.
    #[must_use]
    pub fn time_lat(&self) -> Option<f64> {
        time_to_close(self.gap_lat, self.velocity.y)
    }
}

/// Slower than this, m/s, is standing still relative to each other.
const SLOWEST: f64 = 1e-6;

fn time_to_close(gap: f64, velocity: f64) -> Option<f64> {
    let closing = -velocity * gap.signum();
    (gap != 0.0 && closing > SLOWEST).then(|| gap.abs() / closing)
}

fn direction(gap_long: f64, gap_lat: f64) -> Option<Direction> {
    use std::cmp::Ordering::{Equal, Greater, Less};
    let side = |gap: f64| gap.partial_cmp(&0.0).unwrap_or(Equal);
    Some(match (side(gap_long), side(gap_lat)) {
        (Greater, Equal) => Direction::Front,
        (Greater, Greater) => Direction::FrontLeft,
        (Greater, Less) => Direction::FrontRight,
        (Less, Equal) => Direction::Behind,
        (Less, Greater) => Direction::RearLeft,
        (Less, Less) => Direction::RearRight,
        (Equal, Greater) => Direction::Left,
        (Equal, Less) => Direction::Right,
        (Equal, Equal) => return None,
    })
}

/// The direction where the bodies overlap along both axes: contact, or, between turned bodies that
/// do not touch, the side of the ego that the other's centre lies nearest to.
fn close(encounter: &Encounter<'_>) -> Direction {
    if encounter.distance() == 0.0 {
        return Direction::Contact;
    }
    side_of_centre(encounter)
}

/// The side of the ego that the other's centre lies nearest to, for the ego's proportions.
#[must_use]
pub fn side_of_centre(encounter: &Encounter<'_>) -> Direction {
    let center = encounter.ego.pose.to_local(&encounter.other.pose.position);
    let (length, width) = encounter.ego_body.shape().size();
    if center.x.abs() * width > center.y.abs() * length {
        if center.x > 0.0 {
            Direction::Front
        } else {
            Direction::Behind
        }
    } else if center.y > 0.0 {
        Direction::Left
    } else {
        Direction::Right
    }
}

pub(super) const GAP_LONG: Measure = Measure::new(
    "gap_long",
    "longitudinal gap",
    "m",
    Danger::Neutral,
    "ego frame, bumper to bumper",
    |e| Reading::Value(e.relation().gap_long),
);

pub(super) const GAP_LAT: Measure = Measure::new(
    "gap_lat",
    "lateral gap",
    "m",
    Danger::Neutral,
    "ego frame, side to side",
    |e| Reading::Value(e.relation().gap_lat),
)
.negated();

pub(super) const TTC_LONG: Measure = Measure::new(
    "ttc_long",
    "time to close the longitudinal gap",
    "s",
    Danger::Low,
    "gap over closing speed, ego frame",
    |e| to_close(&e.relation(), |r| r.gap_long, Relation::time_long),
);

pub(super) const TTC_LAT: Measure = Measure::new(
    "ttc_lat",
    "time to close the lateral gap",
    "s",
    Danger::Low,
    "gap over closing speed, ego frame",
    |e| to_close(&e.relation(), |r| r.gap_lat, Relation::time_lat),
);

pub(super) const V_REL_LONG: Measure = Measure::new(
    "v_rel_long",
    "relative velocity, longitudinal",
    "m/s",
    Danger::Neutral,
    "ego frame",
    |e| Reading::Value(e.relation().velocity.x),
);

pub(super) const V_REL_LAT: Measure = Measure::new(
    "v_rel_lat",
    "relative velocity, lateral",
    "m/s",
    Danger::Neutral,
    "ego frame",
    |e| Reading::Value(e.relation().velocity.y),
)
.negated();

pub(super) const A_REL_LONG: Measure = Measure::new(
    "a_rel_long",
    "relative acceleration, longitudinal",
    "m/s²",
    Danger::Neutral,
    "ego frame",
    |e| Reading::Value(e.relation().acceleration.x),
);

pub(super) const A_REL_LAT: Measure = Measure::new(
    "a_rel_lat",
    "relative acceleration, lateral",
    "m/s²",
    Danger::Neutral,
    "ego frame",
    |e| Reading::Value(e.relation().acceleration.y),
)
.negated();

/// The time to close a gap, which is 0 where the bodies overlap along its axis.
fn to_close(
    relation: &Relation,
    gap: fn(&Relation) -> f64,
    time: fn(&Relation) -> Option<f64>,
) -> Reading {
    let none = if gap(relation) == 0.0 {
        NoValue::Overlapping
    } else {
        NoValue::NotApproaching
    };
    time(relation).ok_or(none).into()
}

#[cfg(test)]
pub(super) mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::scenario::Motion;
    use nearmiss_base::geometry::{Footprint, Pose, Shape};

    pub(crate) fn motion(x: f64, y: f64, heading: f64, velocity: f64) -> Motion {
        Motion {
            pose: Pose::new(x, y, heading),
            velocity,
            acceleration: 0.0,
        }
    }

    pub(crate) fn with<T>(ego: Motion, other: Motion, f: impl Fn(&Encounter<'_>) -> T) -> T {
        let car = Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap();
        f(&Encounter::nowhere((&ego, &car), (&other, &car)))
    }

    #[test]
    fn gaps_and_directions() {
        let here = motion(0.0, 0.0, 0.0, 10.0);
        let cases = [
            (10.0, 0.0, Direction::Front, 6.0, 0.0),
            (-10.0, 5.0, Direction::RearLeft, -6.0, 3.0),
            (1.0, -4.0, Direction::Right, 0.0, -2.0),
            (3.0, 1.0, Direction::Contact, 0.0, 0.0),
        ];
        for (x, y, direction, long, lat) in cases {
            let r = with(here, motion(x, y, 0.0, 4.0), |e| e.relation());
            assert_eq!(r.direction, direction);
            assert!(
                (r.gap_long - long).abs() < 1e-9 && (r.gap_lat - lat).abs() < 1e-9,
                "{r:?}"
            );
        }
    }

    #[test]
    fn a_turned_frame_changes_nothing() {
        let angle = 2.3;
        let frame = Pose::new(100.0, -50.0, angle);
        let turn = |m: Motion| Motion {
            pose: Pose {
                position: frame.to_world(&m.pose.position),
                heading: m.pose.heading + angle,
            },
            ..m
        };
        let (ego, other) = (motion(0., 0., 0.1, 9.0), motion(12.0, 3.5, -0.4, 5.0));
        let straight = with(ego, other, |e| e.relation());
        let turned = with(turn(ego), turn(other), |e| e.relation());
        assert_eq!(straight.direction, turned.direction);
        assert!((straight.gap_long - turned.gap_long).abs() < 1e-9);
        assert!((straight.velocity - turned.velocity).norm() < 1e-9);
    }

    #[test]
    fn times_to_close() {
        let r = with(motion(0., 0., 0., 10.), motion(14., 0., 0., 5.), |e| {
            e.relation()
        });
        assert!((r.time_long().unwrap() - 2.0).abs() < 1e-9);
        assert_eq!(r.time_lat(), None);
        let away = with(motion(0., 0., 0., 5.), motion(14., 0., 0., 10.), |e| {
            e.relation()
        });
        assert_eq!(away.time_long(), None);
    }

    #[test]
    fn without_a_gap_there_is_nothing_to_close() {
        let ahead = |measure: &Measure, v| {
            let (ego, other) = (motion(0., 0., 0., 10.), motion(14., 0., 0., v));
            with(ego, other, |e| measure.compute(e))
        };
        assert!(
            ahead(&TTC_LONG, 5.)
                .value()
                .is_some_and(|t| (t - 2.0).abs() < 1e-9)
        );
        assert_eq!(
            ahead(&TTC_LONG, 15.),
            Reading::None(NoValue::NotApproaching)
        );
        assert_eq!(ahead(&TTC_LAT, 5.), Reading::None(NoValue::Overlapping));
    }
}
