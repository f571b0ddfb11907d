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
pub use document::AskDocument;
pub use dry_run::AskDryRun;

use super::interrupt;
use super::open::{configuration, judge_of};
use super::prompt::QuestionArguments;
use super::{Failure, Outcome, output};
use super::{knobs, time};
use nearmiss_ask::llm::{Environment, Parameters, Registry};
use nearmiss_scene::judge;
use nearmiss_scene::verdict::{CriticalObstacle, Task, Verdict};
use nearmiss_settings::{Config, Folders};
use nearmiss_store::{Origin, RunId, Store};
use nearmiss_study::evaluation::batch::Experiment;
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
    /// Change a setting of the question (those of `prompt show`), or of the request: temperature, max_tokens, seed, effort,
    /// tools, tool_rounds, tool_calls, log_probabilities [default: from config.toml]; with --base-url dialect and key_env,
    /// the variable that holds the key [default: those of the provider]. See `nearmiss help providers`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = knobs::of_request)]
    set: Vec<(String, String)>,
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
    #[command(flatten)]
    format: output::FormatOption,
    /// Neither read from nor write to the store.
    #[arg(long)]
    no_store: bool,
    /// Say how many tokens the question has and what it costs at most; nothing is sent.
    #[arg(long)]
    dry_run: bool,
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
    let set = question_settings(arguments, &config)?;
    let question = arguments.asked.question(&set, &folders, &config)?;
    let model = arguments
        .model
        .as_deref()
        .or(config.model.as_deref())
        .unwrap_or(judge::MODEL);
    let bound = budget::resolve(arguments.budget, &config, &folders);
    let judge = judge(arguments, &set, model, &folders, &config, bound.as_ref())?;
    if arguments.dry_run {
        return dry_run::run(
            &question,
            &judge,
            bound.as_ref(),
            arguments.format.is_json(),
        );
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
        let mut words = stream::AnswerPrinter::new(!arguments.format.is_json());
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
            () = interrupt::signal() => Err(interrupted(number, arguments.no_store)),
        };
        words.end();
        outcome
    });
    let AskOutcome { answer, not_stored } = outcome?;
    if arguments.format.is_json() {
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
    match run {
        Some(run) => Failure::interrupted(&format!(
            "the partial answer is stored: `nearmiss runs show {run}`"
        )),
        None if no_store => Failure::interrupted("nothing is kept"),
        None => Failure::interrupted("nothing was sent"),
    }
}

fn judge(
    arguments: &Ask,
    set: &Experiment,
    model: &str,
    folders: &Folders,
    config: &Config,
    bound: Option<&Bound>,
) -> Result<Judge, Failure> {
    let mut providers = config.provider.clone();
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
            dialect: set.dialect.as_deref(),
            key_env: set.key_env.as_deref(),
        };
        server.overlay(&mut providers, name);
    }
    let budget = bound.map(|bound| bound.usd);
    judge_of(
        &models(model, &providers, folders, set.parameters(), budget),
        model,
    )
}

/// The settings, with the address of a server.
fn question_settings(arguments: &Ask, config: &Config) -> Result<Experiment, Failure> {
    let mut set = arguments.set.clone();
    let url = arguments.base_url.clone();
    set.extend(url.map(|url| ("base_url".into(), url)));
    knobs::of_one_question(config, &set)
}

/// The models of these providers; what is wrong with other providers, and what is doubtful about this model, is said.
pub fn models(
    model: &str,
    providers: &toml::Table,
    folders: &Folders,
    parameters: Parameters,
    budget: Option<f64>,
) -> Models {
    let registry = Registry::lenient(providers, &folders.config_file());
    // The provider being asked reports its own problem.
    let asked = model.split('/').next().unwrap_or_default();
    for (_, broken) in registry.broken().filter(|(name, _)| *name != asked) {
        output::say(&format!("nearmiss: {broken}"));
    }
    let environment = Environment::with_files(&[Path::new("."), &folders.config]);
    let models = Models::new(registry, environment, parameters, budget);
    if let Some(warning) = models.warning(model, jiff::Zoned::now().date()) {
        output::say(&format!("nearmiss: {model}: {warning}"));
    }
    models
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
        let calls = tool_rounds::rounds_summary(&answer.tool_rounds, "");
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
