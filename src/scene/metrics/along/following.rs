//! The other ahead in the ego's lane: what every measure of following needs.

use super::LaneBody;
use crate::metrics::{Context, NoValue};

/// The ego behind another in the same lane.
#[derive(Debug, Clone, Copy)]
pub(in crate::metrics) struct Following {
    /// From the ego's front to the other's rear along the route, metres, positive.
    pub gap: f64,
    /// The ego.
    pub ego: LaneBody,
    /// The other.
    pub other: LaneBody,
}

/// Shorter gaps are none, metres.
const TOUCHING: f64 = 1e-6;

/// Bodies farther apart across the route are on no common lane, metres: no lane is so wide.
const WIDEST: f64 = 20.0;

/// Slower changes are none, m/s and m/s²: they are rounding.
pub(super) const STILL: f64 = 1e-6;

impl Following {
    /// The two, if the other is ahead and stands on a lane that the ego stands on.
    pub fn find(context: &Context<'_>, participant: usize, index: usize) -> Result<Self, NoValue> {
        let ego = context.ego_along(index)?;
        let other = context.along(participant, index)?;
        if other.front < ego.rear {
            return Err(NoValue::Behind);
        }
        let gap = other.rear - ego.front;
        if gap <= TOUCHING {
            let touch = context.distances(participant)[index] == Some(0.0);
            return Err(if touch {
                NoValue::Contact
            } else {
                NoValue::Beside
            });
        }
        if ego.clearance(&other) > WIDEST {
            return Err(NoValue::OtherLane);
        }
        let road = context.road().map_err(|_| NoValue::NoRoute)?;
        let lanes = context.ego_lanes(road, index);
        if !lanes.meets(context.lanes_of(participant, index)) {
            return Err(NoValue::OtherLane);
        }
        Ok(Self { gap, ego, other })
    }

    /// Velocity of the other minus the ego's along the route, m/s; negative when closing.
    pub fn velocity(&self) -> f64 {
        still(self.other.velocity.x - self.ego.velocity.x)
    }

    /// Acceleration of the other minus the ego's along the route, m/s².
    pub fn acceleration(&self) -> f64 {
        still(self.other.acceleration - self.ego.acceleration)
    }

    /// Closing speed, m/s.
    pub fn closing(&self) -> Result<f64, NoValue> {
        let closing = -self.velocity();
        (closing > 0.0)
            .then_some(closing)
            .ok_or(NoValue::NotApproaching)
    }
}

fn still(value: f64) -> f64 {
    if value.abs() < STILL { 0.0 } else { value }
}
