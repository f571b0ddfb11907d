//! `nearmiss ask`: one answer, streamed.

mod budget;
mod document;
mod dry_run;
mod past;
mod stream;
mod words;

use std::path::Path;
use std::sync::Arc;

use budget::Bound;
use clap::builder::PossibleValuesParser;
pub use document::AskDocument;
pub use dry_run::AskDryRun;

use super::interrupt::{self, INTERRUPTED};
use super::open::{configuration, judge_of};
use super::prompt::QuestionArguments;
use super::time;
use super::tool_options::ToolLimitOptions;
use super::{Failure, Outcome, output};
use nearmiss_ask::llm::{Dialect, Effort, Environment, Parameters, Registry};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::{CriticalObstacle, Task, Verdict};
use nearmiss_settings::{Config, Folders};
use nearmiss_store::{Origin, RunId, Store};
use nearmiss_study::evaluation::{
    Answer, Case, Event, Judge, JudgeOutcome, RunOptions, StoredOrigin,
};
use nearmiss_study::evaluation::{consumption, tool_rounds};
use nearmiss_workflow::{AskOutcome, AskRequest, Models, Server, ask};

/// Arguments of `ask`.
#[derive(Debug, clap::Args)]
pub struct Ask {
    #[command(flatten)]
    asked: QuestionArguments,
    /// Model to ask, as provider/model [default: `model` in config.toml, else reference/geometry].
    #[arg(long)]
    model: Option<String>,
    /// Address of the server, in place of the provider's own.
    #[arg(long, value_name = "URL")]
    base_url: Option<String>,
    /// Wire protocol of --base-url [default: the dialect of the provider, else openai_chat].
    #[arg(long, value_name = "NAME", requires = "base_url", value_parser = PossibleValuesParser::new(Dialect::ALL.map(Dialect::name)))]
    dialect: Option<String>,
    /// Environment variable that holds the key for --base-url [default: that of the provider].
    #[arg(long, value_name = "NAME", requires = "base_url")]
    key_env: Option<String>,
    /// Sampling temperature, 0 to 2 [default: the server's].
    #[arg(long, allow_negative_numbers = true, value_parser = temperature)]
    temperature: Option<f64>,
    /// Maximum number of tokens in the answer [default: the server's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_tokens: Option<u32>,
    /// Sampling seed, if the server supports one.
    #[arg(long)]
    seed: Option<u64>,
    /// Reasoning effort: off, minimal, low, medium, high, xhigh or max [default: the server's].
    #[arg(long, value_parser = effort)]
    effort: Option<Effort>,
    /// Let the model call tools that compute distances, measures, lanes and predictions from the described window
    /// [default: `tools` in config.toml, else no]; `nearmiss help tools` lists them.
    #[arg(long)]
    tools: bool,
    #[command(flatten)]
    tool_limits: ToolLimitOptions,
    /// Ask for the log probabilities of the answer, where the model gives them [default: `log_probabilities` in
    /// config.toml, else no].
    #[arg(long)]
    log_probabilities: bool,
    /// Maximum cost of the answer in US dollars; needs a known price and a token limit [default: `budget` in
    /// config.toml, else none].
    #[arg(long, value_name = "USD", allow_negative_numbers = true, value_parser = budget)]
    budget: Option<f64>,
    /// Ask again even if the store has the answer.
    #[arg(long)]
    fresh: bool,
    /// Number of the sample: each number is asked once and stored.
    #[arg(long, value_name = "N", default_value_t = 0)]
    sample: u32,
    /// Print one JSON object; the answer is not streamed.
    #[arg(long)]
    json: bool,
    /// Neither read from nor write to the store.
    #[arg(long)]
    no_store: bool,
    /// Say how many tokens the question has and what it costs at most; nothing is sent.
    #[arg(long)]
    dry_run: bool,
}

pub fn temperature(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number".to_string())?;
    if (0.0..=2.0).contains(&value) {
        Ok(value)
    } else {
        Err("expected a number from 0 to 2".into())
    }
}

pub fn effort(text: &str) -> Result<Effort, String> {
    Effort::parse(text).ok_or_else(|| format!("expected {}", Effort::names()))
}

pub fn budget(text: &str) -> Result<f64, String> {
    let usd: f64 = text.parse().map_err(|_| "expected a number".to_string())?;
    if usd.is_finite() && usd > 0.0 {
        Ok(usd)
    } else {
        Err("expected a positive number of dollars".into())
    }
}

