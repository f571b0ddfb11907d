//! Which steps of a scene are looked at, and how far around the ego.

use super::Failure;
use crate::config::Config;
use crate::scenario::{Scene, Window};
use crate::text::Options;
use crate::verdict::Task;

/// Which steps are looked at.
#[derive(Debug, clap::Args)]
pub struct Span {
    /// Last step of the window [default: the last step; for the safety task two steps before it].
    #[arg(long, value_name = "STEP", allow_negative_numbers = true)]
    at: Option<i64>,
    /// Steps in the window [default: 10].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = history)]
    history: Option<u32>,
    /// Obstacles farther from the ego are left out, metres [default: 30].
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    radius: Option<f64>,
}

/// Steps of a window: no recording is longer than the most.
pub fn history(word: &str) -> Result<u32, String> {
    match word.parse() {
        Ok(steps @ 1..=100_000) => Ok(steps),
        _ => Err("a window has 1 to 100000 steps".into()),
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

    /// The window in a scene.
    pub fn window(
        &self,
        scene: &Scene,
        task: Option<Task>,
        config: &Config,
    ) -> Result<Window, Failure> {
        let steps = scene.steps();
        if let Some(at) = self.at.filter(|at| !steps.contains(at)) {
            return Err(Failure::input(format!(
                "--at {at}: the ego is recorded from step {} to {}",
                steps.start,
                steps.end - 1
            )));
        }
        // The paper's safety inference looks at a window that ends two steps before the last one.
        let back = if task == Some(Task::Safety) { 2 } else { 0 };
        let last = self.at.unwrap_or(steps.end - 1 - back);
        let history = self.history.map_or(config.history, |steps| steps as usize);
        Ok(Window::ending_at(scene, last, history))
    }

    /// The options of a description.
    pub fn options(&self, config: &Config) -> Result<Options, Failure> {
        let radius = self.radius.unwrap_or(config.radius);
        if !(radius.is_finite() && radius > 0.0) {
            return Err(Failure::input(
                "--radius must be a positive number of metres",
            ));
        }
        Ok(Options {
            radius,
            ..Options::default()
        })
    }
}
