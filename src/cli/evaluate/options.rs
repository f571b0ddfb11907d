//! Options of `evaluate` that only batches take.

use std::num::NonZeroU32;
use std::path::PathBuf;
use std::str::FromStr;

use crate::ask::{budget, effort, temperature};
use crate::declared::Declared;
use crate::gate::Gate;
use crate::open::{frame, pack, techniques};
use crate::span::{OfFrames, form};
use crate::tool_options::{ToolLimitOptions, on_or_off};
use nearmiss_ask::llm::Effort;
use nearmiss_ask::prompts::{Pack, Techniques};
use nearmiss_base::system::unknown;
use nearmiss_scene::description::{Form, Frame};
use nearmiss_scene::scenario::Transform;
use nearmiss_store::{BatchId, SplitPart};
use nearmiss_study::evaluation::batch::{MatrixAdditions, Shard, Split, Subset};
use nearmiss_study::evaluation::{Lead, Protocol};
use nearmiss_workflow::batch::Selection;

/// The largest seed that TOML can write.
const SEEDS: u64 = i64::MAX as u64;

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
    /// `paper` asks about the windows of "From Words to Collisions" and counts as it does: a yes of the safety task has
    /// to name the obstacle of the collision [default: matched: windows at leads, and safe ones like them].
    #[arg(long, value_name = "PROTOCOL", value_parser = protocol, conflicts_with_all = ["lead", "within"])]
    pub protocol: Option<Protocol>,
    /// Answers per request; with --resume the new total [default: 1].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub samples: Option<u32>,
    /// Also ask about transformed scenes: rotate:DEGREES, mirror, move:X,Y (metres), renumber:SEED. Separate several by
    /// semicolons or spaces, or repeat the option. The first table is about the original scenes, the second shows which
    /// answers changed.
    #[arg(long, value_name = "CHANGES", value_parser = changes)]
    pub transform: Vec<Changes>,
    /// Sampling temperatures, 0 to 2, separated by commas; everything is asked with each [default: from the template,
    /// else the server's].
    #[arg(long, value_delimiter = ',', allow_negative_numbers = true, value_parser = temperature)]
    pub temperature: Vec<f64>,
    /// Maximum number of tokens in an answer [default: the server's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_tokens: Option<u32>,
    /// Reasoning efforts, separated by commas: off, minimal, low, medium, high, xhigh or max; everything is asked with
    /// each [default: the server's].
    #[arg(long, value_delimiter = ',', value_parser = effort)]
    pub effort: Vec<Effort>,
    /// Whether models may call tools that compute (`nearmiss help tools`): on or off; off,on asks with and without them
    /// [default: off].
    #[arg(long, value_delimiter = ',', value_name = "ON|OFF", value_parser = on_or_off)]
    pub tools: Vec<bool>,
    #[command(flatten)]
    pub tool_limits: ToolLimitOptions,
    /// Wordings of the description, separated by commas: prose (sentences), compact (a table); everything is asked with
    /// each [default: from the template, else compact].
    #[arg(long, value_delimiter = ',', value_parser = form)]
    pub form: Vec<Form>,
    /// Describe every Nth step, and always the last; several numbers, separated by commas, are asked each [default: from
    /// the template, else 1].
    #[arg(long, value_delimiter = ',', value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub stride: Vec<u32>,
    #[command(flatten)]
    pub of_frames: OfFrames,
    /// Templates: standard, or paper to ask as "From Words to Collisions" does; --protocol paper chooses its windows
    /// [default: standard].
    #[arg(long, value_name = "PACK", value_parser = pack)]
    pub pack: Option<Pack>,
    /// Seeds of the sampling, separated by commas, for servers that take one; everything is asked with each [default:
    /// none].
    #[arg(long, value_delimiter = ',', value_name = "N", value_parser = clap::value_parser!(u64).range(0..=SEEDS))]
    pub seed: Vec<u64>,
    /// Only scenarios that a filter of the workbench's list lets through, such as `tag:cut_in risk<3`; see
    /// `nearmiss help experiments`.
    #[arg(long, value_name = "FILTER")]
    pub select: Option<String>,
    /// Put this share of the scenarios into a test split, whose figures stay locked until all its questions are
    /// answered; the rest is the dev split.
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub test_share: Option<f64>,
    /// Seed of the split [default: 1].
    #[arg(long, value_name = "N", requires = "test_share", value_parser = clap::value_parser!(u64).range(0..=SEEDS))]
    pub split_seed: Option<u64>,
    /// Ask only this part of a split: dev or test.
    #[arg(long, value_name = "PART", value_parser = part_of_split)]
    pub split: Option<SplitPart>,
    /// Show the figures of a test split before it is complete; later reports say that it was looked at.
    #[arg(long)]
    pub unlock: bool,
    /// Ask for the log probabilities of answers, where a model gives them [default: `log_probabilities` in
    /// config.toml, else no].
    #[arg(long)]
    pub log_probabilities: bool,
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
    #[command(flatten)]
    pub declared: Declared,
    #[command(flatten)]
    pub gate: Gate,
    /// Submit the questions through the batch APIs of OpenAI, Anthropic and Gemini: answers within a day, at half the
    /// price. `nearmiss runs batches collect` fetches the answers, `--resume` counts them.
    #[arg(long, conflicts_with_all = ["dry_run", "concurrency"])]
    pub batch: bool,
    /// Print what would be asked, its tokens and its maximum cost; send nothing.
    #[arg(long, conflicts_with_all = NEED_ANSWERS)]
    pub dry_run: bool,
    /// Print every question as a JSON line: scenario, label, critical obstacles, steps, tokens; send nothing. Needs no
    /// model.
    #[arg(long, conflicts_with_all = ["dry_run", "batch"], conflicts_with_all = NEED_ANSWERS)]
    pub questions: bool,
    /// Print how well position, length and traffic alone tell dangerous from safe windows; send nothing. Needs no model.
    #[arg(long, conflicts_with_all = ["dry_run", "batch", "questions"], conflicts_with_all = NEED_ANSWERS)]
    pub leaks: bool,
    /// The same as --format json.
    #[arg(long, conflicts_with = "format")]
    pub json: bool,
    /// Write scenarios and settings to this experiment file (TOML) and send nothing; `nearmiss evaluate FILE.toml` runs
    /// it.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["dry_run", "batch", "questions", "leaks", "resume"])]
    pub write_experiment: Option<PathBuf>,
    /// Resume a batch by its name, such as b7, or the last one.
    #[arg(long, value_name = "ID|last", conflicts_with = "horizon")]
    pub resume: Option<Resumed>,
    /// Ask only questions that failed, whose answer was cut off, or whose whole answer has no readable verdict.
    #[arg(long, conflicts_with_all = ["add_model", "add_techniques", "add_lead", "add_transform", "samples"])]
    pub retry_failed: bool,
    /// Ask questions that failed, were cut off or have no readable verdict again, up to N times and within the budget.
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with_all = ["dry_run", "batch", "questions", "leaks"])]
    pub retry: u32,
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
    /// List the stored batches and their progress; with --json, one object per line.
    #[arg(long, conflicts_with_all = ["paths", "model", "task", "resume", "dry_run", "format", "truth", "batch"])]
    pub list: bool,
}

