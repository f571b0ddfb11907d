//! A variant's original, to draw both motions of each attacker.

use std::path::Path;
use std::sync::Arc;

use crate::open::entry;
use crate::{Failure, output};
use nearmiss_drive::generation::AttackerRecord;
use nearmiss_formats::Entry;
use nearmiss_render::{Variation, Variations};
use nearmiss_scene::scenario::Scenario;
use nearmiss_workflow::VariantOrigin;

/// A variant's original, and how the two differ.
pub struct Original {
    /// Where it is.
    pub entry: Entry,
    /// The original.
    pub scenario: Arc<Scenario>,
    /// What the manifest says of the variant.
    pub origin: VariantOrigin,
}

impl Original {
    /// The original of an entry; `None` if there is no manifest of `nearmiss generate` beside it.
    ///
    /// # Errors
    /// The original is not available, and why.
    pub fn find(entry: &Entry) -> Result<Option<Self>, String> {
        let Some(origin) = VariantOrigin::read(entry) else {
            return Ok(None);
        };
        match origin.original() {
            Some((entry, scenario)) => Ok(Some(Self {
                entry,
                scenario,
                origin,
            })),
            None => Err(format!(
                "{}; name it with --original FILE",
                origin.missing()
            )),
        }
    }

    /// The scenario that `--original` names for an entry.
    ///
    /// # Errors
    /// It cannot be read, there is no manifest beside the entry, or it names another original.
    pub fn named(variant: &Entry, original: &Path) -> Result<Self, Failure> {
        let origin = VariantOrigin::read(variant).ok_or_else(|| {
            Failure::input(format!(
                "--original: {} has no manifest of `nearmiss generate` (NAME.json) beside it",
                variant.display()
            ))
        })?;
        let entry = entry(original)?;
        let scenario = entry.read().map_err(Failure::input)?;
        if origin.is_original(&scenario) {
            Ok(Self {
                entry,
                scenario,
                origin,
            })
        } else {
            Err(Failure::input(format!(
                "--original {}: its SHA-256 is {}, but {} was generated from {} with {}",
                original.display(),
                scenario.hash,
                variant.display(),
                output::visible(&origin.manifest.original.benchmark_id),
                output::visible(&origin.manifest.original.sha256)
            )))
        }
    }

    /// Both motions of each attacker, in a variant of this.
    pub fn variations<'a>(&'a self, variant: &'a Scenario) -> Variations<'a> {
        let both = |attacker: &AttackerRecord| {
            Some(Variation {
                recorded: self.scenario.obstacle(attacker.id)?,
                changed: variant.obstacle(attacker.id)?,
                from: attacker.from_step,
                shows_changed: true,
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
