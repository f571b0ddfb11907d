//! Ground truth of the scenarios on which the built-in judge is evaluated.

use std::path::{Path, PathBuf};

use crate::{Failure, output};
use nearmiss_formats::Entry;
use nearmiss_study::evaluation::batch::{self, TruthSource};

/// Ground truth of the scenarios, and its source.
pub struct Truth {
    source: TruthSource,
    pub known: batch::Truth,
}

/// Reads what `--truth` names; what is doubtful about these scenarios is said.
pub fn truth(paths: &[PathBuf], entries: &[Entry]) -> Result<Truth, Failure> {
    let source = source(paths, |file| Ok(file.to_path_buf()))?.unwrap_or(TruthSource::Geometry);
    let (known, doubts) = batch::Truth::open(&source, entries).map_err(Failure::input)?;
    say_each(&doubts);
    Ok(Truth { source, known })
}

impl Truth {
    /// Whether it is the exact geometry.
    pub fn is_geometry(&self) -> bool {
        self.source == TruthSource::Geometry
    }

    /// Whether it is the layout of the folders.
    pub fn is_layout(&self) -> bool {
        self.source == TruthSource::Layout
    }

    /// Describes the ground truth for people.
    pub fn words(&self) -> String {
        if self.is_geometry() {
            "exact geometry of the recordings: bodies touch at a recorded step or between two"
                .into()
        } else {
            output::visible(&self.source.words())
        }
    }

    /// The same for programs.
    pub fn json(&self) -> serde_json::Value {
        match &self.source {
            TruthSource::Geometry => "geometry".into(),
            TruthSource::Layout => "layout".into(),
            TruthSource::Score(convention) => TruthSource::word_of_score(*convention).into(),
            files @ TruthSource::Files(_) => {
                let files = files.sources();
                files.iter().map(|file| output::visible(file)).collect()
            }
        }
    }
}

/// Where `--truth` says that the truth of a batch is from; `None` if it says nothing.
pub fn truth_source(said: &[PathBuf]) -> Result<Option<TruthSource>, Failure> {
    source(said, |file| {
        std::path::absolute(file).map_err(|error| Failure::system(file.display(), &error))
    })
}

fn source(
    said: &[PathBuf],
    path: impl Fn(&Path) -> Result<PathBuf, Failure>,
) -> Result<Option<TruthSource>, Failure> {
    let word = |word: &str| said.iter().any(|path| path.as_os_str() == word);
    let score = match said {
        [one] => one.to_str().and_then(TruthSource::score),
        _ => None,
    };
    Ok(match said {
        _ if score.is_some() => score.map(TruthSource::Score),
        [] => None,
        [_] if word("auto") => Some(TruthSource::Geometry),
        [_] if word("layout") => Some(TruthSource::Layout),
        files => {
            let files = files.iter().map(|file| path(file));
            Some(TruthSource::Files(files.collect::<Result<_, _>>()?))
        }
    })
}

/// Prints warnings, as far as there is room.
pub fn say_each(doubts: &[String]) {
    for doubt in doubts.iter().take(NAMED) {
        output::say(&format!("nearmiss: {doubt}"));
    }
    if doubts.len() > NAMED {
        let more = doubts.len() - NAMED;
        output::say(&format!("nearmiss: {more} more like this"));
    }
}

/// Doubts that are named each.
const NAMED: usize = 10;
