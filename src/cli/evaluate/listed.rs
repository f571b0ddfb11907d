//! Lists stored batches with their progress and contents.

use super::{number, some};
use crate::cli::filters::store_to_read;
use crate::cli::{Failure, Outcome, output, time};
use crate::evaluation::batch::{Matrix, Spec};
use crate::verdict::Task;

/// Lists the batches.
pub fn list() -> Outcome {
    let batches = store_to_read()?.batches().map_err(Failure::input)?;
    let mut text = String::new();
    for (batch, progress) in &batches {
        let spec = Spec::from_json(&batch.spec);
        let about = match &spec {
            Ok(spec) => format!(
                "{} · {} · {} · {} × {}{}",
                joined(&spec.matrix.tasks, |task| task.name().to_string()),
                joined(&spec.matrix.frames, |frame| frame.name().to_string()),
                joined(&spec.matrix.techniques, ToString::to_string),
                spec.matrix.models.join(","),
                spec.matrix.samples,
                varied(&spec.matrix)
            ),
            Err(error) => error.to_string(),
        };
        let shard = batch
            .shard
            .as_ref()
            .map_or_else(String::new, |s| format!(" part {s}"));
        let mut more = String::new();
        for (count, word) in [
            (progress.failed, "failed"),
            (progress.truncated, "cut off"),
            (progress.unaskable, "cannot be asked"),
        ] {
            if count > 0 {
                more.push_str(&format!(", {count} {word}"));
            }
        }
        text.push_str(&format!(
            "{:<5} {}  {} of {} answered{more}  {about}{shard}\n",
            batch.id.to_string(),
            time::local(batch.created_ms),
            progress.answered,
            progress.all()
        ));
        if let Ok(spec) = spec {
            let paths: Vec<String> = spec.paths.iter().map(|p| p.display().to_string()).collect();
            text.push_str(&format!(
                "      {}: {} · truth: {}\n",
                number(
                    usize::try_from(progress.scenarios).unwrap_or(usize::MAX),
                    "scenario"
                ),
                some(&paths),
                spec.truth.words()
            ));
        }
    }
    if batches.is_empty() {
        output::say("nearmiss: there is no batch yet");
    }
    output::text(&output::visible(&text))
}

/// The leads of a matrix, and its changes of scenes.
fn varied(matrix: &Matrix) -> String {
    let mut text = String::new();
    if matrix.more_leads.is_empty() && matrix.tasks.contains(&Task::Safety) {
        match matrix.request.lead {
            None => text.push_str(" · to the end of recordings"),
            Some(lead) => text.push_str(&format!(" · lead {lead}")),
        }
    }
    if !matrix.more_leads.is_empty() {
        let leads = matrix.request.lead.iter().chain(&matrix.more_leads);
        let leads: Vec<String> = leads.map(ToString::to_string).collect();
        text.push_str(&format!(" · lead {}", leads.join(",")));
    }
    for change in &matrix.transforms {
        text.push_str(&format!(" · {change}"));
    }
    text
}

fn joined<T>(values: &[T], word: impl Fn(&T) -> String) -> String {
    values.iter().map(word).collect::<Vec<_>>().join(",")
}
