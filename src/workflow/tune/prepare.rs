//! From an experiment to what is tuned: one way of asking, the questions about the dev scenarios, and their parts.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;

use super::copied::Traces;
use super::divide::{DevPart, Division};
use crate::batch::{BatchError, BatchPlan, BatchRequest, DryRun, PlanningEvent};
use crate::{ExperimentContext, name_of, request_of, selected};
use nearmiss_ask::prompts::{Library, Template};
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_record::fields::Fields;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_store::{NewItem, SplitPart};
use nearmiss_study::evaluation::batch::{
    Experiment, Spec, Split, Variant, configuration_of_item, critical_of, label_of_item,
};
use nearmiss_study::evaluation::{Cluster, Label, PromptConfig, Protocol, Question};

/// The dev scenarios of an experiment, asked about in one way.
#[derive(Debug)]
pub struct TuneRequest {
    request: BatchRequest,
    /// Scenarios of the test split, which are not opened.
    pub test_scenarios: usize,
}

/// Those of the `found` scenarios that are in the dev split, asked about in one way.
///
/// # Errors
/// There is no split, or several ways; else as [`prepare_experiment`](crate::prepare_experiment): with the file.
pub fn tune_request(
    experiment: &Experiment,
    file: &Path,
    found: Vec<Entry>,
    context: ExperimentContext<'_>,
) -> Result<TuneRequest, String> {
    let named = |why: String| format!("{}: {why}", file.display());
    let mut one = of_one_way(experiment).map_err(named)?;
    let Some(split) = one.split.take() else {
        return Err(named(
            "no split, and tuning needs scenarios that it never sees; add `split = { test = 0.5 }`"
                .into(),
        ));
    };
    if let Some(part) = split.empty_part(&found) {
        return Err(named(BatchError::EmptyPart(part).to_string()));
    }
    let is_dev = |name: &str| Split::part(&split, name) == SplitPart::Dev;
    let (dev, test): (Vec<Entry>, Vec<Entry>) =
        found.into_iter().partition(|entry| is_dev(&entry.name));
    one.hashes.retain(|key, _| is_dev(name_of(key)));
    let asked = Spec::templates_of(&one, context.library);
    one.templates.retain(|pin| asked.contains_key(&pin.name));
    let dev = selected(dev, one.select.as_deref(), context.thresholds).map_err(named)?;
    let request = request_of(&one, dev, None, context.library).map_err(named)?;
    Ok(TuneRequest {
        request,
        test_scenarios: test.len(),
    })
}

/// The same with one way of asking, about the scenes as they are and at the first lead.
fn of_one_way(experiment: &Experiment) -> Result<Experiment, String> {
    if let Some((key, _)) = experiment.several().next() {
        return Err(format!(
            "it asks with several values of {key}; tuning needs one, so that a template is the only difference"
        ));
    }
    for key in ["tasks", "frames", "techniques", "models"] {
        let values = experiment.texts(key);
        if values.len() > 1 {
            return Err(format!(
                "it has several {key}: {}; choose one with --set {key}={}",
                values.join(", "),
                values[0]
            ));
        }
    }
    let model = experiment.models.first().cloned().unwrap_or_default();
    if model.starts_with("reference/") || model.starts_with("recorded/") {
        return Err(format!(
            "{model} is not asked with a template; tune a language model"
        ));
    }
    Ok(Experiment {
        samples: Some(1),
        leads: experiment.lead().into_iter().collect(),
        transforms: Vec::new(),
        baseline: None,
        compare: None,
        tables: Vec::new(),
        ..experiment.clone()
    })
}

impl TuneRequest {
    /// Plans the questions; nothing is written. Drawing windows reads the dev recordings: nothing where `cancel` asked
    /// for an end.
    ///
    /// # Errors
    /// See [`BatchError`].
    pub fn plan(
        self,
        context: ExperimentContext<'_>,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(PlanningEvent),
    ) -> Result<Option<BatchPlan>, BatchError> {
        let thresholds: &std::sync::Arc<Thresholds> = context.thresholds;
        self.request
            .plan(context.library, thresholds, cancel, on_event)
    }
}

/// A question about a dev scenario, with what is true about it.
#[derive(Debug, Clone)]
pub struct TuneQuestion {
    /// The question as the base template asks it.
    pub question: Question,
    /// The place of its scenario in [`TunePlan::scenarios`].
    pub scenario: usize,
    /// What is true.
    pub truth: Label,
    /// The obstacles that are truly critical.
    pub critical: Vec<i64>,
}

