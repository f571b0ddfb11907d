//! R-G3: the speed limit of the lane.

use super::Rule;
use super::ego::EgoAlong;
use super::report::{Finding, merged};

/// Speeds above the limit by no more than this are rounding of recordings, m/s.
const TOLERANCE: f64 = 0.1;

pub(super) fn finding(ego: &EgoAlong<'_>) -> Finding {
    if ego.scene.scenario.network.signs.is_empty() {
        return Finding::undecided(Rule::SpeedLimit, "the map has no signs");
    }
    let mut limited = false;
    let violations = merged(ego, |_, moment| {
        let middle = f64::midpoint(moment.front, moment.rear);
        let limit = ego.regulations.limit_at(middle)?;
        limited = true;
        let over = moment.velocity - limit.speed;
        (over > TOLERANCE).then_some((over, None))
    });
    if limited {
        Finding::applied(Rule::SpeedLimit, violations)
    } else {
        Finding::not_applicable(Rule::SpeedLimit, "no limit on the lanes driven")
    }
}
