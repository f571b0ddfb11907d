//! One way of asking for many scenarios: a snapshot of everything that decides what is sent.

use std::sync::Arc;

use super::question::{Case, CaseError, Question, prepare};
use super::settings::Decided;
use crate::judge::judge_under;
use crate::metrics::Thresholds;
use crate::prompts::Library;
use crate::scenario::{Entry, Scene, WantedEgo, Window};
use crate::text::Frame;
use crate::verdict::{Task, Verdict};

/// How many scenarios are asked about in the same way.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What is asked.
    pub task: Task,
    /// From where scenes are described.
    pub frame: Frame,
    /// How they are described, and with which techniques.
    pub decided: Decided,
    /// The templates.
    pub library: Library,
    /// A template's file name and text to use instead of the library's.
    pub draft: Option<(String, String)>,
    /// What risk scores are.
    pub thresholds: Arc<Thresholds>,
}

/// Why a scenario cannot be asked about.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// It, or its ego, cannot be read.
    #[error("{0}")]
    Unreadable(String),
    /// It has no ego.
    #[error("{0}: no recorded ego beside it")]
    NoEgo(String),
    /// The window would end before the recording begins.
    #[error(
        "{scenario}: the recording begins after the window of lead {lead} would end; ask for a shorter lead"
    )]
    TooEarly {
        /// Which scenario.
        scenario: String,
        /// The lead that was asked for, as on the command line.
        lead: String,
    },
    /// No prompt can be made of it.
    #[error(transparent)]
    Case(#[from] CaseError),
}

impl Plan {
    /// The window that is asked about: the end of the recording, for the safety task the usual one, which ends
    /// [`Window::AFTER_SAFETY`] steps earlier.
    #[must_use]
    pub fn window(&self, scene: &Scene) -> Window {
        default_window(self.task, scene, self.decided.history)
    }

    /// The question about a scenario with this ego.
    ///
    /// # Errors
    /// It cannot be read, has no ego, or no prompt can be made of it.
    pub fn question(&self, entry: &Entry, ego: &WantedEgo) -> Result<Question, PlanError> {
        let scene = self.scene(entry, ego)?;
        let window = self.window(&scene);
        Ok(self.question_about(entry.name.clone(), scene, window, None)?)
    }

    /// A scenario with this ego.
    pub(super) fn scene(&self, entry: &Entry, ego: &WantedEgo) -> Result<Arc<Scene>, PlanError> {
        let unreadable = |why: String| PlanError::Unreadable(why);
        let scenario = entry.read().map_err(|e| unreadable(e.to_string()))?;
        let ego = ego.of(entry, &scenario);
        let ego = ego.map_err(|e| unreadable(e.to_string()))?;
        let ego = ego.ok_or_else(|| PlanError::NoEgo(entry.display()))?;
        Ok(Arc::new(Scene::new(scenario, ego)))
    }

    /// The question about a scene; `obstacle` is the one that is described in place of the plan's own.
    pub(super) fn question_about(
        &self,
        name: String,
        scene: Arc<Scene>,
        window: Window,
        obstacle: Option<i64>,
    ) -> Result<Question, CaseError> {
        let mut options = self.decided.options;
        options.obstacle = obstacle.or(options.obstacle);
        let case = Case {
            name,
            window,
            scene,
            task: self.task,
            frame: self.frame,
            techniques: self.decided.techniques,
            options,
            thresholds: self.thresholds.clone(),
        };
        let draft = self.draft.as_ref().map(|(f, s)| (f.as_str(), s.as_str()));
        prepare(case, &self.library, draft)
    }

    /// What the built-in judge says to a question of this plan; nothing for tasks that it does not answer.
    #[must_use]
    pub fn truth(&self, question: &Question) -> Option<Verdict> {
        let case = &question.case;
        Task::VERDICTS
            .contains(&case.task)
            .then(|| judge_under(&case.scene, case.task, &case.window, &self.thresholds).verdict)
    }
}

/// The window of a task by default, of so many steps: see [`Plan::window`].
pub(super) fn default_window(task: Task, scene: &Scene, history: usize) -> Window {
    let last = match task {
        Task::Collision => scene.last_step(),
        Task::Safety | Task::Attacker | Task::Trajectory => {
            scene.last_step() - Window::AFTER_SAFETY
        }
    };
    Window::ending_at(scene, last, history)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::evaluation::Settings;
    use crate::scenario::bundled;

    #[test]
    fn one_plan_asks_about_every_scenario_in_the_same_way() {
        let library = Library::load(None);
        let plan = |task| Plan {
            task,
            frame: Frame::Ego,
            decided: Settings::default().with(&crate::prompts::Defaults::default()),
            library: library.clone(),
            draft: None,
            thresholds: Arc::new(Thresholds::shipped().clone()),
        };
        let mut said = Vec::new();
        for entry in bundled() {
            let safety = plan(Task::Safety);
            let question = safety.question(&entry, &WantedEgo::Beside).unwrap();
            let scene = &question.case.scene;
            assert_eq!(question.case.window.last(), scene.last_step() - 2);
            assert!(question.tokens() > 100);
            let collision = plan(Task::Collision);
            let question = collision.question(&entry, &WantedEgo::Beside).unwrap();
            assert_eq!(question.case.window.last(), question.case.scene.last_step());
            said.push(collision.truth(&question).unwrap().dangerous);
        }
        assert_eq!(said.iter().filter(|d| **d).count(), 2);
        let lost = Entry::of_file(std::path::Path::new("no/such.xml"));
        let why = plan(Task::Safety).question(&lost, &WantedEgo::Beside);
        assert!(matches!(why, Err(PlanError::Unreadable(text)) if text.contains("no/such.xml")));
    }
}
