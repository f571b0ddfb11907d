//! Where planners stand beside each other and beside baselines, as a table for people.

use nearmiss_workflow::drive::{BeyondBaselines, Standing, beyond_baselines, standings};

use crate::output::Align::{Left, Right};
use crate::output::{self, line};

/// The table for people.
pub fn words(all: &[Standing]) -> String {
    let names = all
        .iter()
        .map(|one| one.name.chars().count() + if one.is_baseline { 11 } else { 0 });
    let width = names.max().unwrap_or(0).max("planner".len());
    let columns = [
        Left(width),
        Right(5),
        Right(9),
        Right(8),
        Right(10),
        Right(9),
        Left(24),
    ];
    let header = [
        "planner",
        "goal",
        "collision",
        "ran into",
        "rear-ended",
        "serious",
        "collisions to the first, %",
    ];
    let mut out = line("  ", &columns, &header);
    for record in standings(all) {
        let name = if record.baseline {
            format!("{} (baseline)", record.planner)
        } else {
            record.planner.clone()
        };
        let percent = |value: f64| format!("{:+.1}", 100.0 * value);
        let difference = match (record.collision_difference, record.collision_interval) {
            (Some(difference), Some((low, high))) => {
                format!(
                    "{} ({} to {})",
                    percent(difference),
                    percent(low),
                    percent(high)
                )
            }
            (Some(difference), None) => percent(difference),
            (None, _) => String::new(),
        };
        let cells = [
            name,
            record.goal.to_string(),
            record.collision.to_string(),
            record.ran_into.to_string(),
            record.rear_ended.to_string(),
            format!("{:.3}", record.p_serious),
            difference,
        ];
        out += &line("  ", &columns, &cells);
    }
    let BeyondBaselines {
        scenarios,
        first_unharmed,
    } = beyond_baselines(all);
    let drives = all.first().map_or(0, |first| first.drives.len());
    let of = output::counted(drives, "scenario");
    out + &format!(
        "no baseline solves {scenarios} of {of}; of these, {} solves {first_unharmed}\n",
        all.first().map_or("", |first| &first.name)
    )
}
