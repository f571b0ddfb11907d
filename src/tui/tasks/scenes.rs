//! Opens scenarios.

use super::Tasks;
use crate::loaded::Opened;
use crate::message::{Msg, OpenId};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::scenario::Transform;

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
