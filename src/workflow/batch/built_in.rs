//! Built-in predictors on the questions of a batch: each scenario is opened, labelled and judged in place. Nothing is
//! sent, so nothing is stored.

use std::sync::Arc;

use super::{BatchError, BatchPlan, parts};
use crate::{OpenError, OpenRequest, StandIn, open};
use nearmiss_formats::Entry;
use nearmiss_scene::judge::{judge_under, verdict_by};
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::batch::{Answers, Ask, Variant};
use nearmiss_study::evaluation::{
    Alarms, AnswerStatus, Candidate, Label, LabelError, Labelled, Scored,
};

/// The answers, and the scenarios without one.
#[derive(Debug, Default)]
pub struct BuiltInAnswers {
    /// Those of all candidates.
    pub answers: Answers,
    /// Of each candidate its alarms over every window of the safe scenarios.
    pub alarms: Vec<Alarms>,
    /// How many of the judged scenarios are collisions in truth.
    pub collisions: usize,
    /// How many of them are not.
    pub safe: usize,
    /// How many could not be opened.
    pub failed: usize,
    /// Names of those without a recorded ego.
    pub without_ego: Vec<String>,
    /// Names of those without a label, or without the risk score that is the truth.
    pub unlabelled: Vec<String>,
}

/// What became of one scenario.
#[derive(Debug)]
pub enum BuiltInEvent {
    /// It was judged with its ego.
    Judged {
        /// The scene.
        scene: Arc<Scene>,
        /// Where its label and its bodies do not agree.
        doubt: Option<&'static str>,
    },
    /// It has no ego.
    WithoutEgo,
    /// It has no label.
    Unlabelled,
    /// The risk score that is the truth cannot be computed: why.
    NotScored(String),
    /// It could not be opened.
    Failed(OpenError),
}

/// Whether a scenario is a collision, the answers about it, and the alarms of each candidate.
type Predicted = (Label, Vec<(Variant, Scored)>, Vec<Alarms>);

impl BatchPlan {
    /// What the candidates say to its questions about one task, in the order of the scenarios, and on all cores.
    ///
    /// Obstacles beyond the radius of the batch are left out, as is a collision that begins later than the window of a
    /// lead would end.
    ///
    /// # Errors
    /// A label cannot be of its scenario, or there is no template that says how long windows are.
    pub fn built_in(
        &self,
        candidates: &[Candidate],
        mut on_event: impl FnMut(&Entry, BuiltInEvent),
    ) -> Result<BuiltInAnswers, BatchError> {
        let mut found = BuiltInAnswers {
            alarms: vec![Alarms::default(); candidates.len()],
            ..BuiltInAnswers::default()
        };
        let experiment = &self.spec.experiment;
        let Some(configuration) = experiment.configurations().into_iter().next() else {
            return Ok(found);
        };
        let (history, radius) =
            { self.builder.span(&configuration) }.map_err(BatchError::Question)?;
        let task = configuration.task;
        let judge = |(entry, asks): &(Entry, Vec<Ask>)| {
            self.predicted(entry, asks, task, history, radius, candidates)
        };
        let mut said = Vec::new();
        for ((entry, _), judged) in parts(&self.scenarios, judge).flatten() {
            let (event, predicted) = judged?;
            match &event {
                BuiltInEvent::Judged { .. } => {}
                BuiltInEvent::WithoutEgo => found.without_ego.push(entry.name.clone()),
                BuiltInEvent::Unlabelled | BuiltInEvent::NotScored(_) => {
                    found.unlabelled.push(entry.name.clone());
                }
                BuiltInEvent::Failed(_) => found.failed += 1,
            }
            on_event(entry, event);
            let Some((label, answers, alarms)) = predicted else {
                continue;
            };
            found.collisions += usize::from(label.collides());
            found.safe += usize::from(!label.collides());
            said.extend(answers);
            let all = found.alarms.iter_mut().zip(&alarms);
            all.for_each(|(all, more)| all.add(more));
        }
        // The first lead comes first, also where the first scenario has no window there.
        said.sort_by_key(|(variant, _): &(Variant, Scored)| {
            let mut leads = experiment.leads.iter();
            leads.position(|lead| Some(*lead) == variant.lead)
        });
        found.answers = Answers::sorted(said, 0..);
        Ok(found)
    }

    fn predicted(
        &self,
        entry: &Entry,
        asks: &[Ask],
        task: Task,
        history: usize,
        radius: f64,
        candidates: &[Candidate],
    ) -> Result<(BuiltInEvent, Option<Predicted>), LabelError> {
        let (truth, thresholds) = (&self.truth, self.builder.thresholds());
        let label = truth.label(entry, None);
        if label.is_none() && truth.leaves_out() {
            return Ok((BuiltInEvent::Unlabelled, None));
        }
        let request = OpenRequest {
            entry,
            ego: &self.spec.ego,
            transform: None,
            strict: true,
            stand_in: StandIn::None,
        };
        let scene = match open(&request).map(|opened| opened.scene) {
            Ok(Ok(scene)) => scene,
            Ok(Err(_)) => return Ok((BuiltInEvent::WithoutEgo, None)),
            Err(error) => return Ok((BuiltInEvent::Failed(error), None)),
        };
        truth.fits(entry, Some(&scene))?;
        // Contact is contact by any score.
        let scored = task != Task::Collision;
        if let Some(why) = { truth.not_scored(&scene, thresholds) }.filter(|_| scored) {
            return Ok((BuiltInEvent::NotScored(why), None));
        }
        let whole = Window::full(&scene);
        // What the whole recording is in truth.
        let (label_of, doubt) = match (task, truth.convention()) {
            (Task::Safety, Some(_)) | (Task::Recording, _) => (Task::Recording, None),
            _ => (Task::Collision, Labelled::new(&scene, label).doubt()),
        };
        let (label, critical) = truth
            .of_question(label_of, (entry, Some(&scene)), (&whole, 0.0), thresholds)
            .unwrap_or((Label::Safe, Vec::new()));
        let about = |ask: &Ask, candidate: &Candidate| {
            let (truth, critical, status) = match &ask.truth {
                Some(asked) => {
                    let (first, last) = asked.steps;
                    let steps = usize::try_from(last - first + 1).unwrap_or(1);
                    let window = Window::ending_at(&scene, last, steps);
                    let criterion = &candidate.criterion;
                    let verdict = verdict_by(criterion, &scene, &window, radius, thresholds);
                    let status = AnswerStatus::Verdict(verdict);
                    (asked.label, asked.critical.clone(), status)
                }
                None if task == Task::Safety => {
                    let why = "no such window in the recording";
                    (label, label.critical(), AnswerStatus::Unasked(why.into()))
                }
                None => {
                    let judged = judge_under(&scene, task, &whole, thresholds);
                    (
                        label,
                        critical.clone(),
                        AnswerStatus::Verdict(judged.verdict),
                    )
                }
            };
            let scored = Scored {
                window: ask.variant.window,
                critical,
                ..Scored::built_in(&entry.name, &candidate.model(), task, Some(truth), status)
            };
            (ask.variant, scored)
        };
        let each = asks
            .iter()
            .flat_map(|ask| candidates.iter().map(move |one| (ask, one)));
        let answers = each.map(|(ask, candidate)| about(ask, candidate)).collect();
        let alarms = candidates
            .iter()
            .filter(|_| task == Task::Safety && !label.collides())
            .map(|candidate| candidate.alarms(&scene, history, radius))
            .collect();
        Ok((
            BuiltInEvent::Judged { scene, doubt },
            Some((label, answers, alarms)),
        ))
    }
}
