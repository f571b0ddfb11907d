//! Where planners stand beside each other and beside baselines, as a table for people.

use nearmiss_record::CaptionedTable;
use nearmiss_workflow::drive::{BeyondBaselines, Standing, beyond_baselines, standings};

use crate::{Failure, output};

/// The table for people; baselines that were not named are marked. `scenarios` has the names of what was driven.
///
/// # Errors
/// None: records have no maps.
pub fn words(all: &[Standing], scenarios: &[String]) -> Result<String, Failure> {
    let mut records = standings(all);
    for record in records.iter_mut().filter(|record| record.baseline) {
        record.planner += " (baseline)";
    }
    let table = CaptionedTable::of("", "", &records).map_err(Failure::input)?;
    let BeyondBaselines {
        scenarios: beyond,
        first_unharmed,
        undecided,
    } = beyond_baselines(all, scenarios);
    let of = output::counted(scenarios.len(), "scenario");
    let mut text = format!(
        "{}no baseline solves {} of {of}",
        table.text(),
        beyond.len()
    );
    if let Some(first) = all.first().filter(|_| !beyond.is_empty()) {
        text += &format!("; of these, {} solves {first_unharmed}", first.name);
    }
    if undecided > 0 {
        text += &format!(
            "; {undecided} more undecided: traffic that sees nothing runs into a baseline from behind"
        );
    }
    let more = beyond.len().saturating_sub(NAMED);
    let named = beyond.iter().take(NAMED).map(|name| format!("  {name}\n"));
    text += &format!("\n{}", named.collect::<String>());
    if more > 0 {
        text += &format!("  and {more} more; --format json names all\n");
    }
    Ok(text)
}

/// More scenarios are counted, not named.
const NAMED: usize = 20;
