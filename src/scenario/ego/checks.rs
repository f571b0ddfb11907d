//! What is doubtful about an ego once it is held against its scenario.

use super::assumed;
use crate::scenario::{Diagnostic, Ego, Scenario, Severity};

/// An ego that begins farther from its planning problem than this, metres, may be of another scenario.
const START_TOLERANCE: f64 = 1.0;

/// Headings are radians; beyond this many turns they are rather degrees.
const MOST_TURNS: f64 = 3.0;

/// What whoever reads numbers about this ego should know.
pub(super) fn check(ego: &Ego, scenario: &Scenario) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    let mut warn = |message: String| found.push(assumed(Severity::Warning, message));
    let (own, theirs) = (ego.track.steps(), scenario.steps());
    let moving = scenario
        .obstacles
        .iter()
        .any(|o| o.track().iter().count() > 1);
    if moving && (own.end <= theirs.start || own.start >= theirs.end) {
        warn(format!(
            "it is recorded from step {} to {}, and the obstacles from {} to {}: they never meet; are the steps of \
             another scenario?",
            own.start,
            own.end - 1,
            theirs.start,
            theirs.end - 1
        ));
    }
    let missing = (own.end - own.start) as usize - ego.track.iter().count();
    if missing > 0 {
        warn(format!(
            "{missing} steps between its first and its last have no record"
        ));
    }
    if let Some(jump) = ego.track.jump(scenario.dt()) {
        warn(jump.to_string());
    }
    let problem = scenario.planning_problems.iter().find(|p| p.id == ego.id);
    let start = problem.and_then(|p| Some((p.initial.time.from, p.initial.point()?)));
    if let Some((step, planned)) = start
        && let Some(first) = ego.track.at(step)
    {
        let off = (first.pose.position - planned).norm();
        if off > START_TOLERANCE {
            warn(format!(
                "it begins {off:.2} m from where planning problem {} does; is it of another scenario?",
                ego.id
            ));
        }
    }
    let turns = |heading: Option<f64>| {
        heading.is_some_and(|h| h.abs() > MOST_TURNS * std::f64::consts::TAU)
    };
    if ego.recorded.iter().any(|s| turns(s.heading)) {
        warn("headings of many turns; they are read as radians, and look like degrees".into());
    }
    found
}
