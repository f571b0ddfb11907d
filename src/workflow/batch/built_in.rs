//! Built-in judges on many scenarios: each is opened, labelled and judged in place. Nothing is sent, so nothing is
//! stored.

use std::sync::Arc;

use super::parts;
use crate::{OpenError, OpenRequest, open};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::batch::Truth;
use nearmiss_study::evaluation::{CriticalMoments, Label, LabelError, Labelled};

/// Scenarios and what is true about them.
#[derive(Debug, Clone, Copy)]
pub struct BuiltInRequest<'a> {
    /// The scenarios.
    pub entries: &'a [Entry],
    /// Their ego.
    pub ego: &'a EgoSelection,
    /// What is true about them.
    pub truth: &'a Truth,
    /// The task that is judged: what is true of a scenario depends on it.
    pub task: Task,
    /// Thresholds of risk scores.
    pub thresholds: &'a Thresholds,
}

/// The answers, and the scenarios without one.
#[derive(Debug)]
pub struct BuiltInAnswers<T> {
    /// Label and answers of each scenario that was judged, in their order.
    pub judged: Vec<(Label, T)>,
    /// How many could not be opened.
    pub failed: usize,
    /// Names of those without a recorded ego.
    pub without_ego: Vec<String>,
    /// Names of those without a label, or without the risk score that is the truth.
    pub unlabelled: Vec<String>,
}

/// What became of one scenario, in the order of the scenarios.
#[derive(Debug)]
pub enum BuiltInEvent<'a> {
    /// It was judged.
    Judged {
        /// The scenario.
        entry: &'a Entry,
        /// The same with its ego.
        scene: Arc<Scene>,
        /// Where its label and its bodies do not agree.
        doubt: Option<&'static str>,
    },
    /// It has no ego or no label.
    LeftOut,
    /// The risk score that is the truth cannot be computed.
    NotScored {
        /// The scenario.
        entry: &'a Entry,
        /// Why.
        why: String,
    },
    /// It could not be opened.
    Failed(OpenError),
}

/// One scenario.
enum One<T> {
    Judged(Arc<Scene>, Option<&'static str>, (Label, T)),
    WithoutEgo,
    Unlabelled,
    NotScored(String),
    Mislabelled(LabelError),
}

impl BuiltInRequest<'_> {
    /// Judges every scenario with `judge`, on all cores.
    ///
    /// # Errors
    /// A label cannot be of its scenario.
    pub fn run<T: Send>(
        &self,
        judge: impl Fn(&Entry, &Labelled<'_>) -> T + Sync,
        mut on_event: impl FnMut(BuiltInEvent<'_>),
    ) -> Result<BuiltInAnswers<T>, LabelError> {
        let mut answers = BuiltInAnswers {
            judged: Vec::new(),
            failed: 0,
            without_ego: Vec::new(),
            unlabelled: Vec::new(),
        };
        for (entry, one) in parts(self.entries, |entry| self.one(entry, &judge)).flatten() {
            on_event(match one {
                Ok(One::Judged(scene, doubt, answer)) => {
                    answers.judged.push(answer);
                    BuiltInEvent::Judged {
                        entry,
                        scene,
                        doubt,
                    }
                }
                Ok(One::WithoutEgo) => {
                    answers.without_ego.push(entry.name.clone());
                    BuiltInEvent::LeftOut
                }
                Ok(One::Unlabelled) => {
                    answers.unlabelled.push(entry.name.clone());
                    BuiltInEvent::LeftOut
                }
                Ok(One::NotScored(why)) => {
                    answers.unlabelled.push(entry.name.clone());
                    BuiltInEvent::NotScored { entry, why }
                }
                Ok(One::Mislabelled(wrong)) => return Err(wrong),
                Err(error) => {
                    answers.failed += 1;
                    BuiltInEvent::Failed(error)
                }
            });
        }
        Ok(answers)
    }

    fn one<T>(
        &self,
        entry: &Entry,
        judge: impl Fn(&Entry, &Labelled<'_>) -> T,
    ) -> Result<One<T>, OpenError> {
        let label = self.truth.label(entry, None);
        if label.is_none() && self.truth.leaves_out() {
            return Ok(One::Unlabelled);
        }
        let request = OpenRequest {
            entry,
            ego: self.ego,
            transform: None,
            strict: true,
        };
        let Ok(scene) = open(&request)?.scene else {
            return Ok(One::WithoutEgo);
        };
        if let Err(wrong) = self.truth.fits(entry, Some(&scene)) {
            return Ok(One::Mislabelled(wrong));
        }
        // Contact is contact by any score.
        let scored = self.task != Task::Collision;
        let not_scored = { self.truth.not_scored(&scene, self.thresholds) }.filter(|_| scored);
        if let Some(why) = not_scored {
            return Ok(One::NotScored(why));
        }
        let case = self.labelled(entry, &scene, label);
        let answer = (case.label, judge(entry, &case));
        // What is of high risk need not be a collision.
        let doubt = case.doubt().filter(|_| self.task != Task::Recording);
        Ok(One::Judged(scene, doubt, answer))
    }

    /// A scene with what is true about it for the task; `label` says whether it is a collision.
    fn labelled<'s>(&self, entry: &Entry, scene: &'s Scene, label: Option<Label>) -> Labelled<'s> {
        match (self.task, self.truth.convention()) {
            (Task::Safety, Some(convention)) => {
                // What cannot be scored does not come here.
                let moments = CriticalMoments::new(convention, scene, self.thresholds);
                Labelled::by_moments(scene, &moments.unwrap_or_default())
            }
            (Task::Recording, _) => {
                let about = (entry, Some(scene));
                let window = (&Window::full(scene), 0.0);
                let told = self
                    .truth
                    .of_question(self.task, about, window, self.thresholds);
                let label = told.map_or(Label::Safe, |(label, _)| label);
                Labelled {
                    scene,
                    label,
                    contact: None,
                }
            }
            _ => Labelled::new(scene, label),
        }
    }
}

impl<T> BuiltInAnswers<T> {
    /// How many of the judged scenarios are collisions in truth.
    #[must_use]
    pub fn collisions(&self) -> usize {
        let labels = self.judged.iter().map(|(label, _)| *label);
        labels.filter(|label| label.collides()).count()
    }

    /// How many are not.
    #[must_use]
    pub fn safe(&self) -> usize {
        self.judged.len() - self.collisions()
    }
}
