//! An experiment in words: each axis of its matrix with the values, and the other fields that are set.

use nearmiss_ask::prompts::Library;
use nearmiss_record::fields::Fields;
use nearmiss_study::evaluation::batch::{Experiment, Spec};

/// An axis of an experiment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExperimentAxis {
    /// Its key in the file.
    pub name: &'static str,
    /// Its values; empty where the file leaves it open.
    pub values: Vec<String>,
}

/// Every axis, in the order of the file's keys, and the templates of its questions.
#[must_use]
pub fn experiment_axes(experiment: &Experiment, library: &Library) -> Vec<ExperimentAxis> {
    let rows = Experiment::rows().iter();
    let axes = rows.filter(|row| row.section == "questions" || row.is("axis"));
    let mut axes: Vec<ExperimentAxis> = axes
        .map(|row| ExperimentAxis {
            name: row.key,
            values: experiment.texts(row.key),
        })
        .collect();
    let templates = Spec::templates_of(experiment, library);
    axes.push(ExperimentAxis {
        name: "templates",
        values: templates.into_keys().collect(),
    });
    axes
}

/// The fields beside the axes that are set, each with its value in words.
#[must_use]
pub fn experiment_facts(experiment: &Experiment) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    for (row, _) in experiment.given() {
        let value = match row.key {
            "title" => continue,
            "truth" => Spec {
                experiment: experiment.clone(),
                ..Spec::default()
            }
            .truth_words(),
            "templates" => format!("{} by their hashes", experiment.templates.len()),
            "hashes" => format!("{} scenarios", experiment.hashes.len()),
            _ if row.section == "questions" || row.is("axis") => continue,
            key => experiment.text(key).unwrap_or_default(),
        };
        facts.push((row.key, value));
    }
    facts
}
