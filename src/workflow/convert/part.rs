//! Which part of a scenario is written: a time, an area, some obstacles.

use std::collections::BTreeSet;
use std::sync::Arc;

use nearmiss_formats::Entry;
use nearmiss_scene::scenario::{Around, Crop, Cropped, Ego, Scenario};

use crate::span::At;

/// What of scenarios is kept; all of it by default.
#[derive(Debug, Clone, Default)]
pub struct Part {
    /// The first moment.
    pub from: Option<At>,
    /// The last one.
    pub to: Option<At>,
    /// What comes near the ego or a point.
    pub around: Option<Around>,
    /// These obstacles alone; all where there are none.
    pub keep: BTreeSet<i64>,
    /// Not these.
    pub drop: BTreeSet<i64>,
}

impl Part {
    /// Whether the time is another; the ego is as it was otherwise.
    pub(super) fn cuts_time(&self) -> bool {
        self.from.is_some() || self.to.is_some()
    }

    /// Whether nothing is left out.
    pub(super) fn is_whole(&self) -> bool {
        let all = self.keep.is_empty() && self.drop.is_empty();
        all && self.around.is_none() && !self.cuts_time()
    }

    /// The part of a scenario and its ego, and what is said of it; all of it where nothing is asked for. `from_zero`
    /// is whether the format has steps that begin at 0.
    ///
    /// # Errors
    /// There is no such time, area or obstacle in it, or nothing is left.
    pub(super) fn of(
        &self,
        entry: &Entry,
        scenario: Arc<Scenario>,
        ego: Option<Ego>,
        from_zero: bool,
    ) -> Result<Cropped, String> {
        let named = |error: String| format!("{}: {error}", entry.display());
        let all = Crop::steps_of(&scenario, ego.as_ref());
        let step = |option: &str, at: Option<At>, open: i64| match at {
            None => Ok(open),
            Some(at) => at
                .step(option, &all, scenario.dt(), |_| None)
                .map_err(named),
        };
        let (first, last) = (
            step("--from", self.from, all.start)?,
            step("--to", self.to, all.end - 1)?,
        );
        if first > last {
            return Err(named(format!(
                "--from is step {first}, after --to, step {last}"
            )));
        }
        let crop = Crop {
            steps: self.cuts_time().then_some(first..=last),
            around: self.around,
            keep: (!self.keep.is_empty()).then(|| self.keep.clone()),
            drop: self.drop.clone(),
            from_zero,
        };
        if crop.is_whole() {
            return Ok(Cropped {
                scenario,
                ego,
                said: Vec::new(),
            });
        }
        let mut cropped = crop
            .apply(&scenario, ego.as_ref())
            .map_err(|error| named(error.to_string()))?;
        for said in &mut cropped.said {
            *said = format!("{}: {said}", entry.name);
        }
        Ok(cropped)
    }
}
