//! A stored question as far as it decides what the built-in judge says to it.

use std::sync::Arc;

use super::{OpenRequest, open};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::judge::judge_under;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Transform, Window, obstacle_taken};
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::Outcome;

/// As much of a stored question as decides what the built-in judge says to it.
#[derive(Debug, Clone, Copy)]
pub struct StoredQuestion<'a> {
    /// The task.
    pub task: Task,
    /// Name of the scenario, with a change of the scene in brackets if there was one.
    pub scenario: &'a str,
    /// SHA-256 of its file; `None` if only its name is known.
    pub scenario_hash: Option<&'a str>,
    /// The ego, and where its motion comes from; `None` where that is not known, as of imported answers.
    pub ego: Option<&'a str>,
    /// First and last time step of the window, where known.
    pub window: Option<(i64, i64)>,
}

impl<'a> From<&'a Outcome> for StoredQuestion<'a> {
    fn from(one: &'a Outcome) -> Self {
        let imported = one.origin == nearmiss_store::Origin::Recorded;
        Self {
            task: one.task,
            scenario: &one.scenario,
            scenario_hash: one.scenario_hash.as_deref(),
            ego: (!imported).then_some(one.ego.as_str()),
            window: one.window,
        }
    }
}

impl StoredQuestion<'_> {
    /// The scene that was asked about, changed as it was, if this file is its scenario.
    #[must_use]
    pub fn scene(&self, entry: &Entry, ego: &EgoSelection) -> Option<Arc<Scene>> {
        let (_, transform) = Transform::of_name(self.scenario);
        let taken = self
            .ego
            .and_then(obstacle_taken)
            .map(EgoSelection::Obstacle);
        let request = OpenRequest {
            entry,
            ego: taken.as_ref().unwrap_or(ego),
            transform,
            strict: false,
        };
        let scene = open(&request).ok()?.scene.ok()?;
        let hash = scene.scenario.hash.to_string();
        let same_file = self.scenario_hash.is_none_or(|asked| asked == hash);
        let same_ego = self.ego.is_none_or(|asked| asked == scene.ego.to_string());
        (same_file && same_ego).then_some(scene)
    }

    /// The built-in judge's answer to the question about its scene.
    #[must_use]
    pub fn judged(&self, scene: &Scene, thresholds: &Thresholds) -> Option<Verdict> {
        let (first, last) = match (self.window, self.task) {
            (Some(window), _) => window,
            // What is true of these does not depend on the window.
            (None, task) if task.is_about_all_steps() => (scene.last_step(), scene.last_step()),
            (None, _) => return None,
        };
        let history = usize::try_from(last.saturating_sub(first).saturating_add(1)).unwrap_or(1);
        let window = Window::ending_at(scene, last, history);
        Some(judge_under(scene, self.task, &window, thresholds).verdict)
    }
}
