//! Recorded answers compared with the ground truth and the built-in judge.

use std::path::Path;

use rayon::prelude::*;

use super::recorded::{Recorded, find};
use super::scenes::{claims, described, label_of_half, of_answers, subject};
use crate::evaluation::{
    AnswerStatus, AxisValues, Cluster, Label, Labels, Problem, PromptConfig, Scored, annotations,
};
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{ClaimCounts, Consumed};

/// A scene, and the built-in judge's verdicts on both tasks, as far as it can be asked.
#[derive(Default)]
struct Reference {
    scene: Option<Scene>,
    collision: Option<Verdict>,
    safety: Option<Verdict>,
}

/// The recorded answers to the yes-or-no tasks below `root`, each beside the truth of the annotations (where there are
/// none at all, of its folder) and the built-in judge's verdict on the paper's window; then the judge's own verdicts;
/// and what was wrong there.
///
/// The judge is asked where the scenario and its recorded ego lie below `root` too.
#[must_use]
pub fn scored(root: &Path) -> (Vec<Scored>, Vec<Problem>) {
    let (mut answers, mut problems) = find(root);
    answers.retain(|answer| Task::VERDICTS.contains(&answer.task));
    let (labels, wrong) = annotations(root);
    problems.extend(wrong);
    let references = of_answers(&answers, root, &mut problems, |collision, opened| {
        let scene = opened.scene;
        scene.map_or_else(Reference::default, |scene| Reference::on(scene, collision))
    });
    let one = |answer: &Recorded| Scored {
        critical: label(&labels, &answer.scenario, answer.collision)
            .map(Label::critical)
            .unwrap_or_default(),
        scenario: answer.scenario.clone(),
        way: PromptConfig {
            task: answer.task,
            frame: Frame::parse(answer.frame),
            techniques: Some(answer.techniques),
            model: answer.model.clone(),
            settings: AxisValues::default(),
            template: None,
        },
        sample: 0,
        truth: label(&labels, &answer.scenario, answer.collision),
        status: said(answer),
        reference: references
            .get(&subject(answer))
            .and_then(|r| r.of(answer.task).cloned()),
        window: None,
        consumed: Consumed::default(),
        most_usd: None,
        superseded: Vec::new(),
        run: None,
        claims: references
            .get(&subject(answer))
            .and_then(|r| r.scene.as_ref())
            .map_or_else(ClaimCounts::default, |scene| claims(answer, scene)),
        cluster: Cluster::default(),
    };
    let mut scored: Vec<Scored> = answers.par_iter().map(one).collect();
    for (&(name, collision), reference) in &references {
        let truth = label(&labels, name, collision);
        let verdicts = Task::VERDICTS.into_iter().filter_map(|t| reference.of(t));
        scored.extend(verdicts.map(|verdict| of_judge(name, truth, verdict)));
    }
    (scored, problems)
}

/// The truth about a scenario: where only some are annotated, it is unknown for the others.
fn label(labels: &Labels, name: &str, collision: bool) -> Option<Label> {
    match labels.iter().next() {
        Some(_) => labels.get(name),
        None => Some(label_of_half(collision)),
    }
}

fn said(answer: &Recorded) -> AnswerStatus {
    match answer.read() {
        Err(why) => AnswerStatus::Unparsed(why.to_string()),
        Ok(reading) => match reading.said.verdict() {
            Some(verdict) => AnswerStatus::Verdict(verdict.clone()),
            None => AnswerStatus::Unparsed("it answers another task".into()),
        },
    }
}

fn of_judge(name: &str, truth: Option<Label>, verdict: &Verdict) -> Scored {
    Scored {
        reference: Some(verdict.clone()),
        ..Scored::built_in(name, judge::MODEL, truth, verdict.clone())
    }
}

impl Reference {
    fn on(scene: Scene, collision: bool) -> Self {
        let safety = |window: Window| judge::judge(&scene, Task::Safety, &window).verdict;
        Self {
            collision: Some(judge::judge_collision(&scene, Thresholds::shipped()).verdict),
            safety: described(&scene, Task::Safety, collision).map(safety),
            scene: Some(scene),
        }
    }

    fn of(&self, task: Task) -> Option<&Verdict> {
        match task {
            Task::Collision => self.collision.as_ref(),
            Task::Safety => self.safety.as_ref(),
            Task::Recording | Task::Attacker | Task::Trajectory => None,
        }
    }
}
