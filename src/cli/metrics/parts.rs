//! `nearmiss metrics --format parquet -o FOLDER`: measures in Parquet parts, continued with --resume.

use std::path::Path;

use super::{Metrics, Plan, measured, measured_rows, table};
use crate::Outcome;
use crate::interrupt::interrupted;
use crate::open::found;
use crate::output::Format;
use crate::parts::{Measured, PartsRequest, write};
use nearmiss_formats::EgoSelection;

/// Scenarios in a part: what a killed run loses at most, for each of its threads.
const PER_PART: usize = 64;

/// Which drives of a planner are measured, as its name says too little.
fn drives_of(ego: &EgoSelection) -> String {
    let drives = ego.planner();
    drives.map_or(String::new(), |drives| format!(" {}", drives.sha256))
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
        format: Format::Parquet,
    };
    plan.say_thresholds();
    let request = PartsRequest {
        command: "metrics",
        folder,
        many: arguments.many,
        overwrite: arguments.output.overwrites(),
        table: plan.table.clone(),
        settings: format!(
            "{:?} {:?}{}",
            arguments.radius,
            arguments.ego,
            drives_of(&plan.ego)
        ),
        per_part: PER_PART,
    };
    let done = write(request, &entries, &stop, |entry| {
        let (said, rows) = measured_rows(entry, &plan);
        Measured { said, rows }
    });
    done?.end("measured")
}
