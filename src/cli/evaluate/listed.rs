//! Lists stored batches with their progress and contents.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::{number, some};
use crate::files::partition;
use crate::filters::store_to_read;
use crate::{Failure, Outcome, output};
use nearmiss_formats::PlannerDrives;
use nearmiss_record::fields::Fields;
use nearmiss_scene::verdict::Task;
use nearmiss_store::{Batch, Progress};
use nearmiss_study::evaluation::Protocol;
use nearmiss_study::evaluation::batch::{Experiment, Spec};

/// Lists the batches.
pub fn list(as_json: bool) -> Outcome {
    let batches = store_to_read()?.batches().map_err(Failure::input)?;
    if as_json {
        return batches
            .iter()
            .try_for_each(|(batch, progress)| output::document(&document(batch, progress)));
    }
    let mut text = String::new();
    for (batch, progress) in &batches {
        let spec = Spec::from_json(&batch.spec);
        let about = match &spec {
            Ok(spec) => format!(
                "{} · {} · {} · {} × {}{}",
                spec.experiment.texts("tasks").join(","),
                spec.experiment.texts("frames").join(","),
                spec.experiment.texts("techniques").join(","),
                spec.experiment.models.join(","),
                spec.experiment.samples(),
                varied(&spec.experiment)
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
            output::local(batch.created_ms),
            progress.answered,
            progress.all()
        ));
        if let Ok(spec) = spec {
            if let Some(title) = &spec.experiment.title {
                text.push_str(&format!("      {title}\n"));
            }
            text.push_str(&format!(
                "      {} · truth: {}{}\n",
                scenarios(progress.scenarios, &spec.experiment.scenarios),
                spec.truth_summary(),
                spec.ego
                    .planner()
                    .map_or(String::new(), |drives| format!(" · egos {}", drives.text()))
            ));
        }
    }
    if batches.is_empty() {
        output::say("nearmiss: no batches yet; `nearmiss evaluate FOLDER --model …` starts one");
    }
    output::text(&output::visible(&text))
}

/// How many scenarios a batch asks about, and the paths that were named for it: folders, or files of which some may not be
/// asked about.
fn scenarios(asked: u64, paths: &[PathBuf]) -> String {
    let (_, named) = partition(paths);
    let asked = usize::try_from(asked).unwrap_or(usize::MAX);
    let of = match named.len() {
        0 | 1 => String::new(),
        all if all == asked => String::new(),
        all => format!(" of {}", number(all, "path")),
    };
    let named: Vec<String> = named.iter().map(|p| p.display().to_string()).collect();
    format!("{}{of}: {}", number(asked, "scenario"), some(&named))
}

/// A batch for programs: its progress, and what it asks; `problem` where that cannot be read.
#[derive(Serialize, JsonSchema)]
pub struct ListedDocument {
    batch: String,
    created_at: String,
    /// Part of the scenarios, such as 1/4.
    shard: Option<String>,
    questions: u64,
    /// Complete answers.
    answered: u64,
    failed: u64,
    /// Answers that were cut off.
    truncated: u64,
    unaskable: u64,
    /// Number of scenarios.
    scenarios: u64,
    #[serde(flatten)]
    asks: Option<Asks>,
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<String>,
}

/// What a batch asks.
#[derive(Serialize, JsonSchema)]
struct Asks {
    /// What it is about, where its experiment file says it.
    title: Option<String>,
    /// Tasks.
    tasks: Vec<String>,
    /// Frames.
    frames: Vec<String>,
    /// Prompting techniques of the configurations.
    techniques: Vec<String>,
    /// Models.
    models: Vec<String>,
    samples: u32,
    /// Leads of the safety task.
    leads: Vec<String>,
    /// Transforms.
    transforms: Vec<String>,
    /// Settings that are asked in several values, each with its values: effort, temperature, form, stride, seed, tools.
    axes: BTreeMap<&'static str, Value>,
    /// Paths of the scenarios.
    paths: Vec<String>,
    truth: String,
    /// The planner that drove the egos: `planner`, `said` (name and version), `settings`, `sha256` of the drives; null
    /// where egos lie beside their scenarios.
    #[schemars(with = "Option<BTreeMap<String, Value>>")]
    planner: Option<Value>,
}

/// Whose the drives are that are asked about.
fn planner(drives: &PlannerDrives) -> Value {
    serde_json::json!({
        "planner": drives.planner,
        "said": drives.said,
        "settings": drives.settings,
        "sha256": drives.sha256,
    })
}

impl Asks {
    fn of(spec: &Spec) -> Self {
        let experiment = &spec.experiment;
        Self {
            title: experiment.title.clone(),
            tasks: experiment.texts("tasks"),
            frames: experiment.texts("frames"),
            techniques: experiment.texts("techniques"),
            models: experiment.models.clone(),
            samples: experiment.samples(),
            leads: experiment.texts("leads"),
            transforms: experiment.texts("transforms"),
            axes: experiment.axes_as_json(),
            paths: experiment.texts("scenarios"),
            truth: spec.truth_summary(),
            planner: spec.ego.planner().map(planner),
        }
    }
}

fn document(batch: &Batch, progress: &Progress) -> ListedDocument {
    let spec = Spec::from_json(&batch.spec);
    ListedDocument {
        batch: batch.id.to_string(),
        created_at: output::rfc3339(batch.created_ms),
        shard: batch.shard.clone(),
        questions: progress.all(),
        answered: progress.answered,
        failed: progress.failed,
        truncated: progress.truncated,
        unaskable: progress.unaskable,
        scenarios: progress.scenarios,
        asks: spec.as_ref().ok().map(Asks::of),
        problem: spec.as_ref().err().map(ToString::to_string),
    }
}

/// The leads of an experiment, its changes of scenes, and what it asks with several values.
fn varied(experiment: &Experiment) -> String {
    let mut text = String::new();
    match experiment.texts("leads")[..] {
        [] if !experiment.tasks.contains(&Task::Safety) => {}
        [] if experiment.protocol == Protocol::Paper => text.push_str(" · windows of the paper"),
        [] => text.push_str(" · windows at the end of recordings"),
        ref leads => text.push_str(&format!(" · lead {}", leads.join(","))),
    }
    for change in &experiment.transforms {
        text.push_str(&format!(" · {change}"));
    }
    for (key, _) in experiment.several() {
        text.push_str(&format!(" · {key} {}", experiment.texts(key).join(",")));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_and_scenarios_are_counted_apart() {
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        let all =
            ["A", "B", "C", "D"].map(|n| [format!("{n}.xml"), format!("{n}.ego_trajectory.csv")]);
        let all: Vec<&str> = all.iter().flatten().map(String::as_str).collect();
        assert_eq!(
            scenarios(4, &paths(&all)),
            "4 scenarios: A.xml, B.xml, C.xml and 1 more"
        );
        assert_eq!(
            scenarios(1, &paths(&["A.xml", "B.xml"])),
            "1 scenario of 2 paths: A.xml, B.xml"
        );
        assert_eq!(scenarios(9, &paths(&["folder"])), "9 scenarios: folder");
    }
}