/// Options that hold a requirement against answers.
const NEED_ANSWERS: [&str; 3] = ["require", "baseline_bundle", "junit"];

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if share > 0.0 && share < 1.0 => Ok(share),
        _ => Err("expected a share above 0 and below 1".into()),
    }
}

fn protocol(text: &str) -> Result<Protocol, String> {
    let known = Protocol::ALL.map(Protocol::name);
    Protocol::parse(text).ok_or_else(|| unknown("protocol", text, known))
}

/// A part of a split by its word.
pub fn part_of_split(text: &str) -> Result<SplitPart, String> {
    SplitPart::parse(text).ok_or_else(|| "expected dev or test".into())
}

fn at_once(text: &str) -> Result<NonZeroU32, String> {
    text.parse()
        .map_err(|_| "expected a whole number of requests, at least 1".to_string())
}

/// Changes of scenes that were said together.
#[derive(Debug, Clone, PartialEq)]
pub struct Changes(pub Vec<Transform>);

fn changes(text: &str) -> Result<Changes, String> {
    let words = text
        .split(|c: char| c == ';' || c.is_whitespace())
        .filter(|word| !word.is_empty());
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
    /// Which of the scenarios are asked about, and in which parts.
    pub fn subset(&self) -> Subset {
        Subset {
            select: self.select.clone(),
            split: self.test_share.map(|test| Split {
                test,
                seed: self.split_seed.unwrap_or(Split::SEED),
            }),
        }
    }

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

    /// Which questions of a stored batch are asked, or listed.
    pub fn selection(&self) -> Selection {
        match (self.retry_failed, self.questions || self.leaks) {
            (true, _) => Selection::Failed,
            (false, true) => Selection::All,
            (false, false) => Selection::Open,
        }
    }

    /// Whether questions are only looked at.
    pub fn asks_nothing(&self) -> bool {
        self.dry_run || self.questions || self.leaks
    }

    /// Whether any option is given that only a batch understands.
    pub fn any(&self) -> bool {
        !self.frame.is_empty()
            || !self.techniques.is_empty()
            || !self.transform.is_empty()
            || self.samples.is_some()
            || !self.temperature.is_empty()
            || self.max_tokens.is_some()
            || !self.effort.is_empty()
            || !self.tools.is_empty()
            || self.tool_limits.any()
            || !self.form.is_empty()
            || !self.stride.is_empty()
            || self.of_frames.any()
            || self.pack.is_some()
            || !self.seed.is_empty()
            || self.select.is_some()
            || self.test_share.is_some()
            || self.split.is_some()
            || self.unlock
            || self.log_probabilities
            || self.concurrency.is_some()
            || self.retry > 0
            || self.protocol.is_some()
            || self.declared.any()
            || self.gate.any()
            || self.budget.is_some()
            || self.base_url.is_some()
            || self.shard.is_some()
            || self.dry_run
            || self.questions
            || self.leaks
            || self.batch
            || self.write_experiment.is_some()
            || self.resume.is_some()
            || self.list
    }
}
