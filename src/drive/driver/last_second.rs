//! The last-second driver of UN Regulation 157, paragraph 5.2.5.2: brakes when a cut-in could just be avoided.

use super::competent::MOTORWAY;
use super::model::{Driver, DriverModel, Foot, Now, Parameter};

/// A row of [`super::DRIVERS`].
pub const MODEL: DriverModel = DriverModel {
    id: "r157",
    name: "R157 last-second driver",
    formula: "reacts where the other is within y of the ego's width and TTC ≤ Δv/(2B) + ρ + 0.1 s; after ρ it brakes with B",
    parameters: &[
        Parameter {
            symbol: "y",
            value: ASIDE,
            unit: "m",
            what: "lateral gap that is a risk",
        },
        Parameter {
            symbol: "ρ",
            value: DELAY,
            unit: "s",
            what: "reaction of the system",
        },
        Parameter {
            symbol: "B",
            value: MOST,
            unit: "m/s²",
            what: "braking",
        },
    ],
    source: "UN Regulation 157, 5.2.5.2; as in JRC-FSM (Joint Research Centre, 2021)",
    limits: "a demand on systems rather than a model of a person; motorways, cut-ins; it never steers",
    not_made_for: MOTORWAY,
    following_gap: None,
    begin: Some(|| Box::new(LastSecond(Foot::after(DELAY)))),
};

const ASIDE: f64 = 0.5;
const DELAY: f64 = 0.35;
const MOST: f64 = 6.0;
/// A step of the source's program, seconds.
const STEP: f64 = 0.1;

struct LastSecond(Foot);

impl Driver for LastSecond {
    fn react(&mut self, now: &Now<'_>) -> Option<f64> {
        let risky = now.others.iter().any(|other| {
            let closing = now.speed - other.speed;
            let enough = closing / (2.0 * MOST) + DELAY + STEP;
            other.ahead >= 0.0 && other.gap_lat <= ASIDE && other.ttc(now.speed).abs() <= enough
        });
        // A system that has begun to brake is not slow again, as in the source's program.
        (now.alarmed || risky).then(|| if self.0.is_late(now.dt) { 0.0 } else { -MOST })
    }
}
