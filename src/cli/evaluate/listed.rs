//! Lists stored batches with their progress and contents.

use serde_json::{Value, json};

use super::{number, some};
use crate::cli::filters::store_to_read;
use crate::cli::{Failure, Outcome, output, time};
use crate::evaluation::batch::{Matrix, Spec};
use crate::store::{Batch, Progress};
use crate::verdict::Task;

/// Lists the batches.
pub fn list(as_json: bool) -> Outcome {
    let batches = store_to_read()?.batches().map_err(Failure::input)?;
    if as_json {
        return batches
            .iter()
            .try_for_each(|(batch, progress)| output::json(&document(batch, progress)));
    }
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
        output::say("nearmiss: no batches yet; `nearmiss evaluate FOLDER --model …` starts one");
    }
    output::text(&output::visible(&text))
}

/// A batch for programs: its progress, and what it asks; `problem` where that cannot be read.
fn document(batch: &Batch, progress: &Progress) -> Value {
    let mut value = json!({
        "batch": batch.id.to_string(),
        "created_at": time::rfc3339(batch.created_ms),
        "shard": batch.shard,
        "questions": progress.all(),
        "answered": progress.answered,
        "failed": progress.failed,
        "truncated": progress.truncated,
        "unaskable": progress.unaskable,
        "scenarios": progress.scenarios,
    });
    let spec = match Spec::from_json(&batch.spec) {
        Ok(spec) => spec,
        Err(error) => {
            value["problem"] = error.to_string().into();
            return value;
        }
    };
    let matrix = &spec.matrix;
    let words = |all: &mut dyn Iterator<Item = String>| Value::from_iter(all);
    let leads = matrix.request.lead.iter().chain(&matrix.more_leads);
    value["tasks"] = words(&mut matrix.tasks.iter().map(|task| task.name().into()));
    value["frames"] = words(&mut matrix.frames.iter().map(|frame| frame.name().into()));
    value["techniques"] = words(&mut matrix.techniques.iter().map(ToString::to_string));
    value["models"] = json!(matrix.models);
    value["samples"] = json!(matrix.samples);
    value["leads"] = words(&mut leads.map(ToString::to_string));
    value["transforms"] = words(&mut matrix.transforms.iter().map(ToString::to_string));
    value["paths"] = words(&mut spec.paths.iter().map(|path| path.display().to_string()));
    value["truth"] = spec.truth.words().into();
    value
}

/// The leads of a matrix, and its changes of scenes.
fn varied(matrix: &Matrix) -> String {
    let mut text = String::new();
    if matrix.more_leads.is_empty() && matrix.tasks.contains(&Task::Safety) {
        match matrix.request.lead {
            None => text.push_str(" · windows at the end of recordings"),
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