/// Runs `ask`.
pub fn run(arguments: &Ask) -> Outcome {
    let (folders, config) = configuration()?;
    let question = arguments.asked.question(&folders, &config)?;
    let model = arguments
        .model
        .as_deref()
        .or(config.model.as_deref())
        .unwrap_or(judge::MODEL);
    let bound = budget::resolve(arguments.budget, &config, &folders);
    let judge = judge(arguments, model, &folders, &config, bound.as_ref())?;
    if arguments.dry_run {
        return dry_run::run(&question, &judge, bound.as_ref(), arguments.json);
    }
    let store = store(arguments, &folders)?;
    let options = RunOptions {
        sample: arguments.sample,
        fresh: arguments.fresh,
        batch: None,
    };
    let chosen = arguments.asked.span.chosen();
    if let (judge::MODEL, Task::Collision, Some(chosen)) = (model, question.case.task, chosen) {
        output::say(&format!(
            "nearmiss: {chosen} ignored: the built-in judge answers the collision task from all recorded steps"
        ));
    }
    if question.case.task == Task::Safety && arguments.asked.span.is_default_end() {
        let last = question.case.window.last();
        output::say(&format!(
            "nearmiss: the window ends at step {last} ({:.1} s), near the end of the recording; --at worst chooses the \
             most dangerous moment",
            question.case.scene.time_of(last)
        ));
    }
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_all()
        .build()
        .map_err(Failure::input)?;
    let request = AskRequest {
        question: &question,
        judge: &judge,
        store,
        options,
    };
    let outcome = runtime.block_on(async {
        let mut words = stream::AnswerPrinter::new(!arguments.json);
        let mut number = None;
        let outcome = tokio::select! {
            outcome = ask(request, |event| {
                if let Event::Kept(run) = &event {
                    number = Some(*run);
                }
                words.hear(event);
            }) => {
                outcome.map_err(|error| budget::refused(error, bound.as_ref()))
            }
            () = interrupt::signal() => Err(Failure {
                message: String::new(),
                status: INTERRUPTED,
            }),
        };
        words.end();
        outcome.map_err(|failure| match failure.status {
            INTERRUPTED => interrupted(number, arguments.no_store),
            _ => failure,
        })
    });
    let AskOutcome { answer, not_stored } = outcome?;
    if arguments.json {
        output::document(&AskDocument::new(&answer, &question, &judge))?;
    } else {
        output::text(&summary(&answer, &question.case, &judge))?;
    }
    if let Some(message) = not_stored {
        return Err(Failure { message, status: 2 });
    }
    match &answer.judged {
        JudgeOutcome::Verdict(_) | JudgeOutcome::Other(_) => Ok(()),
        JudgeOutcome::Missing(missing) => Err(Failure::finding(match answer.run {
            Some(run) => format!("{} (run {run})", words::missing(missing)),
            None => words::missing(missing),
        })),
    }
}

/// The message after Ctrl-C.
fn interrupted(run: Option<RunId>, no_store: bool) -> Failure {
    let message = match run {
        Some(run) => {
            format!("interrupted; the partial answer is stored: `nearmiss runs show {run}`")
        }
        None if no_store => "interrupted; nothing is kept".into(),
        None => "interrupted before anything was sent".into(),
    };
    Failure {
        message,
        status: INTERRUPTED,
    }
}

fn judge(
    arguments: &Ask,
    model: &str,
    folders: &Folders,
    config: &Config,
    bound: Option<&Bound>,
) -> Result<Judge, Failure> {
    let mut providers = config.providers.clone();
    if let Some(url) = &arguments.base_url {
        let Some((name, _)) = model
            .split_once('/')
            .filter(|(name, _)| *name != "reference")
        else {
            return Err(Failure::input(
                "--base-url needs --model provider/model with any provider name, e.g. local/default",
            ));
        };
        let server = Server {
            url,
            dialect: arguments.dialect.as_deref(),
            key_env: arguments.key_env.as_deref(),
        };
        server.overlay(&mut providers, name);
    }
    let registry = Registry::lenient(&providers, &folders.config_file());
    // The provider being asked reports its own problem.
    let asked = model.split('/').next().unwrap_or_default();
    for (_, broken) in registry.broken().filter(|(name, _)| *name != asked) {
        output::say(&format!("nearmiss: {broken}"));
    }
    let parameters = Parameters {
        temperature: arguments.temperature.or(config.temperature),
        max_tokens: arguments.max_tokens.or(config.max_tokens),
        seed: arguments.seed,
        effort: arguments
            .effort
            .or(config.effort.as_deref().and_then(Effort::parse)),
        log_probabilities: arguments.log_probabilities || config.log_probabilities,
        tools: (arguments.tools || arguments.tool_limits.any() || config.tools)
            .then(|| arguments.tool_limits.limits()),
    };
    let environment = Environment::with_files(&[Path::new("."), &folders.config]);
    let budget = bound.map(|bound| bound.usd);
    let models = Models::new(registry, environment, parameters, budget);
    if let Some(warning) = models.warning(model, jiff::Zoned::now().date()) {
        output::say(&format!("nearmiss: {model}: {warning}"));
    }
    judge_of(&models, model)
}

