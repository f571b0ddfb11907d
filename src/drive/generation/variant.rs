//! The exported variant: the changed scenario under its own name, the ego's drive in it, and its certificates.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::Manifest;
use super::{
    Avoidability, ClosedLoop, Consequence, Effect, EvasiveTrajectory, JointChange, Refusal,
};
use nearmiss_formats::commonroad::{
    self, NewFile, SaveError, SolutionError, WriteError, write_solution,
};
use nearmiss_formats::write_recording;
use nearmiss_scene::scenario::identity::other_traffic;
use nearmiss_scene::scenario::{Scenario, VehicleModel};
use nearmiss_scene::verdict::Motion;

/// A change with everything that is known about it.
#[derive(Debug, Clone, Copy)]
pub struct Variant<'a> {
    /// The recorded scenario and the ego's drive in it.
    pub closed: &'a ClosedLoop,
    /// The change.
    pub change: &'a JointChange,
    /// The original's file as it was named.
    pub file: &'a str,
    /// The motions requested of the attackers, in the order of the change.
    pub asked: &'a [Motion],
    /// What it leads to.
    pub effect: &'a Effect,
    /// Whether an ideal driver avoids it.
    pub avoidability: &'a Avoidability,
    /// What was refused on the way to it.
    pub refusals: &'a [Refusal],
    /// Author: a search with its seed, or a model's id.
    pub by: &'a str,
    /// A model's choice and output, if a model is the author, stored in the manifest under `model`.
    pub author: Option<&'a Value>,
    /// What a bulk run needs to take the variant over later instead of generating it again, stored in the manifest
    /// under `made`.
    pub made: Option<&'a Value>,
}

/// The files of a variant.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VariantFiles {
    /// Its benchmark id, and the names of the files but for their endings.
    pub id: String,
    /// The changed scenario.
    pub scenario: PathBuf,
    /// The ego's drive in it as CSV, where `nearmiss` finds it when it opens the scenario.
    pub ego: PathBuf,
    /// The same as a CommonRoad solution.
    pub solution: PathBuf,
    /// Avoiding trajectories as CSV: reaction times (s) and files.
    pub avoiding: Vec<(f64, PathBuf)>,
    /// Its manifest, as JSON.
    pub document: PathBuf,
}

