//! The planner in the workbench: its settings, and the drive in progress.

use super::JobId;
use super::Model;
use super::rollout_cache::RolloutCache;
use crate::action::Action;
use crate::loaded::{CycleShown, PlannedEgo};
use nearmiss_drive::planner::Forecast;
use nearmiss_scene::scenario::ContentHash;

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
