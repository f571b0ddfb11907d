//! Variants for tests: from short searches with a coarse planner, each made once.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::drive_fixtures::coarse;
use crate::loaded::{GenerationInputs, GenerationOutcome, Opened, VariantRequest};
use nearmiss_drive::generation::Effort;
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::EgoSelection;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_workflow::AttackSource;

/// Few motions: a test waits for it.
pub const SHORT: Effort = Effort {
    candidates: 90,
    rounds: 3,
    drives: 3,
    attackers: 3,
    together: 1,
    delay: 0.5,
    seed: 1,
};

/// A short search.
pub fn with(settings: &Settings) -> GenerationInputs<'_> {
    GenerationInputs {
        settings,
        planner: None,
        source: AttackSource::Search(&SHORT),
    }
}

/// Planning took 12 ms in all cycles.
pub fn in_12_ms(made: &mut GenerationOutcome) {
    if let GenerationOutcome::Found { original, variant } = made {
        for opened in [original, variant] {
            let planned = opened.planned.as_mut().unwrap();
            for cycle in &mut Arc::get_mut(planned).unwrap().cycles {
                cycle.took = Duration::from_millis(12);
            }
        }
    }
}

/// What is made of a bundled scenario, each searched for once for all tests; planning takes 12 ms in all of them.
pub fn generated(wish: &VariantRequest) -> Result<GenerationOutcome, String> {
    type VariantCache =
        HashMap<(String, Option<i64>, u64, usize), Result<GenerationOutcome, String>>;
    static MADE: Mutex<Option<VariantCache>> = Mutex::new(None);
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    let make = || {
        // A folder in which nothing lies decides the name.
        let wish = VariantRequest {
            style: Default::default(),
            folder: Some("/nonexistent".into()),
            ..wish.clone()
        };
        let (settings, thresholds) = (coarse(wish.forecast), Thresholds::shipped());
        let (how, cancel) = (with(&settings), Cancel::default());
        let ego = EgoSelection::Beside;
        let mut made = Opened::generated(&wish, &ego, thresholds, &how, &cancel, &mut |_| {})?
            .expect("it was not stopped");
        in_12_ms(&mut made);
        Ok(made)
    };
    let key = (
        wish.entry.name.clone(),
        wish.only,
        wish.seed,
        wish.attackers,
    );
    made.get_or_insert_default()
        .entry(key)
        .or_insert_with(make)
        .clone()
}
