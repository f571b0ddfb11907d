//! A batch's answers with their ground truth: parsed again from their texts, failed ones included.

use std::collections::{BTreeMap, HashMap};

use rayon::prelude::*;

use super::question_builder::{Variant, obstacle};
use super::spec::Spec;
use super::truth::Truth;
use super::windows::critical_obstacles;
use crate::evaluation::report::QuestionKey;
use crate::evaluation::{
    AnswerCase, AnswerStatus, Attempt, Cluster, Label, LabelError, Lead, PromptConfig, Protocol,
    Scored, TemplateVersion, with_token_probability,
};
use nearmiss_ask::prompts::Techniques;
use nearmiss_formats::Entry;
use nearmiss_scene::description::Frame;
use nearmiss_scene::judge;
use nearmiss_scene::scenario::{Transform, Window};
use nearmiss_scene::verdict::{self, Task, Verdict};
use nearmiss_store::{
    BatchId, Item, ItemState, ItemTruth, NewItem, NewestAnswer, QuestionRun, SplitPart, Store,
    StoreError, attempt_rank,
};

/// The answers of a batch, those about its scenes as they are and with the first lead apart from the others.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Answers {
    /// About the scenes as they are, with the first lead: what is right or wrong is counted of these.
    pub plain: Vec<Scored>,
    /// About changed scenes, called as [`Transform::name`] says, with the ids of the originals.
    pub changed: Vec<Scored>,
    /// About the scenes as they are, at every lead that has a name, the first one, too; none of batches with fewer
    /// than two.
    pub leads: Vec<(Lead, Scored)>,
    /// The places of the plain ones in the batch, in the same order.
    pub places: Vec<u64>,
    /// The leads that the plain ones were asked at, in the same order.
    pub plain_leads: Vec<Option<Lead>>,
    /// Those that are not among the plain ones.
    pub others: usize,
}

impl Answers {
    /// Takes this unit for intervals and comparisons.
    pub fn cluster(&mut self, cluster: Cluster) {
        let leads = self.leads.iter_mut().map(|(_, one)| one);
        let all = self.plain.iter_mut().chain(&mut self.changed).chain(leads);
        all.for_each(|one| one.cluster = cluster);
    }

    /// Sorts answers to the questions at these `places` of a batch by what each is about.
    pub fn sorted(all: Vec<(Variant, Scored)>, places: impl IntoIterator<Item = u64>) -> Self {
        // Of every scenario the first lead stands before the others. Where leads were added to a batch without one, what
        // it was begun with comes first.
        let without = |(variant, scored): &(Variant, Scored)| {
            scored.configuration.task == Task::Safety && *variant == Variant::default()
        };
        let first = if all.iter().any(without) {
            None
        } else {
            all.iter().find_map(|(variant, _)| variant.lead)
        };
        let several = all
            .iter()
            .any(|(variant, _)| variant.lead.is_some() && variant.lead != first);
        let questions = all.len();
        let mut sorted = Self::default();
        for ((variant, scored), place) in all.into_iter().zip(places) {
            if variant.transform.is_some() {
                sorted.changed.push(scored);
                continue;
            }
            if let Some(lead) = variant.lead.filter(|_| several) {
                sorted.leads.push((lead, scored.clone()));
            }
            if variant.lead.is_none() || variant.lead == first {
                sorted.plain.push(scored);
                sorted.places.push(place);
                sorted.plain_leads.push(variant.lead);
            }
        }
        sorted.others = questions - sorted.plain.len();
        let scored = &mut sorted.plain;
        let question = |one: &Scored| (one.scenario.clone(), one.configuration.task, one.window);
        let reference: HashMap<_, Verdict> = scored
            .iter()
            .filter(|one| one.configuration.model == judge::MODEL)
            .filter_map(|one| Some((question(one), one.status.verdict()?.clone())))
            .collect();
        for one in scored {
            one.reference = reference.get(&question(one)).cloned();
        }
        sorted
    }

