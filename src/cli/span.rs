//! The steps of a scene to look at, and how to describe them.

use super::Failure;
use super::at::{AT, At, worst_step};
use nearmiss_ask::prompts::Techniques;
use nearmiss_scene::description::Frame;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::Settings;
use nearmiss_study::evaluation::batch::Experiment;

/// Which steps are looked at, and which obstacle.
#[derive(Debug, clap::Args)]
pub struct Span {
    /// End of the window: a time step (32), seconds (3.2s), worst (the most severe moment, see `nearmiss help
    /// measures`), or the worst by one measure: worst:risk, worst:ttc, worst:distance [default: the last step; two
    /// steps earlier for the safety task].
    #[arg(long, value_name = AT, allow_negative_numbers = true)]
    at: Option<At>,
    /// Steps in the window [default: from the template, else 10].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = history)]
    history: Option<u32>,
    /// Describe only this obstacle; the trajectory frame needs it.
    #[arg(long, value_name = "ID", allow_negative_numbers = true)]
    obstacle: Option<i64>,
}

/// Steps of a window: no recording is longer than the most.
pub fn history(word: &str) -> Result<u32, String> {
    match word.parse() {
        Ok(steps @ 1..=100_000) => Ok(steps),
        _ => Err("expected 1 to 100000 steps".into()),
    }
}

impl Span {
    /// The options with which steps were chosen, for people; nothing if none was.
    pub fn chosen(&self) -> Option<&'static str> {
        match (self.at, self.history) {
            (Some(_), Some(_)) => Some("--at and --history"),
            (Some(_), None) => Some("--at"),
            (None, Some(_)) => Some("--history"),
            (None, None) => None,
        }
    }

    /// Whether the end of the window is left to the program.
    pub fn is_default_end(&self) -> bool {
        self.at.is_none()
    }

    /// The window in a scene, of so many steps.
    pub fn window(
        &self,
        scene: &Scene,
        thresholds: &Thresholds,
        task: Option<Task>,
        history: usize,
    ) -> Result<Window, Failure> {
        if task == Some(Task::Recording) {
            return match self.chosen() {
                Some(chosen) => Err(Failure::input(format!(
                    "--task recording asks about the whole recording; remove {chosen}"
                ))),
                None => Ok(Window::full(scene)),
            };
        }
        let steps = scene.steps();
        let worst = |by| worst_step(scene, thresholds, by);
        let at = self
            .at
            .map(|at| at.step(&steps, scene.scenario.dt(), worst));
        // The paper's safety inference looks at a window that ends two steps before the last one.
        let back = if task == Some(Task::Safety) {
            Window::AFTER_SAFETY
        } else {
            0
        };
        let last = at.transpose()?.unwrap_or(steps.end - 1 - back);
        Ok(Window::ending_at(scene, last, history))
    }

    /// What the user says, here and in the configuration, about how a scene is described.
    pub fn settings(
        &self,
        set: &Experiment,
        techniques: Option<Techniques>,
        frame: Frame,
    ) -> Result<Settings, Failure> {
        let set = set.settings(techniques);
        let settings = Settings {
            history: self.history.map(|steps| steps as usize).or(set.history),
            obstacle: self.obstacle,
            ..set
        };
        match settings.misplaced(&[frame], "--set ") {
            Some(why) => Err(Failure::input(why)),
            None => Ok(settings),
        }
    }
}
