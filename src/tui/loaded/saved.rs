//! The original of a variant that was opened from a file, as the certificate beside it names it.

use super::Opened;
use nearmiss_drive::generation::AttackerRecord;
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_render::{Variation, Variations};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::Scenario;
use nearmiss_workflow::VariantOrigin;

/// A saved variant's origin, with its original opened beside it.
#[derive(Debug)]
pub struct SavedVariant {
    /// What the certificate says.
    pub origin: VariantOrigin,
    /// The original, or why there is none.
    pub original: Result<(Entry, Box<Opened>), String>,
}

impl SavedVariant {
    /// Of a scenario; `None` where no certificate says that it is a variant.
    pub(super) fn of(entry: &Entry, thresholds: &Thresholds) -> Option<Self> {
        let origin = VariantOrigin::read(entry)?;
        let original = match origin.original() {
            None => Err(origin.missing()),
            Some((entry, _)) => Opened::alone(&entry, &EgoSelection::Beside, thresholds, None)
                .map(|opened| (entry, Box::new(opened))),
        };
        Some(Self { origin, original })
    }

    /// Both motions of each attacker, in this variant or its original; none where there is no original.
    #[must_use]
    pub fn variations<'a>(&'a self, variant: &'a Scenario, shows_changed: bool) -> Variations<'a> {
        let Ok((_, original)) = &self.original else {
            return Variations::default();
        };
        let both = |attacker: &AttackerRecord| {
            Some(Variation {
                recorded: original.scenario.obstacle(attacker.id)?,
                changed: variant.obstacle(attacker.id)?,
                from: attacker.from_step,
                shows_changed,
            })
        };
        self.origin
            .manifest
            .attackers
            .iter()
            .filter_map(both)
            .collect()
    }
}
