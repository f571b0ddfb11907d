//! A driver after NIEON (non-impaired, eyes on the conflict): responds the later, the more surprising the conflict is.

use super::competent::{GROWTH, JERK, MOST, STRONGEST};
use super::model::{Driver, DriverModel, Foot, NotMadeFor, Now, Parameter, Seen};

/// A row of [`super::DRIVERS`].
pub const MODEL: DriverModel = DriverModel {
    id: "nieon",
    name: "NIEON-like driver",
    formula: "from the moment at which speeds and directions kept lead to contact within 1/k, it needs \
              r + (R-r)·(1-exp(-S)), S the surprise in nats then; after that braking that grows with j up to B, until \
              it would pass with c to spare",
    parameters: &[
        Parameter {
            symbol: "k",
            value: LOOMING,
            unit: "1/s",
            what: "inverse time to contact that attentive drivers brake after",
        },
        Parameter {
            symbol: "r",
            value: EXPECTED,
            unit: "s",
            what: "response to what is expected",
        },
        Parameter {
            symbol: "R",
            value: SURPRISED,
            unit: "s",
            what: "response to what is not",
        },
        Parameter {
            symbol: "c",
            value: CLEAR,
            unit: "m",
            what: "room to pass; ours",
        },
        GROWTH,
        STRONGEST,
    ],
    source: "its idea: Engström et al., Accident Analysis and Prevention 198, 2024, and Scanlon et al., 2022; its numbers, not \
             theirs: Green, Transportation Human Factors 2, 2000 (r, R), Markkula et al., Accident Analysis and \
             Prevention 95, 2016 (k), UN Regulation 157 (j, B)",
    limits: "not Waymo's model, whose coefficients are not used; it brakes where NIEON may swerve",
    not_made_for: &[NotMadeFor::Behind, NotMadeFor::Reversing],
    following_gap: None,
    begin: Some(|| Box::new(Surprised(None))),
};

const LOOMING: f64 = 0.2;
const EXPECTED: f64 = 0.75;
const SURPRISED: f64 = 1.5;
const CLEAR: f64 = 1.0;

struct Surprised(Option<Foot>);

/// Seconds until speeds and directions kept lead to within a margin (m) of contact; `None` where they do not.
fn contact(other: &Seen, speed: f64, margin: f64) -> Option<f64> {
    let half_widths = other.aside.abs() - other.gap_lat;
    let long = during(
        other.ahead,
        speed - other.speed,
        other.half_lengths + margin,
    )?;
    let lat = during(other.aside.abs(), other.towards, half_widths + margin)?;
    let begin = long.0.max(lat.0).max(0.0);
    (begin <= long.1.min(lat.1)).then_some(begin)
}

/// When two stretches overlap whose middles are `apart` (m) and come closer with `closing` (m/s): both halves are `half`.
fn during(apart: f64, closing: f64, half: f64) -> Option<(f64, f64)> {
    if closing == 0.0 {
        return (apart.abs() < half).then_some((0.0, f64::INFINITY));
    }
    let (a, b) = ((apart - half) / closing, (apart + half) / closing);
    let (begin, end) = (a.min(b), a.max(b));
    (end >= 0.0).then_some((begin, end))
}

impl Driver for Surprised {
    fn react(&mut self, now: &Now<'_>) -> Option<f64> {
        let margin = if self.0.is_some() { CLEAR } else { 0.0 };
        let conflicts = now.others.iter().filter(|other| {
            let seconds = contact(other, now.speed, margin);
            other.ahead >= 0.0 && seconds.is_some_and(|seconds| seconds <= 1.0 / LOOMING)
        });
        let Some(surprise) = conflicts.map(|other| other.surprise).reduce(f64::max) else {
            // Back at the accelerator, the next one surprises anew.
            if self.0.as_mut().is_some_and(|foot| foot.rest(now.dt)) {
                self.0 = None;
            }
            return None;
        };
        let response = || EXPECTED + (SURPRISED - EXPECTED) * (1.0 - (-surprise).exp());
        let foot = self.0.get_or_insert_with(|| Foot::after(response()));
        foot.react(true, now.dt, |foot| {
            if foot.is_late(now.dt) {
                return 0.0;
            }
            foot.press(JERK, MOST, now.dt)
        })
    }
}
