//! The built-in judge's verdicts on a batch's questions, even if it is not one of the batch's models.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use rayon::prelude::*;

use super::question_builder::QuestionBuilder;
use super::scored::{Answers, label_of, way_of};
use super::variant::Variant;
use crate::evaluation::PromptConfig;
use crate::formats::Entry;
use crate::store::{Item, NewItem};
use crate::verdict::{Task, Verdict};

/// A scenario that the judge could not be asked about, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnjudgedScenario {
    /// Its name.
    pub scenario: String,
    /// The reason.
    pub why: String,
}

/// The settings that make the judge's verdicts on one scenario differ.
type VerdictKey<'a> = (Task, Option<&'a str>, Option<&'a str>, Option<&'a str>);

/// Sets the built-in judge's verdict beside those plain answers of a batch that have none, as the batch asks: each
/// scenario is opened once, those of several at once. Says which could not be judged.
#[must_use]
pub fn beside_the_judge(
    answers: &mut Answers,
    items: &[Item],
    builder: &QuestionBuilder,
) -> Vec<UnjudgedScenario> {
    let by_place: HashMap<u64, &Item> = items.iter().map(|item| (item.place, item)).collect();
    let mut missing: BTreeMap<&str, Vec<(usize, &NewItem)>> = BTreeMap::new();
    for (at, (one, place)) in answers.plain.iter().zip(&answers.places).enumerate() {
        if let (None, Some(item)) = (&one.reference, by_place.get(place)) {
            let of_file = missing.entry(item.asked.path.as_str()).or_default();
            of_file.push((at, &item.asked));
        }
    }
    let judged: Vec<_> = missing
        .par_iter()
        .map(|(path, asked)| of_scenario(path, asked, builder))
        .collect();
    let mut unjudged = Vec::new();
    for found in judged {
        for (at, verdict) in found.verdicts {
            answers.plain[at].reference = Some(verdict);
        }
        unjudged.extend(found.unjudged);
    }
    unjudged
}

#[derive(Default)]
struct OfScenario {
    /// By place among the plain answers.
    verdicts: Vec<(usize, Verdict)>,
    unjudged: Option<UnjudgedScenario>,
}

fn of_scenario(path: &str, asked: &[(usize, &NewItem)], builder: &QuestionBuilder) -> OfScenario {
    let mut found = OfScenario::default();
    let entry = Entry::of_argument(Path::new(path));
    let scene = builder.open(&entry).map(|reading| reading.scene);
    // Many questions are about the same file.
    let hash = scene.as_ref().ok();
    let hash = hash.map(|scene| scene.scenario.hash.to_string());
    let mut known: HashMap<VerdictKey<'_>, Result<Verdict, String>> = HashMap::new();
    for &(at, asked) in asked {
        let verdict = match &scene {
            Err(why) => Err(why.clone()),
            Ok(_) if asked.scenario_hash != hash => {
                Err("the file is no longer the one that was asked about".into())
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
        match verdict {
            Ok(verdict) => found.verdicts.push((at, verdict)),
            Err(why) => {
                found.unjudged.get_or_insert_with(|| UnjudgedScenario {
                    scenario: asked.scenario.clone(),
                    why,
                });
            }
        }
    }
    found
}

/// The window depends on the lead, and on what the template of the frame and the techniques say; the judge itself on
/// neither.
fn about(asked: &NewItem) -> VerdictKey<'_> {
    let (frame, techniques) = (asked.frame.as_deref(), asked.techniques.as_deref());
    match asked.task {
        // The judge looks at the whole recording.
        Task::Collision => (asked.task, None, None, None),
        _ => (asked.task, frame, techniques, asked.lead.as_deref()),
    }
}
