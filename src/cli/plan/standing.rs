//! Where planners stand beside each other and beside baselines, as a table for people.

use nearmiss_record::CaptionedTable;
use nearmiss_workflow::drive::{BeyondBaselines, Standing, beyond_baselines, standings};

use crate::{Failure, output};

/// The table for people; baselines that were not named are marked.
///
/// # Errors
/// None: records have no maps.
pub fn words(all: &[Standing]) -> Result<String, Failure> {
    let mut records = standings(all);
    for record in records.iter_mut().filter(|record| record.baseline) {
        record.planner += " (baseline)";
    }
    let table = CaptionedTable::of("", "", &records).map_err(Failure::input)?;
    let BeyondBaselines {
        scenarios,
        first_unharmed,
    } = beyond_baselines(all);
    let drives = all.first().map_or(0, |first| first.drives.len());
    let of = output::counted(drives, "scenario");
    let first = all.first().map_or("", |first| &first.name);
    Ok(format!(
        "{}no baseline solves {scenarios} of {of}; of these, {first} solves {first_unharmed}\n",
        table.text()
    ))
}
