//! The scenarios that recorded answers are about, opened where their files lie in the same folder.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::Recorded;
use crate::evaluation::claims::{self, TimeOrigin};
use crate::evaluation::{Label, Labelled, PAPER_STEPS, Problem};
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::{Scenario, Scene, Window};
use nearmiss_scene::verdict::Task;
use nearmiss_store::ClaimCounts;

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
    let subject = claims::Subject {
        scene,
        times: TimeOrigin::Recording,
        window: window.map(|window| (window.first(), window.last())),
    };
    claims::count("", &answer.text, &subject)
}
