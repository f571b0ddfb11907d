//! Safety judgements of the built-in judge, by window: requested in the background, and kept while the scene is open.

use std::collections::HashMap;
use std::sync::Arc;

use super::Model;
use nearmiss_scene::judge::Judgement;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;

/// Windows that are judged ahead of the current one, so that stepping and playing find theirs there.
const AHEAD: i64 = 12;

/// The first and last step of a window, and the built-in judge's answer about it.
pub type WindowJudgement = ((i64, i64), Judgement);

/// Windows of a scene, by their first and last steps, which the built-in judge is to judge.
#[derive(Debug)]
pub struct WindowsToJudge {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The task.
    pub task: Task,
    /// The windows.
    pub windows: Vec<(i64, i64)>,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
}

/// Safety judgements of one scene under the same thresholds, by the first and last step of their windows.
#[derive(Debug, Default)]
pub struct Judgements {
    about: Option<(Arc<Scene>, Arc<Thresholds>)>,
    /// `None` while a judgement is on its way.
    windows: HashMap<(i64, i64), Option<Judgement>>,
}

impl Judgements {
    fn is_about(&self, scene: &Arc<Scene>, thresholds: &Arc<Thresholds>) -> bool {
        self.about.as_ref().is_some_and(|(known, under)| {
            Arc::ptr_eq(known, scene) && Arc::ptr_eq(under, thresholds)
        })
    }

    /// The judgement of a window; `None` until it has arrived.
    fn get(
        &self,
        scene: &Arc<Scene>,
        thresholds: &Arc<Thresholds>,
        window: (i64, i64),
    ) -> Option<&Judgement> {
        let known = self.windows.get(&window)?.as_ref();
        known.filter(|_| self.is_about(scene, thresholds))
    }

    /// Notes that these windows are judged; gives those that were not requested before. Another scene or other
    /// thresholds clear what is known.
    fn request(
        &mut self,
        scene: &Arc<Scene>,
        thresholds: &Arc<Thresholds>,
        windows: impl IntoIterator<Item = (i64, i64)>,
    ) -> Vec<(i64, i64)> {
        if !self.is_about(scene, thresholds) {
            self.windows.clear();
            self.about = Some((scene.clone(), thresholds.clone()));
        }
        let mut missing = Vec::new();
        for window in windows {
            self.windows.entry(window).or_insert_with(|| {
                missing.push(window);
                None
            });
        }
        missing
    }

    /// Takes judgements that were requested; those of another scene are dropped.
    pub fn take(
        &mut self,
        scene: &Arc<Scene>,
        thresholds: &Arc<Thresholds>,
        found: &[WindowJudgement],
    ) {
        if self.is_about(scene, thresholds) {
            let found = found.iter().cloned();
            self.windows
                .extend(found.map(|(window, judgement)| (window, Some(judgement))));
        }
    }
}

impl Model {
    /// The built-in judge on the current window, where it is known.
    fn judged_now(&self) -> Option<Judgement> {
        let opened = self.opened.as_ref()?;
        let (scene, window) = (opened.scene.as_ref()?, self.window()?);
        match self.task {
            Task::Collision => opened.collision.clone(),
            Task::Recording => opened.recording.clone(),
            Task::Safety => {
                let window = (window.first(), window.last());
                let known = self.judgements.get(scene, &self.thresholds, window);
                known.cloned()
            }
            Task::Attacker | Task::Trajectory => None,
        }
    }

    /// Takes the built-in judge's answer on the current window, where it is known.
    pub fn take_reference(&mut self) {
        self.answers.reference = self.judged_now();
    }

    /// Whether the built-in judge has an answer on the current window, or is at work on it.
    #[must_use]
    pub fn has_reference(&self) -> bool {
        self.answers.reference.is_some() || self.is_judging()
    }

    /// Whether the built-in judge is at work on the current window.
    #[must_use]
    pub fn is_judging(&self) -> bool {
        self.task == Task::Safety && self.answers.reference.is_none() && self.scene().is_some()
    }

    /// Judgements to request: that of the current window by itself, then those of the steps after it.
    pub fn missing_judgements(&mut self) -> Vec<WindowsToJudge> {
        let scene = self.opened.as_ref().and_then(|o| o.scene.clone());
        let Some((scene, now)) = scene.zip(self.window()) else {
            return Vec::new();
        };
        if self.task != Task::Safety {
            return Vec::new();
        }
        let history = self.decided().history;
        let ends = |window: Window| (window.first(), window.last());
        let end = self.clock.range().1.min(now.last().saturating_add(AHEAD));
        let after = (now.last() + 1..=end).map(|s| ends(Window::ending_at(&scene, s, history)));
        let thresholds = self.thresholds.clone();
        let known = &mut self.judgements;
        let now = known.request(&scene, &thresholds, [ends(now)]);
        let after = known.request(&scene, &thresholds, after);
        [now, after]
            .into_iter()
            .filter(|windows| !windows.is_empty())
            .map(|windows| WindowsToJudge {
                scene: scene.clone(),
                task: Task::Safety,
                windows,
                thresholds: thresholds.clone(),
            })
            .collect()
    }
}
