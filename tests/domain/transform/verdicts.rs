//! What the built-in judge says about a scene and about the same scene changed.

use nearmiss::judge::judge;
use nearmiss::scenario::{Scene, Transform, Window};
use nearmiss::verdict::Task;

/// Verdicts that are not the same, ids told as those of the original.
pub fn differences(scene: &Scene, change: &Transform) -> Vec<String> {
    let changed = change.apply(scene);
    let mut found = Vec::new();
    for task in [Task::Collision, Task::Safety] {
        let said = |scene: &Scene, original: &dyn Fn(i64) -> i64| {
            let window = Window::ending_at(scene, scene.last_step() - 2, 10);
            let judgement = judge(scene, task, &window);
            let verdict = judgement.verdict;
            let all = verdict.obstacles.iter();
            let mut all: Vec<_> = all.map(|o| (o.risk_score, original(o.id))).collect();
            all.sort_unstable();
            (verdict.dangerous, judgement.decisive_step, all)
        };
        let before = said(scene, &|id| id);
        let after = said(&changed.scene, &|id| changed.original(id));
        if before != after {
            found.push(format!("{task:?}: {before:?} became {after:?}"));
        }
    }
    found
}
