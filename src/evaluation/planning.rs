//! Default planner settings.

use crate::planner::{self, Forecast};
use crate::simulation::Settings;

/// What is planned with by default: every step anew, the others along their lanes.
#[must_use]
pub fn default_planning() -> Settings {
    Settings {
        planner: planner::Settings::default(),
        forecast: Forecast::Lane,
        replan: 1,
        without: None,
    }
}
