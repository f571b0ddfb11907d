//! Who answers and who proposes, within one budget.

use std::sync::Arc;

use crate::Failure;
use crate::evaluate::BatchContext;
use nearmiss_ask::llm::Budget;
use nearmiss_store::Store;
use nearmiss_study::evaluation::batch::{Experiment, TuneSettings};
use nearmiss_study::evaluation::{Judge, Judges, ModelJudge};
use nearmiss_workflow::batch::{BatchControl, BatchPlan, at_once};
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
    settings: &TuneSettings,
    context: &BatchContext,
    plan: &BatchPlan,
    budget: f64,
) -> Result<Found, Failure> {
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
    Ok(Found {
        at_once: judges
            .get(&id)
            .map_or(1, |judge| at_once(judge, concurrency)),
        judges,
        reflect,
        budget,
    })
}

impl Found {
    /// The same for the workflow.
    pub fn into_models(self, store: Arc<Store>) -> TuneModels {
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
