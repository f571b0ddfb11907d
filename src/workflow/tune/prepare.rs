//! From an experiment to what is tuned: one configuration, the questions about the dev scenarios, and their parts.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use nearmiss_ask::prompts::{Library, Template};
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_record::fields::Fields;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::identity;
use nearmiss_store::{NewItem, SplitPart};
use nearmiss_study::evaluation::batch::{
    Experiment, Spec, Split, Variant, configuration_of_item, critical_obstacles, label_of_item,
};
use nearmiss_study::evaluation::statistics::SplitMix;
use nearmiss_study::evaluation::{
    Cluster, Label, PromptConfig, Protocol, Question, is_stored_alone,
};
use rayon::prelude::*;
use strum::{IntoStaticStr, VariantArray};

use super::candidate::Traces;
use crate::batch::{BatchError, BatchPlan, BatchRequest, DryRun, PlanningEvent};
use crate::{ExperimentContext, batch_request, hashed_name, selected};

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
    let mut one = single_configuration(experiment).map_err(named)?;
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
    one.hashes.retain(|key, _| is_dev(hashed_name(key)));
    let asked = Spec::templates_for(&one, context.library);
    one.templates.retain(|pin| asked.contains_key(&pin.name));
    let dev = selected(dev, one.select.as_deref(), context.thresholds).map_err(named)?;
    let request = batch_request(&one, dev, None, context.library).map_err(named)?;
    Ok(TuneRequest {
        request,
        test_scenarios: test.len(),
    })
}

/// The same with one way of asking, about the scenes as they are and at the first lead.
fn single_configuration(experiment: &Experiment) -> Result<Experiment, String> {
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
    if model.starts_with("reference/") || is_stored_alone(&model) {
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
    pub configuration: PromptConfig,
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
        let made = items.par_iter().map(|item| build_question(plan, item));
        let made: Vec<(PromptConfig, Question)> = made.collect::<Result<_, String>>()?;
        let mut scenarios: Vec<(String, bool)> = Vec::new();
        let mut questions = Vec::with_capacity(items.len());
        let mut configuration = None;
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
            configuration.get_or_insert(asked);
            questions.push(TuneQuestion {
                question,
                scenario,
                truth,
                critical: critical_obstacles(truth, item.facts.as_ref()),
            });
        }
        let (Some(configuration), Some(first)) = (configuration, questions.first()) else {
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
            configuration,
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
        selected
            .map(|(name, _)| self.cluster().unit(name))
            .collect()
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

fn build_question(plan: &BatchPlan, item: &NewItem) -> Result<(PromptConfig, Question), String> {
    let entry = Entry::of_argument(Path::new(&item.path));
    let (configuration, variant) = (configuration_of_item(item)?, Variant::from_item(item)?);
    let question = plan
        .builder
        .question(&entry, &configuration, &variant, label_of_item(item))?;
    Ok((configuration, Question::clone(&question)))
}

/// A part of the dev split.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum DevPart {
    /// Wrong answers of it are shown to the reflecting model.
    Feedback,
    /// Templates are compared on it.
    Selection,
}

nearmiss_record::named!(DevPart);

/// The part of each scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Division {
    /// In the order of the scenarios.
    pub parts: Vec<DevPart>,
    /// Whether scenarios on the same map are in the same part; with fewer than two maps of a kind they are not.
    pub by_map: bool,
}

/// Share of the scenarios that is shown.
const SHOWN_SHARE: f64 = 0.4;

impl Division {
    /// Divides scenarios, each with its name and whether one of its windows is dangerous: both parts get dangerous and
    /// safe ones, by a seed.
    ///
    /// # Errors
    /// There are too few of a kind.
    pub fn new(scenarios: &[(&str, bool)], seed: u64) -> Result<Self, String> {
        let family = |name: &str| identity::family(name).to_string();
        if let Some(parts) = divided(scenarios, seed, family) {
            let by_map = true;
            return Ok(Self { parts, by_map });
        }
        let alone = divided(scenarios, seed, |name| name.to_string());
        let by_map = false;
        alone.map(|parts| Self { parts, by_map }).ok_or_else(|| {
            let dangerous = scenarios.iter().filter(|(_, dangerous)| *dangerous).count();
            format!(
                "the dev split has {dangerous} dangerous and {} safe scenarios; tuning needs at least two of each: change \
                 the share or the seed of the split, or add scenarios",
                scenarios.len() - dangerous
            )
        })
    }
}

