//! The Fuzzy Safety Model: brakes softly while a gap is short, hard while a contact comes near.

use super::competent::{GROWTH, JERK, MOST, MOTORWAY};
use super::model::{Driver, DriverModel, Foot, Now, Parameter, Seen};

/// A row of [`super::DRIVERS`].
pub const MODEL: DriverModel = DriverModel {
    id: "fsm",
    name: "fuzzy safety model",
    formula: "PFS: 0 from a gap of vρ + v²/(2b) - v₂²/(2b₂) + 2m on, 1 below vρ + v²/(2B) - v₂²/(2b₂) + m; \
              CFS likewise of the closing speed after ρ, braking with b or B until both are as fast; \
              where either is above 0, after ρ, brakes with b + CFS·(B-b), else PFS·b, growing with j",
    parameters: &[
        Parameter {
            symbol: "ρ",
            value: DELAY,
            unit: "s",
            what: "reaction time",
        },
        Parameter {
            symbol: "b",
            value: SOFT,
            unit: "m/s²",
            what: "comfortable braking",
        },
        Parameter {
            symbol: "B",
            value: HARD,
            unit: "m/s²",
            what: "hard braking",
        },
        Parameter {
            symbol: "b₂",
            value: AHEAD,
            unit: "m/s²",
            what: "braking of the vehicle ahead",
        },
        Parameter {
            symbol: "m",
            value: MARGIN,
            unit: "m",
            what: "margin of the gap",
        },
        GROWTH,
    ],
    source: "Mattas et al., Accident Analysis and Prevention 148, 2020; UN Regulation 157, performance model 2; as in \
             JRC-FSM (Joint Research Centre, 2021)",
    limits: "motorways: cut-in, cut-out and braking ahead; it never steers",
    not_made_for: MOTORWAY,
    following_gap: Some(|v| {
        v * DELAY + v * v / (2.0 * SOFT) - v * v / (2.0 * AHEAD) + MARGIN + MARGIN
    }),
    begin: Some(|| Box::new(Fuzzy(Foot::after(DELAY)))),
};

const DELAY: f64 = 0.75;
const SOFT: f64 = 4.0;
const HARD: f64 = 6.0;
const AHEAD: f64 = 7.0;
const MARGIN: f64 = 2.0;
/// A cut-in concerns it unless the other gets here later than the ego has passed, by this, seconds.
const LATER: f64 = 0.1;

struct Fuzzy(Foot);

/// How far a value is from `safe` on the way to `unsafe_`, 0 to 1.
fn share(value: f64, safe: f64, unsafe_: f64) -> f64 {
    if value > safe {
        0.0
    } else if value < unsafe_ {
        1.0
    } else {
        (value - safe) / (unsafe_ - safe)
    }
}

/// The proactive fuzzy surrogate safety metric, 0 (safe) to 1.
fn proactive(other: &Seen, speed: f64) -> f64 {
    let ahead = other.speed.powi(2) / (2.0 * AHEAD);
    let stopping = |braking: f64| speed * DELAY + speed.powi(2) / (2.0 * braking) - ahead;
    share(
        other.gap_long - MARGIN,
        stopping(SOFT) + MARGIN,
        stopping(HARD),
    )
}

/// The critical fuzzy surrogate safety metric, 0 (safe) to 1. `acceleration` is the ego's.
fn critical(other: &Seen, speed: f64, acceleration: f64) -> f64 {
    if speed <= other.speed {
        return 0.0;
    }
    let expected = acceleration.max(-SOFT);
    let closing = speed + DELAY * expected - other.speed;
    if closing < 0.0 {
        let stopping = (speed - other.speed).powi(2) / (acceleration * 2.0).abs();
        return f64::from(u8::from(other.gap_long < stopping));
    }
    let meanwhile = (speed + expected * DELAY / 2.0 - other.speed) * DELAY;
    let needed = |braking: f64| meanwhile + closing.powi(2) / (braking * 2.0);
    share(other.gap_long, needed(SOFT), needed(HARD))
}

/// Whether it gets into the ego's way before the ego has passed it.
fn concerns(other: &Seen, speed: f64) -> bool {
    if other.ahead < 0.0 {
        return false;
    }
    if other.gap_lat <= 0.0 {
        return true;
    }
    let entering = other.gap_lat / other.towards;
    let passing = (other.ahead.abs() + other.half_lengths) / (speed - other.speed);
    other.towards > 0.0 && entering <= passing + LATER
}

impl Driver for Fuzzy {
    fn react(&mut self, now: &Now<'_>) -> Option<f64> {
        let near = now.others.iter().filter(|other| concerns(other, now.speed));
        let (cfs, pfs) = near.fold((0.0_f64, 0.0_f64), |(cfs, pfs), other| {
            let critical = critical(other, now.speed, now.acceleration);
            (cfs.max(critical), pfs.max(proactive(other, now.speed)))
        });
        self.0.react(cfs + pfs > 0.0, now.dt, |foot| {
            if foot.is_late(now.dt) {
                return 0.0;
            }
            let most = if cfs > 0.0 {
                cfs * (HARD - SOFT) + SOFT
            } else {
                pfs * SOFT
            };
            let pressed = (foot.deceleration + JERK * now.dt).min(MOST);
            foot.deceleration = pressed.min(most);
            -foot.deceleration
        })
    }
}
