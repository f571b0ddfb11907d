//! `nearmiss evaluate` with language models: a matrix of prompt configurations over many scenarios, as a stored batch.

use std::collections::BTreeMap;
use std::num::NonZeroU32;
use std::str::FromStr;
use std::sync::Arc;

use super::{Evaluate, Format};
use crate::cli::ask::{budget, effort, temperature};
use crate::cli::open::{found, frame, techniques};
use crate::cli::{Failure, Outcome, output};
use crate::description::Frame;
use crate::evaluation::batch::{Matrix, MatrixAdditions, RequestSettings, Shard};
use crate::evaluation::{Lead, default_frame};
use crate::formats::EgoSelection;
use crate::llm::{Effort, Endpoint};
use crate::prompts::Techniques;
use crate::scenario::Transform;
use crate::store::BatchId;
use crate::verdict::Task;
use crate::workflow::batch::{BatchError, BatchPlan, BatchRequest, BatchRun};

use super::context::BatchContext;
use super::dry_run;
use super::listed;
use super::resume;
use super::running::{self, Table};
use super::table::Rows;
use super::truth::{say_each, truth_source};

/// What only batches take.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Language models (any of these makes it a batch, which is stored)")]
pub struct Options {
    /// Frames of the description, separated by commas [default: ego].
    #[arg(long, value_delimiter = ',', value_name = "FRAME", value_parser = frame)]
    pub frame: Vec<Frame>,
    /// Prompting techniques, separated by commas: base, cp, cot, icl, all, or combinations such as cp+cot [default:
    /// all].
    #[arg(long, value_delimiter = ',', value_name = "TECHNIQUES", value_parser = techniques)]
    pub techniques: Vec<Techniques>,
    /// Answers per request; with --resume the new total [default: 1].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub samples: Option<u32>,
    /// Also ask about transformed scenes: rotate:DEGREES, mirror, move:X,Y (metres), renumber:SEED. Separate several by
    /// semicolons or spaces, or repeat the option. The first table is about the original scenes, the second shows which
    /// answers changed.
    #[arg(long, value_name = "CHANGES", value_parser = changes)]
    pub transform: Vec<Changes>,
    /// Sampling temperature, 0 to 2 [default: from the template, else the server's].
    #[arg(long, allow_negative_numbers = true, value_parser = temperature)]
    pub temperature: Option<f64>,
    /// Maximum number of tokens in an answer [default: the server's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_tokens: Option<u32>,
    /// Reasoning effort: off, low, medium or high [default: the server's].
    #[arg(long, value_parser = effort)]
    pub effort: Option<Effort>,
    /// Concurrent requests per provider [default: `concurrency` in config.toml].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = at_once)]
    pub concurrency: Option<NonZeroU32>,
    /// Maximum cost of this run in US dollars; needs known prices and a token limit [default: `budget` in config.toml].
    #[arg(long, value_name = "USD", allow_negative_numbers = true, value_parser = budget)]
    pub budget: Option<f64>,
    /// Address of one server for all models, in place of the providers' own.
    #[arg(long, value_name = "URL")]
    pub base_url: Option<String>,
    /// Only this part of the scenarios, such as 2/8; the name decides the part.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Submit the questions through the batch APIs of OpenAI, Anthropic and Gemini: answers within a day, at half the
    /// price. `nearmiss batches collect` fetches the answers, `--resume` counts them.
    #[arg(long, conflicts_with_all = ["dry_run", "concurrency"])]
    pub batch: bool,
    /// Print what would be asked, its tokens and its maximum cost; send nothing.
    #[arg(long)]
    pub dry_run: bool,
    /// The same as --format json.
    #[arg(long, conflicts_with = "format")]
    pub json: bool,
    /// Resume a batch by its name, such as b7, or the last one.
    #[arg(long, value_name = "ID|last", conflicts_with = "horizon")]
    pub resume: Option<Resumed>,
    /// Ask only questions that failed or whose answer was cut off.
    #[arg(long, conflicts_with_all = ["add_model", "add_techniques", "add_lead", "add_transform", "samples"])]
    pub retry_failed: bool,
    /// Add these models to a resumed batch, separated by commas.
    #[arg(long, value_delimiter = ',', value_name = "MODEL")]
    pub add_model: Vec<String>,
    /// Add these techniques to a resumed batch, separated by commas.
    #[arg(long, value_delimiter = ',', value_name = "TECHNIQUES", value_parser = techniques)]
    pub add_techniques: Vec<Techniques>,
    /// Add these leads of the safety task to a resumed batch, separated by commas; see --lead.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "S",
        allow_negative_numbers = true
    )]
    pub add_lead: Vec<Lead>,
    /// Add these transformed scenes to a resumed batch; see --transform.
    #[arg(long, value_name = "CHANGES", value_parser = changes)]
    pub add_transform: Vec<Changes>,
    /// List the stored batches and their progress; with --json, one object a line.
    #[arg(long, conflicts_with_all = ["paths", "model", "task", "resume", "dry_run", "format", "truth", "batch"])]
    pub list: bool,
}

