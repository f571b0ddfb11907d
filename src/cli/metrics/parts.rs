//! `nearmiss metrics --format parquet -o FOLDER`: measures in Parquet parts, continued with --resume.

use std::path::Path;

use serde::Serialize;

use super::{Metrics, Plan, Rows, measured, table};
use crate::ending::interrupted;
use crate::open::found;
use crate::parts::{PartsRequest, write};
use crate::{Failure, Outcome};
use nearmiss_scene::metrics::own_formulas;
use nearmiss_workflow::journal::RunSettings;

/// Scenarios in a part: what a killed run loses at most, for each of its threads.
const PER_PART: usize = 64;

/// Everything that changes the rows, apart from the scenarios.
#[derive(Serialize)]
struct MetricsSettings<'a> {
    #[serde(flatten)]
    arguments: &'a Metrics,
    /// The hash of a planner's drives.
    drives: Option<&'a str>,
    /// What the user's measures are.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    own_measures: Vec<String>,
    /// What the user's file changes.
    thresholds: Vec<String>,
}

/// Writes the parts.
pub(super) fn run(arguments: &Metrics, folder: &Path) -> Outcome {
    let (rows, thresholds) = measured(arguments)?;
    let entries = arguments.many.part.of(found(&arguments.paths)?);
    let stop = interrupted(true);
    let plan = Plan {
        arguments,
        ego: arguments.ego.wanted(&entries)?,
        rows,
        table: table(arguments, rows, &thresholds),
        thresholds,
    };
    plan.say_thresholds();
    let request = PartsRequest {
        command: "metrics",
        folder,
        many: arguments.many,
        overwrite: arguments.output.overwrites(),
        table: plan.table.clone(),
        settings: RunSettings::new(&MetricsSettings {
            arguments,
            drives: plan.ego.planner().map(|drives| drives.sha256.as_str()),
            own_measures: match rows {
                Rows::Exact => own_formulas(),
                Rows::Scene | Rows::Paper => Vec::new(),
            },
            thresholds: plan.thresholds.change_words(),
        })
        .map_err(Failure::input)?,
        per_part: PER_PART,
        notes: None,
    };
    let done = write(request, &entries, &stop, |entry| plan.measured(entry));
    done?.end("measured")
}
