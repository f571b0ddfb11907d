//! Two versions of a prompt: looking up their stored answers, and two runs to show side by side.

use std::sync::Arc;

use super::Tasks;
use crate::message::runs::{ComparedVersions, VersionSide};
use crate::message::{JobEvent, JobId, Msg, Update};
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::EgoSelection;
use nearmiss_store::{RunId, Store};
use nearmiss_study::evaluation::Judges;
use nearmiss_workflow::{VersionSource, compare_versions};

impl Tasks {
    /// Looks up the answers to two versions.
    pub(super) fn compare_versions(&mut self, id: JobId, sides: Arc<[VersionSide; 2]>) {
        let batch = &sides[0].batch;
        let model = batch.model.clone();
        let needed = self
            .judge(&model, batch.request.tools)
            .and_then(|judge| Ok((judge, self.open_store()?)));
        let (judge, store) = match needed {
            Ok(needed) => needed,
            Err(why) => {
                let ended = JobEvent::Versions(Update::Ended(Err(why)));
                // The receiver is gone once the loop has ended.
                let _ = self.sender.send(Msg::Job(id, ended));
                return;
            }
        };
        let ego = self.ego.clone();
        let judges = Judges::from([(model, judge)]);
        self.run(id, JobEvent::Versions, move |cancel, tell| {
            compared(&sides, &ego, &judges, &store, cancel, tell)
        });
    }

    /// Reads two runs; what is gone is left out.
    pub(super) fn pair(&mut self, id: JobId, runs: [RunId; 2]) {
        let store = self.open_store();
        self.run(id, JobEvent::Pair, move |_, _| {
            let store = store?;
            let found = runs.iter().map(|run| store.run_shown(*run));
            let found: Result<Vec<_>, _> = found.collect();
            let found = found.map_err(|error| error.to_string())?;
            Ok(Some(found.into_iter().flatten().collect()))
        });
    }

    fn open_store(&self) -> Result<Arc<Store>, String> {
        self.store
            .clone()
            .ok_or_else(|| "the store of runs is not open".to_string())
    }
}

fn compared(
    sides: &[VersionSide; 2],
    ego: &EgoSelection,
    judges: &Judges,
    store: &Store,
    cancel: &Cancel,
    tell: &mut dyn FnMut(usize),
) -> Result<Option<Box<ComparedVersions>>, String> {
    let source = |side: &VersionSide| {
        let batch = &side.batch;
        let (library, thresholds) = (&batch.library, &batch.thresholds);
        let plan = batch
            .request(ego)
            .plan(library, thresholds, cancel, &mut |_| {});
        let plan = plan.map_err(|error| error.to_string())?;
        let hash = side.hash.clone();
        Ok::<_, String>(plan.map(|plan| VersionSource { plan, hash }))
    };
    let (Some(first), Some(second)) = (source(&sides[0])?, source(&sides[1])?) else {
        return Ok(None);
    };
    let sources = [first, second];
    let found = compare_versions(&sources, judges, store, cancel, tell);
    let Some(comparison) = found.map_err(|error| error.to_string())? else {
        return Ok(None);
    };
    let batch = &sides[0].batch;
    let asked = store.asked_templates(batch.task, batch.frame.name(), &batch.model);
    Ok(Some(Box::new(ComparedVersions {
        comparison,
        asked: asked.map_err(|error| error.to_string())?,
    })))
}
