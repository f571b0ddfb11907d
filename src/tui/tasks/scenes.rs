//! Opens scenarios.

use super::Tasks;
use crate::formats::{EgoSelection, Entry};
use crate::scenario::Transform;
use crate::tui::loaded::Opened;
use crate::tui::message::{Msg, OpenId};

impl Tasks {
    /// Opens a scenario, with an obstacle as the ego if one is taken, after a change of its scene if there is one.
    pub(super) fn open(
        &self,
        id: OpenId,
        entry: Entry,
        obstacle: Option<i64>,
        change: Option<Transform>,
    ) {
        let ego = obstacle.map_or_else(|| self.ego.clone(), EgoSelection::Obstacle);
        let thresholds = self.thresholds.clone();
        self.background(move || {
            let opened = Opened::changed(&entry, &ego, &thresholds, change);
            Msg::Opened(id, opened.map(Box::new))
        });
    }
}