/// Why a variant was not saved. No part of it is left then, and whatever was there before is unchanged.
#[derive(Debug, thiserror::Error)]
pub enum VariantError {
    /// A file could not be saved.
    #[error(transparent)]
    Save(#[from] SaveError),
    /// The scenario has no XML.
    #[error(transparent)]
    Scenario(#[from] WriteError),
    /// The manifest has no JSON.
    #[error("cannot write the manifest: {0}")]
    Manifest(serde_json::Error),
    /// The ego has no CSV.
    #[error("cannot write the ego: {0}")]
    Ego(#[from] csv::Error),
    /// The ego has no solution.
    #[error("cannot write the solution: {0}")]
    Solution(#[from] SolutionError),
}

/// The tag of a dangerous scenario, and the one that denies it.
const DANGEROUS: &str = "critical";
const HARMLESS: &str = "comfort";

/// The note on all participants except ego and attackers.
pub(super) const OTHERS: &str = "other traffic as recorded; it does not react";

/// What the `source` of every variant says, and that of no other scenario.
pub const MARK: &str = "changed by nearmiss ";

/// What stands before the planner of the ego in the `source` of a variant, where that is not the built-in one.
const ATTACKED: &str = "; ego driven by planner ";

/// The planner that drives the ego of a variant, as its `source` names it; `None` for the built-in one.
#[must_use]
pub fn attacked_planner(variant: &Scenario) -> Option<&str> {
    let source = variant.header.attributes.get("source")?;
    let (_, after) = source.rsplit_once(ATTACKED)?;
    after.split(';').next()
}

/// The program that changed it.
pub(super) const PROGRAM: &str = concat!("nearmiss ", env!("CARGO_PKG_VERSION"));

/// The endings of the files after the id.
const ENDINGS: [&str; 4] = [".xml", ".ego_trajectory.csv", ".solution.xml", ".json"];

impl Variant<'_> {
    /// The first id after that of the recorded scenario under which nothing lies in `folder` yet.
    ///
    /// The same map and initial configuration with other traffic is what the number of a benchmark id's prediction
    /// counts; map and configuration are kept.
    #[must_use]
    pub fn free_id(&self, folder: &Path) -> String {
        let original = &self.closed.scenario().header.benchmark_id;
        let taken = |id: &String| {
            let mut endings = ENDINGS.iter();
            endings.any(|ending| {
                folder
                    .join(format!("{id}{ending}"))
                    .symlink_metadata()
                    .is_ok()
            })
        };
        let mut ids = (1..=u32::MAX).map(|number| other_traffic(original, number));
        let free = ids.find(|id| !taken(id));
        free.unwrap_or_else(|| other_traffic(original, u32::MAX))
    }

    /// The changed scenario with its own id, tag and provenance.
    #[must_use]
    pub fn scenario(&self, id: &str) -> Scenario {
        let mut scenario = Scenario::clone(&self.effect.scenario);
        // A planner that fails does not make a scenario dangerous.
        let harmless = matches!(
            self.effect.consequence,
            Consequence::NoEffect | Consequence::PlannerError(_)
        );
        if !harmless {
            scenario.tags.retain(|tag| tag != HARMLESS);
            if !scenario.tags.iter().any(|tag| tag == DANGEROUS) {
                scenario.tags.push(DANGEROUS.into());
            }
        }
        let source = self.provenance();
        let header = &mut scenario.header;
        header.benchmark_id = id.into();
        let said = header.attributes.entry("source".into()).or_default();
        *said = match said.trim() {
            "" => source,
            before => format!("{before}; {source}"),
        };
        scenario
    }

    /// Where it comes from, in one line.
    fn provenance(&self) -> String {
        let original = self.closed.scenario();
        let motions = self.effect.attackers.iter().map(|attacker| {
            let (id, from) = (attacker.obstacle, attacker.from);
            format!("another motion of obstacle {id} after step {from}")
        });
        let motions: Vec<String> = motions.collect();
        let external = self.closed.baseline().drive().external.as_ref();
        let planner = external.map_or(String::new(), |report| {
            format!("{ATTACKED}{}", report.named().replace(';', ","))
        });
        format!(
            "changed by {PROGRAM}: {} (SHA-256 {}) with {}, by {}{planner}; {OTHERS}",
            original.header.benchmark_id,
            original.hash,
            motions.join(" and "),
            self.by
        )
    }

    /// Saves everything in `folder`, which exists, under the benchmark id `id`: see [`VariantFiles`].
    ///
    /// Nothing is overwritten without `overwrite`. The scenario is written last, so there is none without its manifest.
    ///
    /// # Errors
    /// See [`VariantError`].
    pub fn save(
        &self,
        folder: &Path,
        id: &str,
        overwrite: bool,
    ) -> Result<VariantFiles, VariantError> {
        let path = |ending: &str| folder.join(format!("{id}{ending}"));
        let [scenario, ego, solution, document] = ENDINGS.map(path);
        let avoiding: Vec<(f64, &EvasiveTrajectory)> = self.avoiding().collect();
        let saved = VariantFiles {
            id: id.into(),
            scenario,
            ego,
            solution,
            avoiding: avoiding
                .iter()
                .map(|(delay, _)| (*delay, path(&avoiding_ending(*delay))))
                .collect(),
            document,
        };
        let driver = self.closed.driver();
        let (problem, vehicle) = (driver.problem().id, driver.settings().planner.vehicle);
        let changed = self.scenario(id);
        let drive = &self.effect.drive;
        let solved = drive.solution(&changed.header, problem, VehicleModel::Ks, vehicle)?;
        let mut files = vec![
            (&saved.ego, write_recording(problem, &drive.track())?),
            (&saved.solution, write_solution(&solved)?),
        ];
        for ((_, avoidance), (_, path)) in avoiding.iter().zip(&saved.avoiding) {
            let track = avoidance.drive.track();
            files.push((path, write_recording(problem, &track)?));
        }
        let xml = commonroad::write(&changed)?;
        files.push((&saved.scenario, xml));
        let manifest = Manifest::new(self, &saved, &files);
        let mut words = serde_json::to_vec(&manifest).map_err(VariantError::Manifest)?;
        words.push(b'\n');
        let last = files.len() - 1;
        files.insert(last, (&saved.document, words));
        save_all(&files, overwrite)?;
        Ok(saved)
    }

    /// Reaction times (s) and trajectories that avoid it.
    pub(super) fn avoiding(&self) -> impl Iterator<Item = (f64, &EvasiveTrajectory)> {
        let all = self.avoidability.certificates.iter();
        all.filter_map(|(delay, certificate)| Some((*delay, &**certificate.avoidance()?)))
    }
}

fn avoiding_ending(delay: f64) -> String {
    format!(".avoid-{delay:.1}.csv")
}

/// Saves files that belong together: all are written before the first one is put in its place.
fn save_all(files: &[(&PathBuf, Vec<u8>)], overwrite: bool) -> Result<(), SaveError> {
    let mut begun = Vec::with_capacity(files.len());
    for (path, bytes) in files {
        let mut file = NewFile::begin(path, overwrite)?;
        file.write_all(bytes).map_err(|source| SaveError::Io {
            path: (*path).clone(),
            source,
        })?;
        begun.push(file);
    }
    for (place, file) in begun.into_iter().enumerate() {
        if let Err(error) = file.finish() {
            // What was there before is gone if it was to be overwritten; new files go.
            let new = files[..place].iter().filter(|_| !overwrite);
            for (path, _) in new {
                // The first error says what to do; that a file cannot be taken back adds nothing to it.
                drop(std::fs::remove_file(path));
            }
            return Err(error);
        }
    }
    Ok(())
}
