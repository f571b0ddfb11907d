//! The drivable road area, built once for a scenario.

use super::{Limits, VehicleState};
use nearmiss_base::geometry::{Footprint, Shape};
use nearmiss_scene::scenario::{DrivableArea, LaneletNetwork};

/// The area of all lanelets, and the body that has to stay on it.
#[derive(Debug, Clone)]
pub struct Road {
    area: DrivableArea,
    body: Footprint,
}

impl Road {
    /// The road of `network` for a body of these limits' size.
    ///
    /// All lanelets count, for whichever users: a pavement that is drawn as a lanelet is road here.
    #[must_use]
    pub fn new(network: &LaneletNetwork, limits: &Limits) -> Self {
        Self {
            area: network.drivable_area(None),
            body: Self::body_of(limits),
        }
    }

    /// The body of a vehicle of these limits' size, about its centre.
    #[must_use]
    pub fn body_of(limits: &Limits) -> Footprint {
        Footprint::new(Shape::rectangle(limits.length, limits.width))
            .expect("vehicles have a positive size")
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> &Footprint {
        &self.body
    }

    /// Whether all of the body is on the road.
    #[must_use]
    pub fn holds(&self, state: &VehicleState, limits: &Limits) -> bool {
        self.area.covers(&self.body.at(state.centre(limits).pose))
    }

    /// The first step at which the body leaves the road after it was on it.
    pub(super) fn left_at(
        &self,
        states: impl Iterator<Item = VehicleState>,
        limits: &Limits,
    ) -> Option<usize> {
        let mut on = false;
        for (step, state) in states.enumerate() {
            let holds = self.holds(&state, limits);
            if on && !holds {
                return Some(step);
            }
            on |= holds;
        }
        None
    }
}
