//! `nearmiss tune`: a better prompt template from wrong answers of the dev split of an experiment.

mod document;
mod words;

pub use document::{TuneDocument, TuneDryRunDocument};

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_ask::llm::Budget;
use nearmiss_ask::prompts::{Library, renamed, template_file};
use nearmiss_base::system;
use nearmiss_record::fields::Layers;
use nearmiss_settings::Folders;
use nearmiss_store::Store;
use nearmiss_study::evaluation::batch::Experiment;
use nearmiss_study::evaluation::{Judge, Judges, ModelJudge, validate};
use nearmiss_workflow::batch::{BatchControl, BatchPlan, at_once};
use nearmiss_workflow::tune::{
    TuneError, TuneEvent, TuneModels, TuneOutcome, TunePlan, TuneSettings, can_tune, estimate,
    template_diff, tune, tune_request,
};
use nearmiss_workflow::{find_scenarios, is_experiment_file};

use super::ending::{GRACE, signal};
use super::evaluate::{BatchContext, planned, questions_of, runtime};
use super::json::Output;
use super::knobs::{self, Knobs};
use super::open::with_notes;
use super::output::{self, Progress, refused};
use super::{Failure, Outcome};

/// What stands behind the help.
const BEHIND: &str = "\
The test split is never opened. `nearmiss help tuning` explains what the model sees and how templates are compared.\n\
Exit status: 0 a better template was found; 1 none was found; 2 usage or input error.";

