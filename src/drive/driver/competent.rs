//! The competent and careful driver of UN Regulation 157.

use super::model::{Driver, DriverModel, Foot, NotMadeFor, Now, Parameter, Seen};

/// A row of [`super::DRIVERS`].
pub const MODEL: DriverModel = DriverModel {
    id: "cc",
    name: "competent and careful driver",
    formula: "reacts to who overlaps the ego's width, or is known to have left the middle of its lane by w + p, where TTC ≤ T, \
              and to who brakes ahead by more than b; then -a for ρ, then braking that grows with j up to B",
    parameters: &[
        Parameter {
            symbol: "T",
            value: TTC,
            unit: "s",
            what: "time to collision that is a risk",
        },
        Parameter {
            symbol: "w",
            value: WANDERING,
            unit: "m",
            what: "wandering in a lane that is no cut-in",
        },
        Parameter {
            symbol: "p",
            value: PERCEIVING,
            unit: "m",
            what: "way to the side until it is perceived, 0.4 s at 1.8 m/s",
        },
        Parameter {
            symbol: "b",
            value: HARD,
            unit: "m/s²",
            what: "braking of the vehicle ahead that is a risk",
        },
        Parameter {
            symbol: "ρ",
            value: DELAY,
            unit: "s",
            what: "from perceiving the risk to braking",
        },
        Parameter {
            symbol: "a",
            value: RELEASED,
            unit: "m/s²",
            what: "deceleration with no foot on a pedal",
        },
        GROWTH,
        STRONGEST,
    ],
    source: "UN Regulation 157, annex, performance model 1; a and the overlap, which stands in where no lane is known, as in \
             JRC-FSM (Joint Research Centre, 2021)",
    limits: "motorways: cut-in, cut-out and braking ahead; without the regulation's automatic emergency braking; it never steers",
    not_made_for: MOTORWAY,
    following_gap: Some(|speed| 2.0 * speed),
    begin: Some(|| Box::new(Competent(Foot::after(DELAY)))),
};

/// What the models of motorways are not made for.
pub(super) const MOTORWAY: &[NotMadeFor] = &[
    NotMadeFor::Pedestrian,
    NotMadeFor::Crossing,
    NotMadeFor::Oncoming,
    NotMadeFor::Behind,
    NotMadeFor::Curve,
    NotMadeFor::Reversing,
];

const TTC: f64 = 2.0;
/// Also of who hides what is in front of it.
pub(super) const WANDERING: f64 = 0.375;
const PERCEIVING: f64 = 0.72;
const HARD: f64 = 5.0;
const DELAY: f64 = 0.75;
const RELEASED: f64 = 0.4;
/// Also of the other models that the regulation compares.
pub(super) const JERK: f64 = 12.65;
/// See [`JERK`].
pub(super) const MOST: f64 = 0.774 * 9.81;

/// The row of [`JERK`].
pub(super) const GROWTH: Parameter = Parameter {
    symbol: "j",
    value: JERK,
    unit: "m/s³",
    what: "growth of the braking",
};
/// The row of [`MOST`].
pub(super) const STRONGEST: Parameter = Parameter {
    symbol: "B",
    value: MOST,
    unit: "m/s²",
    what: "strongest braking, 0.774 g",
};

struct Competent(Foot);

fn is_perceived(other: &Seen) -> bool {
    let left = other
        .left_lane
        .is_some_and(|left| left >= WANDERING + PERCEIVING);
    other.gap_lat <= 0.0 || left
}

impl Driver for Competent {
    fn react(&mut self, now: &Now<'_>) -> Option<f64> {
        let risky = now.others.iter().any(|other| {
            let closes = now.speed > other.speed && other.ttc(now.speed) <= TTC;
            other.ahead >= 0.0
                && (is_perceived(other) && closes
                    || other.gap_lat <= 0.0 && other.acceleration < -HARD)
        });
        self.0.react(now.alarmed || risky, now.dt, |foot| {
            if foot.is_late(now.dt) {
                foot.deceleration = RELEASED;
                return -RELEASED;
            }
            foot.press(JERK, MOST, now.dt)
        })
    }

    fn dismisses(&self, other: &Seen, speed: f64) -> bool {
        other.ahead >= 0.0 && is_perceived(other) && other.ttc(speed).abs() > TTC
    }
}