    /// Every answer once, with its lead and its transform.
    #[must_use]
    pub fn cases(&self) -> Vec<AnswerCase<'_>> {
        let case = |scored, lead| AnswerCase { scored, lead };
        let plain = self
            .plain
            .iter()
            .zip(&self.plain_leads)
            .map(|(scored, lead)| case(scored, *lead));
        let is_plain = |lead: &Lead| self.plain_leads.contains(&Some(*lead));
        let leads = self
            .leads
            .iter()
            .filter(|(lead, _)| !is_plain(lead))
            .map(|(lead, scored)| case(scored, Some(*lead)));
        let first = self.plain_leads.iter().flatten().next().copied();
        let changed = self.changed.iter().map(|one| {
            case(
                one,
                first.filter(|_| one.configuration.task == Task::Safety),
            )
        });
        plain.chain(leads).chain(changed).collect()
    }
}

/// Every yes-or-no question of a batch with its answer, in order: the newest complete answer to the same request and
/// sample, else why there is none.
///
/// Verdicts are parsed again from the stored texts; what has none by its reading keeps none, as in reports of runs.
///
/// # Errors
/// The store cannot be read, or holds words that this version does not know.
pub fn answers(store: &Store, batch: BatchId) -> Result<Answers, StoreError> {
    answers_of_part(store, batch, None)
}

/// The same of one part of a split; `None` for all questions.
///
/// # Errors
/// As [`answers`].
pub fn answers_of_part(
    store: &Store,
    batch: BatchId,
    part: Option<SplitPart>,
) -> Result<Answers, StoreError> {
    let mut found = store.items_with_answers(batch)?;
    found.retain(|(item, _)| Task::VERDICTS.contains(&item.asked.task));
    found.retain(|(item, _)| part.is_none() || item.asked.split == part);
    let protocol = protocol(store, batch)?;
    let mut all = read(&found, &store.question_runs(batch, 0, None)?)?;
    all.iter_mut()
        .for_each(|(_, scored)| protocol.count(scored));
    let mut templates = BatchTemplates::default();
    templates.note(&found);
    all.iter_mut()
        .for_each(|(_, scored)| templates.name(&mut scored.configuration));
    let places = found.iter().map(|(item, _)| item.place);
    Ok(Answers::sorted(all, places))
}

/// The rules by which the answers of a batch count.
fn protocol(store: &Store, batch: BatchId) -> Result<Protocol, StoreError> {
    let Some(batch) = store.batch(batch)? else {
        return Ok(Protocol::default());
    };
    let spec = Spec::from_json(&batch.spec).map_err(|why| StoreError::Word(why.to_string()))?;
    Ok(spec.experiment.protocol)
}

/// The templates that a batch asks with, by task and frame: it pins one version of each, which its answers tell.
#[derive(Debug, Default)]
pub(super) struct BatchTemplates(BTreeMap<(Task, String), TemplateVersion>);

impl BatchTemplates {
    /// Notes what these questions were asked with.
    pub fn note(&mut self, found: &[(Item, Option<NewestAnswer>)]) {
        for (item, answer) in found {
            let (Some(frame), Some(answer)) = (&item.asked.frame, answer) else {
                continue;
            };
            if let Some(version) = TemplateVersion::from_stored(&answer.template) {
                let place = (item.asked.task, frame.clone());
                self.0.entry(place).or_insert(version);
            }
        }
    }

    /// Gives a way of asking the version of its template.
    pub fn name(&self, configuration: &mut PromptConfig) {
        let frame = configuration.frame.map(|frame| frame.name().to_string());
        let place = frame.map(|frame| (configuration.task, frame));
        configuration.template = place.and_then(|place| self.0.get(&place).cloned());
    }
}

/// The runs that were made for questions of a batch, by their places.
type Runs = BTreeMap<u64, Vec<QuestionRun>>;

/// Answers to questions of a batch, in order, with the variant each is about, and with all `runs` made for them.
///
/// # Errors
/// The store holds words that this version does not know.
pub(super) fn read(
    found: &[(Item, Option<NewestAnswer>)],
    runs: &Runs,
) -> Result<Vec<(Variant, Scored)>, StoreError> {
    let one = |(item, found): &(Item, Option<NewestAnswer>)| {
        let variant = Variant::from_item(&item.asked).map_err(StoreError::Word)?;
        let runs = runs.get(&item.place).map_or(&[][..], Vec::as_slice);
        let scored = one(item, found.as_ref(), runs)?;
        Ok((variant, with_original_ids(item, variant.transform, scored)))
    };
    found.par_iter().map(one).collect()
}

