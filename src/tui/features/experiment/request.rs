//! An experiment file is read and its questions are made, or a new file is written.

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use tokio::runtime::Handle;

use crate::features::batch::request::{self, BatchUpdate, Prepared, Ready};
use crate::message::Effect;
use crate::model::{
    Batch, CountedExperiment, ExperimentOutline, Job, JobId, JobKind, Model, Update,
};
use crate::request::{Replies, Request};
use crate::services::Services;
use nearmiss_ask::llm::{Budget, Environment};
use nearmiss_ask::prompts::Library;
use nearmiss_base::system::SaveError;
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::EgoSelection;
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::TextFile;
use nearmiss_store::{BatchId, Filter, ItemState, SplitPart, Store};
use nearmiss_study::evaluation::batch::{Experiment, TestSplit};
use nearmiss_study::evaluation::{Spending, validate};
use nearmiss_workflow::batch::{
    BatchModels, BatchPlan, DryRun, DryRunEvent, PlanningEvent, Selection,
};
use nearmiss_workflow::{
    ExperimentContext, ExperimentProgress, FolderOfExperiments, WriteExperimentError,
    count_reasons, experiment_axes, experiment_facts, experiment_from_request, experiments_in,
    find_scenarios, prepare_experiment, read_experiment, write_experiment,
};

/// What a reading needs of the program.
struct Reading {
    query: ReadExperiment,
    store: Option<Arc<Store>>,
    providers: toml::Table,
    config_file: PathBuf,
    environment: Environment,
    /// What is left of the session's budget.
    budget: Option<Budget>,
    runtime: Handle,
}

/// Reads an experiment file and prepares its questions to know what they take, in place of those that were prepared
/// before; nothing is asked.
#[derive(Debug)]
pub struct ReadExperiment {
    /// Its number.
    pub id: JobId,
    /// The file.
    pub file: PathBuf,
    /// The part of its split that would be asked; `None` for all.
    pub part: Option<SplitPart>,
    /// The templates.
    pub library: Library,
    /// The thresholds of risk scores.
    pub thresholds: Arc<Thresholds>,
}

/// How far the reading of an experiment is.
#[derive(Debug)]
pub enum ExperimentNews {
    /// The file was read: its text, and what it says; nothing where it has mistakes.
    Read(Box<(String, Option<ExperimentOutline>)>),
    /// What takes its time now, in words.
    Working(String),
}

/// The experiment that was read last.
#[derive(Default)]
struct LastRead(Prepared);

impl Request for ReadExperiment {
    /// What the file says, then what it would ask.
    type Reply = (JobId, Update<ExperimentNews, Box<CountedExperiment>>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        if let Some((before, _)) = services.state::<LastRead>().0.take() {
            services.jobs.cancel(before);
        }
        let id = self.id;
        let reading = Reading {
            query: self,
            store: services.store.clone(),
            providers: services.providers.clone(),
            config_file: services.folders.config_file(),
            environment: services.models.environment().clone(),
            budget: services.models.budget(),
            runtime: Handle::current(),
        };
        let ready = Arc::new(OnceLock::new());
        services.state::<LastRead>().0 = Some((id, Arc::clone(&ready)));
        services.run(id, replies, move |cancel, progress| {
            reading.run(&ready, cancel, progress)
        });
    }

    fn reply(model: &mut Model, (id, update): Self::Reply) -> Vec<Effect> {
        if model.experiment.job == Some(id) {
            super::on_read(model, update);
        }
        Vec::new()
    }
}

/// Asks the questions of the experiment that was read under the same number.
#[derive(Debug)]
pub struct AskExperiment {
    /// Its number.
    pub id: JobId,
    /// Its name in the list of tasks.
    pub name: String,
    /// Questions that are asked.
    pub questions: usize,
}

impl Request for AskExperiment {
    type Reply = (JobId, BatchUpdate);

    fn sent(&self, model: &mut Model) {
        let title = format!("experiment {}", self.name);
        let job = Job::new(self.id, JobKind::Batch, title, self.questions, model.uptime);
        model.jobs.add(job);
    }

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let read = services.state::<LastRead>().0.take();
        request::ask(services, self.id, read, replies, true);
    }

    fn reply(model: &mut Model, (id, update): Self::Reply) -> Vec<Effect> {
        request::on_update(model, id, update)
    }
}

/// Writes an experiment file from what the workbench would ask.
#[derive(Debug)]
pub struct WriteExperiment {
    /// Its number.
    pub id: JobId,
    /// The file.
    pub file: PathBuf,
    /// The scenarios, and how they are asked about.
    pub batch: Batch,
    /// Whether an existing file is replaced.
    pub overwrite: bool,
}

