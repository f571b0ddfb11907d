//! Planning the ego of a scenario in the background.

use super::super::loaded::Opened;
use super::super::message::{JobEvent, JobId};
use super::Tasks;
use nearmiss_drive::planner::Forecast;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::Transform;
use nearmiss_workflow::{OpenRequest, PlanRequest};

impl Tasks {
    /// Plans the ego of a scenario, after a change of its scene if there is one.
    pub(super) fn plan(
        &mut self,
        id: JobId,
        entry: Entry,
        change: Option<Transform>,
        forecast: Forecast,
        place: usize,
    ) {
        let chosen = place.checked_sub(1);
        let planner = chosen.and_then(|chosen| self.planners.get(chosen)).cloned();
        let settings = Settings {
            forecast,
            ..self.planning
        };
        let (ego, thresholds) = (self.ego.clone(), self.thresholds.clone());
        self.run(id, JobEvent::Plan, move |cancel, tell| {
            let request = PlanRequest {
                open: OpenRequest {
                    entry: &entry,
                    ego: &ego,
                    transform: change,
                    strict: false,
                },
                problem: None,
                settings: &settings,
            };
            let mut on_step = |done, of| tell((done, of));
            let planned =
                Opened::planned_by(&request, place, planner, &thresholds, cancel, &mut on_step)?;
            Ok(planned.map(Box::new))
        });
    }
}
