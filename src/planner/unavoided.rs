//! Obstacles the planner does not avoid: those known only as regions.

use crate::scenario::{Prediction, Scenario};

/// Obstacles that are named; of more the rest is counted.
const NAMED: usize = 4;

/// Which obstacles of a scenario are given as regions that they may cover (set-based predictions), and that planner and
/// closed loop take no notice of these, in a sentence; `None` if there is no such obstacle.
#[must_use]
pub fn unavoided(scenario: &Scenario) -> Option<String> {
    let as_regions = |p: &Prediction| matches!(p, Prediction::Occupancies(all) if !all.is_empty());
    let found = scenario.obstacles.iter();
    let found: Vec<i64> = found
        .filter(|o| as_regions(&o.prediction))
        .map(|o| o.id)
        .collect();
    let named: Vec<String> = found.iter().take(NAMED).map(i64::to_string).collect();
    let (who, is) = match (found.len(), named.split_last()) {
        (_, None) => return None,
        (1, Some((only, _))) => (format!("obstacle {only}"), "is"),
        (n, _) if n > NAMED => {
            let more = n - NAMED;
            (
                format!("obstacles {} and {more} more", named.join(", ")),
                "are",
            )
        }
        (_, Some((last, others))) => (format!("obstacles {} and {last}", others.join(", ")), "are"),
    };
    Some(format!(
        "{who} {is} given as regions (occupancy sets): the planner does not avoid them, and contact with them is not counted"
    ))
}