/// An answer about a changed scene under its name, with the ids of the original. New numbers can be told back only as
/// long as the scenario can be read as it was.
fn with_original_ids(item: &Item, change: Option<Transform>, mut scored: Scored) -> Scored {
    let Some(change) = change else { return scored };
    scored.scenario = change.name(&scored.scenario);
    if !matches!(change, Transform::Renumber(_))
        || !matches!(scored.status, AnswerStatus::Verdict(_))
    {
        return scored;
    }
    let asked = &item.asked;
    if let Some(known) = asked.scene.as_ref().filter(|scene| !scene.ids.is_empty()) {
        return scored.mapped_back(&known.ids);
    }
    let read = Entry::of_argument(std::path::Path::new(&asked.path)).read();
    match read.map_err(|error| error.to_string()) {
        Ok(scenario) if asked.scenario_hash == Some(scenario.hash.to_string()) => {
            scored.mapped_back(&change.ids(&scenario))
        }
        Ok(_) => {
            let why = "its obstacle ids cannot be mapped back: the scenario has changed";
            scored.status = AnswerStatus::Failed(why.into());
            scored
        }
        Err(why) => {
            scored.status =
                AnswerStatus::Failed(format!("its obstacle ids cannot be mapped back: {why}"));
            scored
        }
    }
}

fn one(
    item: &Item,
    found: Option<&NewestAnswer>,
    runs: &[QuestionRun],
) -> Result<Scored, StoreError> {
    let asked = &item.asked;
    // The same that counts in a report of the store.
    let counts = match found {
        Some(found) => runs.iter().find(|one| one.run == found.run),
        None => runs
            .iter()
            .max_by_key(|one| (attempt_rank(one.state), one.run)),
    };
    let others = runs
        .iter()
        .filter(|one| Some(one.run) != counts.map(|c| c.run));
    let window = counts.or(runs.first()).and_then(|one| one.window);
    let status = match found {
        // What the text alone does not say: the question was cut, a draft in thinking, a refusal.
        Some(found) if found.verdict.is_none() && found.reading.is_some() => {
            AnswerStatus::Unparsed(found.reading.clone().unwrap_or_default())
        }
        Some(found) => match verdict::parse(asked.task, &found.text) {
            Ok(parsed) => AnswerStatus::Verdict(with_token_probability(
                parsed.verdict,
                found.verdict.as_deref(),
            )),
            Err(why) => AnswerStatus::Unparsed(why.to_string()),
        },
        None => without_answer(item),
    };
    let asked_for = !matches!(status, AnswerStatus::Unasked(_));
    Ok(Scored {
        scenario: asked.scenario.clone(),
        configuration: configuration_of_item(asked).map_err(StoreError::Word)?,
        sample: asked.sample,
        truth: label_of_item(asked),
        critical: label_of_item(asked).map_or_else(Vec::new, |label| {
            critical_obstacles(label, asked.facts.as_ref())
        }),
        status,
        reference: None,
        window: asked
            .window
            .or_else(|| QuestionKey::window(asked.task, window)),
        consumed: counts.map(|one| one.consumed).unwrap_or_default(),
        most_usd: counts.and_then(|one| one.most_usd),
        superseded: others.map(attempt).collect(),
        claims: counts.map(|one| one.claims).unwrap_or_default(),
        cluster: asked.split.map_or(Cluster::Scenario, |_| Cluster::Map),
        // A question that was not asked has no run but those that were made for it.
        run: counts.map(|one| one.run).or(item.run.filter(|_| asked_for)),
    })
}

fn attempt(run: &QuestionRun) -> Attempt {
    let (consumed, most_usd) = (run.consumed, run.most_usd);
    Attempt { consumed, most_usd }
}

