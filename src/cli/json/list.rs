//! The outputs of all commands that are one type each.

use nearmiss_base::system::KeyBinding;
use nearmiss_drive::driver::DriverRecord;
use nearmiss_store::{BatchRecord, ImageRecord, QuestionRecord, RatingRecord, RunRecord, Summary};
use nearmiss_study::evaluation::batch::QuestionLine;
use nearmiss_study::evaluation::claims::{AgreementRow, SentenceRecord};
use nearmiss_study::evaluation::report::{AxesDocument, ReportDocument};
use nearmiss_study::evaluation::{RaterAgreement, Standing};

use nearmiss_workflow::annex::AnnexRecord;
use nearmiss_workflow::drive::DriveRecord;
use nearmiss_workflow::variant::VariantLine;
use nearmiss_workflow::{AskDocument, EventLine, Rate, RateLike, ScenarioRow};

use super::derived::{Derived, Output, derived, noun};
use crate::{
    ask, batches, bundle, config, corpus, doctor, evaluate, export, find, generate, import, index,
    inspect, metrics, models, plan, prompt, prompts, tune,
};

/// Gives outputs that are one type their names and what they are, in one line, and lists all of them.
macro_rules! outputs {
    ($($type:ty = $name:literal: $title:literal;)+ $(+ $more:expr;)+) => {
        $(impl Output for $type {
            const NAME: &'static str = $name;
            const TITLE: &'static str = $title;
        })+

        /// Every output that is one type.
        pub const DERIVED: &[Derived] = &[$(derived::<$type>(),)+ $($more,)+];
    };
}

outputs! {
    AskDocument<'_> = "ask": "`ask --format json`: one answer";
    SentenceRecord = "check": "`check --format json`: a sentence with its claims a line";
    crate::check::TraceRecord = "check-traces": "`check FILE.jsonl --format json`: a sentence of a text a line";
    AgreementRow = "check-labelled": "`check --labelled --format json`: sentences of a style a line";
    ask::AskDryRun<'_> = "ask-dry-run": "`ask --dry-run --format json`: what a question would take";
    batches::Document = "runs-batches": "`runs batches --format json`: one batch at a provider a line";
    generate::CheckDocument = "generate-check": "`generate --check --format json`: a variant against its original";
    generate::GenerateReport = "generate-report": "`generate --report`: summary of all scenarios";
    VariantLine = "generate": "`generate --format json`: one scenario a line";
    prompt::DescriptionDocument = "prompt-describe":
        "`prompt describe --format json`: a description and the source of its numbers";
    doctor::Document = "doctor": "`doctor --format json`: findings of the check";
    evaluate::BatchDocument = "evaluate":
        "`evaluate --format json`: the table of a batch, or of the built-in judge alone";
    evaluate::LeaksDocument = "evaluate-leaks":
        "`evaluate --dry-run=leaks --format json`: what the surface of the questions tells";
    evaluate::DryRunDocument<'_> = "evaluate-dry-run": "`evaluate --dry-run --format json`: what would be asked";
    evaluate::ListedDocument = "evaluate-list": "`evaluate list --format json`: one stored batch a line";
    bundle::BundleDocument = "runs-import-dry-run":
        "`runs import BUNDLE --dry-run --format json`: the manifest of a bundle";
    export::ChatManifest = "runs-export-chat": "`runs export --format chat`: manifest.json beside the examples";
    find::FindDocument = "corpus-find": "`corpus find --format json`: terms and the windows that fit them";
    import::Counts = "runs-import": "`runs import --format json`: counts";
    index::ShowDocument = "corpus-show": "`corpus show --format json`: windows by manoeuvre, road and severity";
    inspect::DifferenceDocument = "inspect-diff": "`inspect A B --diff --format json`: what differs";
    inspect::ScenarioDocument<'_> = "inspect": "`inspect FILE --format json`: a scenario";
    inspect::SolutionDocument<'_> = "inspect-solution": "`inspect SOLUTION --format json`: a solution";
    metrics::ListDocument = "metrics-list": "`metrics --list --format json`: one measure a line";
    models::ModelLine<'_> = "models": "`models --format json`: one model a line";
    plan::ComparisonRecord = "plan-comparison": "`plan --planner A --planner B --format json`: the last line";
    plan::CycleRecord = "plan-log": "`plan --log`: one planning cycle a line";
    DriveRecord = "plan": "`plan --format json`: one drive a line";
    plan::MonitorDryRun = "plan-dry-run": "`plan --monitor --dry-run --format json`: what the questions cost";
    plan::NotDrivenRecord = "not-driven":
        "`plan --format json`, `generate --format json`: a scenario that could not be driven";
    plan::StandardErrorRecord = "plan-log-stderr":
        "`plan --planner --log`: standard error of a planner's process, after the cycles of its drive";
    prompt::PromptDocument = "prompt-show": "`prompt show --format json`: the messages to a model";
    prompts::Document = "prompt-list": "`prompt list --format json`: one template a line";
    prompt::StoryDocument = "prompt-describe-story":
        "`prompt describe --story --format json`: what happened, and its facts";
    QuestionLine = "evaluate-questions": "`evaluate --dry-run=questions`: one question a line";
    ReportDocument = "report": "`report --format json`: tables of stored or recorded answers";
    AxesDocument = "report-axes":
        "`report --rows AXIS --format json`: a measure over axes, and differences from a baseline";
    corpus::SampleLine = "corpus-sample": "`corpus sample --format json`: one drawn window a line";
    KeyBinding = "config-keys": "`config keys --format json`: one action a line";
    config::ThemeDocument = "config-themes": "`config themes --format json`: one theme a line";
    tune::TuneDocument = "tune": "`tune --format json`: templates, their gains, and whether one is better";
    tune::TuneDryRunDocument = "tune-dry-run": "`tune --dry-run --format json`: what would be asked";
    + derived::<DriverRecord>();
    + noun::<AnnexRecord>();
    + noun::<BatchRecord<'static>>();
    + noun::<EventLine>();
    + noun::<ImageRecord<'static>>();
    + noun::<QuestionRecord<'static>>();
    + noun::<RatingRecord<'static>>();
    + noun::<Rate>();
    + noun::<RateLike>();
    + noun::<RaterAgreement>();
    + noun::<RunRecord<'static>>();
    + noun::<Standing>();
    + noun::<ScenarioRow>();
    + noun::<Summary>();
}
