//! Marks the open scenario on disk, for crash reports and for the next start if it ends the program.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::message::Effect;
use crate::session::SavedLocation;
use crate::update::Open;
use nearmiss_base::system::activity::{ActivityGuard, trying};

/// A program that is killed later than this after the first picture was not ended by the scenario.
const SETTLED: Duration = Duration::from_millis(800);

/// The scenario opened last.
#[derive(Debug, Default)]
pub struct LastOpened {
    open: Option<Arc<ActivityGuard>>,
    drawn: bool,
}

impl LastOpened {
    /// An effect is about to be performed: if it opens a scenario, that is tried from now on.
    pub fn hear(&mut self, effect: &Effect, here: &Path) {
        let Some(Open { entry, .. }) = effect.request() else {
            return;
        };
        // The one before is over first.
        self.open = None;
        let words = format!("opening or showing {}", entry.name);
        let subject = SavedLocation::from_entry(entry, here).subject();
        self.open = Some(Arc::new(trying(words, subject)));
        self.drawn = false;
    }

    /// A frame was drawn: the scenario is in it unless it is still being opened.
    pub fn drawn(&mut self, opening: bool) {
        if opening || self.drawn {
            return;
        }
        self.drawn = true;
        if let Some(open) = self.open.clone() {
            tokio::spawn(async move {
                tokio::time::sleep(SETTLED).await;
                open.settle();
            });
        }
    }
}
