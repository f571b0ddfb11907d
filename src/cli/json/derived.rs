//! Outputs that are one type each: what is written and what the schema says come from the same fields.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::{
    batches, describe, doctor, evaluate, experiment, export, find, generate, import, inspect,
    metrics, prompt,
};
use crate::{index, prompts, runs, sample, themes_and_keys, tune};
use nearmiss_base::system::KeyBinding;
use nearmiss_study::evaluation::Standing;
use nearmiss_study::evaluation::batch::QuestionLine;
use nearmiss_study::evaluation::report::{AxesDocument, ReportDocument};

/// An output of a command as one type. Fields without a doc comment have the meaning that the vocabulary gives their key.
pub trait Output: Serialize + JsonSchema {
    /// Its name in `nearmiss help json`.
    const NAME: &'static str;
    /// What it is, in one line.
    const TITLE: &'static str;
    /// Whether keys of the vocabulary have its words, whatever the fields say: for types from outside the commands.
    const COMMON_WORDS: bool = false;

    /// The object that is written.
    ///
    /// # Errors
    /// A map in it has keys that JSON does not allow.
    fn document(&self) -> serde_json::Result<Value> {
        serde_json::to_value(self)
    }
}

/// An output with its schema.
pub struct Derived {
    pub name: &'static str,
    pub title: &'static str,
    pub common_words: bool,
    pub schema: fn() -> Value,
}

const fn derived<T: Output>() -> Derived {
    Derived {
        name: T::NAME,
        title: T::TITLE,
        common_words: T::COMMON_WORDS,
        schema: nearmiss_record::schema::<T>,
    }
}

/// Every output that is one type.
pub const DERIVED: &[Derived] = &[
    derived::<batches::Document>(),
    derived::<generate::CheckDocument>(),
    derived::<describe::Document>(),
    derived::<doctor::Document>(),
    derived::<evaluate::BatchDocument>(),
    derived::<evaluate::CollisionDocument>(),
    derived::<evaluate::LeaksDocument>(),
    derived::<evaluate::SafetyDocument>(),
    derived::<evaluate::DryRunDocument<'static>>(),
    derived::<evaluate::ListedDocument>(),
    derived::<experiment::Document>(),
    derived::<export::ChatManifest>(),
    derived::<find::FindDocument>(),
    derived::<import::Counts>(),
    derived::<index::ShowDocument>(),
    derived::<inspect::FolderLine>(),
    derived::<metrics::ListDocument>(),
    derived::<prompt::Document>(),
    derived::<prompts::Document>(),
    derived::<QuestionLine>(),
    derived::<Standing>(),
    derived::<ReportDocument>(),
    derived::<AxesDocument>(),
    derived::<runs::RunLine<'static>>(),
    derived::<sample::SampleLine>(),
    derived::<KeyBinding>(),
    derived::<themes_and_keys::ThemeDocument>(),
    derived::<tune::TuneDocument>(),
    derived::<tune::TuneDryRunDocument>(),
];

impl Output for QuestionLine {
    const NAME: &'static str = "evaluate-questions";
    const TITLE: &'static str = "`evaluate --questions`: one question a line";
}

impl Output for ReportDocument {
    const NAME: &'static str = "report";
    const TITLE: &'static str = "`report --json`: tables of stored or recorded answers";
}

impl Output for AxesDocument {
    const NAME: &'static str = "report-axes";
    const TITLE: &'static str =
        "`report --rows AXIS --json`: a measure over axes, and differences from a baseline";
}

impl Output for Standing {
    const NAME: &'static str = "ratings";
    const TITLE: &'static str = "`ratings --json`: one model or prompt a line";
}

impl Output for KeyBinding {
    const NAME: &'static str = "keys";
    const TITLE: &'static str = "`keys --json`: one action a line";
}
