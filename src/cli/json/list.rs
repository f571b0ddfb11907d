//! The outputs of all commands that are one type each.

use super::derived::{Derived, derived};
use crate::{
    batches, bundle, describe, doctor, evaluate, export, find, generate, import, index, inspect,
    metrics, plan, prompt, prompts, runs, sample, themes_and_keys, tune,
};
use nearmiss_base::system::KeyBinding;
use nearmiss_study::evaluation::Standing;
use nearmiss_study::evaluation::batch::QuestionLine;
use nearmiss_study::evaluation::report::{AxesDocument, ReportDocument};

/// Every output that is one type.
pub const DERIVED: &[Derived] = &[
    derived::<batches::Document>(),
    derived::<generate::CheckDocument>(),
    derived::<generate::GenerateReport>(),
    derived::<generate::VariantLine>(),
    derived::<describe::Document>(),
    derived::<doctor::Document>(),
    derived::<evaluate::BatchDocument>(),
    derived::<evaluate::CollisionDocument>(),
    derived::<evaluate::SafetyDocument>(),
    derived::<evaluate::LeaksDocument>(),
    derived::<evaluate::DryRunDocument<'static>>(),
    derived::<evaluate::ListedDocument>(),
    derived::<bundle::Document>(),
    derived::<export::ChatManifest>(),
    derived::<find::FindDocument>(),
    derived::<import::Counts>(),
    derived::<index::ShowDocument>(),
    derived::<inspect::FolderLine>(),
    derived::<metrics::ListDocument>(),
    derived::<plan::ComparisonRecord>(),
    derived::<plan::CycleRecord>(),
    derived::<plan::DriveRecord>(),
    derived::<plan::MonitorDryRun>(),
    derived::<plan::NotDrivenRecord>(),
    derived::<plan::StandardErrorRecord>(),
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
