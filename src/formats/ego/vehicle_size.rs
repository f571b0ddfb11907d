//! The vehicle size of a recorded ego, from a solution beside the recording with the same motion.
//!
//! A recording cannot store the vehicle; `nearmiss plan` writes a solution beside it, which names one.

use std::path::{Path, PathBuf};

use super::recording::usual_size;
use super::{assumed, read_ego_file};
use nearmiss_scene::scenario::EgoSource;
use nearmiss_scene::scenario::{Ego, Scenario, Severity, Track, VehicleModel, VehicleType};

/// Positions of the same motion differ by rounding only, metres.
const ROUNDING: f64 = 1e-3;

/// `ego` of the file `recording`, with the vehicle of the solution that lies with it, is called as `nearmiss plan`
/// calls it, and has the same positions at the same steps; as it was where there is none, also where what lies there
/// is broken or tells another motion, which says nothing about this one.
#[must_use]
pub fn sized(mut ego: Ego, recording: &Path, name: &str, scenario: &Scenario) -> Ego {
    let usual = usual_size();
    if !matches!(ego.source, EgoSource::Recording(_)) || !ego.diagnostics.contains(&usual) {
        return ego;
    }
    let files = candidates(recording, name, &scenario.header.version);
    let same = files.into_iter().find_map(|file| {
        let solved = read_ego_file(&file, scenario, Some(ego.id)).ok()?;
        same_motion(&ego.track, &solved.track).then_some((file, solved))
    });
    if let Some((file, solved)) = same {
        ego.diagnostics.retain(|d| *d != usual);
        let vehicle = match &solved.source {
            EgoSource::Solution { vehicle, .. } => vehicle.as_str(),
            _ => "",
        };
        ego.diagnostics.push(assumed(
            Severity::Note,
            format!(
                "no size given; assuming the vehicle of {}, which has the same motion, {vehicle}",
                file.display()
            ),
        ));
        ego.footprint = solved.footprint;
    }
    ego
}

/// The solutions with states that `nearmiss plan` may have written with a recording: in its folder, and where that is
/// the scenario's own, beside it.
fn candidates(recording: &Path, name: &str, version: &str) -> Vec<PathBuf> {
    let own = recording.parent();
    let above = own.filter(|folder| folder.file_name().is_some_and(|f| f == name));
    let folders = [own, above.and_then(Path::parent)];
    let mut files = Vec::new();
    for folder in folders.into_iter().flatten() {
        for model in [VehicleModel::Ks, VehicleModel::Pm] {
            for vehicle in VehicleType::ALL {
                let number = vehicle.number();
                files.push(
                    folder.join(format!("solution_{model}{number}_SM1_{name}_{version}.xml")),
                );
            }
        }
    }
    files.retain(|file| file.is_file());
    files
}

fn same_motion(a: &Track, b: &Track) -> bool {
    a.steps() == b.steps()
        && a.steps().all(|step| match (a.at(step), b.at(step)) {
            (Some(a), Some(b)) => (a.pose.position - b.pose.position).norm() < ROUNDING,
            (a, b) => a.is_none() && b.is_none(),
        })
}
