//! Recorded answers matched to their scenarios: compared with the ground truth and the built-in judge, and as runs.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use nearmiss_formats::Entry;
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Scenario, Scene, Window};
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{ClaimCounts, Consumed, Ending, Key, NewRun, Origin, Run, RunId, RunState};
use rayon::prelude::*;
use serde_json::json;

use super::recorded::{Recorded, find};
use crate::evaluation::claims::{self, TimeOrigin};
use crate::evaluation::{
    AnswerStatus, AxisValues, Cluster, Label, Labelled, Labels, PAPER_STEPS, Problem, PromptConfig,
    Scored, annotations, reading,
};

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
        configuration: PromptConfig {
            task: answer.task,
            frame: Frame::parse(answer.frame),
            techniques: Some(answer.techniques),
            model: answer.model.clone(),
            settings: AxisValues::default(),
            template: None,
        },
        sample: 0,
        truth: label(&labels, &answer.scenario, answer.collision),
        status: status(answer),
        reference: references
            .get(&subject(answer))
            .and_then(|r| r.verdict(answer.task).cloned()),
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
        let verdicts = Task::VERDICTS
            .into_iter()
            .filter_map(|t| reference.verdict(t));
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

fn status(answer: &Recorded) -> AnswerStatus {
    match answer.read() {
        Err(why) => AnswerStatus::Unparsed(why.to_string()),
        Ok(reading) => match reading.said.verdict() {
            Some(verdict) => AnswerStatus::Verdict(verdict.clone()),
            None => AnswerStatus::Unparsed("it answers another task".into()),
        },
    }
}

fn of_judge(name: &str, truth: Option<Label>, verdict: &Verdict) -> Scored {
    let status = AnswerStatus::Verdict(verdict.clone());
    Scored {
        reference: Some(verdict.clone()),
        ..Scored::built_in(name, judge::MODEL, verdict.task, truth, status)
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

    fn verdict(&self, task: Task) -> Option<&Verdict> {
        match task {
            Task::Collision => self.collision.as_ref(),
            Task::Safety => self.safety.as_ref(),
            Task::Recording | Task::Attacker | Task::Trajectory => None,
        }
    }
}

/// The name of a scenario, and whether it is in the half of the collisions.
pub(super) type Subject<'a> = (&'a str, bool);

/// The scenario that an answer is about.
pub(super) fn subject(answer: &Recorded) -> Subject<'_> {
    (&answer.scenario, answer.collision)
}

/// What `read` makes of each scenario of `answers` whose file lies below `root`; files that cannot be read go to
/// `problems`.
pub(super) fn of_answers<'a, T: Send>(
    answers: &'a [Recorded],
    root: &Path,
    problems: &mut Vec<Problem>,
    read: impl Fn(bool, Opened) -> T + Sync,
) -> BTreeMap<Subject<'a>, T> {
    let files = scenarios(root);
    let mut subjects: Vec<Subject<'_>> = answers.iter().map(subject).collect();
    subjects.sort_unstable();
    subjects.dedup();
    let one = |(name, collision): Subject<'a>| {
        let entry = chosen(files.get(name)?, collision);
        let opened = Opened::read(entry).map(|opened| read(collision, opened));
        Some(((name, collision), opened))
    };
    let all: Vec<_> = subjects.into_par_iter().filter_map(one).collect();
    let mut found = BTreeMap::new();
    for (subject, opened) in all {
        match opened {
            Ok(opened) => drop(found.insert(subject, opened)),
            Err(problem) => problems.push(problem),
        }
    }
    found
}

/// The scenarios below a folder by name; none where there is none, which is said answer by answer.
fn scenarios(root: &Path) -> BTreeMap<String, Vec<Entry>> {
    let mut files: BTreeMap<String, Vec<Entry>> = BTreeMap::new();
    let found = nearmiss_formats::find(&[root.to_path_buf()]);
    for entry in found.map(|found| found.entries).unwrap_or_default() {
        files.entry(entry.name.clone()).or_default().push(entry);
    }
    files
}

/// Of several files of one name the one in the half of the data that the answer is from.
fn chosen(files: &[Entry], collision: bool) -> &Entry {
    let half = |entry: &&Entry| entry.group.starts_with("normal") != collision;
    files.iter().find(half).unwrap_or(&files[0])
}

/// A scenario, with its recorded ego where there is one.
pub(super) struct Opened {
    pub scenario: Arc<Scenario>,
    pub scene: Option<Scene>,
}

impl Opened {
    fn read(entry: &Entry) -> Result<Self, Problem> {
        let problem = |message: String| Problem::unread(entry.display(), message);
        let scenario = entry.read().map_err(|e| problem(e.to_string()))?;
        let ego = entry
            .recorded_ego(&scenario)
            .map_err(|e| problem(e.to_string()))?;
        Ok(Self {
            scene: ego.map(|ego| Scene::new(Arc::clone(&scenario), ego)),
            scenario,
        })
    }
}

