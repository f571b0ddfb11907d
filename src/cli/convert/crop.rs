//! Which part of scenarios is converted: options for time, area and obstacles.

use std::collections::BTreeSet;
use std::sync::Arc;

use nearmiss_formats::Entry;
use nearmiss_scene::scenario::{Around, Crop, Cropped, Ego, Scenario};
use serde::Serialize;

use crate::Failure;
use crate::span::{At, moment};

/// What of scenarios is kept.
#[derive(Debug, Clone, clap::Args, Serialize)]
#[command(next_help_heading = "A part of it")]
pub(super) struct CropOptions {
    /// Keep the time from here on: a time step (20) or seconds (2s). Steps keep their numbers, but begin at 0 in
    /// OpenSCENARIO, with --schema, and where a table is read again.
    #[arg(long, value_name = "STEP|SECONDS", allow_negative_numbers = true, value_parser = moment)]
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<At>,
    /// Keep the time until here, this step included.
    #[arg(long, value_name = "STEP|SECONDS", allow_negative_numbers = true, value_parser = moment)]
    #[serde(skip_serializing_if = "Option::is_none")]
    to: Option<At>,
    /// Keep what comes within so many metres of the way of the ego in that time (ego:60m), or of a point of the map
    /// (12.5,-3:60m): lanelets, and obstacles with all their states of that time.
    #[arg(long, value_name = "ego|X,Y:METRES", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    around: Option<Around>,
    /// Keep these obstacles alone, separated by commas.
    #[arg(
        long,
        value_name = "ID",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    keep: Vec<i64>,
    /// Leave out these obstacles.
    #[arg(
        long,
        value_name = "ID",
        value_delimiter = ',',
        allow_negative_numbers = true,
        conflicts_with = "keep"
    )]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    drop: Vec<i64>,
}

impl CropOptions {
    /// Whether the time is another; the ego is as it was otherwise.
    pub fn cuts_time(&self) -> bool {
        self.from.is_some() || self.to.is_some()
    }

    /// Whether nothing is left out.
    pub fn is_whole(&self) -> bool {
        let all = self.keep.is_empty() && self.drop.is_empty();
        all && self.around.is_none() && !self.cuts_time()
    }

    /// The part of a scenario and its ego, and what is said of it; all of it where nothing is asked for. `from_zero`
    /// is whether the format has steps that begin at 0.
    ///
    /// # Errors
    /// There is no such time, area or obstacle in it, or nothing is left.
    pub fn apply(
        &self,
        entry: &Entry,
        scenario: Arc<Scenario>,
        ego: Option<Ego>,
        from_zero: bool,
    ) -> Result<Cropped, Failure> {
        let named = |error: String| Failure::input(format!("{}: {error}", entry.display()));
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
            keep: (!self.keep.is_empty()).then(|| BTreeSet::from_iter(self.keep.iter().copied())),
            drop: self.drop.iter().copied().collect(),
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
