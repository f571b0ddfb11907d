//! `nearmiss evaluate` with language models: a matrix of prompt configurations over many scenarios, as a stored batch.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Evaluate, Format};
use crate::open::found;
use crate::{Failure, Outcome, output};
use nearmiss_ask::llm::{Effort, Endpoint};
use nearmiss_ask::prompts::Techniques;
use nearmiss_scene::verdict::Task;
use nearmiss_store::NewItem;
use nearmiss_study::evaluation::batch::{Matrix, MatrixAdditions, QuestionLine, RequestSettings};
use nearmiss_study::evaluation::{Axes, default_frame};
use nearmiss_workflow::batch::{BatchError, BatchPlan, BatchRequest, BatchRun, DryRun};
use nearmiss_workflow::{experiment_among, selected};

use super::context::BatchContext;
use super::drawing::planned;
use super::dry_run;
use super::experiment;
use super::leaks;
use super::listed;
use super::resume;
use super::running::{self, Table};
use super::table::BatchTable;
use super::truth::truth_source;

/// Runs what is no evaluation of the built-in judge alone.
pub fn run(arguments: &Evaluate) -> Outcome {
    if arguments.batch.list {
        return listed::list(arguments.batch.json);
    }
    if let Some(which) = arguments.batch.resume {
        resume::all_stays(arguments)?;
        return resume::run(arguments, which);
    }
    match experiment_among(&arguments.paths).map_err(Failure::input)? {
        Some(file) => experiment::run(arguments, file),
        None => begin(arguments),
    }
}

/// Begins a batch.
fn begin(arguments: &Evaluate) -> Outcome {
    let options = &arguments.batch;
    let added = MatrixAdditions {
        samples: None,
        ..options.more()
    };
    if options.retry_failed || added.any() {
        return Err(Failure::input(
            "--retry-failed and --add-… need a batch: --resume ID",
        ));
    }
    let secret = |url: &String| Endpoint::new("", url.as_str()).has_secret_address();
    if options.base_url.as_ref().is_some_and(secret) {
        return Err(Failure::input(
            "--base-url contains a password or key, which the batch would store; set base_url of the provider in config.toml, or name the key with key_env",
        ));
    }
    let context = BatchContext::new()?;
    let matrix = matrix(arguments, &context)?;
    let ways = matrix.ways();
    let comparison = options
        .declared
        .comparison(&ways.iter().collect::<Vec<_>>())?;
    let subset = options.subset();
    let entries = selected(found(&arguments.paths)?, &subset, &context.thresholds)
        .map_err(|why| Failure::input(format!("--{why}")))?;
    let request = BatchRequest {
        title: None,
        matrix,
        paths: arguments.paths.clone(),
        ego: arguments.ego(&entries)?,
        entries,
        truth: truth_source(&arguments.truth)?,
        shard: options.shard,
        drafts: BTreeMap::new(),
        base_url: options.base_url.clone(),
        comparison,
        subset,
    };
    if let Some(file) = &options.write_experiment {
        return experiment::write(file, request, options.budget, &context);
    }
    let mut plan = planned(|cancel, on_event| {
        request.plan(&context.library, &context.thresholds, cancel, on_event)
    })?;
    carry_out(arguments, &context, &mut plan)
}

/// Asks what a plan has to ask, then writes the table of the batch.
pub fn carry_out(arguments: &Evaluate, context: &BatchContext, plan: &mut BatchPlan) -> Outcome {
    let options = &arguments.batch;
    plan.ask_part(options.split).map_err(Failure::input)?;
    let plan = &*plan;
    if let (Some(shard), 0, false) = (options.shard, plan.scenarios(), plan.is_stored()) {
        output::say(&format!("nearmiss: part {shard} has no scenarios"));
        return empty_part(arguments, context, plan);
    }
    let judges = context.judges(&plan.models(), &plan.spec, options)?;
    let dry_run = dry_run::make(plan, &judges, &context.store)?;
    if let (Some(shard), true, false) = (options.shard, dry_run.items.is_empty(), plan.is_stored())
    {
        output::say(&format!("nearmiss: part {shard} has nothing to ask"));
        return empty_part(arguments, context, plan);
    }
    plan.check_labels(&dry_run).map_err(Failure::input)?;
    if options.questions || options.leaks {
        let asked = |item: &&NewItem| plan.part.is_none() || item.split == plan.part;
        let items: Vec<NewItem> = dry_run.items.iter().filter(asked).cloned().collect();
        return if options.questions {
            question_lines(&items)
        } else {
            leaks::write(&items, json(arguments))
        };
    }
    let runtime = running::runtime()?;
    let refused = runtime.block_on(dry_run.refused(&judges));
    if options.dry_run {
        return dry_run::write(&dry_run, &refused, context.budget(options), json(arguments));
    }
    // Nothing is started if a model would refuse every question.
    if let Some((model, why)) = refused.first() {
        return Err(Failure::input(format!("{model}: {why}")));
    }
    let id = plan
        .write(&context.store, &dry_run)
        .map_err(Failure::input)?;
    let table = Table {
        json: json(arguments),
        csv: arguments.format == Format::Csv,
        unlock: options.unlock,
        part: plan.part,
    };
    if plan.scenarios() == 0 {
        output::say(&format!("nearmiss: {id}: nothing to ask"));
        let shown = running::show(context, id, table);
        return options.gate.after(shown, &context.store, id);
    }
    let run = Arc::new(BatchRun::new(
        (id, plan),
        Arc::clone(&context.store),
        judges,
        context.concurrency(options),
        Arc::default(),
    ));
    let asked = running::ask(
        &runtime,
        context,
        &run,
        &dry_run,
        (options.batch, options.retry, table),
    );
    if options.batch {
        // Answers come later.
        asked
    } else {
        options.gate.after(asked, &context.store, id)
    }
}

