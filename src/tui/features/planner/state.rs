//! The planner in the workbench: its settings, and the drive in progress.

use crate::action::Action;
use crate::loaded::{CycleShown, DriveKey, Opened, PlannedEgo};
use crate::model::{JobId, Model};
use nearmiss_drive::planner::Forecast;
use nearmiss_scene::scenario::{ContentHash, Transform};

/// State of planning beside the open scenario.
#[derive(Debug)]
pub struct Driver {
    /// The forecast given to the planner.
    pub forecast: Forecast,
    /// The planner that drives: 0 is the built-in one, then those of [`Self::planners`].
    pub planner: usize,
    /// Names of the planners that are processes, as configured.
    pub planners: Vec<String>,
    /// The drive that is under way.
    pub under_way: Option<RunningDrive>,
    /// The place in the list of a scenario without an ego, and the seconds after which one is planned for it.
    pub waits: Option<(usize, f64)>,
    /// The scenario that shall stay without a planned ego, until another one is open.
    pub declined: Option<ContentHash>,
    /// Drives that were made since the start.
    pub kept: RolloutCache,
    /// A kept drive has just replaced the recorded ego, not yet announced.
    pub again: bool,
}

/// A drive that is under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunningDrive {
    /// Its number.
    pub id: JobId,
    /// The place of the scenario in the list.
    pub place: usize,
    /// Steps that are planned.
    pub done: usize,
    /// Steps at most; 0 while that is not known.
    pub of: usize,
}

impl Default for Driver {
    fn default() -> Self {
        Self {
            forecast: Forecast::Lane,
            planner: 0,
            planners: Vec::new(),
            under_way: None,
            waits: None,
            declined: None,
            kept: RolloutCache::default(),
            again: false,
        }
    }
}

impl Driver {
    /// The name of the planner that drives.
    #[must_use]
    pub fn planner_name(&self) -> &str {
        let place = self.planner.checked_sub(1);
        let name = place.and_then(|place| self.planners.get(place));
        name.map_or("nearmiss", String::as_str)
    }
}

/// The displayed name of a forecast.
#[must_use]
pub fn forecast_words(forecast: Forecast) -> &'static str {
    match forecast {
        Forecast::Lane => "predictions along the lanes",
        Forecast::ConstantVelocity => "predictions of constant velocity",
        Forecast::Recorded => "the recorded future, which no vehicle knows",
    }
}

impl Model {
    /// How the ego of the opened scenario was planned, where it was.
    #[must_use]
    pub fn planned(&self) -> Option<&PlannedEgo> {
        self.opened.as_ref()?.planned.as_deref()
    }

    /// The planner's cycle at the cursor.
    #[must_use]
    pub fn cycle(&self) -> Option<&CycleShown> {
        self.moment()?.cycle()
    }

    /// Why the planner has nothing to do in what is open, and what to do.
    #[must_use]
    pub fn nothing_to_plan(&self) -> Option<String> {
        let opened = self.opened.as_deref()?;
        opened.scenario.planning_problems.is_empty().then(|| {
            format!(
                "no planning problem, so no start and goal: open another scenario, or make an obstacle the ego ({} {})",
                self.look.key(Action::NextObstacle),
                self.look.key(Action::TakeAsEgo)
            )
        })
    }

    /// Why there is no planned ego, and what to do.
    #[must_use]
    pub fn unplanned(&self) -> String {
        if self.opened.is_none() {
            return "no scenario is open".into();
        }
        if self.driver.under_way.is_some() {
            return "the ego is still being planned".into();
        }
        self.nothing_to_plan().unwrap_or_else(|| {
            let key = self.look.key(Action::DrivePlanner);
            format!("the ego was not planned; {key} lets the planner drive")
        })
    }
}

/// Bytes that kept cycles may take; a drive has some two megabytes. Beyond, the oldest drives go.
const MAX_CYCLE_BYTES: usize = 128 << 20;

/// A drive that is kept.
#[derive(Debug)]
pub struct CachedDrive {
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
    drives: Vec<CachedDrive>,
}

impl RolloutCache {
    /// Keeps a drive, which is shown; one of the same goes.
    pub fn keep(&mut self, opened: &Opened) {
        let (Some(key), Some(planned)) = (opened.drive_key(), opened.planned.as_ref()) else {
            return;
        };
        self.drives.retain(|drive| drive.key != key);
        self.drives.push(CachedDrive {
            key,
            opened: Box::new(opened.clone()),
            shown: false,
            saved: None,
            bytes: planned.cycles.iter().map(CycleShown::bytes).sum(),
        });
        self.show(key);
        let mut held: usize = self.drives.iter().map(|drive| drive.bytes).sum();
        while held > MAX_CYCLE_BYTES && self.drives.len() > 1 {
            held -= self.drives.remove(0).bytes;
        }
    }

    /// The drive of this.
    #[must_use]
    pub fn find(&self, key: DriveKey) -> Option<&CachedDrive> {
        self.drives.iter().find(|drive| drive.key == key)
    }

    /// The drives of a scenario.
    pub fn for_scenario(
        &self,
        hash: ContentHash,
        change: Option<Transform>,
    ) -> impl Iterator<Item = &CachedDrive> {
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
