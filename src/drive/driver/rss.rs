//! Responsibility-Sensitive Safety as a driver: brakes once the safe distances are no longer kept.

use super::competent::{GROWTH, JERK, MOST, MOTORWAY, STRONGEST};
use super::model::{Driver, DriverModel, Foot, Now, Parameter, Seen};

/// A row of [`super::DRIVERS`].
pub const MODEL: DriverModel = DriverModel {
    id: "rss",
    name: "RSS driver",
    formula: "reacts where gap < vρ + ½aρ² + (v+aρ)²/(2b) - v₂²/(2b) and lateral gap < \
              μ + (2u+a₁ρ)ρ/2 + (u+a₁ρ)²/(2a₁), with u the other's lateral speed; after ρ braking that grows with j up to B",
    parameters: &[
        Parameter {
            symbol: "ρ",
            value: DELAY,
            unit: "s",
            what: "response time",
        },
        Parameter {
            symbol: "a",
            value: FASTER,
            unit: "m/s²",
            what: "acceleration until the response",
        },
        Parameter {
            symbol: "b",
            value: BRAKING,
            unit: "m/s²",
            what: "braking of both",
        },
        Parameter {
            symbol: "a₁",
            value: LATERAL,
            unit: "m/s²",
            what: "lateral acceleration and braking",
        },
        Parameter {
            symbol: "μ",
            value: FLUCTUATION,
            unit: "m",
            what: "lateral fluctuation",
        },
        GROWTH,
        STRONGEST,
    ],
    source: "Shalev-Shwartz, Shammah and Shashua, arXiv 1708.06374, 2017; as a driver with the braking of the competent \
             and careful one in JRC-FSM (Joint Research Centre, 2021)",
    limits: "same direction only; of the rule's proper response the braking alone; it never steers",
    not_made_for: MOTORWAY,
    following_gap: Some(following_gap),
    begin: Some(|| Box::new(Rss(Foot::after(DELAY)))),
};

const DELAY: f64 = 0.75;
const FASTER: f64 = 3.0;
const BRAKING: f64 = 6.0;
const LATERAL: f64 = 1.0;
const FLUCTUATION: f64 = 0.3;

/// The gap to a vehicle ahead with speed `ahead`, metres.
fn safe_gap(speed: f64, ahead: f64) -> f64 {
    speed * DELAY
        + FASTER * DELAY.powi(2) / 2.0
        + (speed + DELAY * FASTER).powi(2) / (2.0 * BRAKING)
        - ahead.powi(2) / (2.0 * BRAKING)
}

/// The gap that is still safe when the vehicle ahead, as fast now, has braked for the response time.
fn following_gap(speed: f64) -> f64 {
    safe_gap(speed, (speed - DELAY * BRAKING).max(0.0)) + BRAKING * DELAY.powi(2) / 2.0
}

struct Rss(Foot);

impl Rss {
    fn is_too_close(other: &Seen, speed: f64) -> bool {
        let lateral = other.towards.abs();
        let moved = (2.0 * lateral + LATERAL * DELAY) * DELAY / 2.0;
        let stopped = (lateral + LATERAL * DELAY).powi(2) / (2.0 * LATERAL);
        other.ahead >= 0.0
            && other.gap_long < safe_gap(speed, other.speed)
            && other.gap_lat < FLUCTUATION + moved + stopped
    }
}

impl Driver for Rss {
    fn react(&mut self, now: &Now<'_>) -> Option<f64> {
        let risky = now
            .others
            .iter()
            .any(|other| Self::is_too_close(other, now.speed));
        self.0.react(risky, now.dt, |foot| {
            if foot.is_late(now.dt) {
                return 0.0;
            }
            foot.press(JERK, MOST, now.dt)
        })
    }
}