/// The parts, where scenarios of one unit stay together; `None` where a kind has fewer than two units.
fn divided(
    scenarios: &[(&str, bool)],
    seed: u64,
    unit_of: impl Fn(&str) -> String,
) -> Option<Vec<DevPart>> {
    let mut units: BTreeMap<String, (Vec<usize>, bool)> = BTreeMap::new();
    for (place, (name, dangerous)) in scenarios.iter().enumerate() {
        let unit = units.entry(unit_of(name)).or_default();
        unit.0.push(place);
        unit.1 |= dangerous;
    }
    let mut parts = vec![DevPart::Selection; scenarios.len()];
    for kind in [true, false] {
        let mut of_kind: Vec<(u64, &Vec<usize>)> = units
            .iter()
            .filter(|(_, (_, dangerous))| *dangerous == kind)
            .map(|(name, (places, _))| (order(seed, name), places))
            .collect();
        if of_kind.len() < 2 {
            return None;
        }
        of_kind.sort_unstable();
        let all: usize = of_kind.iter().map(|(_, places)| places.len()).sum();
        let wanted = (all as f64 * SHOWN_SHARE).round().max(1.0) as usize;
        let mut shown = 0;
        // The last one is for the selection.
        for (_, places) in &of_kind[..of_kind.len() - 1] {
            if shown >= wanted {
                break;
            }
            shown += places.len();
            for place in *places {
                parts[*place] = DevPart::Feedback;
            }
        }
    }
    Some(parts)
}

/// A number for a name that another seed makes another one: FNV-1a, mixed.
fn order(seed: u64, name: &str) -> u64 {
    let hash = name.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    SplitMix(hash ^ SplitMix(seed).draw()).draw()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn names(maps: usize) -> Vec<(String, bool)> {
        let name = |map: usize, number: usize| format!("DEU_Town-{map}_{number}_T-1");
        let of_map = |map| (1..=2).map(move |number| (name(map, number), map % 2 == 0));
        (1..=maps).flat_map(of_map).collect()
    }

    fn divide(all: &[(String, bool)], seed: u64) -> Result<Division, String> {
        let all: Vec<(&str, bool)> = all.iter().map(|(n, d)| (n.as_str(), *d)).collect();
        Division::new(&all, seed)
    }

    #[test]
    fn both_parts_have_both_kinds_and_maps_stay_together() {
        let all = names(20);
        let found = divide(&all, 1).unwrap();
        assert!(found.by_map);
        for part in [DevPart::Feedback, DevPart::Selection] {
            for kind in [true, false] {
                let of = all.iter().zip(&found.parts);
                let count = of.filter(|((_, d), p)| *d == kind && **p == part).count();
                assert_eq!(count, if part == DevPart::Feedback { 8 } else { 12 });
            }
        }
        for pair in found.parts.chunks(2) {
            assert_eq!(pair[0], pair[1]);
        }
        assert_eq!(divide(&all, 1).unwrap(), found);
        assert_ne!(divide(&all, 2).unwrap(), found);
    }

    #[test]
    fn few_maps_are_divided_by_scenario_and_too_few_scenarios_not_at_all() {
        let two = names(2);
        let found = divide(&two, 1).unwrap();
        assert!(!found.by_map);
        assert_eq!(
            found
                .parts
                .iter()
                .filter(|p| **p == DevPart::Feedback)
                .count(),
            2
        );
        let why = divide(&two[..3], 1).unwrap_err();
        assert!(why.contains("1 dangerous and 2 safe"), "{why}");
    }
}
