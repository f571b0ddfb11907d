//! Session state: what of the last session is yet to be restored, and what has been saved of this one.

use std::collections::HashSet;
use std::path::PathBuf;

use super::{SavedLocation, SavedScenario, Session};

/// State of session saving and restoring.
#[derive(Debug, Default)]
pub struct SessionState {
    /// Whether this session is kept.
    pub on: bool,
    /// The folder that the program was started in.
    pub here: PathBuf,
    /// Paths the workbench was started with.
    pub paths: Vec<SavedLocation>,
    /// Scenarios of the list that were looked at for what has yet to come back.
    pub seen: usize,
    /// Marked scenarios that are not found again yet.
    pub marks: HashSet<SavedLocation>,
    /// The scenario that was open last time, until it is open again or another one is chosen.
    pub wanted: Option<SavedScenario>,
    /// The session last saved.
    pub kept: Option<Box<Session>>,
    /// Whether something may have changed since.
    pub changed: bool,
    /// Whether keeping is already asked for.
    pub asked: bool,
    /// Whether a first-time user sees the hint towards a verdict.
    pub hint: bool,
}