/// What became of a file that was to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ExperimentWritten {
    /// It is there.
    Written(PathBuf),
    /// There is a file of this name already.
    Exists(PathBuf),
}

impl Request for WriteExperiment {
    type Reply = (JobId, Update<(), ExperimentWritten>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let ego = services.ego.clone();
        services.run(self.id, replies, move |_, _| write(&self, &ego).map(Some));
    }

    fn reply(model: &mut Model, (id, update): Self::Reply) -> Vec<Effect> {
        if model.experiment.writing == Some(id) {
            super::written(model, update)
        } else {
            Vec::new()
        }
    }
}

/// Looks through a folder for experiment files; an empty path is the working folder.
#[derive(Debug)]
pub struct ListExperiments(pub PathBuf);

impl Request for ListExperiments {
    type Reply = (PathBuf, Result<FolderOfExperiments, String>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Self(folder) = self;
        services.background(replies, move || {
            let found = experiments_in(&folder);
            (folder, found)
        });
    }

    fn reply(model: &mut Model, found: Self::Reply) -> Vec<Effect> {
        model.experiment.folder = Some(found);
        Vec::new()
    }
}

impl Reading {
    fn run(
        self,
        ready: &OnceLock<Ready>,
        cancel: &Cancel,
        tell: &mut dyn FnMut(ExperimentNews),
    ) -> Result<Option<Box<CountedExperiment>>, String> {
        let file = self.query.file.as_path();
        let text = TextFile::read(file)?.text;
        // As the command line has them.
        let library = validate(self.query.library.clone());
        let experiment = read_experiment(&text, file, &library);
        let outline = experiment
            .as_ref()
            .ok()
            .map(|experiment| outline_of(experiment, &library));
        tell(ExperimentNews::Read(Box::new((text, outline))));
        let experiment = experiment?;
        let store = self.store.clone().ok_or("the store of runs is not open")?;
        let context = ExperimentContext {
            library: &library,
            thresholds: &self.query.thresholds,
            store: &store,
        };
        tell(ExperimentNews::Working("looking for scenarios".into()));
        let found = find_scenarios(&experiment)?;
        let mut doubts: Vec<String> = found.passed_over_in_short().into_iter().collect();
        let prepared = prepare_experiment(&experiment, file, found.entries, None, context)?;
        let split = experiment.split.map(|split| {
            let entries = &prepared.request().entries;
            let of_test = |name: &str| split.part(name) == SplitPart::Test;
            let test = entries.iter().filter(|entry| of_test(&entry.name)).count();
            (entries.len() - test, test)
        });
        let batch = prepared.batch();
        let on_read = &mut |PlanningEvent::Read { done, of }| {
            tell(ExperimentNews::Working(format!(
                "{done} of {of} recordings read"
            )));
        };
        let plan = prepared.plan(Selection::Open, context, cancel, on_read);
        let Some(mut plan) = plan.map_err(|error| error.to_string())? else {
            return Ok(None);
        };
        let asks = plan.ask_part(self.query.part);
        asks.map_err(|error| error.to_string())?;
        doubts.extend(plan.doubts.iter().cloned());
        doubts.extend(plan.left_out.clone());
        let usd = experiment.budget;
        let budget = usd.map(Budget::new).or_else(|| self.budget.clone());
        let usd = usd.or_else(|| self.budget.as_ref().map(Budget::left));
        let models = BatchModels {
            providers: &self.providers,
            config_file: &self.config_file,
            environment: self.environment,
            budget,
            concurrency: experiment.concurrency.and_then(NonZeroU32::new),
            today: jiff::Zoned::now().date(),
        };
        let judges = models.judges(&plan.models(), &plan.spec, &mut |warning| {
            doubts.push(warning);
        })?;
        let of = plan.scenarios();
        let on_event = &mut |event: DryRunEvent<'_>| {
            let DryRunEvent::Described { done, .. } = event;
            tell(ExperimentNews::Working(format!(
                "questions about {done} of {of} scenarios made"
            )));
        };
        let dry_run = plan.dry_run(&judges, &store, cancel, on_event);
        let Some(dry_run) = dry_run.map_err(|error| error.to_string())? else {
            return Ok(None);
        };
        let labelled = plan.check_labels(&dry_run);
        labelled.map_err(|error| error.to_string())?;
        let refused = self.runtime.block_on(dry_run.refused(&judges));
        let stored = Stored::read(&store, batch, &dry_run).map_err(|error| error.to_string())?;
        doubts.extend(dry_run.doubts.iter().cloned());
        if !dry_run.unlabelled.is_empty() {
            let left_out = dry_run.unlabelled.len();
            doubts.push(format!("{left_out} without ground truth left out"));
        }
        let counted = counted(&plan, &dry_run, refused, usd, stored);
        // It is set once.
        let _ = ready.set(Ready {
            plan,
            dry_run,
            judges,
        });
        Ok(Some(Box::new(CountedExperiment {
            batch,
            split,
            doubts,
            ..counted
        })))
    }
}

