//! `nearmiss evaluate FILE.toml` runs an experiment file, and goes on with it; `--write-experiment` writes one.

use std::path::Path;

use super::Evaluate;
use super::batch::carry_out;
use super::context::BatchContext;
use super::drawing::planned;
use super::resume;
use crate::open::with_notes;
use crate::output::{self, refused};
use crate::{Failure, Outcome};
use nearmiss_settings::TextFile;
use nearmiss_workflow::batch::BatchRequest;
use nearmiss_workflow::{Experiment, WriteExperimentError};

/// Runs an experiment, or goes on with it where the store has a batch that asks the same.
pub fn run(arguments: &Evaluate, file: &Path) -> Outcome {
    let options = &arguments.batch;
    let settings = resume::settings(arguments).map(|(given, _)| given);
    let truth = (!arguments.truth.is_empty()).then_some("--truth");
    let samples = options.samples.map(|_| "--samples");
    let write = options
        .write_experiment
        .as_ref()
        .map(|_| "--write-experiment");
    if let Some(given) = settings.chain(truth).chain(samples).chain(write).next() {
        return Err(Failure::input(format!(
            "{given} is not allowed beside {}, which says what is asked: change the file",
            file.display()
        )));
    }
    let mut context = BatchContext::new()?;
    let text = TextFile::read(file).map_err(Failure::input)?.text;
    let experiment = Experiment::from_toml(&text, file, &context.library)
        .map_err(|mistakes| Failure::input(output::visible(&mistakes)))?;
    context.config.budget = experiment.budget.or(context.config.budget);
    let found = with_notes(experiment.find_scenarios().map_err(Failure::input)?);
    let prepared = experiment
        .prepare(file, found, options.shard, context.of_experiment())
        .map_err(Failure::input)?;
    match prepared.batch() {
        None if options.retry_failed => {
            return Err(Failure::input(format!(
                "--retry-failed: {} has not been run yet",
                file.display()
            )));
        }
        None => {}
        Some(batch) => output::say(&format!(
            "nearmiss: going on with {batch}, which asks what {} says",
            file.display()
        )),
    }
    let selection = options.selection();
    let mut plan = planned(|cancel, on_event| {
        prepared.plan(selection, context.of_experiment(), cancel, on_event)
    })?;
    carry_out(arguments, &context, &mut plan)
}

/// Writes a batch that is to be begun as an experiment file.
pub fn write(
    file: &Path,
    request: BatchRequest,
    budget: Option<f64>,
    context: &BatchContext,
) -> Outcome {
    let (library, thresholds) = (&context.library, &context.thresholds);
    let experiment = Experiment::of_request(request, budget, library, thresholds);
    let written = experiment.map_err(Failure::input)?.write(file, false);
    written.map_err(|error| match error {
        WriteExperimentError::Save(error) => refused(&error),
        error => Failure::input(error),
    })?;
    output::say(&format!(
        "nearmiss: wrote {}; `nearmiss evaluate {}` runs it",
        file.display(),
        file.display()
    ));
    Ok(())
}
