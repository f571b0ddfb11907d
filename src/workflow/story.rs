//! What happened, and who would have avoided it: the same words on every face.

use nearmiss_drive::driver::PreventabilityRecord;
use nearmiss_formats::Entry;
use nearmiss_scene::metrics::{Context, critical_moments};
use nearmiss_scene::story::Story;

use crate::VariantOrigin;
use crate::tables::Encounter;

/// The moment that matters, told.
#[derive(Debug, Clone, PartialEq)]
pub struct ToldStory {
    /// What happened.
    pub story: Story,
    /// Who would have avoided it, of a contact, conflict or near miss that does not begin with the recording.
    pub drivers: Option<PreventabilityRecord>,
    /// Seconds between two steps.
    dt: f64,
}

impl ToldStory {
    /// The story of a scene of this entry; `None` where no other road user is ever there with the ego.
    ///
    /// # Errors
    /// As of [`VariantOrigin::read`].
    pub fn new(entry: &Entry, context: &Context<'_>) -> Result<Option<Self>, String> {
        let moments = critical_moments(context);
        let scene = context.scene();
        let is_certified = VariantOrigin::certified(entry, scene)?;
        let of = |worst| {
            let encounter = Encounter::at(scene, worst, is_certified);
            Some(Self {
                story: Story::of_moment(context, worst)?,
                drivers: encounter.map(|encounter| encounter.drivers),
                dt: scene.scenario.dt(),
            })
        };
        Ok(moments.first().and_then(of))
    }

    /// At most four sentences of what happened, and one of the drivers.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let happened = self.story.sentences.iter().map(|one| one.text.clone());
        let drivers = self.drivers.iter().map(|found| found.sentence(self.dt));
        happened.chain(drivers).collect()
    }
}
