//! Which drivers would have avoided what an attack leads to.

use std::sync::Arc;

use nearmiss_scene::scenario::Scene;

use super::{Avoidability, ClosedLoop, Effect};
use crate::driver::{Field, Preventability, PreventabilityRecord};

impl Effect {
    /// The attacked ego's drive as a scene.
    #[must_use]
    pub fn scene(&self, closed: &ClosedLoop) -> Scene {
        let driver = closed.driver();
        let ego = self.drive.ego(driver.problem(), driver.settings());
        Scene::new(Arc::clone(&self.scenario), ego)
    }

    /// The obstacle and the step of the contact, or of the least risk without one.
    #[must_use]
    pub fn encounter(&self) -> Option<(i64, i64)> {
        let nearest = self.main().after.iter().min_by_key(|(_, score)| *score);
        match self.contact {
            Some(contact) => Some((contact.with, contact.step)),
            None => Some((self.main().obstacle, nearest?.0)),
        }
    }

    /// What drivers make of its encounter, each in the place of the attacked ego, and until when; the ideal one also with
    /// the certificates. `None` where the ego is not there before.
    #[must_use]
    pub fn preventability(
        &self,
        closed: &ClosedLoop,
        avoidability: &Avoidability,
    ) -> Option<PreventabilityRecord> {
        let scene = self.scene(closed);
        let (obstacle, step) = self.encounter()?;
        let is_certified = avoidability.at(0.0) == Some(true);
        PreventabilityRecord::of(&scene, obstacle, step, is_certified)
    }

    /// Whether all drivers with these ids avoid contact.
    #[must_use]
    pub(super) fn is_preventable_by(&self, closed: &ClosedLoop, drivers: &[&str]) -> bool {
        if drivers.is_empty() {
            return true;
        }
        let scene = self.scene(closed);
        let judged = self.encounter().and_then(|(obstacle, step)| {
            let field = Field::around(&scene, obstacle, step)?;
            Some(Preventability::of(&field))
        });
        judged.is_some_and(|found| drivers.iter().all(|id| found.is_avoided_by(id)))
    }
}
