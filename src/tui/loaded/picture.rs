//! A request to save a picture.

use std::path::PathBuf;
use std::sync::Arc;

use strum::{IntoStaticStr, VariantArray};

use super::{GeneratedVariant, VariantShown};
use nearmiss_drive::generation::AttackerEffect;
use nearmiss_render::{FigureOptions, Format, Screen, Variation, Variations};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scenario, Scene};
use nearmiss_study::evaluation::ScenePicture;

/// Subject of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum PictureKind {
    /// The map.
    Map,
    /// The plot.
    Plot,
    /// The map, and the plot below it.
    #[strum(to_string = "map_plot")]
    Both,
    /// The whole screen.
    Screen,
    /// The map at every step.
    Animation,
    /// The picture that models are shown with the question.
    Question,
}

nearmiss_record::named!(PictureKind);

/// A picture to be drawn and saved.
#[derive(Debug)]
pub struct PictureJob {
    /// Its subject.
    pub kind: PictureKind,
    /// How it is written.
    pub format: Format,
    /// Name of the scenario.
    pub name: String,
    /// The scenario.
    pub scenario: Arc<Scenario>,
    /// The scenario with its ego.
    pub scene: Option<Arc<Scene>>,
    /// The variant that is open, or whose original is.
    pub variant: Option<VariantShown>,
    /// The current step.
    pub step: i64,
    /// How it looks.
    pub look: FigureOptions,
    /// From where on values are dangerous.
    pub thresholds: Arc<Thresholds>,
    /// Where it is saved; the current folder if none.
    pub folder: Option<PathBuf>,
    /// The screen, when it is painted; or why it could not be.
    pub screen: Result<Option<Screen>, String>,
    /// The picture of the question, if its frame has one.
    pub shown: Option<ScenePicture>,
}

impl GeneratedVariant {
    /// Both motions of each attacker, beside the variant or its original.
    #[must_use]
    pub fn variations(&self, shows_changed: bool) -> Variations<'_> {
        let both = |attacker: &AttackerEffect| {
            Some(Variation {
                recorded: self.closed.scenario().obstacle(attacker.obstacle)?,
                changed: self.effect.scenario.obstacle(attacker.obstacle)?,
                from: attacker.from,
                shows_changed,
            })
        };
        self.effect.attackers.iter().filter_map(both).collect()
    }
}

impl VariantShown {
    /// Both motions of each attacker.
    #[must_use]
    pub fn variations(&self) -> Variations<'_> {
        self.made.variations(self.changed)
    }
}

impl PictureJob {
    /// Whether the screen is still to be painted.
    #[must_use]
    pub fn needs_screen(&self) -> bool {
        self.kind == PictureKind::Screen && self.screen == Ok(None)
    }
}
