//! A batch submitted to providers: what they accepted, and how to continue.

use tokio::runtime::Runtime;

use super::number;
use crate::{Failure, output};
use nearmiss_store::Item;
use nearmiss_workflow::batch::{BatchRun, SubmittedItems};

/// Questions left to ask here.
pub enum Left {
    /// Everything was submitted.
    Nothing,
    /// The built-in judge's questions, which no provider accepts.
    Own(Vec<Item>),
}

/// Submits the questions, and prints which provider received them.
pub fn submit(runtime: &Runtime, run: &BatchRun, items: Vec<Item>) -> Result<Left, Failure> {
    let submitted: SubmittedItems = runtime
        .block_on(run.submit(items))
        .map_err(Failure::input)?;
    for (model, taken) in &submitted.submitted {
        let batches: Vec<String> = taken.batches.iter().map(ToString::to_string).collect();
        let mut words = format!(
            "{}: {} with the provider",
            output::visible(model),
            number(taken.handed, "question")
        );
        if !batches.is_empty() {
            words.push_str(&format!(" as {}", batches.join(", ")));
        }
        if taken.stored > 0 {
            let stored = number(taken.stored, "answer");
            words.push_str(&format!("; the store has {stored}"));
        }
        if taken.taken > 0 {
            words.push_str(&format!("; {} already running", taken.taken));
        }
        output::say(&format!("nearmiss: {words}"));
        for note in &taken.notes {
            output::say(&format!("nearmiss: {}: {note}", output::visible(model)));
        }
    }
    for (item, why) in submitted.unaskable.iter().take(3) {
        output::say(&format!("nearmiss: {}: {why}", item.asked.scenario));
    }
    if submitted.unaskable.len() > 3 {
        let more = submitted.unaskable.len() - 3;
        output::say(&format!("nearmiss: {more} more cannot be asked"));
    }
    let id = run.id;
    let on = format!(
        "`nearmiss runs batches collect --wait` fetches the answers, then `nearmiss evaluate {id}` writes the table"
    );
    for (model, error) in &submitted.broken {
        let words = format!("nearmiss: {model}: {error}");
        output::say(&output::visible(&words));
    }
    if !submitted.broken.is_empty() {
        let models = number(submitted.broken.len(), "model");
        return Err(Failure::finding(format!(
            "not everything could be submitted for {models}; {on}"
        )));
    }
    output::say(&format!("nearmiss: {on}"));
    if submitted.own.is_empty() {
        return Ok(Left::Nothing);
    }
    Ok(Left::Own(submitted.own))
}
