//! What is true about the scenarios that the built-in judge is evaluated on.

use std::path::PathBuf;

use super::batch::absolute;
use crate::cli::{Failure, output};
use crate::evaluation::batch::{self, TruthSource};
use crate::evaluation::{Label, LabelError, Labels};
use crate::scenario::{Entry, Scenario};
use crate::system;

/// What is true about the scenarios.
pub enum Truth {
    Geometry,
    /// The scenarios' folders, with the annotations beside them.
    Layout(batch::Truth),
    Labels(Labels, Vec<String>),
}

/// Reads what `--truth` names; what is doubtful about these scenarios is said.
pub fn truth(paths: &[PathBuf], entries: &[Entry]) -> Result<Truth, Failure> {
    match paths {
        [] => return Ok(Truth::Geometry),
        [only] if only.as_os_str() == "auto" => return Ok(Truth::Geometry),
        [only] if only.as_os_str() == "layout" => {
            let opened = batch::Truth::open(&TruthSource::Layout, entries);
            let (truth, doubts) = opened.map_err(Failure::input)?;
            say_each(&doubts);
            return Ok(Truth::Layout(truth));
        }
        _ => {}
    }
    let (mut labels, mut files) = (Labels::default(), Vec::new());
    for path in paths {
        let file = path.display().to_string();
        let bytes = system::read_file(path, system::LARGEST).map_err(|e| {
            Failure::input(format!(
                "--truth {file}: {}; it takes CSV files, or auto (exact geometry) or layout (folders) alone",
                system::words(&e)
            ))
        })?;
        labels.read(&bytes, &file).map_err(Failure::input)?;
        files.push(output::visible(&file));
    }
    if let Some(strangers) = labels.strangers(entries.iter().map(|e| e.name.as_str())) {
        output::say(&format!("nearmiss: {}", output::visible(&strangers)));
    }
    Ok(Truth::Labels(labels, files))
}

impl Truth {
    /// What is said to be true about a scenario; nothing where it is unknown.
    pub fn of(&self, entry: &Entry) -> Option<Label> {
        match self {
            Self::Geometry => None,
            Self::Layout(truth) => truth.of(entry, None),
            Self::Labels(labels, _) => labels.of(&entry.name),
        }
    }

    /// Whether the label of an entry can be of its scenario.
    pub fn fits(&self, entry: &Entry, scenario: &Scenario) -> Result<(), LabelError> {
        match self {
            Self::Labels(labels, _) => labels.fit(&entry.name, scenario),
            Self::Geometry | Self::Layout(_) => Ok(()),
        }
    }

    /// What is true, in words for people.
    pub fn words(&self) -> String {
        match self {
            Self::Geometry => {
                "exact geometry of the whole recordings: real bodies that overlap at a recorded step".into()
            }
            Self::Layout(_) => TruthSource::Layout.words(),
            Self::Labels(_, files) => format!("labels of {}", files.join(", ")),
        }
    }

    /// The same for programs.
    pub fn json(&self) -> serde_json::Value {
        match self {
            Self::Geometry => "geometry".into(),
            Self::Layout(_) => "layout".into(),
            Self::Labels(_, files) => files.clone().into(),
        }
    }
}

/// What is said about the truth; nothing where nothing is.
pub fn truth_source(said: &[PathBuf]) -> Result<Option<TruthSource>, Failure> {
    let word = |word: &str| said.iter().any(|path| path.as_os_str() == word);
    Ok(match said {
        [] => None,
        [_] if word("auto") => Some(TruthSource::Geometry),
        [_] if word("layout") => Some(TruthSource::Layout),
        files => {
            let files = files.iter().map(|file| absolute(file));
            Some(TruthSource::Files(files.collect::<Result<_, _>>()?))
        }
    })
}

/// What is doubtful, as far as there is room for it.
pub fn say_each(doubts: &[String]) {
    for doubt in doubts.iter().take(NAMED) {
        output::say(&format!("nearmiss: {doubt}"));
    }
    if doubts.len() > NAMED {
        let more = doubts.len() - NAMED;
        output::say(&format!("nearmiss: {more} more of this kind"));
    }
}

/// Doubts that are named each.
const NAMED: usize = 10;
