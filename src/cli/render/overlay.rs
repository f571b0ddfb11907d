//! `--overlay`: a planner's predictions drawn over the map, from a table of tracks.

use std::path::Path;

use nearmiss_formats::{Entry, Forecast, read_forecasts};
use nearmiss_render::Subject;
use nearmiss_scene::scenario::{ContentHash, Severity};

use super::Drawing;
use crate::{Failure, output};

/// Predictions, and the hash of their table.
#[derive(Default)]
pub struct Overlay {
    pub forecasts: Vec<Forecast>,
    pub hash: Option<String>,
}

/// Reads the table; what is odd about it is said.
pub fn read(file: Option<&Path>) -> Result<Overlay, Failure> {
    let Some(file) = file else {
        return Ok(Overlay::default());
    };
    let (forecasts, diagnostics) = read_forecasts(file).map_err(Failure::input)?;
    let odd = diagnostics.iter().filter(|d| d.severity != Severity::Note);
    for diagnostic in odd {
        output::say(&format!("nearmiss: {}: {diagnostic}", file.display()));
    }
    let bytes = std::fs::read(file).map_err(|e| Failure::system(file.display(), &e))?;
    Ok(Overlay {
        forecasts,
        hash: Some(ContentHash::digest(&bytes).to_string()),
    })
}

impl Drawing<'_> {
    /// The predictions about a scenario; where they are about no road user in it, that is said.
    pub(super) fn forecasts_of(&self, entry: &Entry, subject: &Subject<'_>) -> Vec<Forecast> {
        let is_meant = |one: &&Forecast| one.scenario.is_empty() || one.scenario == entry.name;
        let found: Vec<Forecast> = self.forecasts.iter().filter(is_meant).cloned().collect();
        let ego = subject.scene.map(|scene| scene.ego.id);
        let is_known = |id: i64| Some(id) == ego || subject.scenario.obstacle(id).is_some();
        if !self.forecasts.is_empty() && !found.iter().filter_map(|one| one.id).any(is_known) {
            output::say(&format!(
                "nearmiss: {}: no id of --overlay is the ego's or an obstacle's here",
                entry.display()
            ));
        }
        found
    }
}
