//! Who answers and who proposes, within one budget.

use std::num::NonZeroU32;
use std::path::Path;
use std::sync::Arc;

use super::Tune;
use crate::evaluate::BatchContext;
use crate::{Failure, output};
use nearmiss_ask::llm::{Budget, Environment};
use nearmiss_store::Store;
use nearmiss_study::evaluation::batch::{RequestSettings, Spec};
use nearmiss_study::evaluation::{Judge, Judges, ModelJudge};
use nearmiss_workflow::batch::{BatchControl, BatchModels, BatchPlan, at_once};
use nearmiss_workflow::tune::TuneModels;

/// The models.
pub struct Found {
    /// Who answers, as batches have it.
    pub judges: Judges,
    /// Who proposes.
    pub reflect: Box<ModelJudge>,
    /// What both may cost together.
    pub budget: Budget,
    /// Requests on their way at once.
    pub at_once: usize,
}

/// Finds the models of a tune.
pub fn find(
    arguments: &Tune,
    context: &BatchContext,
    plan: &BatchPlan,
    budget: f64,
) -> Result<Found, Failure> {
    let budget = Budget::new(budget);
    let asked = plan.models();
    let id = asked.first().cloned().unwrap_or_default();
    let judges = judges(arguments, context, (&asked, &plan.spec), &budget)?;
    let proposes = arguments.reflect.clone().unwrap_or_else(|| id.clone());
    let mut spec = plan.spec.clone();
    // What answers are to be like is said of answers, not of proposals.
    spec.matrix.request = RequestSettings {
        max_tokens: Some(arguments.proposal_tokens),
        ..RequestSettings::default()
    };
    let all = [proposes.clone()];
    let reflects = self::judges(arguments, context, (&all, &spec), &budget)?;
    let Some(Judge::Model(reflect)) = reflects.get(&proposes).cloned() else {
        return Err(Failure::input(format!(
            "--reflect {proposes}: proposals need a language model"
        )));
    };
    let concurrency: NonZeroU32 = arguments.concurrency.unwrap_or(context.config.concurrency);
    Ok(Found {
        at_once: judges
            .get(&id)
            .map_or(1, |judge| at_once(judge, concurrency)),
        judges,
        reflect,
        budget,
    })
}

fn judges(
    arguments: &Tune,
    context: &BatchContext,
    (models, spec): (&[String], &Spec),
    budget: &Budget,
) -> Result<Judges, Failure> {
    let models_of_tune = BatchModels {
        providers: &context.config.providers,
        config_file: &context.folders.config_file(),
        environment: Environment::with_files(&[Path::new("."), &context.folders.config]),
        budget: Some(budget.clone()),
        concurrency: arguments.concurrency,
        today: jiff::Zoned::now().date(),
    };
    let mut warn = |warning: String| output::say(&format!("nearmiss: {warning}"));
    let judges = models_of_tune.judges(models, spec, &mut warn);
    judges.map_err(Failure::input)
}

impl Found {
    /// The same for the workflow.
    pub fn into_models(self, store: Arc<Store>) -> TuneModels {
        let judge = self.judges.into_values().next();
        TuneModels {
            judge: Arc::new(judge.unwrap_or(Judge::Reference)),
            reflect: self.reflect,
            store,
            control: BatchControl::default(),
        }
    }
}