/// Why a question has no whole answer: it was asked and none came, or it was not asked.
fn without_answer(item: &Item) -> AnswerStatus {
    let why = |usual: &str| item.error.clone().unwrap_or_else(|| usual.into());
    match item.state {
        ItemState::Answered => AnswerStatus::Failed(why("the answer was deleted from the store")),
        ItemState::Truncated | ItemState::Failed => AnswerStatus::Failed(why("no complete answer")),
        ItemState::Waiting => AnswerStatus::Unasked(why("not asked yet")),
        ItemState::Unaskable => {
            AnswerStatus::Unasked(why("no question can be built from the scenario"))
        }
    }
}

/// The questions of a batch beside another truth, with the critical obstacles that it tells.
///
/// The `builder` opens scenarios where the truth needs their scene.
///
/// # Errors
/// A label names an obstacle that its scenario does not have.
pub fn relabel(
    items: &[Item],
    truth: &Truth,
    builder: &super::QuestionBuilder,
) -> Result<Vec<ItemTruth>, LabelError> {
    items
        .par_iter()
        .map(|item| {
            let entry = Entry::of_argument(std::path::Path::new(&item.asked.path));
            let task = item.asked.task;
            let scene = match truth {
                Truth::Geometry | Truth::Score(_) => builder.open(&entry).ok(),
                Truth::Layout(_) if task == Task::Recording => builder.open(&entry).ok(),
                Truth::Labels(labels) if labels.names_an_obstacle(&entry.name) => {
                    builder.open(&entry).ok()
                }
                Truth::Layout(_) | Truth::Labels(_) | Truth::Known(_) => None,
            };
            let scene = scene.as_ref().map(|reading| &*reading.scene);
            truth.fits(&entry, scene)?;
            let by_score = task == Task::Safety && truth.convention().is_some();
            let told = match (scene, asked_steps(item)) {
                (Some(scene), Some((first, last))) if by_score || task == Task::Recording => {
                    let steps = usize::try_from(last - first + 1).unwrap_or(1);
                    let window = Window::ending_at(scene, last, steps);
                    let about = (&entry, Some(scene));
                    let horizon = builder.horizon();
                    truth.of_question(task, about, (&window, horizon), builder.thresholds())
                }
                // Which steps a score would have to be about is not known.
                _ if by_score => None,
                _ => truth
                    .label(&entry, scene)
                    .map(|label| (label, label.critical())),
            };
            let told = match (told, item.asked.window) {
                (Some((label, _)), Some(steps)) if !by_score => {
                    Some(builder.window_truth(&entry, item, label, steps))
                }
                (told, _) => told,
            };
            let (label, critical) = told.unzip();
            Ok(ItemTruth {
                place: item.place,
                collides: label.map(Label::collides),
                obstacle: obstacle(label),
                critical: Some(critical.unwrap_or_default()),
            })
        })
        .collect()
}

/// The steps that a question is about, as far as they are known.
fn asked_steps(item: &Item) -> Option<(i64, i64)> {
    let facts = item.asked.facts.as_ref();
    item.asked.window.or(facts.map(|facts| facts.steps))
}

/// How a question was asked.
///
/// # Errors
/// A word that this version does not know.
pub fn configuration_of_item(asked: &NewItem) -> Result<PromptConfig, String> {
    let frame = asked.frame.as_deref().map(|word| {
        Frame::parse(word).ok_or_else(|| format!("the frame {word} is not known to this version"))
    });
    Ok(PromptConfig {
        task: asked.task,
        frame: frame.transpose()?,
        techniques: asked
            .techniques
            .as_deref()
            .map(Techniques::parse)
            .transpose()?,
        model: asked.model.clone(),
        settings: asked
            .settings
            .as_deref()
            .map(str::parse)
            .transpose()?
            .unwrap_or_default(),
        template: None,
    })
}

/// The ground truth stored by the batch.
#[must_use]
pub fn label_of_item(asked: &NewItem) -> Option<Label> {
    asked.collides.map(|collides| {
        if collides {
            Label::Collision(asked.obstacle)
        } else {
            Label::Safe
        }
    })
}
