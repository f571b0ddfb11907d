//! Planner drives: the key that identifies one, and requests to export it.

use std::path::PathBuf;
use std::sync::Arc;

use super::Opened;
use nearmiss_drive::planner::Forecast;
use nearmiss_scene::scenario::{ContentHash, Scene, Transform, VehicleType};

/// The key of a drive: equal keys give equal drives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveKey {
    /// Hash of the scenario.
    pub hash: ContentHash,
    /// The change of the scenario.
    pub change: Option<Transform>,
    /// The forecast given to the planner.
    pub forecast: Forecast,
    /// The planner: 0 is the built-in one, then those of the configuration.
    pub planner: usize,
}

/// A drive to be written.
#[derive(Debug)]
pub struct DriveFiles {
    /// Which.
    pub key: DriveKey,
    /// Name of the scenario.
    pub name: String,
    /// The scenario with the planned ego.
    pub scene: Arc<Scene>,
    /// The vehicle that was driven.
    pub vehicle: VehicleType,
    /// Id of the planning problem that was solved.
    pub problem: i64,
    /// Where the files go; the current folder if none.
    pub folder: Option<PathBuf>,
}

impl Opened {
    /// The identity of the planned drive; `None` if the ego was not planned.
    #[must_use]
    pub fn drive_key(&self) -> Option<DriveKey> {
        self.planned.as_ref().map(|planned| DriveKey {
            hash: self.scenario.hash,
            change: self.change,
            forecast: planned.forecast,
            planner: planned.planner,
        })
    }
}
