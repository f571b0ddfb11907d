//! Plans the ego of a scenario in the background, and writes it: its motion as CSV, and as a CommonRoad solution.

use std::path::Path;

use crate::features::jobs::notes;
use crate::features::pictures::file_name;
use crate::loaded::{DriveFiles, DriveKey, Opened};
use crate::message::Effect;
use crate::model::{Job, JobId, JobKind, Model, Update};
use crate::request::{Replies, Request};
use crate::services::Services;
use nearmiss_base::system::shown_path;
use nearmiss_drive::planner::Forecast;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::commonroad::{ProblemSolution, Solution, save, write_solution};
use nearmiss_formats::{Entry, write_recording};
use nearmiss_scene::scenario::{Transform, VehicleModel, VehicleType};
use nearmiss_workflow::{OpenRequest, PlanRequest, StandIn};

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
                    stand_in: StandIn::None,
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
        if notes::note(model, id, |job, now| super::note(job, &update, now)) {
            super::on_update(model, update)
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
        services.background(replies, move || (files.key, write(&files)));
    }

    /// A planned ego was written, or not.
    fn reply(model: &mut Model, (key, result): Self::Reply) -> Vec<Effect> {
        match result {
            Ok(files) => {
                model.driver.kept.saved(key, &files);
                model.say(format!("saved as {files}"));
            }
            Err(error) => model.complain(format!("the planned ego is not written: {error}")),
        }
        Vec::new()
    }
}

/// Files of one name that are tried before another name is asked for.
const MAX_FILE_TRIES: usize = 1000;

/// Writes both; gives their names.
///
/// # Errors
/// They cannot be made or written: in words, with what to do.
pub fn write(job: &DriveFiles) -> Result<String, String> {
    let folder = job.folder.as_deref().unwrap_or(Path::new("."));
    // Bytes first: what cannot be made takes no name.
    let track = &job.scene.ego.track;
    let recording = write_recording(job.problem, track).map_err(|e| e.to_string())?;
    let scenario = &job.scene.scenario;
    let model = VehicleModel::Ks;
    let solved = ProblemSolution::of_track(track, scenario.dt(), job.problem, model, job.vehicle)
        .map_err(|e| e.to_string())?;
    let (vehicle, cost) = (solved.vehicle_id(), solved.cost.clone());
    let solution = Solution::of_problem(&scenario.header, solved);
    let solution = write_solution(&solution).map_err(|e| e.to_string())?;
    let (name, version) = (file_name(&job.name), &scenario.header.version);
    let forecast = job.key.forecast.name();
    for number in 1..=MAX_FILE_TRIES {
        let again = match number {
            1 => String::new(),
            n => format!("_{n}"),
        };
        let csv = folder.join(format!("{name}_planned_{forecast}{again}.csv"));
        let xml = format!("solution_{vehicle}_{cost}_{name}_{version}_{forecast}{again}.xml");
        let xml = folder.join(xml);
        if [&csv, &xml]
            .into_iter()
            .any(|path| path.symlink_metadata().is_ok())
        {
            continue;
        }
        let refused = |e| format!("{e}; `pictures` in config.toml names another folder");
        save(&csv, &recording, false).map_err(refused)?;
        let csv = shown_path(&csv);
        save(&xml, &solution, false)
            .map_err(|e| format!("{csv} saved, but not the solution: {}", refused(e)))?;
        return Ok(format!(
            "{csv} and {}{}",
            shown_path(&xml),
            sizes(job.vehicle)
        ));
    }
    Err(format!(
        "{MAX_FILE_TRIES} drives called {name} exist already; move some away"
    ))
}

/// Vehicle data that CSV cannot carry.
fn sizes(vehicle: VehicleType) -> String {
    match vehicle {
        VehicleType::Bmw320i => String::new(),
        other => format!(
            "; the CSV is read as a {1}, the solution names the {0}",
            other.name(),
            VehicleType::Bmw320i.name()
        ),
    }
}
