//! The original of a variant that was opened from a file, as the certificate beside it names it.

use super::Opened;
use crate::formats::{EgoSelection, Entry};
use crate::metrics::Thresholds;
use crate::render::Variation;
use crate::scenario::Scenario;
use crate::workflow::VariantOrigin;

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
        let origin = VariantOrigin::of(entry)?;
        let original = match origin.original() {
            None => Err(origin.missing()),
            Some((entry, _)) => Opened::alone(&entry, &EgoSelection::Beside, thresholds, None)
                .map(|opened| (entry, Box::new(opened))),
        };
        Some(Self { origin, original })
    }

    /// Both motions of the attacker, in this variant or its original.
    #[must_use]
    pub fn variation<'a>(
        &'a self,
        variant: &'a Scenario,
        shows_changed: bool,
    ) -> Option<Variation<'a>> {
        let (_, original) = self.original.as_ref().ok()?;
        Some(Variation {
            recorded: original.scenario.obstacle(self.origin.attacker)?,
            changed: variant.obstacle(self.origin.attacker)?,
            from: self.origin.from,
            shows_changed,
        })
    }
}
