//! Ground truth of the scenarios on which the built-in judge is evaluated.

use crate::{Failure, output};
use nearmiss_formats::Entry;
use nearmiss_study::evaluation::batch::{self, TruthSource};

/// Ground truth of the scenarios, and its source.
pub struct Truth {
    source: TruthSource,
    pub known: batch::Truth,
}

impl Truth {
    /// Reads what `--truth` names; what is doubtful about these scenarios is said.
    pub fn read(source: Option<TruthSource>, entries: &[Entry]) -> Result<Self, Failure> {
        let source = source.unwrap_or(TruthSource::Geometry);
        let (known, doubts) = batch::Truth::open(&source, entries).map_err(Failure::input)?;
        say_each(&doubts);
        Ok(Self { source, known })
    }

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
            output::visible(&self.source.summary())
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
