//! `nearmiss tune`: a better prompt template from wrong answers of the dev split of an experiment.

mod document;
mod dry_run;
mod files;
mod models;
mod progress;
mod words;

pub use document::{TuneDocument, TuneDryRunDocument};

use std::num::NonZeroU32;
use std::path::PathBuf;

use super::ask::budget;
use super::evaluate::{BatchContext, planned, questions_of, runtime};
use super::interrupt::{GRACE, INTERRUPTED, signal};
use super::open::{frame, task, techniques, with_notes};
use super::{Failure, Outcome, output};
use nearmiss_ask::prompts::Techniques;
use nearmiss_scene::description::Frame;
use nearmiss_scene::verdict::Task;
use nearmiss_settings::TextFile;
use nearmiss_workflow::tune::{
    PROPOSAL_TOKENS, TuneChoice, TuneError, TuneModels, TuneOutcome, TunePlan, TuneSettings,
    can_tune, estimate, tune,
};
use nearmiss_workflow::{Experiment, is_experiment_file};
use progress::Stages;

/// Arguments of `tune`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The test split is never opened. `nearmiss help tuning`: what is shown, how templates are compared.\n\
Exit status: 0 a better template was found; 1 none was, or the tune ended early without one; 2 an error of input.")]
pub struct Tune {
    /// Experiment file (FILE.toml, see `nearmiss help experiments`) with a split; its dev scenarios are asked about.
    experiment: PathBuf,
    /// Model whose template is tuned, where the experiment names several.
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Task, where the experiment names several.
    #[arg(long, value_parser = task)]
    task: Option<Task>,
    /// Frame of the description, where the experiment names several.
    #[arg(long, value_parser = frame)]
    frame: Option<Frame>,
    /// Prompting techniques, where the experiment names several.
    #[arg(long, value_parser = techniques)]
    techniques: Option<Techniques>,
    /// Model that proposes templates, as provider/model [default: the one whose template is tuned].
    #[arg(long, value_name = "MODEL")]
    reflect: Option<String>,
    /// Maximum number of tokens in a proposal, reasoning included.
    #[arg(long, value_name = "N", default_value_t = PROPOSAL_TOKENS, value_parser = clap::value_parser!(u32).range(1..))]
    proposal_tokens: u32,
    /// Maximum cost of this run in US dollars, proposals and answers together; needs known prices and a token limit
    /// [default: `budget` of the experiment, else that in config.toml; one is required].
    #[arg(long, value_name = "USD", allow_negative_numbers = true, value_parser = budget)]
    budget: Option<f64>,
    /// Number of rounds.
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=100))]
    rounds: u32,
    /// Templates that are proposed in each round.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=20))]
    candidates: u32,
    /// Seed of the parts of the dev split, of the answers that are shown, and of the templates that are changed.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Concurrent requests per provider [default: `concurrency` in config.toml].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    concurrency: Option<NonZeroU32>,
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
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// What a tune was about, for its result.
struct Tuned<'a> {
    arguments: &'a Tune,
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
    let context = BatchContext::new()?;
    files::check(arguments, &context.folders)?;
    let text = TextFile::read(file).map_err(Failure::input)?.text;
    let experiment = Experiment::from_toml(&text, file, &context.library)
        .map_err(|mistakes| Failure::input(output::visible(&mistakes)))?;
    let budget = arguments
        .budget
        .or(experiment.budget)
        .or(context.config.budget).ok_or_else(|| {
        Failure::input("no budget given: use --budget USD, or set `budget` in the experiment or in config.toml")
    })?;
    let found = with_notes(experiment.find_scenarios().map_err(Failure::input)?);
    let choice = TuneChoice {
        task: arguments.task,
        frame: arguments.frame,
        techniques: arguments.techniques,
        model: arguments.model.clone(),
    };
    let request = experiment
        .tuned(&choice, file, found, context.of_experiment())
        .map_err(Failure::input)?;
    let test_scenarios = request.test_scenarios;
    let batch =
        planned(|cancel, on_event| request.plan(context.of_experiment(), cancel, on_event))?;
    let found = models::find(arguments, &context, &batch, budget)?;
    let dry_run = questions_of(&batch, &found.judges, &context.store)?;
    let plan = TunePlan::new(&batch, &dry_run, &context.library, arguments.seed)
        .map_err(|why| Failure::input(format!("{}: {why}", file.display())))?;
    drop(batch);
    let settings = TuneSettings {
        rounds: arguments.rounds,
        candidates: arguments.candidates,
        seed: arguments.seed,
        at_once: found.at_once,
    };
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
            arguments.json,
        );
    }
    // Nothing is paid where a proposal could not be.
    runtime
        .block_on(can_tune(&plan, &models))
        .map_err(Failure::input)?;
    words::begin(&plan, test_scenarios);
    let outcome = runtime.block_on(until_interrupted(&plan, models, settings))?;
    let tuned = Tuned {
        arguments,
        plan: &plan,
        test_scenarios,
        reflect: &reflect,
        budget,
        spent: spent.spent(),
        pinned: !experiment.templates.is_empty(),
    };
    files::write(&tuned, &outcome)?;
    if arguments.json {
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
    let interrupted = || Failure {
        message: "interrupted; the same command goes on, and pays for no answer twice".into(),
        status: INTERRUPTED,
    };
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
