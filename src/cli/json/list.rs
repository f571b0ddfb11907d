//! The outputs of all commands that are one type each.

use nearmiss_base::system::KeyBinding;
use nearmiss_drive::driver::DriverRecord;
use nearmiss_store::{BatchRecord, ImageRecord, QuestionRecord, RatingRecord, RunRecord, Summary};
use nearmiss_study::evaluation::batch::QuestionLine;
use nearmiss_study::evaluation::report::{AxesDocument, ReportDocument};
use nearmiss_study::evaluation::{RaterAgreement, Standing};

use nearmiss_workflow::annex::AnnexRecord;
use nearmiss_workflow::drive::DriveRecord;
use nearmiss_workflow::variant::VariantLine;
use nearmiss_workflow::{AskDocument, EventLine, Rate, RateLike, ScenarioRow};

use super::derived::{Derived, derived, noun};
use crate::{
    ask, batches, bundle, config, corpus, doctor, evaluate, export, find, generate, import, index,
    inspect, metrics, models, plan, prompt, prompts, tune,
};

/// Every output that is one type.
pub const DERIVED: &[Derived] = &[
    derived::<AskDocument<'static>>(),
    derived::<ask::AskDryRun<'static>>(),
    derived::<batches::Document>(),
    derived::<generate::CheckDocument>(),
    derived::<generate::GenerateReport>(),
    derived::<VariantLine>(),
    derived::<prompt::DescriptionDocument>(),
    derived::<doctor::Document>(),
    derived::<DriverRecord>(),
    derived::<evaluate::BatchDocument>(),
    derived::<evaluate::LeaksDocument>(),
    derived::<evaluate::DryRunDocument<'static>>(),
    derived::<evaluate::ListedDocument>(),
    derived::<bundle::BundleDocument>(),
    derived::<export::ChatManifest>(),
    derived::<find::FindDocument>(),
    derived::<import::Counts>(),
    derived::<index::ShowDocument>(),
    derived::<inspect::DifferenceDocument>(),
    derived::<inspect::ScenarioDocument<'static>>(),
    derived::<inspect::SolutionDocument<'static>>(),
    derived::<metrics::ListDocument>(),
    derived::<models::ModelLine<'static>>(),
    derived::<plan::ComparisonRecord>(),
    derived::<plan::CycleRecord>(),
    derived::<DriveRecord>(),
    derived::<plan::MonitorDryRun>(),
    derived::<plan::NotDrivenRecord>(),
    derived::<plan::StandardErrorRecord>(),
    derived::<prompt::PromptDocument>(),
    derived::<prompts::Document>(),
    derived::<prompt::StoryDocument>(),
    derived::<QuestionLine>(),
    derived::<ReportDocument>(),
    derived::<AxesDocument>(),
    derived::<corpus::SampleLine>(),
    derived::<KeyBinding>(),
    derived::<config::ThemeDocument>(),
    derived::<tune::TuneDocument>(),
    derived::<tune::TuneDryRunDocument>(),
    noun::<AnnexRecord>(),
    noun::<BatchRecord<'static>>(),
    noun::<EventLine>(),
    noun::<ImageRecord<'static>>(),
    noun::<QuestionRecord<'static>>(),
    noun::<RatingRecord<'static>>(),
    noun::<Rate>(),
    noun::<RateLike>(),
    noun::<RaterAgreement>(),
    noun::<RunRecord<'static>>(),
    noun::<Standing>(),
    noun::<ScenarioRow>(),
    noun::<Summary>(),
];
