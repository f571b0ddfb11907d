//! What all batches share: configuration, templates, thresholds, store and models; planning with its progress; the runtime.

use std::num::NonZeroU32;
use std::path::Path;
use std::sync::Arc;

use tokio::runtime::Runtime;

use crate::open::{configuration, user_thresholds};
use crate::output::LateProgress;
use crate::prompts::templates;
use crate::{Failure, output};
use nearmiss_ask::llm::{Budget, Environment};
use nearmiss_ask::prompts::Library;
use nearmiss_drive::planner::Cancel;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::{Config, Folders};
use nearmiss_store::Store;
use nearmiss_study::evaluation::Judges;
use nearmiss_study::evaluation::batch::{Experiment, Spec};
use nearmiss_workflow::ExperimentContext;
use nearmiss_workflow::batch::{BatchError, BatchModels, BatchPlan, PlanningEvent};

/// The shared context of a batch.
pub struct BatchContext {
    pub folders: Folders,
    pub config: Config,
    pub library: Library,
    pub thresholds: Arc<Thresholds>,
    pub store: Arc<Store>,
    /// Requests to each provider at once, in the place of the providers' own numbers.
    pub concurrency: Option<NonZeroU32>,
}

impl BatchContext {
    /// Opens everything, and reports errors of templates.
    pub fn new() -> Result<Self, Failure> {
        let (folders, config) = configuration()?;
        let library = templates(&folders)?;
        let thresholds = Arc::new(user_thresholds(&folders)?);
        let store = Store::open(&folders.store()).map_err(Failure::input)?;
        Ok(Self {
            folders,
            config,
            library,
            thresholds,
            store: Arc::new(store),
            concurrency: None,
        })
    }

    /// Takes how much may be asked at once, and how much it may cost, where an experiment says so.
    pub fn limits(&mut self, experiment: &Experiment) {
        self.config.budget = experiment.budget.or(self.config.budget);
        self.concurrency = experiment.concurrency.and_then(NonZeroU32::new);
    }

    /// Who is asked; they share one pool of connections, and the budget.
    pub fn judges(&self, models: &[String], spec: &Spec) -> Result<Judges, Failure> {
        self.judges_within(models, spec, self.config.budget.map(Budget::new))
    }

    /// The same within a budget.
    pub fn judges_within(
        &self,
        models: &[String],
        spec: &Spec,
        budget: Option<Budget>,
    ) -> Result<Judges, Failure> {
        let models_of_batch = BatchModels {
            providers: &self.config.provider,
            config_file: &self.folders.config_file(),
            environment: Environment::with_files(&[Path::new("."), &self.folders.config]),
            budget,
            concurrency: self.concurrency,
            today: jiff::Zoned::now().date(),
        };
        let mut warn = |warning: String| output::say(&format!("nearmiss: {warning}"));
        let judges = models_of_batch.judges(models, spec, &mut warn);
        judges.map_err(Failure::input)
    }

    /// What an experiment is run with.
    pub fn of_experiment(&self) -> ExperimentContext<'_> {
        ExperimentContext {
            library: &self.library,
            thresholds: &self.thresholds,
            store: &self.store,
        }
    }
}

/// Plans a batch, then says what is doubtful about its truth and which scenarios are left out.
pub fn planned(
    plan: impl FnOnce(&Cancel, &mut dyn FnMut(PlanningEvent)) -> Result<Option<BatchPlan>, BatchError>,
) -> Result<BatchPlan, Failure> {
    let progress = LateProgress::new("recordings read");
    let mut shown = 0;
    let plan = plan(
        &Cancel::default(),
        &mut |PlanningEvent::Read { done, of }| {
            (shown..done).for_each(|_| progress.step(of));
            shown = done;
        },
    );
    drop(progress);
    // Nothing cancels it: Ctrl-C ends the program.
    let plan = plan
        .map_err(Failure::input)?
        .ok_or_else(|| Failure::interrupted(""))?;
    say_each(&plan.doubts);
    if let Some(words) = &plan.left_out {
        output::say(&format!("nearmiss: {words}"));
    }
    Ok(plan)
}

/// Prints warnings, as far as there is room.
pub fn say_each(doubts: &[String]) {
    for doubt in doubts.iter().take(NAMED) {
        output::say(&format!("nearmiss: {doubt}"));
    }
    if doubts.len() > NAMED {
        let more = doubts.len() - NAMED;
        output::say(&format!("nearmiss: {more} more like this"));
    }
}

/// Doubts that are named each.
const NAMED: usize = 10;

/// Threads that wait for the network and the disk. An answer's thread waits until it is on the disk; the more wait at
/// once, the more share a sync.
const WAITING: usize = 16;

/// What waits for the network.
pub fn runtime() -> Result<Runtime, Failure> {
    crate::open::runtime(WAITING)
}