/// The label of a half of the data.
pub(super) fn label_of_half(collision: bool) -> Label {
    if collision {
        Label::Collision(None)
    } else {
        Label::Safe
    }
}

/// The window that the paper's scripts describe to a task, where it is known.
pub(super) fn described(scene: &Scene, task: Task, collision: bool) -> Option<Window> {
    let labelled = Labelled {
        scene,
        label: label_of_half(collision),
        contact: None,
    };
    labelled.paper_window(task, PAPER_STEPS)
}

/// The claims of a recorded answer, checked against its scene.
pub(super) fn claims(answer: &Recorded, scene: &Scene) -> ClaimCounts {
    let window = described(scene, answer.task, answer.collision);
    let subject = claims::Subject::new(
        scene,
        TimeOrigin::Recording,
        window.map(|window| (window.first(), window.last())),
    );
    claims::count("", &answer.text, &subject)
}

/// A scenario whose file was found.
struct Tied {
    hash: String,
    scene: Option<Scene>,
}

/// Every answer recorded below `root`, as a run that was read at `now_ms`, and everything there that is none.
///
/// An answer is tied to its scenario by the name, and by the hash of the file where that lies below the same folder.
/// Its window is the one that the paper's scripts describe; of tasks other than collision and safety it is not known.
#[must_use]
pub fn runs(root: &Path, now_ms: i64) -> (Vec<Run>, Vec<Problem>) {
    let (answers, mut problems) = find(root);
    let tied = of_answers(&answers, root, &mut problems, |_, opened| Tied {
        hash: opened.scenario.hash.to_string(),
        scene: opened.scene,
    });
    let run = |answer| {
        let tied = tied.get(&subject(answer));
        to_run(answer, tied, root, now_ms)
    };
    let runs = answers.par_iter().map(run).collect();
    (runs, problems)
}

/// An answer about this scene, whose file has this hash, as a run that was read at `now_ms`.
#[must_use]
pub fn run_of(answer: &Recorded, hash: &str, scene: &Scene, now_ms: i64) -> Run {
    let tied = Tied {
        hash: hash.to_string(),
        scene: Some(scene.clone()),
    };
    to_run(answer, Some(&tied), Path::new(""), now_ms)
}

fn to_run(answer: &Recorded, tied: Option<&Tied>, root: &Path, now_ms: i64) -> Run {
    let said = answer.read();
    let techniques = answer.techniques.to_string();
    let scene = tied.and_then(|tied| tied.scene.as_ref());
    let window = scene.and_then(|scene| described(scene, answer.task, answer.collision));
    let key = Key::digest(&json!({
        "recorded": answer.model,
        "scenario": answer.scenario,
        "collision": answer.collision,
        "task": answer.task.name(),
        "frame": answer.frame,
        "techniques": techniques,
        "answer": answer.text,
    }));
    let (verdict, how) = match said {
        Ok(read) => (Some(read.said), reading(&read.how)),
        Err(why) => (None, why.to_string()),
    };
    let verdict_json = verdict.as_ref().and_then(|v| serde_json::to_string(v).ok());
    let state = match answer.text.trim() {
        "" => RunState::Truncated,
        _ => RunState::Answered,
    };
    let file = answer.file.strip_prefix(root).unwrap_or(&answer.file);
    Run {
        id: RunId(0),
        created_ms: now_ms,
        updated_ms: now_ms,
        key: Some(key),
        origin: Origin::Recorded,
        source: Some(file.display().to_string()),
        question: NewRun {
            sample: 0,
            batch: None,
            scenario: answer.scenario.clone(),
            scenario_hash: tied.map(|tied| tied.hash.clone()),
            ego: scene.map_or_else(|| "recorded".into(), |scene| scene.ego.to_string()),
            task: answer.task,
            frame: answer.frame.to_string(),
            techniques,
            window: window.map(|window| (window.first(), window.last())),
            model: answer.model.clone(),
            provider: "recorded".into(),
            dialect: None,
            endpoint: "recorded".into(),
            address: None,
            template: String::new(),
            template_version: None,
            template_hash: String::new(),
            messages: "[]".into(),
            parameters: "{}".into(),
            answer_schema: None,
            images: Vec::new(),
        },
        answer: answer.text.clone(),
        reasoning: String::new(),
        ending: Ending {
            verdict,
            reading: Some(how),
            claims: scene.map_or_else(ClaimCounts::default, |scene| claims(answer, scene)),
            ..Ending::bare(state)
        },
        verdict_json,
        tool_rounds: None,
        most_usd: None,
        notes: String::new(),
        pinned: false,
        deleted_ms: None,
    }
}
