//! Where an obstacle is at a step, whether it moves or stands for ever.

use super::{Motion, Obstacle, ObstacleRole, SignalState, StateField, Steps};
use nearmiss_base::geometry::{Placed, angle_between};

impl Obstacle {
    /// Its motion at a step; static obstacles are present at all steps. Of a region of an occupancy set the place of its
    /// middle, and nothing else: see [`Self::is_occupancy_at`].
    #[must_use]
    pub fn motion_at(&self, step: i64) -> Option<&Motion> {
        if let Some(region) = self.region_at(step) {
            return Some(&region.motion);
        }
        match self.role {
            ObstacleRole::Static => self.track().iter().next().map(|(_, motion)| motion),
            _ => self.track().at(step),
        }
    }

    /// Its body at a step.
    #[must_use]
    pub fn placed_at(&self, step: i64) -> Option<Placed<'_>> {
        Some(self.footprint_at(step)?.at(self.motion_at(step)?.pose))
    }

    /// Its signals at a step; `None` if the file gives none.
    #[must_use]
    pub fn signals_at(&self, step: i64) -> Option<&SignalState> {
        let covers = |time: &Steps| (time.from..=time.to).contains(&step);
        self.signals.iter().find(|state| covers(&state.time))
    }

    /// Its yaw rate at a step, rad/s, and whether the file says it; else it is the change of the heading since the
    /// step before.
    #[must_use]
    pub fn yaw_rate_at(&self, step: i64, dt: f64) -> Option<(f64, bool)> {
        let said = self.states().find(|s| s.time == Steps::exact(step));
        if let Some(rate) = said.and_then(|s| s.quantity(StateField::YawRate)) {
            return Some((rate.middle(), true));
        }
        let heading = |step| self.track().at(step).map(|m| m.pose.heading);
        let turned = angle_between(heading(step.checked_sub(1)?)?, heading(step)?);
        Some((turned / dt, false))
    }
}
