//! Jobs that run: started, cancelled and waited for in one way, whatever their work.

use std::collections::HashMap;

use tokio::task::AbortHandle;

use crate::model::JobId;
use nearmiss_drive::planner::Cancel;
use nearmiss_workflow::batch::BatchControl;

/// How a job is cancelled.
pub enum Canceller {
    /// It looks at a flag.
    Flag(Cancel),
    /// Its task is aborted, which writes down what was asked as cancelled.
    Abort,
    /// It first begins nothing more, then ends what it began.
    Batch(BatchControl),
}

/// A job that runs. Dropping it cancels.
pub struct Handle {
    canceller: Canceller,
    task: AbortHandle,
}

impl Drop for Handle {
    fn drop(&mut self) {
        match &self.canceller {
            Canceller::Flag(cancel) => cancel.ask(),
            Canceller::Abort => self.task.abort(),
            Canceller::Batch(control) => control.cancel(),
        }
    }
}

/// All jobs that run.
#[derive(Default)]
pub struct RunningJobs {
    handles: HashMap<JobId, Handle>,
    /// Cancelled, and not yet written down.
    ending: Vec<AbortHandle>,
}

impl RunningJobs {
    /// Adds one; another one of the same id is cancelled.
    pub fn insert(&mut self, id: JobId, canceller: Canceller, task: AbortHandle) {
        self.handles.retain(|_, handle| !handle.task.is_finished());
        self.handles.insert(id, Handle { canceller, task });
    }

    /// Cancels one. A batch goes on with what it began until it is cancelled once more.
    pub fn cancel(&mut self, id: JobId) {
        let handle = self.handles.get(&id);
        if let Some(Canceller::Batch(control)) = handle.map(|handle| &handle.canceller)
            && !control.is_stopped()
        {
            control.stop();
        } else if let Some(handle) = self.handles.remove(&id) {
            self.end(&handle);
        }
    }

    /// Cancels all.
    pub fn cancel_all(&mut self) {
        for (_, handle) in std::mem::take(&mut self.handles) {
            self.end(&handle);
        }
    }

    /// Waits at the end of the program for this task, too.
    pub fn wait_for(&mut self, task: AbortHandle) {
        self.ending.retain(|task| !task.is_finished());
        self.ending.push(task);
    }

    /// Whether everything that was cancelled is written down.
    pub fn is_settled(&self) -> bool {
        self.ending.iter().all(AbortHandle::is_finished)
    }

    /// Jobs that only work in memory are not waited for.
    fn end(&mut self, handle: &Handle) {
        if !matches!(handle.canceller, Canceller::Flag(_)) {
            self.wait_for(handle.task.clone());
        }
    }
}
