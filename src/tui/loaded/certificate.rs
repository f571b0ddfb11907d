//! The good driver who survives a variant, opened to stand beside the drive that does not.

use std::sync::Arc;

use super::{GeneratedVariant, Opened};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scenario, Scene};

/// The certificate's drive in a variant.
#[derive(Debug)]
pub struct CertificateDrive {
    /// Reaction time of the driver, seconds: the longest one that survives.
    pub delay: f64,
    /// The variant with that drive as its ego.
    pub opened: Opened,
}

impl CertificateDrive {
    /// Of a variant that was just made; nothing where no good driver survives it.
    pub(super) fn made(
        made: &GeneratedVariant,
        entry: &Entry,
        scenario: &Arc<Scenario>,
        thresholds: &Thresholds,
    ) -> Option<Self> {
        let certificates = made.avoidability.certificates.iter().rev();
        let mut survived = certificates.filter_map(|(delay, c)| Some((*delay, c.avoidance()?)));
        let (delay, avoidance) = survived.next()?;
        let driver = made.closed.driver();
        let ego = avoidance.drive.ego(driver.problem(), driver.settings());
        let scene = Arc::new(Scene::new(Arc::clone(scenario), ego));
        let opened = Opened::with(entry, None, Arc::clone(scenario), Ok(scene), thresholds);
        Some(Self { delay, opened })
    }

    /// Of a variant that was saved, from the file that its manifest names.
    pub(super) fn saved(entry: &Entry, variant: &Opened, thresholds: &Thresholds) -> Option<Self> {
        let saved = variant.saved.as_ref()?;
        let (delay, path) = saved.origin.certificate(None)?;
        let from_file = EgoSelection::File {
            path,
            planning_problem: None,
        };
        let mut ego = from_file.resolve(entry, &variant.scenario).ok()??;
        // The same vehicle drives; a recording cannot say so.
        ego.footprint = variant.scene.as_ref()?.ego.footprint.clone();
        let scenario = Arc::clone(&variant.scenario);
        let scene = Arc::new(Scene::new(Arc::clone(&scenario), ego));
        let opened = Opened::with(entry, None, scenario, Ok(scene), thresholds);
        Some(Self { delay, opened })
    }
}
