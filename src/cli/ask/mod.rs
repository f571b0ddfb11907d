//! `nearmiss ask`: one answer, streamed to standard error, then said for people.

mod document;

pub use document::AskDryRun;

use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::Arc;

use nearmiss_ask::llm::{Chunk, Environment, Parameters, Registry};
use nearmiss_base::system::KeyLines;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::{
    CriticalObstacle, Motion, ObstacleRisk, ParsedAnswer, Task, Verdict,
};
use nearmiss_settings::{Config, Folders, TextFile};
use nearmiss_store::{Origin, RunId, Store};
use nearmiss_study::evaluation::batch::Experiment;
use nearmiss_study::evaluation::{
    Answer, AskError, Case, Event, Judge, JudgeOutcome, ModelJudge, RunOptions, StoredOrigin,
    consumption, motion_lines, tool_rounds,
};
use nearmiss_workflow::{
    AskDocument, AskOutcome, AskRequest, Models, Server, ask, configured_experiment,
    cost_at_current_prices, missing_verdict,
};

use super::open::{configuration, judge_of, runtime};
use super::prompt::QuestionArguments;
use super::{Failure, Outcome, ending, knobs, output};

/// Arguments of `ask`.
#[derive(Debug, clap::Args)]
pub struct Ask {
    #[command(flatten)]
    asked: QuestionArguments,
    /// Model to ask, as provider/model [default: `model` in config.toml, else reference/geometry].
    #[arg(long)]
    model: Option<String>,
    /// Server address, instead of the provider's own.
    #[arg(long, value_name = "URL")]
    base_url: Option<String>,
    /// Change a setting of the question or the request [default: from config.toml]
    ///
    /// Keys of the question are those of `prompt show --set`. Keys of the request: temperature, max_tokens, seed,
    /// effort, tools, tool_rounds, tool_calls, log_probabilities. For a server of --base-url: dialect, and key_env, the
    /// environment variable with its API key [default: those of the provider]. See `nearmiss help providers`.
    #[arg(long, value_name = "KEY=VALUE", value_parser = knobs::of_request)]
    set: Vec<(String, String)>,
    /// Maximum cost of the answer in US dollars; needs a known price and a token limit [default: `budget` in
    /// config.toml, else none].
    #[arg(long, value_name = "USD", allow_negative_numbers = true, value_parser = budget)]
    budget: Option<f64>,
    /// Send the question even if its answer is stored.
    #[arg(long)]
    fresh: bool,
    /// Sample number; each number is asked once and stored.
    #[arg(long, value_name = "N", default_value_t = 0)]
    sample: u32,
    #[command(flatten)]
    format: output::FormatOption,
    /// Neither read nor write the store.
    #[arg(long)]
    no_store: bool,
    /// Print the token count and maximum cost of the question; send nothing.
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
    let bound = cost_limit(arguments.budget, &config, &folders);
    let judge = judge(arguments, &set, model, &folders, &config, bound.as_ref())?;
    if arguments.dry_run {
        return document::dry_run(
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
    let span = arguments.asked.span.named();
    let chosen = span.chosen();
    if let (judge::MODEL, Task::Collision, Some(chosen)) = (model, question.case.task, chosen) {
        output::say(&format!(
            "nearmiss: {chosen} ignored: the built-in judge answers the collision task from all recorded steps"
        ));
    }
    if question.case.task == Task::Safety && span.at.is_none() {
        let last = question.case.window.last();
        output::say(&format!(
            "nearmiss: the window ends at step {last} ({:.1} s), near the end of the recording; --at worst chooses the \
             most dangerous moment",
            question.case.scene.time_of(last)
        ));
    }
    let runtime = runtime(1)?;
    let request = AskRequest {
        question: &question,
        judge: &judge,
        store,
        options,
    };
    let outcome = runtime.block_on(async {
        let mut words = AnswerPrinter::new(!arguments.format.is_json());
        let mut number = None;
        let outcome = tokio::select! {
            outcome = ask(request, |event| {
                if let Event::Kept(run) = &event {
                    number = Some(*run);
                }
                words.hear(event);
            }) => {
                outcome.map_err(|error| not_asked(error, bound.as_ref()))
            }
            () = ending::signal() => Err(interrupted(number, arguments.no_store)),
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
            Some(run) => format!("{} (run {run})", missing_verdict(missing)),
            None => missing_verdict(missing),
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
    bound: Option<&CostLimit>,
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

/// A language model that writes a text of at most so many tokens, within a budget in US dollars.
pub fn text_model(
    model: &str,
    (folders, config): (&Folders, &Config),
    (tokens, budget): (u32, Option<f64>),
) -> Result<Box<ModelJudge>, Failure> {
    let parameters = Parameters {
        max_tokens: Some(config.max_tokens.unwrap_or(tokens)),
        log_probabilities: false,
        tools: None,
        ..configured_experiment(config).parameters()
    };
    let models = models(model, &config.provider, folders, parameters, budget);
    match judge_of(&models, model)? {
        Judge::Model(judge) => Ok(judge),
        _ => Err(Failure::input(format!(
            "--model {model}: not a language model; give provider/model"
        ))),
    }
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
    let whose = provenance_label(answer, judge.id());
    let mut lines = match &answer.judged {
        JudgeOutcome::Verdict(parsed) => verdict_lines(&parsed.verdict, answer, case, &whose),
        JudgeOutcome::Other(reading) => answer_lines(&reading.said, &whose),
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
        let cost = match (consumed.cost_usd, cost_at_current_prices(answer, judge)) {
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
    lines.extend(verdict.obstacles.iter().map(risk_line));
    let (listed, all) = (verdict.obstacles.len(), case.scene.participants().count());
    if is_built_in && listed < all {
        lines.push(format!("  {listed} of {all} obstacles listed"));
    }
    lines.push(line("justification", &verdict.justification));
    lines
}

/// Describes the origin of a stored answer.
fn stored(past: &StoredOrigin) -> String {
    let asked = output::local(past.created_ms);
    match past.origin {
        Origin::Asked => format!("from the store, asked {asked}; --fresh asks again"),
        Origin::Replayed => {
            format!("from the store, asked {asked} elsewhere and imported; --fresh asks again")
        }
        Origin::Recorded => format!("from the store, recorded, imported {asked}"),
    }
}

/// The most that an answer may cost.
struct CostLimit {
    /// US dollars.
    usd: f64,
    /// Where the configuration says it; `None` if the command line does.
    said: Option<String>,
}

/// The bound that holds, if there is one: the option wins.
fn cost_limit(option: Option<f64>, config: &Config, folders: &Folders) -> Option<CostLimit> {
    if let Some(usd) = option {
        return Some(CostLimit { usd, said: None });
    }
    let (usd, path) = (config.budget?, folders.config_file());
    // It was read a moment ago; where it is gone by now, its name says enough.
    let text = TextFile::read_if_there(&path).ok().flatten();
    let line = text.and_then(|file| KeyLines::new(&file.text).line(&["budget"]));
    let line = line.map_or(String::new(), |line| format!(":{line}"));
    let said = Some(format!("{}{line}: budget = {usd}", path.display()));
    Some(CostLimit { usd, said })
}

/// Why nothing was asked; of money, where the bound is from and what to do about it here.
fn not_asked(error: AskError, bound: Option<&CostLimit>) -> Failure {
    let said = bound.and_then(|bound| bound.said.as_ref());
    match (&error, said) {
        (AskError::OverBudget(_), Some(said)) => Failure::input(format!(
            "{error} (the budget is that of {said}; --budget USD sets another for this answer, --set max_tokens=N a limit)"
        )),
        _ => Failure::input(error),
    }
}

/// Whose answer it is: the model, and where it was asked for under another name, which run that was.
fn provenance_label(answer: &Answer, asked: &str) -> String {
    match answer.run {
        Some(run) if answer.model != asked => {
            format!(
                "{asked}; the answer of run {run}, asked as {}",
                answer.model
            )
        }
        _ => answer.model.clone(),
    }
}

/// Streams the words of an answer to standard error, where a person is watching.
struct AnswerPrinter {
    on: bool,
    /// Whether what was written last does not end its line.
    open: bool,
    part: Option<Part>,
}

/// The text that a piece belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Reasoning,
    Answer,
}

impl AnswerPrinter {
    /// Nothing is streamed unless that is wanted.
    fn new(wanted: bool) -> Self {
        Self {
            on: wanted && std::io::stderr().is_terminal(),
            open: false,
            part: None,
        }
    }

    /// Ends the line, so that what follows has its own.
    fn end(&mut self) {
        if std::mem::take(&mut self.open) {
            output::say("");
        }
    }

    /// Says what happens; what people must know is said in any case.
    fn hear(&mut self, event: Event) {
        match event {
            Event::Chunk(Chunk::Note(note)) => {
                self.say(&format!("nearmiss: {}", output::visible(&note)))
            }
            Event::Awaiting(run) => self.say(&format!(
                "nearmiss: another program is asking the same question (run {run}); waiting for its answer"
            )),
            Event::Chunk(Chunk::Retrying { attempt, wait, why }) if self.on => {
                let why = output::visible(&why);
                self.say(&format!(
                    "{why}; try {attempt} in {:.0} s",
                    wait.as_secs_f64()
                ));
            }
            Event::Tools(round) if self.on => {
                for line in tool_rounds::lines(&round) {
                    self.say(&format!("▸ {}", output::visible(&line)));
                }
            }
            Event::Chunk(Chunk::Reasoning(text)) if self.on => self.piece(&text, Part::Reasoning),
            Event::Chunk(Chunk::Text(text)) if self.on => self.piece(&text, Part::Answer),
            _ => {}
        }
    }

    /// Writes a separate line.
    fn say(&mut self, words: &str) {
        self.end();
        output::say(words);
    }

    /// A piece as it is; the terminal breaks the lines.
    fn piece(&mut self, text: &str, part: Part) {
        if part == Part::Answer && self.part == Some(Part::Reasoning) {
            self.say("── answer ──");
        }
        self.part = Some(part);
        self.open = !text.ends_with('\n');
        let mut err = std::io::stderr().lock();
        // Errors of a closed standard error are ignored.
        let _ = write!(err, "{}", output::visible(text)).and_then(|()| err.flush());
    }
}

/// Who could attack, or how an attacker moves.
fn answer_lines(said: &ParsedAnswer, model: &str) -> Vec<String> {
    let mut lines = match said {
        ParsedAnswer::Verdict(verdict) => {
            vec![line("verdict", format!("{} ({model})", verdict.word()))]
        }
        ParsedAnswer::Attacker(choice) => {
            let who = choice.attacker.map_or("none".into(), |id| id.to_string());
            let first = line("attacker", format!("{who} ({model})"));
            let risks = choice.obstacles.iter().map(risk_line);
            std::iter::once(first).chain(risks).collect()
        }
        ParsedAnswer::Trajectory(new) => {
            let first = line("obstacle", format!("{} ({model})", new.obstacle));
            let name = match new.motion {
                Motion::Manoeuvre(_) => "manoeuvre",
                Motion::Waypoints(_) => "waypoint",
            };
            let parts = motion_lines(&new.motion);
            let motion = parts.iter().map(|words| line(name, words));
            std::iter::once(first).chain(motion).collect()
        }
    };
    lines.push(line("justification", said.justification()));
    lines
}

/// The score of an obstacle, and why.
fn risk_line(one: &ObstacleRisk) -> String {
    format!("  risk {}      {}  {}", one.risk_score, one.id, one.reason)
}
