//! Work without Python's lock, which Ctrl-C stops.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use nearmiss_drive::planner::Cancel;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// How long a Ctrl-C may wait.
const POLL: Duration = Duration::from_millis(50);

/// Reading nests as deeply as files do.
const STACK: usize = 8 << 20;

/// Does what may take long. Ctrl-C raises `KeyboardInterrupt` at once; the work is asked to end, and what comes of it is
/// dropped.
///
/// # Errors
/// An exception of a signal handler, or that the work panicked.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Cancel) -> T + Send + 'static,
) -> PyResult<T> {
    let cancel = Cancel::default();
    let asked = cancel.clone();
    let (sender, mut receiver) = sync_channel(1);
    std::thread::Builder::new()
        .name("nearmiss".into())
        .stack_size(STACK)
        .spawn(move || {
            let done = catch_unwind(AssertUnwindSafe(|| work(&asked)));
            // Nobody waits after a Ctrl-C.
            let _ = sender.send(done);
        })?;
    loop {
        let waited: Result<Result<T, Box<dyn Any + Send>>, RecvTimeoutError>;
        (waited, receiver) = py.detach(move || wait(receiver));
        match waited {
            Ok(Ok(done)) => return Ok(done),
            Ok(Err(panic)) => return Err(panicked(&*panic)),
            Err(RecvTimeoutError::Disconnected) => return Err(panicked(&"")),
            Err(RecvTimeoutError::Timeout) => py.check_signals().inspect_err(|_| cancel.ask())?,
        }
    }
}

/// Does what may panic on the bytes of others.
///
/// # Errors
/// It panicked.
pub fn caught<T>(work: impl FnOnce() -> T) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| panicked(&*panic))
}

fn wait<T>(receiver: Receiver<T>) -> (Result<T, RecvTimeoutError>, Receiver<T>) {
    (receiver.recv_timeout(POLL), receiver)
}

fn panicked(panic: &(dyn Any + Send)) -> PyErr {
    let plain = panic.downcast_ref::<&str>().copied();
    let words = plain.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    PyRuntimeError::new_err(format!(
        "internal error of nearmiss: {}; please report it with the file",
        words.unwrap_or("no message")
    ))
}
