//! The outputs of all commands that are one type each.

use super::derived::{Derived, derived, noun};
use crate::{
    ask, batches, bundle, describe, doctor, evaluate, export, find, generate, import, index,
    inspect, metrics, models, plan, prompt, prompts, sample, themes_and_keys, tune,
};
use nearmiss_base::system::KeyBinding;
use nearmiss_store::{BatchRecord, ImageRecord, QuestionRecord, RatingRecord, RunRecord, Summary};
use nearmiss_study::evaluation::batch::QuestionLine;
use nearmiss_study::evaluation::report::{AxesDocument, ReportDocument};
use nearmiss_study::evaluation::{RaterAgreement, Standing};

/// Every output that is one type.
pub const DERIVED: &[Derived] = &[
    derived::<ask::AskDocument<'static>>(),
    derived::<ask::AskDryRun<'static>>(),
    derived::<batches::Document>(),
    derived::<generate::CheckDocument>(),
    derived::<generate::GenerateReport>(),
    derived::<generate::VariantLine>(),
    derived::<describe::Document>(),
    derived::<doctor::Document>(),
    derived::<evaluate::BatchDocument>(),
    derived::<evaluate::LeaksDocument>(),
    derived::<evaluate::DryRunDocument<'static>>(),
    derived::<evaluate::ListedDocument>(),
    derived::<bundle::Document>(),
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
    derived::<prompt::Document>(),
    derived::<prompts::Document>(),
    derived::<QuestionLine>(),
    derived::<ReportDocument>(),
    derived::<AxesDocument>(),
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
