//! JSON that commands print: the version of its form, the outputs that have a schema, and how one is written.

mod schemas;

pub use nearmiss_record::{SCHEMA_VERSION, versioned};
pub use schemas::{document, keys, names};

use nearmiss_base::system::KeyBinding;
use nearmiss_record::Record;
use nearmiss_store::{BatchRecord, ImageRecord, QuestionRecord, RatingRecord, RunRecord, Summary};
use nearmiss_study::evaluation::batch::QuestionLine;
use nearmiss_study::evaluation::report::{AxesDocument, ReportDocument};
use nearmiss_study::evaluation::{RaterAgreement, Standing};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::{
    ask, batches, bundle, config, corpus, doctor, evaluate, export, find, generate, import, index,
    inspect, metrics, models, plan, prompt, prompts, tune,
};

/// Every output that is one type.
const DERIVED: &[Derived] = &[
    derived::<ask::AskDocument<'static>>(),
    derived::<ask::AskDryRun<'static>>(),
    derived::<batches::Document>(),
    derived::<generate::CheckDocument>(),
    derived::<generate::GenerateReport>(),
    derived::<generate::VariantLine>(),
    derived::<prompt::DescriptionDocument>(),
    derived::<doctor::Document>(),
    derived::<evaluate::BatchDocument>(),
    derived::<evaluate::LeaksDocument>(),
    derived::<evaluate::DryRunDocument<'static>>(),
    derived::<evaluate::ListedDocument>(),
    derived::<bundle::BundleDocument>(),
    derived::<export::ChatManifest>(),
    derived::<find::FindDocument>(),
    derived::<import::Counts>(),
    derived::<index::ShowDocument>(),
    derived::<inspect::FolderLine>(),
    derived::<inspect::ScenarioDocument<'static>>(),
    derived::<inspect::SolutionDocument<'static>>(),
    derived::<metrics::ListDocument>(),
    derived::<models::ModelLine<'static>>(),
    derived::<plan::ComparisonRecord>(),
    derived::<plan::CycleRecord>(),
    derived::<plan::DriveRecord>(),
    derived::<plan::MonitorDryRun>(),
    derived::<plan::NotDrivenRecord>(),
    derived::<plan::StandardErrorRecord>(),
    derived::<prompt::PromptDocument>(),
    derived::<prompts::Document>(),
    derived::<QuestionLine>(),
    derived::<ReportDocument>(),
    derived::<AxesDocument>(),
    derived::<corpus::SampleLine>(),
    derived::<KeyBinding>(),
    derived::<config::ThemeDocument>(),
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
struct Derived {
    name: &'static str,
    title: &'static str,
    common_words: bool,
    schema: fn() -> Value,
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

impl Output for QuestionLine {
    const NAME: &'static str = "evaluate-questions";
    const TITLE: &'static str = "`evaluate --dry-run=questions`: one question a line";
}

impl Output for ReportDocument {
    const NAME: &'static str = "report";
    const TITLE: &'static str = "`report --format json`: tables of stored or recorded answers";
}

impl Output for AxesDocument {
    const NAME: &'static str = "report-axes";
    const TITLE: &'static str =
        "`report --rows AXIS --format json`: a measure over axes, and differences from a baseline";
}

impl Output for KeyBinding {
    const NAME: &'static str = "config-keys";
    const TITLE: &'static str = "`config keys --format json`: one action a line";
}
