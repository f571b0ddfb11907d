//! The outputs of all commands that are one type each.

use super::derived::{Derived, derived};
use crate::{
    batches, describe, doctor, evaluate, experiment, export, find, generate, import, index,
    inspect, metrics, prompt, prompts, runs, sample, themes_and_keys, tune,
};
use nearmiss_base::system::KeyBinding;
use nearmiss_study::evaluation::Standing;
use nearmiss_study::evaluation::batch::QuestionLine;

/// Every output that is one type.
pub const DERIVED: &[Derived] = &[
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
    derived::<metrics::ListDocument>(),
    derived::<prompt::Document>(),
    derived::<prompts::Document>(),
    derived::<QuestionLine>(),
    derived::<Standing>(),
    derived::<runs::RunLine<'static>>(),
    derived::<sample::SampleLine>(),
    derived::<KeyBinding>(),
    derived::<themes_and_keys::ThemeDocument>(),
    derived::<tune::TuneDocument>(),
    derived::<tune::TuneDryRunDocument>(),
];
