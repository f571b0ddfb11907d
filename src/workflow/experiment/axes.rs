//! The matrix of an experiment in words: each axis with its values.

use super::Experiment;
use nearmiss_ask::prompts::Library;
use nearmiss_study::evaluation::batch::Spec;
use nearmiss_study::evaluation::report::technique;
use nearmiss_study::evaluation::{Lead, Protocol, tools_word};

/// An axis of an experiment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExperimentAxis {
    /// Its key in the file.
    pub name: &'static str,
    /// Its values; empty where the file leaves it open.
    pub values: Vec<String>,
}

impl Experiment {
    /// Every axis, in the order of the file's keys.
    #[must_use]
    pub fn axes(&self, library: &Library) -> Vec<ExperimentAxis> {
        let (matrix, request) = (&self.matrix, &self.matrix.request);
        let axes = &matrix.axes;
        let mut found = Vec::new();
        let mut add = |name, values: Vec<String>| found.push(ExperimentAxis { name, values });
        add("models", matrix.models.clone());
        add("tasks", words(&matrix.tasks, |task| task.name().into()));
        add("frames", words(&matrix.frames, |frame| frame.name().into()));
        add(
            "techniques",
            words(&matrix.techniques, |one| technique(*one)),
        );
        let templates = Spec::templates_of(matrix, library);
        add("templates", templates.into_keys().collect());
        if request.protocol != Protocol::default() {
            add("protocol", vec![request.protocol.name().to_string()]);
        }
        let leads = request
            .lead
            .iter()
            .chain(&matrix.more_leads)
            .map(|lead| match lead {
                Lead::Paper => "end".to_string(),
                Lead::Seconds(seconds) => format!("{seconds} s"),
            });
        add("leads", leads.collect());
        add("transforms", words(&matrix.transforms, ToString::to_string));
        add(
            "effort",
            one_or_each(request.effort, &axes.efforts, |effort| effort.name().into()),
        );
        add(
            "temperature",
            one_or_each(request.temperature, &axes.temperatures, ToString::to_string),
        );
        add(
            "form",
            one_or_each(request.form, &axes.forms, |form| form.name().into()),
        );
        add(
            "stride",
            one_or_each(request.stride, &axes.strides, ToString::to_string),
        );
        add(
            "seed",
            one_or_each(request.seed, &axes.seeds, ToString::to_string),
        );
        let on = |on: &bool| tools_word(*on).to_string();
        let one = request
            .tools
            .filter(|_| axes.tools.is_empty())
            .map(|_| true);
        add("tools", one_or_each(one, &axes.tools, on));
        add("samples", vec![matrix.samples.to_string()]);
        found
    }

    /// How many ways of asking it has: combinations of task, frame, techniques, model and settings.
    #[must_use]
    pub fn ways(&self) -> usize {
        self.matrix.ways().len()
    }
}

fn words<T>(values: &[T], word: impl Fn(&T) -> String) -> Vec<String> {
    values.iter().map(word).collect()
}

/// The value of a setting, or those of its axis.
fn one_or_each<T>(one: Option<T>, each: &[T], word: impl Fn(&T) -> String) -> Vec<String> {
    one.iter().chain(each).map(word).collect()
}
