//! Where planners stand beside each other and beside baselines, as a table for people.

use nearmiss_record::CaptionedTable;
use nearmiss_study::evaluation::statistics::FEWEST;
use nearmiss_workflow::drive::{Standing, beyond_baselines, standings};

use crate::Failure;

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
    let beyond = beyond_baselines(all, scenarios);
    let first = all.first().map_or("", |first| &first.name);
    let mut text = format!("{}{}", table.text(), beyond.words(scenarios.len(), first));
    if scenarios.len() < FEWEST as usize {
        text += &format!("\nfewer than {FEWEST} scenarios: no intervals");
    }
    let beyond = beyond.scenarios;
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
