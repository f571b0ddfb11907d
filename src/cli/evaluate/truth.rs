//! What is true about the scenarios that the built-in judge is evaluated on.

use std::path::PathBuf;

use crate::cli::{Failure, output};
use crate::evaluation::Labels;
use crate::system;

/// What is true about the scenarios.
pub enum Truth {
    Geometry,
    Labels(Labels, Vec<String>),
}

/// Reads what `--truth` names.
pub fn truth(paths: &[PathBuf]) -> Result<Truth, Failure> {
    let auto = |path: &PathBuf| path.as_os_str() == "auto";
    if paths.is_empty() || (paths.len() == 1 && paths.iter().all(auto)) {
        return Ok(Truth::Geometry);
    }
    let (mut labels, mut files) = (Labels::default(), Vec::new());
    for path in paths {
        let file = path.display().to_string();
        let bytes = system::read_file(path, system::LARGEST).map_err(|e| {
            Failure::input(format!(
                "--truth {file}: {}; it takes CSV files, or `auto` alone for the exact geometry",
                system::words(&e)
            ))
        })?;
        labels.read(&bytes, &file).map_err(Failure::input)?;
        files.push(output::visible(&file));
    }
    Ok(Truth::Labels(labels, files))
}

impl Truth {
    /// What is true, in words for people.
    pub fn words(&self) -> String {
        match self {
            Self::Geometry => {
                "exact geometry of the whole recordings: real bodies that overlap at a recorded step".into()
            }
            Self::Labels(_, files) => format!("labels of {}", files.join(", ")),
        }
    }

    /// The same for programs.
    pub fn json(&self) -> serde_json::Value {
        match self {
            Self::Geometry => "geometry".into(),
            Self::Labels(_, files) => files.clone().into(),
        }
    }
}