/// Keeps a part without questions, so that all parts together are known to be the whole.
fn empty_part(arguments: &Evaluate, context: &BatchContext, plan: &BatchPlan) -> Outcome {
    let options = &arguments.batch;
    if !plan.is_stored() && !options.asks_nothing() {
        let written = plan.write(&context.store, &DryRun::default());
        written.map_err(Failure::input)?;
    }
    if json(arguments) {
        output::document(&BatchTable::document(None, Vec::new(), Vec::new()))
    } else {
        Ok(())
    }
}

fn question_lines(items: &[NewItem]) -> Outcome {
    let lines = QuestionLine::of_items(items);
    let lines: Result<String, Failure> = lines.iter().map(output::json_line).collect();
    output::text(&lines?)
}

/// Whether the table is to be JSON.
pub fn json(arguments: &Evaluate) -> bool {
    arguments.format() == Format::Json
}

fn matrix(arguments: &Evaluate, context: &BatchContext) -> Result<Matrix, Failure> {
    let (options, config) = (&arguments.batch, &context.config);
    let tasks = arguments.tasks();
    for task in &tasks {
        if !Task::VERDICTS.contains(task) {
            return Err(super::no_verdicts(*task));
        }
    }
    let mut models = arguments.model.clone();
    if models.is_empty() {
        models.extend(config.model.clone());
    }
    if models.is_empty() && (options.questions || options.leaks) {
        // Nothing is sent; the questions are the same for every model.
        models.push(ANY_MODEL.into());
    }
    if models.is_empty() {
        return Err(Failure::input(
            "no model given: use --model provider/model,… or set `model` in config.toml; `nearmiss models` lists models",
        ));
    }
    models.dedup();
    if arguments.lead.len() > 1 && !tasks.contains(&Task::Safety) {
        return Err(Failure::input(BatchError::Leads { option: "--lead" }));
    }
    let mut leads = each_once(arguments.lead.iter().copied()).into_iter();
    let lead = leads.next();
    let changes = options.transform.iter().flat_map(|changes| &changes.0);
    let frames = if options.frame.is_empty() {
        vec![default_frame(&context.library, tasks[0])]
    } else {
        options.frame.clone()
    };
    let techniques = if options.techniques.is_empty() {
        vec![Techniques::ALL]
    } else {
        options.techniques.clone()
    };
    let history = arguments.history.map(|steps| steps as usize);
    let usual = config.effort.as_deref().and_then(Effort::parse);
    let (effort, efforts) = Axes::one_or_several(options.effort.clone());
    let (temperature, temperatures) = Axes::one_or_several(options.temperature.clone());
    let (form, forms) = Axes::one_or_several(options.form.clone());
    let strides = options.stride.iter().map(|steps| *steps as usize);
    let (stride, strides) = Axes::one_or_several(strides.collect());
    let (seed, seeds) = Axes::one_or_several(options.seed.clone());
    let (with_tools, tools) = Axes::one_or_several(options.tools.clone());
    let with_tools = with_tools.unwrap_or(config.tools && tools.is_empty());
    let limits = options.tool_limits.limits();
    let limits = (with_tools || !tools.is_empty()).then_some(limits);
    let axes = Axes {
        tools,
        forms,
        strides,
        efforts,
        temperatures,
        seeds,
    };
    let usual = usual.filter(|_| axes.efforts.is_empty());
    let usual_temperature = config.temperature.filter(|_| axes.temperatures.is_empty());
    let request = RequestSettings {
        history: history.or(config.history),
        radius: arguments.radius.or(config.radius),
        lead,
        within: Some(arguments.within()?),
        every_scenario: false,
        protocol: options.protocol.unwrap_or_default(),
        temperature: temperature.or(usual_temperature),
        max_tokens: options.max_tokens.or(config.max_tokens),
        effort: effort.or(usual),
        log_probabilities: options.log_probabilities || config.log_probabilities,
        tools: limits,
        form,
        stride,
        road: options.of_frames.road,
        axes: options.of_frames.axes,
        measures: options.of_frames.measures,
        pack: options.pack.unwrap_or_default(),
        seed,
    };
    if let Some(why) = request.settings(None).misplaced(&frames, "--") {
        return Err(Failure::input(why));
    }
    let matrix = Matrix {
        request: request.drawn(&tasks),
        tasks,
        frames,
        techniques,
        models,
        samples: options.samples.unwrap_or(1),
        more_leads: leads.collect(),
        transforms: each_once(changes.copied()),
        axes,
    };
    matrix.check_size().map_err(Failure::input)?;
    Ok(matrix)
}

/// A model that every installation knows.
const ANY_MODEL: &str = "local/default";

/// The same without repetitions.
fn each_once<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut seen = Vec::new();
    for value in values {
        if !seen.contains(&value) {
            seen.push(value);
        }
    }
    seen
}
