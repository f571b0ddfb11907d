//! Obstacles given as occupancy sets, whose regions the planner avoids.

use nearmiss_scene::scenario::Scenario;

/// Obstacles that are named; of more the rest is counted.
const NAMED: usize = 4;

/// Which obstacles of a scenario are given as regions that they may cover (set-based predictions), and what planner and
/// closed loop make of these, in a sentence; `None` if there is no such obstacle.
#[must_use]
pub fn occupancy_sets(scenario: &Scenario) -> Option<String> {
    let found = scenario.obstacles.iter().filter(|o| o.is_set_based());
    let found: Vec<i64> = found.map(|o| o.id).collect();
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
        "{who} {is} given as regions (occupancy sets): the planner keeps out of all of each region, whatever it forecasts of others, external planners are not told of them, and contact with one is a possible contact"
    ))
}
