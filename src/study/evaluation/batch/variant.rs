//! Variants of a question: a changed scene, or a window that ends at another lead before the collision.

use crate::evaluation::Lead;
use nearmiss_scene::scenario::Transform;
use nearmiss_store::NewItem;

/// Distinguishes questions about one scenario under the same prompt configuration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Variant {
    /// End of the window; `None` for the batch's common end.
    pub lead: Option<Lead>,
    /// Change of the scene; `None` if unchanged.
    pub transform: Option<Transform>,
    /// First and last step of the window, where it was drawn; `None` for the one that task and lead give.
    pub window: Option<(i64, i64)>,
}

impl Variant {
    /// The variant of a question of a batch.
    ///
    /// # Errors
    /// A value written by an unknown version.
    pub fn from_item(asked: &NewItem) -> Result<Self, String> {
        let lead = asked.lead.as_deref().map(|word| {
            word.parse()
                .map_err(|why| format!("the lead {word} is not known to this version: {why}"))
        });
        let transform = asked.transform.as_deref().map(|word| {
            word.parse()
                .map_err(|why: nearmiss_scene::scenario::TransformError| why.to_string())
        });
        Ok(Self {
            lead: lead.transpose()?,
            transform: transform.transpose()?,
            window: asked.window,
        })
    }

    /// The lead and the change as stored.
    #[must_use]
    pub fn words(&self) -> (Option<String>, Option<String>) {
        let lead = self.lead.map(Lead::stored);
        (lead, self.transform.map(|change| change.to_string()))
    }
}
