//! Exports a planned ego: its motion as CSV, and as a CommonRoad solution.

use std::path::Path;

use super::pictures::file_name;
use crate::loaded::DriveFiles;
use nearmiss_base::system::shown_path;
use nearmiss_formats::commonroad::{ProblemSolution, Solution, save, write_solution};
use nearmiss_formats::write_recording;
use nearmiss_scene::scenario::{VehicleModel, VehicleType};

/// Files of one name that are tried before another name is asked for.
const MOST: usize = 1000;

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
    for number in 1..=MOST {
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
        "{MOST} drives called {name} exist already; move some away"
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
