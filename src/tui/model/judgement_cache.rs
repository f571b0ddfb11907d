//! Cached verdicts of the built-in judge for visited steps, so stepping back and forth does not repeat a prediction.

use std::collections::HashMap;
use std::sync::Arc;

use crate::judge::{Judgement, judge_under};
use crate::metrics::Thresholds;
use crate::scenario::{Scene, Window};
use crate::verdict::Task;

/// Judgements of safety of one scene under the same thresholds, by the first and last step of their windows.
#[derive(Debug, Clone, Default)]
pub struct JudgementCache {
    of: Option<(Arc<Scene>, Arc<Thresholds>)>,
    windows: HashMap<(i64, i64), Judgement>,
}

impl JudgementCache {
    /// The safety judgement of this window, computed if not cached. Another scene or other thresholds clear the cache.
    pub fn safety(
        &mut self,
        scene: &Arc<Scene>,
        window: &Window,
        thresholds: &Arc<Thresholds>,
    ) -> Judgement {
        let same = self.of.as_ref().is_some_and(|(known, under)| {
            Arc::ptr_eq(known, scene) && Arc::ptr_eq(under, thresholds)
        });
        if !same {
            self.windows.clear();
            self.of = Some((scene.clone(), thresholds.clone()));
        }
        let key = (window.first(), window.last());
        let judge = || judge_under(scene, Task::Safety, window, thresholds);
        self.windows.entry(key).or_insert_with(judge).clone()
    }
}
