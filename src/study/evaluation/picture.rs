//! The picture of a case for models that see: drawn when it is first needed, since most questions are only counted.

use std::sync::{Arc, OnceLock};

use super::question::Case;
use nearmiss_ask::llm::{Image, ImageTokens};
use nearmiss_render::{Picture, Storyboard, StoryboardPanel, png};
use nearmiss_scene::description::{Frame, Options, picture_moments};
use nearmiss_scene::scenario::{Scene, Window};

/// Pixels an inch of a storyboard: as many as its size was counted in.
const DPI: f64 = 96.0;

/// A storyboard of a window of a scene.
#[derive(Debug, Clone)]
pub struct ScenePicture {
    scene: Arc<Scene>,
    panels: Vec<StoryboardPanel>,
    from: i64,
    north_up: bool,
    recorded_times: bool,
    contact: bool,
    drawn: Arc<OnceLock<Image>>,
}

impl ScenePicture {
    /// The picture of a case; `None` if its frame has none.
    #[must_use]
    pub fn of(case: &Case) -> Option<Self> {
        Self::new(&case.scene, case.frame, &case.window, &case.options)
    }

    /// The picture of a window; `None` if the frame has none.
    #[must_use]
    pub fn new(
        scene: &Arc<Scene>,
        frame: Frame,
        window: &Window,
        options: &Options,
    ) -> Option<Self> {
        if !frame.has_picture() {
            return None;
        }
        let moments = picture_moments(scene, frame, window, options).into_iter();
        let panels = moments.map(|moment| StoryboardPanel {
            step: moment.step,
            obstacles: moment.obstacles,
        });
        Some(Self {
            scene: scene.clone(),
            panels: panels.collect(),
            from: window.first(),
            north_up: frame.is_on_the_map(),
            recorded_times: frame.is_of_one_obstacle(),
            contact: options.contact,
            drawn: Arc::default(),
        })
    }

    /// The picture to be drawn in any format.
    #[must_use]
    pub fn picture(&self) -> Picture {
        let board = Storyboard {
            scene: &self.scene,
            panels: &self.panels,
            from: self.from,
            north_up: self.north_up,
            recorded_times: self.recorded_times,
            contact: self.contact,
        };
        board.picture()
    }

    /// The picture as a model is sent it.
    #[must_use]
    pub fn image(&self) -> Image {
        // It has fewer pixels than any PNG may have.
        let draw = || Image::png(png(&self.picture(), DPI).unwrap_or_default(), self.size());
        self.drawn.get_or_init(draw).clone()
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        Storyboard::size(self.panels.len())
    }

    /// Tokens that it is taken for where the provider is not known.
    #[must_use]
    pub fn tokens(&self) -> usize {
        let (width, height) = self.size();
        ImageTokens::default().of(width, height) as usize
    }
}