fn at_once(text: &str) -> Result<NonZeroU32, String> {
    text.parse()
        .map_err(|_| "expected a whole number of requests, at least 1".to_string())
}

/// Changes of scenes that were said together.
#[derive(Debug, Clone, PartialEq)]
pub struct Changes(Vec<Transform>);

fn changes(text: &str) -> Result<Changes, String> {
    let words = text.split(|c: char| c == ';' || c.is_whitespace());
    let words = words.filter(|word| !word.is_empty());
    let changes = words.map(|word| {
        let change = word.parse::<Transform>();
        change.map_err(|error| format!("{error}; several are separated by semicolons or spaces"))
    });
    match changes.collect::<Result<Vec<_>, _>>()? {
        none if none.is_empty() => Err("expected a transform such as mirror".into()),
        changes => Ok(Changes(changes)),
    }
}

/// Which batch is resumed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Resumed {
    Last,
    Batch(BatchId),
}

impl FromStr for Resumed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "last" => Ok(Self::Last),
            other => other.parse().map(Self::Batch),
        }
    }
}

impl Options {
    /// Additions to a resumed batch.
    pub fn more(&self) -> MatrixAdditions {
        let changes = self.add_transform.iter().flat_map(|changes| &changes.0);
        MatrixAdditions {
            models: self.add_model.clone(),
            techniques: self.add_techniques.clone(),
            leads: self.add_lead.clone(),
            transforms: changes.copied().collect(),
            samples: self.samples,
        }
    }

    /// Whether any option is given that only a batch understands.
    pub fn any(&self) -> bool {
        !self.frame.is_empty()
            || !self.techniques.is_empty()
            || !self.transform.is_empty()
            || self.samples.is_some()
            || self.temperature.is_some()
            || self.max_tokens.is_some()
            || self.effort.is_some()
            || self.concurrency.is_some()
            || self.budget.is_some()
            || self.base_url.is_some()
            || self.shard.is_some()
            || self.dry_run
            || self.batch
            || self.resume.is_some()
            || self.list
    }
}

/// Runs what is no evaluation of the built-in judge alone.
pub fn run(arguments: &Evaluate) -> Outcome {
    if arguments.batch.list {
        return listed::list(arguments.batch.json);
    }
    match arguments.batch.resume {
        Some(which) => {
            resume::all_stays(arguments)?;
            resume::run(arguments, which)
        }
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
    let request = BatchRequest {
        matrix: matrix(arguments, &context)?,
        paths: arguments.paths.clone(),
        entries: found(&arguments.paths)?,
        ego: EgoSelection::Beside,
        truth: truth_source(&arguments.truth)?,
        shard: options.shard,
        drafts: BTreeMap::new(),
        base_url: options.base_url.clone(),
    };
    let plan = request.plan(&context.library, &context.thresholds);
    let plan = plan.map_err(Failure::input)?;
    say_each(&plan.doubts);
    if let (Some(shard), 0) = (options.shard, plan.scenarios()) {
        output::say(&format!("nearmiss: no scenario in part {shard}"));
        return match json(arguments) {
            true => output::json(&Rows::from_scored(&[]).document(None)),
            false => Ok(()),
        };
    }
    carry_out(arguments, &context, &plan)
}

/// Asks what a plan has to ask, then writes the table of the batch.
pub fn carry_out(arguments: &Evaluate, context: &BatchContext, plan: &BatchPlan) -> Outcome {
    let options = &arguments.batch;
    let judges = context.judges(&plan.models(), &plan.spec, options)?;
    let dry_run = dry_run::make(plan, &judges, &context.store)?;
    if dry_run.items.is_empty() && options.resume.is_none() {
        return Err(Failure::input(format!(
            "no label for any of {}; ground truth: {}",
            super::number(plan.scenarios(), "scenario"),
            plan.spec.truth.words()
        )));
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
    };
    if plan.scenarios() == 0 {
        output::say(&format!("nearmiss: {id}: nothing to ask"));
        return running::show(context, id, table);
    }
    let run = Arc::new(BatchRun::new(
        (id, plan),
        Arc::clone(&context.store),
        judges,
        context.concurrency(options),
        Arc::default(),
    ));
    running::ask(&runtime, context, &run, &dry_run, (options.batch, table))
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
    let frames = match options.frame.is_empty() {
        true => vec![default_frame(&context.library, tasks[0])],
        false => options.frame.clone(),
    };
    let techniques = match options.techniques.is_empty() {
        true => vec![Techniques::ALL],
        false => options.techniques.clone(),
    };
    let history = arguments.history.map(|steps| steps as usize);
    let effort = config.effort.as_deref().and_then(Effort::parse);
    Ok(Matrix {
        tasks,
        frames,
        techniques,
        models,
        samples: options.samples.unwrap_or(1),
        more_leads: leads.collect(),
        transforms: each_once(changes.copied()),
        request: RequestSettings {
            history: history.or(config.history),
            radius: arguments.radius.or(config.radius),
            lead,
            temperature: options.temperature.or(config.temperature),
            max_tokens: options.max_tokens.or(config.max_tokens),
            effort: options.effort.or(effort),
        },
    })
}

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
