//! Outputs that are one type each: what is written and what the schema says come from the same fields.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::{
    ask, batches, describe, doctor, evaluate, experiment, export, find, generate, import, inspect,
    metrics, models, plan, prompt,
};
use crate::{index, prompts, sample, themes_and_keys, tune};
use nearmiss_base::system::KeyBinding;
use nearmiss_record::Record;
use nearmiss_store::{BatchRecord, ImageRecord, QuestionRecord, RatingRecord, RunRecord, Summary};
use nearmiss_study::evaluation::batch::QuestionLine;
use nearmiss_study::evaluation::{RaterAgreement, Standing};

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

/// A noun from outside the commands.
const fn noun<T: Record>() -> Derived {
    Derived {
        name: T::NAME,
        title: T::TITLE,
        common_words: false,
        schema: nearmiss_record::schema::<T>,
    }
}

/// Every output that is one type.
pub const DERIVED: &[Derived] = &[
    derived::<ask::AskDocument<'static>>(),
    derived::<ask::AskDryRun<'static>>(),
    derived::<batches::Document>(),
    derived::<generate::CheckDocument>(),
    derived::<describe::Document>(),
    derived::<doctor::Document>(),
    derived::<evaluate::DryRunDocument<'static>>(),
    derived::<evaluate::ListedDocument>(),
    derived::<experiment::Document>(),
    derived::<export::ChatManifest>(),
    derived::<find::FindDocument>(),
    derived::<import::Counts>(),
    derived::<index::ShowDocument>(),
    derived::<inspect::FolderLine>(),
    derived::<inspect::ScenarioDocument<'static>>(),
    derived::<inspect::SolutionDocument<'static>>(),
    derived::<metrics::ListDocument>(),
    derived::<models::ModelLine<'static>>(),
    derived::<plan::MonitorDryRun<'static>>(),
    derived::<prompt::Document>(),
    derived::<prompts::Document>(),
    derived::<QuestionLine>(),
    derived::<sample::SampleLine>(),
    derived::<KeyBinding>(),
    derived::<themes_and_keys::ThemeDocument>(),
    derived::<tune::TuneDocument>(),
    derived::<tune::TuneDryRunDocument>(),
    noun::<BatchRecord<'static>>(),
    noun::<ImageRecord<'static>>(),
    noun::<QuestionRecord<'static>>(),
    noun::<RatingRecord<'static>>(),
    noun::<RaterAgreement>(),
    noun::<RunRecord<'static>>(),
    noun::<Standing>(),
    noun::<Summary>(),
];

impl Output for QuestionLine {
    const NAME: &'static str = "evaluate-questions";
    const TITLE: &'static str = "`evaluate --questions`: one question a line";
}

impl Output for KeyBinding {
    const NAME: &'static str = "keys";
    const TITLE: &'static str = "`keys --json`: one action a line";
}
