//! A batch that is handed to providers: what they took, and how it goes on.

use std::sync::Arc;

use tokio::runtime::Runtime;

use super::number;
use crate::cli::{Failure, output};
use crate::evaluation::batch::{Asking, Handed};
use crate::store::Item;

/// What is left to be asked here.
pub enum Left {
    /// Everything is with providers.
    Nothing,
    /// The built-in judge's questions, which no provider takes.
    Own(Vec<Item>),
}

/// Hands the questions over, and says to whom.
pub fn over(runtime: &Runtime, asking: &Arc<Asking>, items: Vec<Item>) -> Result<Left, Failure> {
    let handed: Handed = runtime
        .block_on(asking.hand_over(items))
        .map_err(Failure::input)?;
    for (model, submitted) in &handed.submitted {
        let batches: Vec<String> = submitted.batches.iter().map(ToString::to_string).collect();
        let mut words = format!(
            "{}: {} with the provider",
            output::visible(model),
            number(submitted.handed, "question")
        );
        if !batches.is_empty() {
            words.push_str(&format!(" as {}", batches.join(", ")));
        }
        if submitted.stored > 0 {
            let stored = number(submitted.stored, "answer");
            words.push_str(&format!("; the store has {stored}"));
        }
        if submitted.taken > 0 {
            words.push_str(&format!("; {} are being asked already", submitted.taken));
        }
        output::say(&format!("nearmiss: {words}"));
        for note in &submitted.notes {
            output::say(&format!("nearmiss: {}: {note}", output::visible(model)));
        }
    }
    for (item, why) in handed.unaskable.iter().take(3) {
        output::say(&format!("nearmiss: {}: {why}", item.asked.scenario));
    }
    let id = asking.batch;
    let on = format!(
        "`nearmiss batches collect --wait` fetches the answers, then `nearmiss evaluate --resume {id}` writes the table"
    );
    for (model, error) in &handed.broken {
        let words = format!("nearmiss: {model}: {error}");
        output::say(&output::visible(&words));
    }
    if !handed.broken.is_empty() {
        let models = number(handed.broken.len(), "model");
        return Err(Failure {
            message: format!("{models} could not be handed everything; {on}"),
            status: 1,
        });
    }
    output::say(&format!("nearmiss: {on}"));
    if handed.own.is_empty() {
        return Ok(Left::Nothing);
    }
    Ok(Left::Own(handed.own))
}
