//! `nearmiss tune`: a better prompt template from wrong answers of the dev split of an experiment.

mod document;
mod dry_run;
mod files;
mod models;
mod progress;
mod words;

pub use document::{TuneDocument, TuneDryRunDocument};

use std::path::PathBuf;

use super::evaluate::{BatchContext, planned, questions_of, runtime};
use super::interrupt::{GRACE, signal};
use super::knobs::{self, Knobs};
use super::open::with_notes;
use super::{Failure, Outcome, output};
use nearmiss_record::fields::Layers;
use nearmiss_workflow::tune::{
    TuneError, TuneModels, TuneOutcome, TunePlan, TuneSettings, can_tune, estimate, tune,
    tune_request,
};
use nearmiss_workflow::{find_scenarios, is_experiment_file};
use progress::Stages;

/// Arguments of `tune`.
#[derive(Debug, clap::Args)]
#[command(after_long_help = crate::knobs::help())]
#[command(after_help = "\
The test split is never opened. `nearmiss help tuning`: what is shown, how templates are compared.\n\
Exit status: 0 a better template was found; 1 none was, or the tune ended early without one; 2 an error of input.")]
pub struct Tune {
    /// Experiment file (FILE.toml, see `nearmiss help experiments`) with a split; its dev scenarios are asked about.
    experiment: PathBuf,
    #[command(flatten)]
    knobs: Knobs,
    /// Maximum cost of this run in US dollars, proposals and answers together; needs known prices and a token limit
    /// [default: `budget` of the experiment, else that in config.toml; one is required].
    #[arg(long, value_name = "USD", allow_hyphen_values = true)]
    budget: Option<String>,
    /// Folder for template.diff, template.md and tune.json [default: the diff is printed].
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Replace files in the folder.
    #[arg(long, requires = "output")]
    overwrite: bool,
    /// Keep a better template in your folder of templates under this new name.
    #[arg(long, value_name = "NAME", conflicts_with = "dry_run")]
    save: Option<String>,
    /// Print what would be asked and its maximum cost; send nothing.
    #[arg(long, conflicts_with_all = ["output"])]
    dry_run: bool,
    #[command(flatten)]
    format: crate::output::FormatOption,
}

/// What a tune was about, for its result.
struct Tuned<'a> {
    arguments: &'a Tune,
    settings: &'a TuneSettings,
    plan: &'a TunePlan,
    /// Scenarios of the test split.
    test_scenarios: usize,
    reflect: &'a str,
    budget: f64,
    spent: f64,
    /// Whether the experiment names the version of its template.
    pinned: bool,
}

/// Runs `tune`.
pub fn run(arguments: &Tune) -> Outcome {
    let file = &arguments.experiment;
    if !is_experiment_file(file) {
        return Err(Failure::input(format!(
            "{}: expected an experiment file, FILE.toml; `nearmiss evaluate … --write-experiment FILE.toml` writes one",
            file.display()
        )));
    }
    let mut context = BatchContext::new()?;
    files::check(arguments, &context.folders)?;
    let mut layers = Layers::default();
    knobs::add_file(&mut layers, file)?;
    // Nothing is compared with them here, and one way of asking may be left.
    layers.remove("baseline");
    layers.remove("compare");
    let budget = arguments.budget.as_slice();
    arguments
        .knobs
        .add(&mut layers, &[("--budget", "budget", budget)]);
    let experiment = knobs::complete(layers, &context.library)?;
    context.limits(&experiment);
    let budget = context.config.budget.ok_or_else(|| {
        Failure::input("no budget given: use --budget USD, or set `budget` in the experiment or in config.toml")
    })?;
    let settings = experiment.tune.clone();
    let found = with_notes(find_scenarios(&experiment).map_err(Failure::input)?);
    let request =
        tune_request(&experiment, file, found, context.of_experiment()).map_err(Failure::input)?;
    let test_scenarios = request.test_scenarios;
    let batch =
        planned(|cancel, on_event| request.plan(context.of_experiment(), cancel, on_event))?;
    let found = models::find(&settings, &context, &batch, budget)?;
    let dry_run = questions_of(&batch, &found.judges, &context.store)?;
    let plan = TunePlan::new(&batch, &dry_run, &context.library, settings.seed)
        .map_err(|why| Failure::input(format!("{}: {why}", file.display())))?;
    drop(batch);
    let spent = found.budget.clone();
    let reflect = found.reflect.id.clone();
    let models = found.into_models(std::sync::Arc::clone(&context.store));
    let runtime = runtime()?;
    if arguments.dry_run {
        let estimate = estimate(&plan, &models, &settings, &context.store);
        let about = (&plan, test_scenarios, reflect.as_str());
        return dry_run::write(
            &estimate.map_err(Failure::input)?,
            about,
            budget,
            arguments.format.is_json(),
        );
    }
    // Nothing is paid where a proposal could not be.
    runtime
        .block_on(can_tune(&plan, &models))
        .map_err(Failure::input)?;
    words::begin(&plan, test_scenarios);
    let outcome = runtime.block_on(until_interrupted(&plan, models, settings.clone()))?;
    let tuned = Tuned {
        arguments,
        settings: &settings,
        plan: &plan,
        test_scenarios,
        reflect: &reflect,
        budget,
        spent: spent.spent(),
        pinned: !experiment.templates.is_empty(),
    };
    files::write(&tuned, &outcome)?;
    if arguments.format.is_json() {
        output::document(&TuneDocument::new(&tuned, &outcome))?
    } else {
        output::text(&output::visible(&words::result(&tuned, &outcome)))?
    }
    files::save(&tuned, &outcome, &context.folders)?;
    words::end(&tuned, &outcome);
    match outcome.winner() {
        Some(_) => Ok(()),
        None => Err(Failure::finding(words::none(&outcome))),
    }
}

/// Tunes until it is done or interrupted: then nothing more is begun, and what is on its way is waited for a little.
async fn until_interrupted(
    plan: &TunePlan,
    models: TuneModels,
    settings: TuneSettings,
) -> Result<TuneOutcome, Failure> {
    let control = models.control.clone();
    let interrupted =
        || Failure::interrupted("the same command goes on, and pays for no answer twice");
    let failed = |error| match error {
        TuneError::Interrupted => interrupted(),
        other => Failure::input(other),
    };
    let mut stages = Stages::default();
    let all = tune(plan, models, settings, |event| stages.hear(&event));
    tokio::pin!(all);
    tokio::select! {
        biased;
        done = &mut all => return done.map_err(failed),
        () = signal() => {}
    }
    control.stop();
    output::say("nearmiss: interrupted; waiting briefly for answers on their way");
    tokio::select! {
        _ = &mut all => {}
        () = tokio::time::sleep(GRACE) => {}
    }
    Err(interrupted())
}
