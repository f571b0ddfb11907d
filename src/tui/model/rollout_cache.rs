//! Planner drives kept while the workbench runs, so a reopened scenario has its planned ego again.

use crate::loaded::{CycleShown, DriveKey, Opened};
use nearmiss_scene::scenario::{ContentHash, Transform};

/// Bytes that kept cycles may take; a drive has some two megabytes. Beyond, the oldest drives go.
const MOST: usize = 128 << 20;

/// A drive that is kept.
#[derive(Debug)]
pub struct KeptDrive {
    /// The key of the drive.
    pub key: DriveKey,
    /// The scenario with it.
    pub opened: Box<Opened>,
    /// Whether the planned ego stands in the recorded one's place whenever the scenario is opened.
    pub shown: bool,
    /// The files that it was written to.
    pub saved: Option<String>,
    bytes: usize,
}

/// Kept drives, oldest first.
#[derive(Debug, Default)]
pub struct RolloutCache {
    drives: Vec<KeptDrive>,
}

impl RolloutCache {
    /// Keeps a drive, which is shown; one of the same goes.
    pub fn keep(&mut self, opened: &Opened) {
        let (Some(key), Some(planned)) = (opened.drive_key(), opened.planned.as_ref()) else {
            return;
        };
        self.drives.retain(|drive| drive.key != key);
        self.drives.push(KeptDrive {
            key,
            opened: Box::new(opened.clone()),
            shown: false,
            saved: None,
            bytes: planned.cycles.iter().map(CycleShown::bytes).sum(),
        });
        self.show(key);
        let mut held: usize = self.drives.iter().map(|drive| drive.bytes).sum();
        while held > MOST && self.drives.len() > 1 {
            held -= self.drives.remove(0).bytes;
        }
    }

    /// The drive of this.
    #[must_use]
    pub fn find(&self, key: DriveKey) -> Option<&KeptDrive> {
        self.drives.iter().find(|drive| drive.key == key)
    }

    /// The drives of a scenario.
    pub fn for_scenario(
        &self,
        hash: ContentHash,
        change: Option<Transform>,
    ) -> impl Iterator<Item = &KeptDrive> {
        let drives = self.drives.iter();
        drives.filter(move |drive| drive.key.hash == hash && drive.key.change == change)
    }

    /// Its planned ego is the one to show of the scenario from now on.
    pub fn show(&mut self, key: DriveKey) {
        self.put_away(key.hash, key.change);
        let drive = self.drives.iter_mut().find(|drive| drive.key == key);
        if let Some(drive) = drive {
            drive.shown = true;
        }
    }

    /// The scenario shows no planned ego when it is opened.
    pub fn put_away(&mut self, hash: ContentHash, change: Option<Transform>) {
        for drive in &mut self.drives {
            drive.shown &= drive.key.hash != hash || drive.key.change != change;
        }
    }

    /// The drive was written to these files.
    pub fn saved(&mut self, key: DriveKey, files: &str) {
        let drive = self.drives.iter_mut().find(|drive| drive.key == key);
        if let Some(drive) = drive {
            drive.saved = Some(files.into());
        }
    }

    /// Forgets all: what was measured on them holds no longer.
    pub fn forget(&mut self) {
        self.drives.clear();
    }
}
