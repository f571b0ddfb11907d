//! Planner drives for tests: coarse, each made once.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use crate::loaded::Opened;
use nearmiss_drive::planner::{self, Cancel, Forecast, RuleMode, Sampling};
use nearmiss_drive::simulation::{Settings, TrafficMode};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_workflow::{OpenRequest, PlanRequest};

/// Few samples over a short horizon: a test waits for it.
pub fn coarse(forecast: Forecast) -> Settings {
    let usual = planner::Settings::default();
    Settings {
        planner: planner::Settings {
            horizon: 3.0,
            sampling: Sampling {
                durations: 2,
                speeds: 4,
                offsets: 5,
                changes: 1,
                refinements: 0,
                ..usual.sampling
            },
            // With so few samples a rule may leave no way to drive.
            rules: RuleMode::Off,
            ..usual
        },
        forecast,
        replan: 1,
        without: None,
        traffic: TrafficMode::Recorded,
    }
}

/// Its ego as it lies beside it.
pub fn request<'a>(entry: &'a Entry, settings: &'a Settings) -> PlanRequest<'a> {
    PlanRequest {
        open: OpenRequest {
            entry,
            ego: &EgoSelection::Beside,
            transform: None,
            strict: false,
        },
        problem: None,
        settings,
    }
}

/// A bundled scenario with its ego planned, each driven once for all tests; planning takes 12 ms in all of them.
pub fn planned(entry: &Entry, forecast: Forecast) -> Result<Opened, String> {
    type Driven = HashMap<(String, &'static str), Result<Opened, String>>;
    static DRIVEN: Mutex<Option<Driven>> = Mutex::new(None);
    let mut driven = DRIVEN.lock().unwrap_or_else(PoisonError::into_inner);
    let drive = || {
        let settings = coarse(forecast);
        let thresholds = Thresholds::shipped();
        let request = request(entry, &settings);
        let mut opened = Opened::planned(&request, thresholds, &Cancel::default(), &mut |_, _| {})?
            .expect("it was not stopped");
        let planned = opened.planned.as_mut().unwrap();
        let planned = Arc::get_mut(planned).unwrap();
        for cycle in &mut planned.cycles {
            cycle.took = Duration::from_millis(12);
        }
        Ok(opened)
    };
    let key = (entry.name.clone(), forecast.name());
    let driven = driven.get_or_insert_default();
    driven.entry(key).or_insert_with(drive).clone()
}
