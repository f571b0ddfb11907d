//! Verifies what lies beside a saved variant: its files are the ones that were written, and the good driver of each
//! certificate touches nothing.

use std::path::Path;

use super::{OpenRequest, PlanRequest, VariantOrigin, prepare};
use nearmiss_base::system;
use nearmiss_drive::planner::{self, Cancel, Forecast};
use nearmiss_drive::simulation::{Settings, TrafficMode};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::description::visible;
use nearmiss_scene::scenario::ContentHash;

/// What was verified of a variant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VariantProofs {
    /// Files whose SHA-256 the manifest names.
    pub files: usize,
    /// What is wrong with them.
    pub changed: Vec<String>,
    /// The certificates, the shortest reaction time first.
    pub certificates: Vec<VerifiedCertificate>,
}

/// The drive of a good driver, looked at anew.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VerifiedCertificate {
    /// Reaction time of the driver, seconds.
    pub delay: String,
    /// The file of the drive.
    pub file: String,
    /// Steps of the drive; or why it proves nothing.
    pub result: Result<usize, String>,
}

impl VariantProofs {
    /// Whether all of it holds.
    #[must_use]
    pub fn hold(&self) -> bool {
        self.changed.is_empty() && self.certificates.iter().all(|c| c.result.is_ok())
    }
}

/// Verifies a variant by the manifest beside it; `None` where there is none.
///
/// Contact is looked for at and between the steps of each drive, with exact bodies; leaving the road counts as well.
/// Whether the vehicle can be driven so is not verified again.
#[must_use]
pub fn verify_variant(variant: &Path) -> Option<VariantProofs> {
    let entry = Entry::of_file(variant);
    let origin = VariantOrigin::of(&entry)?;
    let folder = variant.parent().unwrap_or(Path::new(""));
    let hashes = &origin.manifest.sha256;
    let changed = hashes.iter().filter_map(|(name, hash)| {
        // A name that leads elsewhere is none.
        let name = Path::new(name).file_name()?;
        is_unchanged(&folder.join(name), hash).err()
    });
    let certificates = origin.certificates().map(|(delay, name)| {
        let path = delay
            .parse()
            .ok()
            .and_then(|d: f64| origin.certificate(Some(d)));
        VerifiedCertificate {
            delay: visible(delay).into_owned(),
            file: visible(name).into_owned(),
            result: match path {
                Some((_, path)) => drive(&entry, &origin, &path),
                None => Err("no such file".into()),
            },
        }
    });
    Some(VariantProofs {
        files: hashes.len(),
        changed: changed.collect(),
        certificates: certificates.collect(),
    })
}

/// The number of steps of a drive that touches nothing.
fn drive(entry: &Entry, origin: &VariantOrigin, path: &Path) -> Result<usize, String> {
    let mut planner = planner::Settings::default();
    planner.vehicle = origin.vehicle().unwrap_or(planner.vehicle);
    let settings = Settings {
        planner,
        forecast: Forecast::Lane,
        replan: 1,
        without: None,
        traffic: TrafficMode::Recorded,
    };
    let ego = EgoSelection::File {
        path: path.to_owned(),
        planning_problem: None,
    };
    let open = OpenRequest {
        entry,
        ego: &ego,
        transform: None,
        strict: true,
    };
    let prepared = prepare(&PlanRequest {
        open,
        problem: Some(origin.manifest.planning.problem),
        settings: &settings,
    })
    .map_err(|error| error.to_string())?;
    let Some(scene) = &prepared.recorded else {
        return Err("no drive in it".into());
    };
    let driver = prepared
        .driver(&prepared.scenario, &Cancel::default())
        .map_err(|error| error.to_string())?;
    match driver.fault_of(&prepared.scenario, &scene.ego.track) {
        Some(fault) => Err(fault.to_string()),
        None => Ok(scene.ego.track.steps().count()),
    }
}

/// Whether a file is there, and still has the content with this SHA-256.
///
/// # Errors
/// It is not, or cannot be read.
pub fn is_unchanged(path: &Path, hash: &str) -> Result<(), String> {
    let named = |words: &str| format!("{}: {words}", path.display());
    let bytes =
        system::read_file(path, system::LARGEST).map_err(|e| named(&system::error_text(&e)))?;
    if ContentHash::digest(&bytes).to_string() == hash {
        Ok(())
    } else {
        Err(named("it was changed after generation"))
    }
}