/// What the store knows of the batch.
struct Stored {
    progress: ExperimentProgress,
    reasons: Vec<(String, usize)>,
    test: Vec<String>,
    spent: (f64, usize),
}

impl Stored {
    fn read(store: &Store, batch: Option<BatchId>, dry_run: &DryRun) -> Result<Self, String> {
        let Some(id) = batch else {
            return Ok(Self {
                progress: ExperimentProgress::of_new(&dry_run.items)?,
                reasons: Vec::new(),
                test: Vec::new(),
                spent: (0.0, 0),
            });
        };
        let words = |error: nearmiss_store::StoreError| error.to_string();
        let items = store.items(id).map_err(words)?;
        let progress = ExperimentProgress::of_items(&items)?;
        let unanswered = [
            ItemState::Failed,
            ItemState::Truncated,
            ItemState::Unaskable,
        ];
        let unanswered = items.iter().filter(|item| unanswered.contains(&item.state));
        let reasons = count_reasons(unanswered);
        let batch = store.batch(id).map_err(words)?;
        let split = batch
            .map(|batch| TestSplit::open(store, &batch, false))
            .transpose()
            .map_err(words)?
            .flatten();
        let test = split.map(|test| [Some(test.summary()), test.looks_note()]);
        let runs = Filter {
            batch: Some(id.to_string()),
            deleted: false,
            ..Filter::default()
        };
        let runs = store.list(&runs, MOST_RUNS).map_err(words)?;
        let mut spent = Spending::default();
        for run in runs.iter().filter(|run| run.model != judge::MODEL) {
            spent.add(run.cost_usd, run.most_usd);
        }
        let spent = (spent.usd, spent.unpriced() as usize);
        Ok(Self {
            progress,
            reasons,
            test: test.into_iter().flatten().flatten().collect(),
            spent,
        })
    }
}

/// Runs of a batch whose cost is added up.
const MOST_RUNS: usize = 10_000_000;

fn counted(
    plan: &BatchPlan,
    dry_run: &DryRun,
    refused: Vec<(String, String)>,
    usd: Option<f64>,
    stored: Stored,
) -> CountedExperiment {
    let estimate = &dry_run.estimate;
    // A batch whose questions are all answered has none to make.
    let lines = if plan.is_stored() && plan.scenarios() == 0 {
        Vec::new()
    } else {
        dry_run.lines(&refused, usd)
    };
    CountedExperiment {
        progress: stored.progress,
        lines,
        requests: estimate.requests,
        free: estimate.free + estimate.stored,
        price: estimate.price(),
        refused,
        reasons: stored.reasons,
        test: stored.test,
        spent: stored.spent,
        ..CountedExperiment::default()
    }
}

/// The file in words.
fn outline_of(
    experiment: &Experiment,
    library: &nearmiss_ask::prompts::Library,
) -> ExperimentOutline {
    let shown = |(key, value): (&'static str, String)| match key {
        "scenarios" => {
            let paths: Vec<String> = experiment.scenarios.iter().map(|p| shown(p)).collect();
            (key, paths.join(", "))
        }
        key => (key, value),
    };
    ExperimentOutline {
        title: experiment.title.clone(),
        axes: experiment_axes(experiment, library),
        ways: experiment.configurations().len(),
        facts: experiment_facts(experiment)
            .into_iter()
            .map(shown)
            .collect(),
        is_split: experiment.split.is_some(),
    }
}

/// A path of a file; names of bundled scenarios are as they are.
fn shown(path: &Path) -> String {
    if path.is_absolute() {
        nearmiss_base::system::shown_path(path)
    } else {
        path.display().to_string()
    }
}

fn write(new: &WriteExperiment, ego: &EgoSelection) -> Result<ExperimentWritten, String> {
    if *ego != EgoSelection::Beside {
        return Err(
            "an experiment asks about the ego beside each scenario; start nearmiss without --ego"
                .into(),
        );
    }
    let batch = &new.batch;
    let library = validate(batch.library.clone());
    let request = batch.request(ego);
    let experiment = experiment_from_request(request, &library, &batch.thresholds)
        .map_err(|error| error.to_string())?;
    match write_experiment(&experiment, &new.file, new.overwrite) {
        Ok(()) => Ok(ExperimentWritten::Written(new.file.clone())),
        Err(WriteExperimentError::Save(SaveError::Exists(_))) => {
            Ok(ExperimentWritten::Exists(new.file.clone()))
        }
        Err(error) => Err(error.to_string()),
    }
}
