//! `nearmiss evaluate` with language models: a matrix of prompt configurations over many scenarios, as a stored batch.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::context::{BatchContext, planned, runtime};
use super::options::{DryRunOf, Format, Run, Subject};
use super::running::{self, Table};
use super::table::BatchDocument;
use super::{dry_run, number, some};
use crate::open::{found, with_notes};
use crate::output::refused;
use crate::{Failure, Outcome, knobs, output};
use nearmiss_record::fields::Layers;
use nearmiss_store::{BatchId, NewItem};
use nearmiss_study::evaluation::batch::{Experiment, TruthSource};
use nearmiss_workflow::batch::{
    BatchPlan, BatchRequest, BatchRun, DryRun, Relabelling, ResumeRequest,
};
use nearmiss_workflow::{
    WriteExperimentError, configured_experiment, experiment_from_request, find_scenarios,
    prepare_experiment, selected, write_experiment,
};

/// Runs what is no evaluation of the built-in judge alone.
pub fn run(arguments: &Run, subject: Subject<'_>) -> Outcome {
    let begun = [
        ("--ego", arguments.ego.is_some()),
        ("--write-experiment", arguments.write_experiment.is_some()),
        (
            "--shard",
            arguments.shard.is_some() && matches!(subject, Subject::Batch(_)),
        ),
    ];
    let given = begun.iter().find(|(_, given)| *given);
    if let (Some((option, _)), Subject::Experiment(_) | Subject::Batch(_)) = (given, &subject) {
        return Err(Failure::input(format!(
            "{option} is for scenarios; experiment files and stored batches say what they are about"
        )));
    }
    let context = BatchContext::new()?;
    match subject {
        Subject::Batch(which) => resume(arguments, which, context),
        Subject::Experiment(file) => run_file(arguments, file, context),
        Subject::Scenarios => begin(arguments, context),
    }
}

/// Begins a batch.
fn begin(arguments: &Run, mut context: BatchContext) -> Outcome {
    if arguments.retry_failed {
        return Err(Failure::input(
            "--retry-failed needs a batch: nearmiss evaluate b7 --retry-failed",
        ));
    }
    let mut layers = Layers::default();
    let usual = Experiment {
        scenarios: arguments.paths.clone(),
        ..configured_experiment(&context.config)
    };
    layers.fields("config.toml: ", &usual);
    arguments.add_knobs(&mut layers);
    if !layers.has("models") {
        if matches!(arguments.dry_run, None | Some(DryRunOf::Cost)) {
            return Err(Failure::input(
                "no model given: use --model provider/model,…, --model reference/geometry for the built-in judge, or set `model` in config.toml; `nearmiss models` lists models",
            ));
        }
        // Nothing is sent; the questions are the same for every model.
        layers.word("--model", "models", ANY_MODEL);
    }
    let experiment = Experiment {
        scenarios: arguments.paths.clone(),
        ..knobs::complete(layers, &context.library)?
    };
    context.limits(&experiment);
    let entries = found(&arguments.paths)?;
    let select = experiment.select.as_deref();
    let entries = selected(entries, select, &context.thresholds).map_err(Failure::input)?;
    let request = BatchRequest {
        ego: arguments.ego(&entries)?,
        entries,
        shard: arguments.shard,
        drafts: BTreeMap::new(),
        experiment,
    };
    if let Some(file) = &arguments.write_experiment {
        return write(file, request, &context);
    }
    let mut plan = planned(|cancel, on_event| {
        request.plan(&context.library, &context.thresholds, cancel, on_event)
    })?;
    carry_out(arguments, &context, &mut plan)
}

/// Writes a batch that is to be begun as an experiment file.
fn write(file: &Path, request: BatchRequest, context: &BatchContext) -> Outcome {
    let experiment = experiment_from_request(request, &context.library, &context.thresholds);
    let experiment = experiment.map_err(Failure::input)?;
    write_experiment(&experiment, file, false).map_err(|error| match error {
        WriteExperimentError::Save(error) => refused(&error),
        error => Failure::input(error),
    })?;
    let file = file.display();
    output::say(&format!(
        "nearmiss: wrote {file}; `nearmiss evaluate {file}` runs it"
    ));
    Ok(())
}

