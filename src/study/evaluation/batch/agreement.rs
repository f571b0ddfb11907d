//! The built-in judge's verdicts on a batch's questions, even if it is not one of the batch's models.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use rayon::prelude::*;

use super::question_builder::QuestionBuilder;
use super::scored::{Answers, label_of, way_of};
use super::variant::Variant;
use crate::evaluation::PromptConfig;
use nearmiss_base::system::without_folders;
use nearmiss_formats::Entry;
use nearmiss_scene::verdict::{Task, Verdict};
use nearmiss_store::{Item, NewItem, SceneRecord};

/// A scenario that the judge could not be asked about, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnjudgedScenario {
    /// Its name.
    pub scenario: String,
    /// The reason.
    pub why: String,
}

/// The settings that make the judge's verdicts on one scenario differ.
type VerdictKey<'a> = (
    Task,
    Option<&'a str>,
    Option<&'a str>,
    Option<&'a str>,
    Option<(i64, i64)>,
);

/// The built-in judge's verdict on a question, or why it could not be asked.
pub type Judgement = Result<Verdict, String>;

/// What came of asking the built-in judge about the answers without its verdict.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Judgements {
    /// By place in the batch.
    pub all: BTreeMap<u64, Judgement>,
    /// Scenarios that it could not be asked about, by name.
    pub unjudged: Vec<UnjudgedScenario>,
}

impl Judgements {
    /// How many verdicts there are.
    #[must_use]
    pub fn verdicts(&self) -> usize {
        self.all.values().filter(|one| one.is_ok()).count()
    }
}

/// Sets the built-in judge's verdict beside those plain answers of a batch that have none, as the batch asks: from the
/// records of a bundle, else from the scenarios, each of which is opened once, those of several at once. `builder` is
/// needed for the latter only.
#[must_use]
pub fn beside_the_judge(
    answers: &mut Answers,
    items: &[Item],
    builder: impl FnOnce() -> Result<QuestionBuilder, String>,
) -> Judgements {
    let by_place: HashMap<u64, &Item> = items.iter().map(|item| (item.place, item)).collect();
    let mut all: BTreeMap<u64, Judgement> = BTreeMap::new();
    let mut missing: BTreeMap<&str, Vec<(u64, &NewItem)>> = BTreeMap::new();
    for (one, place) in answers.plain.iter().zip(&answers.places) {
        let (None, Some(item)) = (&one.reference, by_place.get(place)) else {
            continue;
        };
        match item.asked.scene.as_ref().and_then(SceneRecord::judgement) {
            Some(known) => drop(all.insert(*place, known)),
            None => {
                let of_file = missing.entry(item.asked.path.as_str()).or_default();
                of_file.push((*place, &item.asked));
            }
        }
    }
    if !missing.is_empty() {
        let builder = builder();
        let judged: Vec<Vec<(u64, Judgement)>> = missing
            .par_iter()
            .map(|(path, asked)| match &builder {
                Ok(builder) => of_scenario(path, asked, builder),
                Err(why) => asked
                    .iter()
                    .map(|(at, _)| (*at, Err(why.clone())))
                    .collect(),
            })
            .collect();
        all.extend(judged.into_iter().flatten());
    }
    for (one, place) in answers.plain.iter_mut().zip(&answers.places) {
        if let Some(Ok(verdict)) = all.get(place) {
            one.reference = Some(verdict.clone());
        }
    }
    let mut unjudged: BTreeMap<(&str, &str), &String> = BTreeMap::new();
    for (place, judgement) in &all {
        if let (Err(why), Some(item)) = (judgement, by_place.get(place)) {
            let scenario = (item.asked.scenario.as_str(), item.asked.path.as_str());
            unjudged.entry(scenario).or_insert(why);
        }
    }
    let unjudged = unjudged
        .into_iter()
        .map(|((scenario, _), why)| UnjudgedScenario {
            scenario: scenario.into(),
            why: why.clone(),
        })
        .collect();
    Judgements { all, unjudged }
}

fn of_scenario(
    path: &str,
    asked: &[(u64, &NewItem)],
    builder: &QuestionBuilder,
) -> Vec<(u64, Judgement)> {
    let entry = Entry::of_argument(Path::new(path));
    let scene = builder.open(&entry).map(|reading| reading.scene);
    // Many questions are about the same file.
    let hash = scene.as_ref().ok();
    let hash = hash.map(|scene| scene.scenario.hash.to_string());
    let mut known: HashMap<VerdictKey<'_>, Judgement> = HashMap::new();
    let each = asked.iter().map(|&(at, asked)| {
        let verdict = match &scene {
            Err(why) => Err(why.clone()),
            Ok(_) if asked.scenario_hash != hash => {
                Err("the file has changed since it was asked about".into())
            }
            Ok(scene) => known
                .entry(about(asked))
                .or_insert_with(|| {
                    let way = PromptConfig {
                        model: String::new(),
                        ..way_of(asked)?
                    };
                    let variant = Variant::from_item(asked)?;
                    builder.judged(&entry, scene, &way, &variant, label_of(asked))
                })
                .clone(),
        };
        // The same words wherever the file lies.
        (at, verdict.map_err(|why| named(&why, path)))
    });
    each.collect()
}

/// A reason without the folders of its scenario.
fn named(why: &str, path: &str) -> String {
    let name = Path::new(path)
        .file_name()
        .unwrap_or_default()
        .to_string_lossy();
    without_folders(&why.replace(path, &name))
}

/// The window depends on the lead, and on what the template of the frame and the techniques say; the judge itself on
/// neither.
fn about(asked: &NewItem) -> VerdictKey<'_> {
    let (frame, techniques) = (asked.frame.as_deref(), asked.techniques.as_deref());
    match asked.task {
        // The judge looks at the whole recording.
        task if task.is_about_all_steps() => (task, None, None, None, None),
        _ => (
            asked.task,
            frame,
            techniques,
            asked.lead.as_deref(),
            asked.window,
        ),
    }
}
