//! Default planner settings.

use nearmiss_drive::planner::{self, Forecast};
use nearmiss_drive::simulation::{Settings, TrafficMode};

/// The default: every step is planned again, and others follow their lanes.
#[must_use]
pub fn default_planning() -> Settings {
    Settings {
        planner: planner::Settings::default(),
        forecast: Forecast::Lane,
        replan: 1,
        without: None,
        traffic: TrafficMode::Recorded,
    }
}
