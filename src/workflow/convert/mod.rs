//! Scenarios in other formats: the files of one, what is said of it, and how the files get into their places.

mod formats;
mod part;
mod target;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::system::{NewFile, SaveError, escaped_xml};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::Settings;
use nearmiss_formats::{Entry, VariedMotion};
use nearmiss_scene::scenario::{Ego, Scenario, Scene};

use super::journal::holds;
use super::{SimulatedEgo, scene_to_export};
use formats::{READING, commonroad, commonroad_2018b, ego_beside, openscenario, tables};

pub use part::Part;
pub use target::{ENDINGS, ROADS, Target, ends_with};

/// A scenario, and what it is written as.
#[derive(Debug, Clone, Copy)]
pub struct ConvertRequest<'a> {
    /// Where it is from.
    pub entry: &'a Entry,
    /// What it is written as.
    pub target: Target,
    /// The file; `None` where it is printed.
    pub file: Option<&'a Path>,
    /// What of it is written.
    pub part: &'a Part,
    /// Its ego; CommonRoad has the recorded one beside it unless the scenario was opened with another.
    pub ego: &'a SimulatedEgo,
    /// Whether CommonRoad 2020a is made to fit its schema.
    pub to_schema: bool,
}

/// A scenario as it is written.
#[derive(Debug, Default)]
pub struct Converted {
    /// In the order in which they are written.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// For standard output.
    pub printed: Option<String>,
    /// What is said of it: what the format has no place for, and what was noted while it was read.
    pub said: Vec<String>,
    /// Whether it fits the schema.
    pub fits: bool,
}

impl Converted {
    /// A file, or what is printed where there is none.
    fn add(&mut self, file: Option<PathBuf>, bytes: Vec<u8>) {
        match file {
            Some(path) => self.files.push((path, bytes)),
            None => self.printed = Some(escaped_xml(&String::from_utf8_lossy(&bytes))),
        }
    }
}

/// Reads a scenario and makes its files; none where `cancel` asked for an end. `settings` is how egos are planned.
///
/// # Errors
/// The scenario cannot be read or written so, or has no such ego or part: in words that begin with the file.
pub fn convert(
    request: &ConvertRequest<'_>,
    settings: impl FnOnce() -> Result<Settings, String>,
    cancel: &Cancel,
) -> Result<Converted, String> {
    request.check()?;
    let ConvertRequest { entry, ego, .. } = *request;
    if request.target.has_ego() {
        return match scene_to_export(entry, ego, &settings()?, cancel)? {
            Some((scenario, ego)) => made(request, scenario, ego),
            None => Ok(Converted::default()),
        };
    }
    let scenario = entry.read().map_err(|error| error.to_string())?;
    let mut unread = None;
    let recorded = entry.recorded_ego(&scenario).unwrap_or_else(|error| {
        unread = Some(format!("{}: the ego is left out: {error}", entry.name));
        None
    });
    let mut converted = made(request, scenario, recorded)?;
    converted.said.splice(0..0, unread);
    Ok(converted)
}

/// Makes the files of a scenario that is open, with the ego that is asked for. What was noted while it was read is not said
/// again.
///
/// # Errors
/// It cannot be written so: in words that begin with the file.
pub fn convert_opened(
    request: &ConvertRequest<'_>,
    scenario: Arc<Scenario>,
    ego: Option<Ego>,
) -> Result<Converted, String> {
    request.check()?;
    let mut converted = made(request, scenario, ego)?;
    let noted = format!("{}: {READING}", request.entry.name);
    converted.said.retain(|said| !said.starts_with(&noted));
    Ok(converted)
}

/// Makes the files of a scene for simulators, in which the motion of an obstacle follows from parameters.
///
/// # Errors
/// It cannot be written so: in words that begin with the file.
pub fn convert_varied(
    request: &ConvertRequest<'_>,
    scene: &Scene,
    varied: &VariedMotion,
) -> Result<Converted, String> {
    request.check()?;
    let (scenario, ego) = (Arc::clone(&scene.scenario), Some(scene.ego.clone()));
    openscenario(request, scenario, ego, Some(varied))
}

fn made(
    request: &ConvertRequest<'_>,
    scenario: Arc<Scenario>,
    ego: Option<Ego>,
) -> Result<Converted, String> {
    match request.target {
        Target::CommonRoad => commonroad(request, scenario, ego),
        Target::CommonRoad2018b => commonroad_2018b(request, scenario, ego),
        Target::OpenScenario => openscenario(request, scenario, ego, None),
        Target::Tracks | Target::Interaction | Target::HighD => tables(request, scenario, ego),
    }
}

/// Why files are not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// It is a scenario that was read.
    #[error("{}: is one of the input scenarios and is not overwritten; name another file", .0.display())]
    Input(PathBuf),
    /// It cannot be saved.
    #[error(transparent)]
    Save(#[from] SaveError),
}

impl ConvertRequest<'_> {
    /// Refuses to print several files.
    fn check(&self) -> Result<(), &'static str> {
        match (self.file, self.target) {
            (None, Target::OpenScenario) => {
                Err("OpenSCENARIO is two files; name the first one or a folder: -o FILE.xosc")
            }
            (None, Target::HighD) => Err(
                "highD is three files; name the one of the tracks or a folder: -o 01_tracks.csv",
            ),
            _ => Ok(()),
        }
    }

    /// Whether a file is the scenario's own, and all of it is written: of CommonRoad, as CommonRoad.
    fn rewrites(&self, path: &Path) -> bool {
        let is_whole = self.target == Target::CommonRoad && self.part.is_whole();
        let whole = |path: &Path| path.canonicalize().ok();
        let own = || self.entry.file().and_then(|own| whole(&own));
        is_whole && path.exists() && own() == whole(path) && !self.entry.is_recording()
    }

    /// Puts the files in their places: all are begun before one is there, so that none is left without the others. A file
    /// that is there with the same bytes stays where a run `resumes`. What `is_input` is never replaced, but for a whole
    /// CommonRoad file that is written as such in its own place.
    ///
    /// # Errors
    /// See [`WriteError`].
    pub fn save(
        &self,
        files: &[(PathBuf, Vec<u8>)],
        overwrite: bool,
        resumes: bool,
        is_input: impl Fn(&Path) -> bool,
    ) -> Result<(), WriteError> {
        let own_ego = self.file.map(ego_beside);
        let mut begun = Vec::new();
        for (path, bytes) in files.iter().rev() {
            // A scenario that is rewritten in its place has its ego already.
            let may_hold = resumes || Some(path) == own_ego.as_ref();
            if may_hold && holds(path, bytes) {
                continue;
            }
            if is_input(path) && !self.rewrites(path) {
                return Err(WriteError::Input(path.clone()));
            }
            let mut file = NewFile::begin(path, overwrite)?;
            file.write_all(bytes).map_err(|source| SaveError::Io {
                path: path.clone(),
                source,
            })?;
            begun.push(file);
        }
        for file in begun.into_iter().rev() {
            file.finish()?;
        }
        Ok(())
    }
}