fn store(arguments: &Ask, folders: &Folders) -> Result<Option<Arc<Store>>, Failure> {
    if arguments.no_store {
        return Ok(None);
    }
    Store::open(&folders.store())
        .map(|s| Some(Arc::new(s)))
        .map_err(|error| {
            Failure::input(format!("{error}; --no-store asks without keeping the run"))
        })
}

fn summary(answer: &Answer, case: &Case, judge: &Judge) -> String {
    let whose = past::whose(answer, judge.id());
    let mut lines = match &answer.judged {
        JudgeOutcome::Verdict(parsed) => verdict_lines(&parsed.verdict, answer, case, &whose),
        JudgeOutcome::Other(reading) => words::said(&reading.said, &whose),
        JudgeOutcome::Missing(_) if answer.text.trim().is_empty() => Vec::new(),
        JudgeOutcome::Missing(_) => vec![answer.text.trim_end().into()],
    };
    let flags = answer.flags(&case.scene.scenario).into_iter();
    lines.extend(flags.map(|flag| line("doubtful", flag)));
    if !answer.repairs().is_empty() {
        lines.push(line("repaired", answer.repairs().join("; ")));
    }
    lines.extend(answer.cut_off().map(|why| line("cut off", why)));
    if let Some(returned) = answer
        .model_returned
        .as_ref()
        .filter(|_| answer.model_differs())
    {
        lines.push(line("answered by", returned));
    }
    if !answer.tool_rounds.is_empty() {
        let calls = tool_rounds::words(&answer.tool_rounds, "");
        lines.push(line("tool calls", calls));
    }
    let consumed = &answer.consumed;
    if let Some(tokens) = consumption::tokens(consumed) {
        let cost = match (consumed.cost_usd, past::worked_out(answer, judge)) {
            (Some(0.0), _) if answer.price_source.is_some() => {
                answer.price_source.clone().unwrap_or_default()
            }
            (Some(usd), _) => format!("{usd:.6} USD"),
            (None, Some((usd, how))) => format!("{usd:.6} USD ({how})"),
            (None, None) => format!(
                "unknown ({})",
                consumption::unknown(consumed, &answer.model, answer.model_returned.as_deref())
            ),
        };
        lines.extend([line("tokens", tokens), line("cost", cost)]);
    }
    lines.extend(answer.run.map(|run| match &answer.past {
        Some(past) => line("run", format!("{run}, {}", stored(past))),
        None => line("run", run),
    }));
    let lines = lines.into_iter().map(|line| line + "\n");
    output::visible(&lines.collect::<String>())
}

/// A name and a value, below those of other lines.
fn line(name: &str, value: impl std::fmt::Display) -> String {
    format!("{name:<13} {value}")
}

/// What a verdict says.
fn verdict_lines(verdict: &Verdict, answer: &Answer, case: &Case, whose: &str) -> Vec<String> {
    let is_built_in = answer.model == judge::MODEL;
    // The probability that a body is at one place of its region is unknown.
    let possible = match (verdict.dangerous, verdict.task, verdict.probability) {
        (true, Task::Collision, None) if is_built_in => ", as a possible contact",
        _ => "",
    };
    let said = format!("{}{possible} ({whose})", verdict.word());
    let mut lines = vec![line("verdict", said)];
    let probability = |name, value: Option<f64>| value.map(|v| line(name, format!("{v:.2}")));
    lines.extend(probability("probability", verdict.probability));
    lines.extend(probability("by tokens", verdict.token_probability));
    if let Some(critical) = verdict.critical.as_ref().filter(|all| !all.is_empty()) {
        let one = |c: &CriticalObstacle| match c.probability {
            Some(probability) => format!("{} ({probability:.2})", c.id),
            None => c.id.to_string(),
        };
        let all: Vec<String> = critical.iter().map(one).collect();
        lines.push(line("critical", all.join(", ")));
    }
    lines.extend(verdict.obstacles.iter().map(words::risk));
    let (listed, all) = (verdict.obstacles.len(), case.scene.participants().count());
    if is_built_in && listed < all {
        lines.push(format!("  {listed} of {all} obstacles listed"));
    }
    lines.push(line("justification", &verdict.justification));
    lines
}

/// Describes the origin of a stored answer.
fn stored(past: &StoredOrigin) -> String {
    let asked = time::local(past.created_ms);
    match past.origin {
        Origin::Asked => format!("from the store, asked {asked}; --fresh asks again"),
        Origin::Replayed => {
            format!("from the store, asked {asked} elsewhere and imported; --fresh asks again")
        }
        Origin::Recorded => format!("from the store, recorded, imported {asked}"),
    }
}
