//! Which drivers would have avoided what an attack leads to.

use std::sync::Arc;

use nearmiss_scene::scenario::Scene;

use super::{ClosedLoop, Effect};
use crate::driver::{Field, Preventability};

impl Effect {
    /// The attacked ego's drive as a scene.
    #[must_use]
    pub fn scene(&self, closed: &ClosedLoop) -> Scene {
        let driver = closed.driver();
        let ego = self.drive.ego(driver.problem(), driver.settings());
        Scene::new(Arc::clone(&self.scenario), ego)
    }

    /// What drivers make of the contact, or of the step at which the risk is least without one: each in the place of the
    /// attacked ego. With `moments` the last one of each is looked for, too. `None` where the ego is not there before.
    #[must_use]
    pub fn preventability(&self, closed: &ClosedLoop, moments: bool) -> Option<Preventability> {
        let scene = self.scene(closed);
        let nearest = self.main().after.iter().min_by_key(|(_, score)| *score);
        let (obstacle, step) = match self.contact {
            Some(contact) => (contact.with, contact.step),
            None => (self.main().obstacle, nearest?.0),
        };
        let field = Field::around(&scene, step)?;
        let found = Preventability::in_field(&field, obstacle, step);
        Some(if moments {
            found.with_last_moments(&field)
        } else {
            found
        })
    }
}