/// What is tuned.
#[derive(Debug)]
pub struct TunePlan {
    /// The way of asking.
    pub way: PromptConfig,
    /// The base template: its file.
    pub file: String,
    /// The base template.
    pub template: Template,
    /// SHA-256 of it and of what it includes.
    pub hash: String,
    /// The names of the dev scenarios.
    pub scenarios: Vec<String>,
    /// Their parts.
    pub division: Division,
    /// The questions about them, in order.
    pub questions: Vec<TuneQuestion>,
    /// Questions that are left out, since no prompt can be made or their truth is unknown.
    pub left_out: usize,
    /// By which rules answers count.
    pub(super) protocol: Protocol,
    /// Whether risk scores tell what is true, not contacts.
    pub(super) by_score: bool,
    /// The templates.
    pub(super) library: Library,
    /// What a template must not have from the dev scenarios.
    pub(super) traces: Traces,
}

impl TunePlan {
    /// Makes the questions of a plan, and divides its scenarios by a seed.
    ///
    /// # Errors
    /// There are too few scenarios of a kind, or a template cannot be read: in words.
    pub fn new(
        plan: &BatchPlan,
        dry_run: &DryRun,
        library: &Library,
        seed: u64,
    ) -> Result<Self, String> {
        let library = plan.spec.library(library).map_err(|why| why.to_string())?;
        let askable = |item: &&NewItem| item.unaskable.is_none() && item.collides.is_some();
        let items: Vec<&NewItem> = dry_run.items.iter().filter(askable).collect();
        let made = items.par_iter().map(|item| made(plan, item));
        let made: Vec<(PromptConfig, Question)> = made.collect::<Result<_, String>>()?;
        let mut scenarios: Vec<(String, bool)> = Vec::new();
        let mut questions = Vec::with_capacity(items.len());
        let mut way = None;
        for (item, (asked, question)) in items.iter().zip(made) {
            let known = scenarios
                .iter()
                .position(|(name, _)| *name == item.scenario);
            let scenario = known.unwrap_or_else(|| {
                scenarios.push((item.scenario.clone(), false));
                scenarios.len() - 1
            });
            let Some(truth) = label_of_item(item) else {
                continue;
            };
            scenarios[scenario].1 |= truth.collides();
            way.get_or_insert(asked);
            questions.push(TuneQuestion {
                question,
                scenario,
                truth,
                critical: critical_of(truth, item.facts.as_ref()),
            });
        }
        let (Some(way), Some(first)) = (way, questions.first()) else {
            return Err("no dev scenario can be asked about".into());
        };
        let file = first.question.template.clone();
        let (template, _) = library
            .file(&file)
            .ok_or_else(|| format!("{file}: not a template"))?;
        let named: Vec<(&str, bool)> = scenarios.iter().map(|(n, d)| (n.as_str(), *d)).collect();
        let division = Division::new(&named, seed)?;
        let (template, hash) = (template.clone(), first.question.template_hash.clone());
        let scenarios: Vec<String> = scenarios.into_iter().map(|(name, _)| name).collect();
        Ok(Self {
            traces: Traces::new(&scenarios, questions.iter().map(|one| &one.question)),
            way,
            file,
            template,
            hash,
            division,
            left_out: dry_run.items.len() - questions.len(),
            protocol: plan.spec.experiment.protocol,
            by_score: plan.spec.truth().is_score(first.question.case.task),
            library,
            scenarios,
            questions,
        })
    }

    /// The places of the questions of a part.
    #[must_use]
    pub fn of_part(&self, part: DevPart) -> Vec<usize> {
        let all = self.questions.iter().enumerate();
        let of = all.filter(|(_, one)| self.division.parts[one.scenario] == part);
        of.map(|(place, _)| place).collect()
    }

    /// What gains are over: maps, where the parts have whole ones.
    #[must_use]
    pub fn cluster(&self) -> Cluster {
        if self.division.by_map {
            Cluster::Map
        } else {
            Cluster::Scenario
        }
    }

    /// The units of the selection part.
    #[must_use]
    pub fn units(&self) -> BTreeSet<&str> {
        let parts = self.scenarios.iter().zip(&self.division.parts);
        let selected = parts.filter(|(_, part)| **part == DevPart::Selection);
        selected.map(|(name, _)| self.cluster().of(name)).collect()
    }

    /// Scenarios of a part, its questions, and how many of these are dangerous.
    #[must_use]
    pub fn counts(&self, part: DevPart) -> (usize, usize, usize) {
        let scenarios = self
            .division
            .parts
            .iter()
            .filter(|one| **one == part)
            .count();
        let places = self.of_part(part);
        let dangerous = places
            .iter()
            .filter(|at| self.questions[**at].truth.collides())
            .count();
        (scenarios, places.len(), dangerous)
    }
}

fn made(plan: &BatchPlan, item: &NewItem) -> Result<(PromptConfig, Question), String> {
    let entry = Entry::of_argument(Path::new(&item.path));
    let (way, variant) = (configuration_of_item(item)?, Variant::from_item(item)?);
    let question = plan
        .builder
        .question(&entry, &way, &variant, label_of_item(item))?;
    Ok((way, Question::clone(&question)))
}