/// Arguments of `tune`.
#[derive(Debug, clap::Args)]
#[command(after_long_help = format!("{}\n{BEHIND}", crate::knobs::help()), after_help = BEHIND)]
pub struct Tune {
    /// Experiment file (FILE.toml, see `nearmiss help experiments`) with a split; only its dev scenarios are asked
    /// about.
    experiment: PathBuf,
    #[command(flatten)]
    knobs: Knobs,
    /// Maximum cost of this run in US dollars, proposals and answers together; needs known prices and a token limit
    /// [default: `budget` of the experiment, else of config.toml; one is required].
    #[arg(long, value_name = "USD", allow_hyphen_values = true)]
    budget: Option<String>,
    /// Folder for template.diff, template.md and tune.json [default: print the diff].
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Replace files in the folder.
    #[arg(long, requires = "output")]
    overwrite: bool,
    /// Save a better template in your template folder under this new name.
    #[arg(long, value_name = "NAME", conflicts_with = "dry_run")]
    save: Option<String>,
    /// Print the number of requests and their maximum cost; send nothing.
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
    check_files(arguments, &context.folders)?;
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
    let found = find_models(&settings, &context, &batch, budget)?;
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
        return document::write_dry_run(
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
    write_files(&tuned, &outcome)?;
    if arguments.format.is_json() {
        output::document(&TuneDocument::new(&tuned, &outcome))?
    } else {
        output::text(&output::visible(&words::result(&tuned, &outcome)))?
    }
    save_template(&tuned, &outcome, &context.folders)?;
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

/// The files in the folder.
const FILES: [&str; 3] = ["template.diff", "template.md", "tune.json"];

/// Checks, before anything is paid, that nothing would be replaced.
fn check_files(arguments: &Tune, folders: &Folders) -> Outcome {
    if let (Some(folder), false) = (&arguments.output, arguments.overwrite) {
        if folder.is_file() {
            return Err(Failure::input(format!(
                "{}: is a file; name a folder",
                folder.display()
            )));
        }
        let there = FILES
            .iter()
            .map(|name| folder.join(name))
            .find(|path| path.exists());
        if let Some(path) = there {
            return Err(Failure::input(format!(
                "{} exists; use another folder, or --overwrite",
                path.display()
            )));
        }
    }
    if let Some(name) = &arguments.save {
        template_place(name, folders)?;
    }
    Ok(())
}

/// Where a template of this name is kept.
fn template_place(name: &str, folders: &Folders) -> Result<(String, PathBuf), Failure> {
    let file = template_file(name).map_err(|why| Failure::input(format!("--save: {why}")))?;
    if Library::shipped(&file).is_some() {
        return Err(Failure::input(format!(
            "--save: {file} is the name of a shipped template; choose another name"
        )));
    }
    let path = folders.prompts().join(&file);
    if path.exists() {
        Err(Failure::input(format!(
            "--save: {} exists; choose another name",
            path.display()
        )))
    } else {
        Ok((file, path))
    }
}

/// Writes the folder; diff and template only where a better one was found.
fn write_files(tuned: &Tuned<'_>, outcome: &TuneOutcome) -> Outcome {
    let Some(folder) = &tuned.arguments.output else {
        return Ok(());
    };
    std::fs::create_dir_all(folder).map_err(|error| Failure::system(folder.display(), &error))?;
    let plan = tuned.plan;
    let document = TuneDocument::new(tuned, outcome).document();
    let document = output::json_line(&document.map_err(Failure::input)?)?;
    let mut files = vec![(FILES[2], document)];
    if let Some(winner) = outcome.winner() {
        let diff = template_diff(&plan.file, &plan.template.source, &winner.source);
        files.push((FILES[0], diff));
        files.push((FILES[1], winner.source.clone()));
    }
    for (name, text) in &files {
        save_file(&folder.join(name), text, tuned.arguments.overwrite)?;
        output::say(&format!("nearmiss: wrote {}", folder.join(name).display()));
    }
    Ok(())
}

fn save_file(path: &Path, text: &str, overwrite: bool) -> Outcome {
    system::save(path, text.as_bytes(), overwrite).map_err(|error| refused(&error))
}

/// Keeps a better template in the user's folder, where that is asked for.
fn save_template(tuned: &Tuned<'_>, outcome: &TuneOutcome, folders: &Folders) -> Outcome {
    let (Some(name), Some(winner)) = (&tuned.arguments.save, outcome.winner()) else {
        return Ok(());
    };
    let (file, path) = template_place(name, folders)?;
    let folder = folders.prompts();
    system::make_folder(&folder).map_err(|error| Failure::system(folder.display(), &error))?;
    save_file(&path, &renamed(&winner.source, &file), false)?;
    let library = validate(Library::load(Some(&folder)));
    let stem = file.trim_end_matches(".md");
    let front = &tuned.plan.template.front;
    output::say(&if library.in_use(&file) {
        format!(
            "nearmiss: wrote {}; it is used for task {} in frame {} from now on",
            path.display(),
            front.task,
            front.frame
        )
    } else {
        format!(
            "nearmiss: wrote {}; `nearmiss prompt use {stem}` uses it for task {} in frame {}",
            path.display(),
            front.task,
            front.frame
        )
    });
    Ok(())
}

/// The models.
struct FoundModels {
    /// Who answers, as batches have it.
    judges: Judges,
    /// Who proposes.
    reflect: Box<ModelJudge>,
    /// What both may cost together.
    budget: Budget,
    /// Requests on their way at once.
    at_once: usize,
}

/// Finds the models of a tune.
fn find_models(
    settings: &TuneSettings,
    context: &BatchContext,
    plan: &BatchPlan,
    budget: f64,
) -> Result<FoundModels, Failure> {
    let budget = Budget::new(budget);
    let asked = plan.models();
    let id = asked.first().cloned().unwrap_or_default();
    let judges = context.judges_within(&asked, &plan.spec, Some(budget.clone()))?;
    let proposes = settings.reflect.clone().unwrap_or_else(|| id.clone());
    let mut spec = plan.spec.clone();
    // What answers are to be like is said of answers, not of proposals.
    spec.experiment = Experiment {
        base_url: spec.experiment.base_url,
        dialect: spec.experiment.dialect,
        key_env: spec.experiment.key_env,
        max_tokens: Some(settings.proposal_tokens),
        ..Experiment::default()
    };
    let all = [proposes.clone()];
    let reflects = context.judges_within(&all, &spec, Some(budget.clone()))?;
    let Some(Judge::Model(reflect)) = reflects.get(&proposes).cloned() else {
        return Err(Failure::input(format!(
            "tune.reflect = {proposes}: proposals need a language model"
        )));
    };
    let concurrency = context.concurrency.unwrap_or(context.config.at_once());
    Ok(FoundModels {
        at_once: judges
            .get(&id)
            .map_or(1, |judge| at_once(judge, concurrency)),
        judges,
        reflect,
        budget,
    })
}

impl FoundModels {
    /// The same for the workflow.
    fn into_models(self, store: Arc<Store>) -> TuneModels {
        let judge = self.judges.into_values().next();
        TuneModels {
            judge: Arc::new(judge.unwrap_or(Judge::Reference)),
            reflect: self.reflect,
            at_once: self.at_once,
            store,
            control: BatchControl::default(),
        }
    }
}

/// The stage that is shown.
#[derive(Default)]
struct Stages {
    bar: Option<Progress>,
}

impl Stages {
    /// Shows an event.
    fn hear(&mut self, event: &TuneEvent<'_>) {
        match event {
            TuneEvent::Asking {
                candidate,
                part,
                done: 0,
                of,
            } => {
                let what = match candidate {
                    0 => format!("answers, base, {} part", part.name()),
                    n => format!("answers, candidate {n}, {} part", part.name()),
                };
                self.bar = Some(Progress::new(*of, &what, true));
            }
            TuneEvent::Asking { .. } => {
                if let Some(bar) = &self.bar {
                    bar.step();
                }
            }
            TuneEvent::Reflecting { .. } => self.bar = None,
            TuneEvent::Refused(refusal) => {
                self.bar = None;
                output::say(&format!(
                    "nearmiss: round {}, proposal {}: {}: {}",
                    refusal.round,
                    refusal.number,
                    or_dash(&refusal.change),
                    refusal.because
                ));
            }
            TuneEvent::Compared(candidate) => {
                self.bar = None;
                if candidate.number > 0 {
                    output::say(&format!(
                        "nearmiss: round {}, candidate {}: {}",
                        candidate.round,
                        candidate.number,
                        or_dash(&candidate.change)
                    ));
                }
            }
        }
    }
}

fn or_dash(text: &str) -> &str {
    if text.is_empty() { "–" } else { text }
}
