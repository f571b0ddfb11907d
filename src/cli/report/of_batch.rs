//! The report of a batch from `evaluate`.

use std::sync::Arc;

use super::AnyReport;
use crate::cli::{Failure, open, output};
use crate::evaluation::batch::{
    self, Answers, QuestionBuilder, SceneDescriptions, Spec, SpecError, UnjudgedScenario,
    beside_the_judge,
};
use crate::evaluation::report::{Report, ReportSubject, Varied};
use crate::evaluation::{AnswerStatus, validate};
use crate::prompts::Library;
use crate::store::{BatchId, Item, Store};

/// A batch of `evaluate`: every question of it, also those without an answer, beside the truth that it was begun with.
pub fn made(store: &Store, id: BatchId) -> Result<AnyReport, Failure> {
    let Some(batch) = store.batch(id).map_err(Failure::input)? else {
        return Err(Failure::input(format!(
            "no batch {id}; `nearmiss evaluate --list` lists batches"
        )));
    };
    let spec = Spec::from_json(&batch.spec).map_err(Failure::input)?;
    let mut answers = batch::answers(store, id).map_err(Failure::input)?;
    let items = store.items(id).map_err(Failure::input)?;
    let judged = judged(&mut answers, &items, &spec);
    let scored = &answers.plain;
    let truth = output::visible(&spec.truth.words());
    let mut notes = vec![format!(
        "Batch {id}: {} questions. Truth: {truth}.",
        scored.len()
    )];
    let described = described(&spec);
    notes.push(output::visible(&spec.asked_words(described.as_ref())));
    if answers.others > 0 {
        notes.push(format!(
            "{} more, about changed scenes or at other leads, are not counted among these; they have tables of their own."
            ,
            answers.others
        ));
    }
    let unasked = scored
        .iter()
        .filter(|one| matches!(one.status, AnswerStatus::Unasked(_)))
        .count();
    if unasked > 0 {
        let unfinished = format!(
            "Of these questions {unasked} were not asked, or not yet; they have a count of their own. `nearmiss evaluate \
             --resume {id}` resumes the batch."
        );
        output::say(&format!("nearmiss: {unfinished}"));
        notes.push(unfinished);
    }
    notes.extend(judged.map(|words| output::visible(&words)));
    let about = ReportSubject {
        batch: Some(id.to_string()),
        asked: Some(spec.asked(described.as_ref())),
        truth,
        sources: spec.truth.sources(),
        notes,
    };
    Ok(AnyReport::Report(
        Report::from_scored(scored)
            .about(about)
            .varied(Varied::from_answers(&answers)),
    ))
}

/// What the templates say where the batch does not; `None` if they cannot be read or are no longer the same.
fn described(spec: &Spec) -> Option<SceneDescriptions> {
    let (folders, _) = open::configuration().ok()?;
    spec.described(&validate(Library::load(Some(&folders.prompts()))))
}

/// Asks the built-in judge about the scenarios, where it has said nothing yet; says what came of it, if anything did.
fn judged(answers: &mut Answers, items: &[Item], spec: &Spec) -> Option<String> {
    if answers.plain.iter().all(|one| one.reference.is_some()) {
        return None;
    }
    let none = |why: String| {
        Some(format!(
            "Not every answer is beside a verdict of the built-in judge (κ), who could not be asked: {why}."
        ))
    };
    let builder = match builder(spec) {
        Ok(builder) => builder,
        Err(why) => return none(why),
    };
    let before = without(answers);
    let unjudged = beside_the_judge(answers, items, &builder);
    let after = without(answers);
    let asked = format!(
        "For κ the built-in judge was asked now about the {} questions that the batch has no verdict of it on.",
        before - after
    );
    Some(match words(&unjudged) {
        None => asked,
        Some(words) => format!("{asked} It could not be asked about {words}."),
    })
}

fn without(answers: &Answers) -> usize {
    let missing = answers.plain.iter().filter(|one| one.reference.is_none());
    missing.count()
}

/// Scenarios that are named each.
const NAMED: usize = 3;

fn words(unjudged: &[UnjudgedScenario]) -> Option<String> {
    let named = unjudged.iter().take(NAMED);
    let named: Vec<String> = named
        .map(|one| format!("{} ({})", one.scenario, one.why))
        .collect();
    let more = if unjudged.len() > NAMED { ", …" } else { "" };
    let count = match unjudged.len() {
        0 => return None,
        1 => "1 scenario".to_string(),
        n => format!("{n} scenarios"),
    };
    Some(format!(
        "{count}, whose answers κ leaves out: {}{more}",
        named.join("; ")
    ))
}

/// What makes the batch's windows again; nothing where they would be others now.
fn builder(spec: &Spec) -> Result<QuestionBuilder, String> {
    let words = |failure: Failure| failure.message;
    let (folders, _) = open::configuration().map_err(words)?;
    let library = validate(Library::load(Some(&folders.prompts())));
    let thresholds = open::user_thresholds(&folders).map_err(words)?;
    let words = |error: SpecError| error.to_string();
    spec.still(&library, &thresholds).map_err(words)?;
    spec.builder(&library, Arc::new(thresholds)).map_err(words)
}
