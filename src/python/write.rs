//! Scenarios as files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_drive::planner::Cancel;
use nearmiss_formats::commonroad::SaveError;
use nearmiss_workflow::convert::{
    ConvertRequest, ENDINGS, Part, Target, WriteError, convert_opened,
};
use pyo3::prelude::*;

use crate::errors::Problem;
use crate::files::warn;
use crate::scenario::Scenario;
use crate::work;

/// What messages call options of the command, and how they are called here.
const OPTIONS: [(&str, &str); 2] = [
    ("; --schema ", "; `nearmiss convert --schema` "),
    ("; --map FILE ", "; open(…, map=FILE) "),
];

/// Writes a scenario in the format of the file's ending; what it says is a warning each.
pub fn write(py: Python<'_>, own: &Scenario, path: PathBuf, overwrite: bool) -> PyResult<()> {
    let own = own.clone();
    let said = work::run(py, move |cancel| own.written(&path, overwrite, cancel))??;
    said.iter().try_for_each(|words| {
        let words = OPTIONS.iter().fold(words.clone(), |words, (option, here)| {
            words.replace(option, here)
        });
        warn(py, &words)
    })
}

impl Scenario {
    fn written(
        &self,
        path: &Path,
        overwrite: bool,
        cancel: &Cancel,
    ) -> Result<Vec<String>, Problem> {
        let target = Target::of_ending(path).ok_or_else(|| {
            Problem::new(format!(
                "{}: no ending of a scenario: {ENDINGS}",
                path.display()
            ))
        })?;
        let request = ConvertRequest {
            entry: &self.entry,
            target,
            file: Some(path),
            part: &Part::default(),
            ego: &self.asked,
            to_schema: false,
        };
        let (scenario, ego) = match &self.opened {
            Ok(scene) if !self.stands_in => (&scene.scenario, Some(scene.ego.clone())),
            _ => (&self.scenario, None),
        };
        let made = convert_opened(&request, Arc::clone(scenario), ego)?;
        if cancel.is_asked() {
            return Err(Problem::new("interrupted"));
        }
        let own = self.entry.file().and_then(|own| own.canonicalize().ok());
        let is_own = |file: &Path| own.is_some() && file.canonicalize().ok() == own;
        let saved = request.save(&made.files, overwrite, false, is_own);
        saved.map_err(|error| match error {
            WriteError::Save(SaveError::Exists(_)) => {
                Problem::new(format!("{error} (overwrite=True)"))
            }
            _ => Problem::new(error),
        })?;
        Ok(made.said)
    }
}
