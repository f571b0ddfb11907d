//! A drive as the ego of a scene.

use super::{Rollout, Settings};
use crate::planner::Road;
use nearmiss_scene::scenario::{Diagnostic, Ego, EgoSource, PlanningProblem, Severity};

impl Rollout {
    /// The ego that drove it; nothing where the vehicle has no body.
    ///
    /// Its source says that it was planned, by what and under which forecast; how the drive ended is a diagnostic.
    #[must_use]
    pub fn ego(&self, problem: &PlanningProblem, settings: &Settings) -> Ego {
        let outcome = Diagnostic {
            severity: Severity::Note,
            line: 0,
            element: String::new(),
            message: match &self.external {
                None => format!("the planned drive ended with: {}", self.outcome),
                Some(report) => format!(
                    "the drive planned by {} ended with: {}",
                    report.planner, self.outcome
                ),
            },
        };
        Ego {
            id: problem.id,
            source: EgoSource::Planned {
                planner: self.external.as_ref().map(|report| report.named()),
                vehicle: settings.planner.vehicle.name().into(),
                forecast: settings.forecast.name().into(),
                planning_problem: problem.id,
            },
            footprint: Road::body_of(&self.limits),
            track: self.track(),
            recorded: Vec::new(),
            diagnostics: vec![outcome],
        }
    }
}
