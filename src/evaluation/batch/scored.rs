//! The answers of a batch beside what is true: read anew from their texts, with those that failed.

use rayon::prelude::*;

use super::desk::obstacle;
use super::truth::Truth;
use crate::evaluation::{Label, Said, Scored, Way};
use crate::judge;
use crate::prompts::Techniques;
use crate::scenario::Entry;
use crate::store::{BatchId, Consumed, Found, Item, ItemState, NewItem, Store, StoreError};
use crate::text::Frame;
use crate::verdict::{self, Verdict};

/// Every question of a batch with what was said to it, in their order: the newest whole answer to the same request and
/// sample, else why there is none.
///
/// Verdicts are read from the stored texts, so that a better parser finds more in them without asking again.
///
/// # Errors
/// The store cannot be read, or holds words that this version does not know.
pub fn scored(store: &Store, batch: BatchId) -> Result<Vec<Scored>, StoreError> {
    let found = store.items_with_answers(batch)?;
    let mut scored = found
        .par_iter()
        .map(|(item, found)| one(item, found.as_ref()))
        .collect::<Result<Vec<Scored>, _>>()?;
    let reference: Vec<(String, verdict::Task, Verdict)> = scored
        .iter()
        .filter(|one| one.way.model == judge::MODEL)
        .filter_map(|one| match &one.said {
            Said::Verdict(verdict) => Some((one.scenario.clone(), one.way.task, verdict.clone())),
            Said::Unparsed(_) | Said::Failed(_) => None,
        })
        .collect();
    let of: std::collections::HashMap<_, _> = reference
        .iter()
        .map(|(scenario, task, verdict)| ((scenario.as_str(), *task), verdict))
        .collect();
    for one in &mut scored {
        one.reference = of
            .get(&(one.scenario.as_str(), one.way.task))
            .map(|v| (*v).clone());
    }
    Ok(scored)
}

fn one(item: &Item, found: Option<&Found>) -> Result<Scored, StoreError> {
    let asked = &item.asked;
    let said = match found {
        Some(found) => match verdict::parse(asked.task, &found.text) {
            Ok(parsed) => Said::Verdict(parsed.verdict),
            Err(why) => Said::Unparsed(why.to_string()),
        },
        None => Said::Failed(item.error.clone().unwrap_or_else(|| {
            match item.state {
                ItemState::Answered => "the answer was deleted from the store",
                _ => "it was not asked yet",
            }
            .into()
        })),
    };
    Ok(Scored {
        scenario: asked.scenario.clone(),
        way: way_of(asked).map_err(StoreError::Word)?,
        sample: asked.sample,
        truth: label_of(asked),
        said,
        reference: None,
        consumed: found.map_or_else(Consumed::default, |found| found.consumed),
        run: found.map(|found| found.run).or(item.run),
    })
}

/// The same answers beside another truth: by place in the batch, whether the ego collides, and with whom.
///
/// The `desk` opens scenarios where the truth needs their scene.
#[must_use]
pub fn retold(
    items: &[Item],
    truth: &Truth,
    desk: &super::Desk,
) -> Vec<(u64, Option<bool>, Option<i64>)> {
    items
        .par_iter()
        .map(|item| {
            let entry = Entry::of_argument(std::path::Path::new(&item.asked.path));
            let scene = match truth {
                Truth::Geometry => desk.open(&entry).ok(),
                Truth::Layout(_) | Truth::Labels(_) | Truth::Known(_) => None,
            };
            let label = truth.of(&entry, scene.as_ref().map(|reading| &*reading.scene));
            (item.place, label.map(Label::collides), obstacle(label))
        })
        .collect()
}

/// How a question was asked.
///
/// # Errors
/// A word that this version does not know.
pub fn way_of(asked: &NewItem) -> Result<Way, String> {
    let frame = asked.frame.as_deref().map(|word| {
        Frame::parse(word).ok_or_else(|| format!("the frame {word} is not known to this version"))
    });
    Ok(Way {
        task: asked.task,
        frame: frame.transpose()?,
        techniques: asked
            .techniques
            .as_deref()
            .map(Techniques::parse)
            .transpose()?,
        model: asked.model.clone(),
    })
}

/// What is true, as the batch has it.
pub(super) fn label_of(asked: &NewItem) -> Option<Label> {
    asked.collides.map(|collides| match collides {
        true => Label::Collision(asked.obstacle),
        false => Label::Safe,
    })
}