/// Runs an experiment, or goes on with it where the store has a batch that asks the same.
fn run_file(arguments: &Run, file: &Path, mut context: BatchContext) -> Outcome {
    let mut layers = Layers::default();
    knobs::add_file(&mut layers, file)?;
    arguments.add_knobs(&mut layers);
    let experiment = knobs::complete(layers, &context.library)?;
    context.limits(&experiment);
    let found = with_notes(find_scenarios(&experiment).map_err(Failure::input)?);
    let shard = arguments.shard;
    let prepared = prepare_experiment(&experiment, file, found, shard, context.of_experiment())
        .map_err(Failure::input)?;
    match prepared.batch() {
        None if arguments.retry_failed => {
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
    let selection = arguments.selection();
    let mut plan = planned(|cancel, on_event| {
        prepared.plan(selection, context.of_experiment(), cancel, on_event)
    })?;
    carry_out(arguments, &context, &mut plan)
}

/// Resumes a batch, and warns if its ground truth differs.
fn resume(arguments: &Run, which: Option<BatchId>, mut context: BatchContext) -> Outcome {
    let mut layers = Layers::<Experiment>::default();
    arguments.add_knobs(&mut layers);
    let mut more = layers
        .read()
        .map_err(|mistakes| Failure::input(output::visible(&mistakes)))?;
    context.limits(&more);
    let truth = more.truth.take().map(TruthSource::absolute);
    let request = ResumeRequest {
        batch: which,
        selection: arguments.selection(),
        more,
        truth,
        dry_run: arguments.dry_run.is_some(),
    };
    let (store, library, thresholds) = (&context.store, &context.library, &context.thresholds);
    let mut plan =
        planned(|cancel, on_event| request.plan(store, library, thresholds, cancel, on_event))?;
    if let Some(relabelling) = &plan.relabelling {
        say_truth(relabelling, plan.spec.truth(), arguments.dry_run.is_some());
    }
    carry_out(arguments, &context, &mut plan)?;
    let unlabelled = plan
        .relabelling
        .map_or(0, |relabelling| relabelling.unlabelled.len());
    match unlabelled {
        _ if arguments.dry_run == Some(DryRunOf::Cost) => Ok(()),
        0 => Ok(()),
        count => Err(Failure::finding(format!(
            "{} without a label",
            number(count, "scenario")
        ))),
    }
}

/// Says that the truth is another one, and about which scenarios it says nothing.
fn say_truth(relabelling: &Relabelling, source: &TruthSource, dry_run: bool) {
    let Relabelling {
        batch,
        before,
        unlabelled,
    } = relabelling;
    if source != before {
        let (before, now) = (before.summary(), source.summary());
        let would = if dry_run {
            "would be"
        } else {
            "is from now on"
        };
        output::say(&output::visible(&format!(
            "nearmiss: {batch}: the truth {would}: {now}; it was: {before}"
        )));
    }
    if !unlabelled.is_empty() {
        output::say(&output::visible(&format!(
            "nearmiss: {batch}: no label for {}: {}; their answers are not scored",
            number(unlabelled.len(), "scenario"),
            some(unlabelled)
        )));
    }
}

/// Asks what a plan has to ask, then writes the table of the batch.
fn carry_out(arguments: &Run, context: &BatchContext, plan: &mut BatchPlan) -> Outcome {
    plan.ask_part(arguments.split).map_err(Failure::input)?;
    let plan = &*plan;
    if let (Some(shard), 0, false) = (arguments.shard, plan.scenarios(), plan.is_stored()) {
        output::say(&format!("nearmiss: part {shard} has no scenarios"));
        return empty_part(arguments, context, plan);
    }
    let judges = context.judges(&plan.models(), &plan.spec)?;
    let dry_run = dry_run::make(plan, &judges, &context.store)?;
    if let (Some(shard), true, false) =
        (arguments.shard, dry_run.items.is_empty(), plan.is_stored())
    {
        output::say(&format!("nearmiss: part {shard} has nothing to ask"));
        return empty_part(arguments, context, plan);
    }
    plan.check_labels(&dry_run).map_err(Failure::input)?;
    let json = arguments.format == Format::Json;
    let runtime = runtime()?;
    if let Some(what) = arguments.dry_run {
        let asked = |item: &&NewItem| plan.part.is_none() || item.split == plan.part;
        let items = || {
            dry_run
                .items
                .iter()
                .filter(asked)
                .cloned()
                .collect::<Vec<_>>()
        };
        return match what {
            DryRunOf::Questions => dry_run::write_questions(&items()),
            DryRunOf::Leaks => dry_run::write_leaks(&items(), json),
            DryRunOf::Cost => {
                let refused = runtime.block_on(dry_run.refused(&judges));
                dry_run::write(&dry_run, &refused, context.config.budget, json)
            }
        };
    }
    // Nothing is started if a model would refuse every question.
    if let Some((model, why)) = runtime.block_on(dry_run.refused(&judges)).first() {
        return Err(Failure::input(format!("{model}: {why}")));
    }
    let id = plan
        .write(&context.store, &dry_run)
        .map_err(Failure::input)?;
    let table = Table {
        format: arguments.format,
        unlock: arguments.unlock,
        part: plan.part,
    };
    if plan.scenarios() == 0 {
        output::say(&format!("nearmiss: {id}: nothing to ask"));
        let shown = running::show(context, id, table);
        return arguments.gate.after(shown, &context.store, id);
    }
    let run = Arc::new(BatchRun::new(
        (id, plan),
        Arc::clone(&context.store),
        judges,
        context.concurrency.unwrap_or(context.config.at_once()),
        Arc::default(),
    ));
    let asked = running::ask(
        &runtime,
        context,
        &run,
        &dry_run,
        (arguments.batch, arguments.retry, table),
    );
    if arguments.batch {
        // Answers come later.
        asked
    } else {
        arguments.gate.after(asked, &context.store, id)
    }
}

/// Keeps a part without questions, so that all parts together are known to be the whole.
fn empty_part(arguments: &Run, context: &BatchContext, plan: &BatchPlan) -> Outcome {
    if !plan.is_stored() && arguments.dry_run.is_none() {
        let written = plan.write(&context.store, &DryRun::default());
        written.map_err(Failure::input)?;
    }
    if arguments.format == Format::Json {
        output::document(&BatchDocument::default())
    } else {
        Ok(())
    }
}

/// A model that every installation knows.
const ANY_MODEL: &str = "local/default";
