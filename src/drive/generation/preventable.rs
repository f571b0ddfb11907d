//! Which drivers would have avoided what an attack leads to.

use std::sync::Arc;

use nearmiss_scene::metrics::{Context, critical_moments};
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

    /// The obstacle and the step of the contact, or of its critical moment without one.
    fn encounter(&self, scene: &Scene) -> Option<(i64, i64)> {
        if let Some(contact) = self.contact {
            return Some((contact.with, contact.step));
        }
        let obstacle = self.main().obstacle;
        let moments = critical_moments(&Context::new(scene));
        let moment = moments.iter().find(|moment| moment.obstacle == obstacle)?;
        Some((obstacle, moment.step))
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
        let (obstacle, step) = self.encounter(&scene)?;
        let is_certified = avoidability.at(0.0) == Some(true);
        PreventabilityRecord::of(&scene, obstacle, step, is_certified)
    }

    /// Whether it comes to a contact that all drivers with these ids avoid.
    #[must_use]
    pub(super) fn is_preventable_by(&self, closed: &ClosedLoop, drivers: &[&str]) -> bool {
        if drivers.is_empty() {
            return true;
        }
        let scene = self.scene(closed);
        let judged = self.contact.and_then(|contact| {
            let field = Field::around(&scene, contact.with, contact.step)?;
            Some(Preventability::of(&field))
        });
        judged.is_some_and(|found| drivers.iter().all(|id| found.is_avoided_by(id)))
    }
}
