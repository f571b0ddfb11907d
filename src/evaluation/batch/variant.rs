//! Variants of a question: a changed scene, or a window that ends at another lead before the collision.

use crate::evaluation::Lead;
use crate::scenario::Transform;
use crate::store::NewItem;

/// What tells questions about one scenario apart that are asked in the same way.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Variant {
    /// Where the window ends; nothing for where all windows of the batch do.
    pub lead: Option<Lead>,
    /// What is changed about the scene; nothing where it is as it is.
    pub transform: Option<Transform>,
}

impl Variant {
    /// The variant of a question of a batch.
    ///
    /// # Errors
    /// A word that this version does not know.
    pub fn of(asked: &NewItem) -> Result<Self, String> {
        let lead = asked.lead.as_deref().map(|word| {
            word.parse()
                .map_err(|why| format!("the lead {word} is not known to this version: {why}"))
        });
        let transform = asked.transform.as_deref().map(|word| {
            word.parse()
                .map_err(|why: crate::scenario::TransformError| why.to_string())
        });
        Ok(Self {
            lead: lead.transpose()?,
            transform: transform.transpose()?,
        })
    }

    /// The lead and the change as the store keeps them.
    #[must_use]
    pub fn words(&self) -> (Option<String>, Option<String>) {
        let lead = self.lead.map(Lead::stored);
        (lead, self.transform.map(|change| change.to_string()))
    }
}
