//! Plans the ego of a scenario in the background, and writes it.

use crate::loaded::{DriveFiles, DriveKey, Opened};
use crate::message::Effect;
use crate::model::{Job, JobId, JobKind, Model, Update};
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::tasks::drives;
use crate::update::{jobs, planning};
use nearmiss_drive::planner::Forecast;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::Entry;
use nearmiss_scene::scenario::Transform;
use nearmiss_workflow::{OpenRequest, PlanRequest};

/// Plans the ego of a scenario.
#[derive(Debug)]
pub struct Plan {
    /// Its number.
    pub id: JobId,
    /// The scenario.
    pub entry: Entry,
    /// The change of its scene.
    pub change: Option<Transform>,
    /// How the planner foresees others.
    pub forecast: Forecast,
    /// The planner's place among those of the configuration, from 1; 0 for the built-in one.
    pub planner: usize,
}

/// Planned steps, and steps at most; then the scenario with the planned ego.
pub type PlanUpdate = Update<(usize, usize), Box<Opened>>;

impl Request for Plan {
    type Reply = (JobId, PlanUpdate);

    fn sent(&self, model: &mut Model) {
        let forecast = self.forecast.name();
        let title = format!("the ego of {} planned, {forecast}", self.entry.name);
        let job = Job::new(self.id, JobKind::Plan, title, 1, model.uptime);
        model.jobs.add(job);
    }

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let planner = services.planner(self.planner);
        let settings = Settings {
            forecast: self.forecast,
            ..services.planning
        };
        let (ego, thresholds) = (services.ego.clone(), services.thresholds.clone());
        services.run(self.id, replies, move |cancel, progress| {
            let request = PlanRequest {
                open: OpenRequest {
                    entry: &self.entry,
                    ego: &ego,
                    transform: self.change,
                    strict: false,
                },
                problem: None,
                settings: &settings,
            };
            let mut on_step = |done, of| progress((done, of));
            let place = self.planner;
            let planned =
                Opened::planned_by(&request, place, planner, &thresholds, cancel, &mut on_step)?;
            Ok(planned.map(Box::new))
        });
    }

    fn reply(model: &mut Model, (id, update): Self::Reply) -> Vec<Effect> {
        if jobs::note(model, id, |job, now| planning::note(job, &update, now)) {
            planning::on_update(model, update)
        } else {
            Vec::new()
        }
    }
}

/// Writes a planned ego.
#[derive(Debug)]
pub struct SaveDrive(pub Box<DriveFiles>);

impl Request for SaveDrive {
    /// The files, or why it was not written.
    type Reply = (DriveKey, Result<String, String>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Self(files) = self;
        services.background(replies, move || (files.key, drives::write(&files)));
    }

    fn reply(model: &mut Model, (key, written): Self::Reply) -> Vec<Effect> {
        planning::saved(model, key, written);
        Vec::new()
    }
}
