//! `nearmiss check`: the sentences of texts about scenarios, each held against the scene.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::system;
use nearmiss_record::CaptionedTable;
use nearmiss_scene::scenario::{Scene, Window};
use nearmiss_store::Store;
use nearmiss_study::evaluation::Judge;
use nearmiss_study::evaluation::claims::{
    CheckedSentence, Judgement, SentenceOutcome, SentenceRecord, Subject, TimeOrigin, Trace,
    Waypoint, agreement, sentences, sentences_of, truth_table, waypoints,
};
use nearmiss_workflow::batch::at_once;
use nearmiss_workflow::span::Span;
use nearmiss_workflow::{ReadText, SecondReader};
use schemars::JsonSchema;
use serde::Serialize;

use super::evaluate::runtime;
use super::open::{EgoChoice, configuration, entry, scene_and_doubts, thresholds_in_use};
use super::output::{self, FormatOption};
use super::span::{AT, At, history};
use super::{Failure, Outcome, ask, ending};

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
`nearmiss help answers` explains claims, tolerances and the accuracy of the rules.\n\
Exit status: 0 the text was checked, whatever the result; 1 a model did not answer; 2 usage or input error.")]
pub struct Check {
    /// Scenario file, name of a bundled scenario, or FILE.jsonl with one text about a scenario per line.
    #[arg(required_unless_present = "labelled")]
    scenario: Option<PathBuf>,
    /// File with the text; - reads standard input.
    #[arg(long, value_name = "FILE")]
    text: Option<PathBuf>,
    #[command(flatten)]
    ego: EgoChoice,
    /// Present of the text: a time step (32), seconds (3.2s) or worst [default: the last step].
    #[arg(long, value_name = AT, allow_negative_numbers = true)]
    at: Option<At>,
    /// Steps in the window that its author was shown, up to the present [default: 10].
    #[arg(long, value_name = "N", value_parser = history)]
    history: Option<u32>,
    /// Count times in the text from its present: "0.5 s ago", "at -0.5 s".
    #[arg(long)]
    relative: bool,
    /// Trajectory that came with the text: JSON, [[t, x, y], …] from the present on.
    #[arg(long, value_name = "FILE")]
    trajectory: Option<PathBuf>,
    /// Prompt that the model received; numbers that are not in it are reported as invented.
    #[arg(long, value_name = "FILE")]
    prompt: Option<PathBuf>,
    /// Model that turns sentences the rules cannot parse into claims, as provider/model; the geometry still decides.
    #[arg(long)]
    model: Option<String>,
    /// Maximum cost of the model's answers in US dollars [default: `budget` in config.toml, else none].
    #[arg(long, value_name = "USD", requires = "model", allow_negative_numbers = true, value_parser = ask::budget)]
    budget: Option<f64>,
    /// Print the number of requests and their maximum cost; send nothing.
    #[arg(long, requires = "model")]
    dry_run: bool,
    /// Print how often the rules agree with people on built-in labelled sentences.
    #[arg(long, conflicts_with_all = ["scenario", "text", "model"])]
    labelled: bool,
    #[command(flatten)]
    format: FormatOption,
}

impl Check {
    /// What each line of a file of texts says for itself is not said for all of them.
    fn refuse_what_lines_say(&self) -> Result<(), Failure> {
        let said = [
            ("--at", self.at.is_some()),
            ("--history", self.history.is_some()),
            ("--relative", self.relative),
            ("--trajectory", self.trajectory.is_some()),
            ("--prompt", self.prompt.is_some()),
        ];
        match said.iter().find(|(_, is_said)| *is_said) {
            Some((option, _)) => Err(Failure::input(format!(
                "{option} is of one text: write it into the lines of the file"
            ))),
            None => Ok(()),
        }
    }
}

/// Runs `check`.
pub fn run(arguments: &Check) -> Outcome {
    let is_json = arguments.format.is_json();
    let Some(scenario) = &arguments.scenario else {
        return agree(is_json);
    };
    let is_traces = { scenario.extension() }.is_some_and(|end| end == "jsonl");
    match &arguments.text {
        None if is_traces => {
            arguments.refuse_what_lines_say()?;
            traces(arguments, scenario)
        }
        None => Err(Failure::input(
            "say the text with --text FILE, or name a FILE.jsonl of texts",
        )),
        Some(text) => one(arguments, (scenario, text)),
    }
}

/// The agreement with the built-in labelled sentences.
fn agree(is_json: bool) -> Outcome {
    let rows = agreement();
    if is_json {
        return rows.iter().try_for_each(output::json);
    }
    let table = CaptionedTable::of("", "", &rows).map_err(Failure::input)?;
    output::text(&table.text())
}

/// One text about one scenario.
fn one(arguments: &Check, (scenario, file): (&Path, &Path)) -> Outcome {
    let entry = entry(scenario)?;
    let ego = arguments.ego.wanted(std::slice::from_ref(&entry))?;
    let (scene, doubts) = scene_and_doubts(&entry, &ego)?;
    doubts.iter().for_each(|said| output::say(said));
    let told = text(file)?;
    let prompt = arguments.prompt.as_deref().map(text).transpose()?;
    let way = match &arguments.trajectory {
        Some(file) => {
            let rows: Vec<[f64; 3]> = serde_json::from_str(&text(file)?).map_err(|error| {
                Failure::input(format!("{}: no [[t, x, y], …]: {error}", file.display()))
            })?;
            let way = waypoints(&rows)
                .map_err(|why| Failure::input(format!("{}: {why}", file.display())))?;
            if way.is_empty() {
                let none = format!("{}: a trajectory without points", file.display());
                return Err(Failure::input(none));
            }
            way
        }
        None => Vec::new(),
    };
    let times = origin(arguments.relative);
    let window = window(&scene, arguments.at, arguments.history.unwrap_or(HISTORY))
        .map_err(|why| Failure::input(format!("{}: {why}", entry.display())))?;
    let subject = Subject {
        prompt: prompt.as_deref(),
        trajectory: &way,
        ..Subject::new(&scene, times, Some((window.first(), window.last())))
    };
    let found = sentences(&told, &subject);
    let mut texts = vec![(subject, told.as_str(), found)];
    let failed = match read_again(arguments, &mut texts)? {
        Reading::Estimated => return Ok(()),
        Reading::Done(failed) => failed,
    };
    for (subject, told, found) in &texts {
        if arguments.format.is_json() {
            { found.iter() }
                .map(|sentence| SentenceRecord::new(told, sentence, subject))
                .try_for_each(|record| output::json(&record))?;
        } else {
            output::text(&words(told, found, &scene))?;
        }
    }
    failed
}

/// What came of a second reader.
enum Reading {
    /// Nothing was to be sent.
    Estimated,
    /// The sentences are read, or there is no second reader; why some questions have no answer.
    Done(Outcome),
}

/// The most tokens of an answer of a second reader, where the configuration sets no limit.
const TOKENS: u32 = 8192;

/// Has the model that is named, if one is, read what the rules do not understand.
fn read_again(arguments: &Check, texts: &mut [ReadText<'_>]) -> Result<Reading, Failure> {
    let Some(name) = &arguments.model else {
        return Ok(Reading::Done(Ok(())));
    };
    let (folders, config) = configuration()?;
    let budget = arguments.budget.or(config.budget);
    let model = ask::text_model(name, (&folders, &config), (TOKENS, budget))?;
    let store = Store::open(&folders.store()).map_err(Failure::input)?;
    let reader = SecondReader {
        at_once: at_once(&Judge::Model(model.clone()), config.at_once()),
        model: &model,
        store: &store,
    };
    if arguments.dry_run {
        let estimate = reader.estimate(texts).map_err(Failure::input)?;
        let usd = match estimate.usd {
            Some(usd) => format!("at most {usd:.4} USD"),
            None => "at an unknown price".into(),
        };
        output::text(&format!(
            "{} not understood; {} to {name}, {usd}\n",
            output::counted(estimate.sentences, "sentence"),
            output::counted(estimate.questions, "question"),
        ))?;
        return Ok(Reading::Estimated);
    }
    let done = runtime()?.block_on(async {
        tokio::select! {
            done = reader.read(texts) => done.map_err(Failure::input),
            () = ending::signal() => {
                Err(Failure::interrupted("the same command goes on, and pays for no answer twice"))
            }
        }
    })?;
    let cost = match done.usd {
        Some(usd) => format!("{usd:.4} USD"),
        None => "at an unknown price".into(),
    };
    output::say(&format!(
        "nearmiss: {name} read {} of {} that the rules do not understand ({}, {cost})",
        done.read,
        output::counted(done.asked, "sentence"),
        output::counted(done.questions, "question"),
    ));
    let failed = match done.failed.as_slice() {
        [] => Ok(()),
        all => Err(Failure::finding(output::visible(&all.join("; ")))),
    };
    Ok(Reading::Done(failed))
}

fn origin(is_relative: bool) -> TimeOrigin {
    if is_relative {
        TimeOrigin::WindowEnd
    } else {
        TimeOrigin::Recording
    }
}

fn window(scene: &Scene, at: Option<At>, history: u32) -> Result<Window, String> {
    let span = Span {
        at,
        history: Some(history as usize),
        obstacle: None,
    };
    let thresholds = thresholds_in_use().map_err(|why| why.message)?;
    let found = span.window(scene, &thresholds, None, history as usize);
    found.map_err(|why| why.to_string())
}

/// A sentence of a trace.
#[derive(Debug, Serialize, JsonSchema)]
pub struct TraceRecord {
    /// The line of the file, from 1.
    line: usize,
    /// The model.
    model: Option<String>,
    /// The scenario as the line names it.
    scenario: String,
    #[serde(flatten)]
    sentence: SentenceRecord,
}

/// The model of a trace that names none.
const UNNAMED: &str = "unnamed";

/// Texts about scenarios, one a line, and how true they are by model and kind of claim.
fn traces(arguments: &Check, file: &Path) -> Outcome {
    let read = text(file)?;
    let at = |line: usize, why: &dyn std::fmt::Display| {
        Failure::input(format!("{}:{line}: {why}", file.display()))
    };
    let mut all: Vec<(usize, Trace)> = Vec::new();
    for (place, line) in read.lines().enumerate() {
        if !line.trim().is_empty() {
            all.push((
                place + 1,
                Trace::read(line).map_err(|why| at(place + 1, &why))?,
            ));
        }
    }
    if all.is_empty() {
        return Err(Failure::input(format!(
            "{}: no line with a text",
            file.display()
        )));
    }
    // A scenario is opened once, however many texts are about it; files are beside the file that names them.
    let mut scenes: BTreeMap<(PathBuf, Option<String>), Arc<Scene>> = BTreeMap::new();
    for (line, trace) in &all {
        let key = (trace.scenario.clone(), trace.ego.clone());
        if scenes.contains_key(&key) {
            continue;
        }
        let beside = file.parent().unwrap_or(Path::new("")).join(&trace.scenario);
        let path = if beside.exists() {
            beside
        } else {
            trace.scenario.clone()
        };
        let open = || -> Result<Arc<Scene>, Failure> {
            let entry = entry(&path)?;
            let ego = EgoChoice::said(trace.ego.as_deref()).wanted(std::slice::from_ref(&entry))?;
            let (scene, doubts) = scene_and_doubts(&entry, &ego)?;
            doubts.iter().for_each(|said| output::say(said));
            Ok(scene)
        };
        scenes.insert(key, open().map_err(|why| at(*line, &why.message))?);
    }
    let ways: Vec<Vec<Waypoint>> = { all.iter() }
        .map(|(line, trace)| waypoints(&trace.trajectory).map_err(|why| at(*line, &why)))
        .collect::<Result<_, _>>()?;
    let mut texts: Vec<(Subject<'_>, &str)> = Vec::new();
    for ((line, trace), way) in all.iter().zip(&ways) {
        let scene = &scenes[&(trace.scenario.clone(), trace.ego.clone())];
        let when = trace.step.map(At::Step).or(trace.time.map(At::Seconds));
        let window = window(scene, when, trace.history.unwrap_or(HISTORY).max(1))
            .map_err(|why| at(*line, &why))?;
        let subject = Subject {
            prompt: trace.prompt.as_deref(),
            trajectory: way,
            ..Subject::new(
                scene,
                origin(trace.relative),
                Some((window.first(), window.last())),
            )
        };
        texts.push((subject, &trace.text));
    }
    let found = sentences_of(&texts);
    let mut texts: Vec<ReadText<'_>> = { texts.into_iter().zip(found) }
        .map(|((subject, text), found)| (subject, text, found))
        .collect();
    let failed = match read_again(arguments, &mut texts)? {
        Reading::Estimated => return Ok(()),
        Reading::Done(failed) => failed,
    };
    if arguments.format.is_json() {
        for ((line, trace), (subject, text, sentences)) in all.iter().zip(&texts) {
            for sentence in sentences {
                output::json(&TraceRecord {
                    line: *line,
                    model: trace.model.clone(),
                    scenario: trace.scenario.display().to_string(),
                    sentence: SentenceRecord::new(text, sentence, subject),
                })?;
            }
        }
    } else {
        output::text(&truth(&all, &texts)?)?;
    }
    failed
}

/// The steps that a text was told of where nothing says it.
const HISTORY: u32 = 10;

/// The table of claims by model and kind, and what sentences came to.
fn truth(all: &[(usize, Trace)], found: &[ReadText<'_>]) -> Result<String, Failure> {
    let names: Vec<(&str, String)> = { all.iter() }
        .map(|(_, trace)| {
            let model = trace.model.as_deref().unwrap_or(UNNAMED);
            (model, trace.scenario.display().to_string())
        })
        .collect();
    let texts = { names.iter().zip(found) }
        .map(|((model, scenario), (.., found))| (*model, scenario.as_str(), found.as_slice()));
    let rows = truth_table(texts);
    let table = CaptionedTable::of("", "", &rows).map_err(Failure::input)?;
    let mut told = table.text();
    let models: BTreeSet<&str> = names.iter().map(|name| name.0).collect();
    for model in models {
        let own = names.iter().zip(found).filter(|(name, _)| name.0 == model);
        let sentences: Vec<CheckedSentence> =
            own.flat_map(|(_, (.., all))| all.iter().cloned()).collect();
        told += &format!("{}: {}\n", output::visible(model), tally(&sentences));
    }
    Ok(told)
}

/// What sentences come to, in words.
fn tally(found: &[CheckedSentence]) -> String {
    let counts = SentenceOutcome::ALL
        .iter()
        .zip(CheckedSentence::counts(found));
    let counts: Vec<String> = counts
        .map(|(outcome, count)| format!("{} {count}", outcome.name().replace('_', " ")))
        .collect();
    let mut told = format!(
        "{}: {}",
        output::counted(found.len(), "sentence"),
        counts.join(", ")
    );
    let read = |one: &&CheckedSentence| !one.translated.is_empty() && one.is_understood();
    let translated = found.iter().filter(read).count();
    if translated > 0 {
        told += &format!("; {translated} read by a model");
    }
    let against = found
        .iter()
        .filter(|one| !one.contradicts.is_empty())
        .count();
    if against > 0 {
        told += &format!("; {against} contradict another one");
    }
    let invented: usize = found.iter().map(|one| one.invented.len()).sum();
    if invented > 0 {
        told += &format!("; {}", output::counted(invented, "invented number"));
    }
    told
}

/// The longest text, bytes.
const LONGEST: u64 = 16 << 20;

fn text(path: &Path) -> Result<String, Failure> {
    if path == Path::new("-") {
        let mut text = String::new();
        let read = std::io::stdin().take(LONGEST + 1).read_to_string(&mut text);
        return match read {
            Ok(read) if read as u64 > LONGEST => Err(Failure::input(format!(
                "standard input: longer than {} MiB; check parts of it",
                LONGEST >> 20
            ))),
            Ok(_) => Ok(text),
            Err(error) => Err(Failure::input(format!("standard input: {error}"))),
        };
    }
    let read = system::read_text(path, LONGEST);
    read.map_err(|error| {
        Failure::input(format!(
            "{}: {}",
            path.display(),
            system::error_text(&error)
        ))
    })
}

/// Each sentence with its claims, and the counts.
fn words(text: &str, found: &[CheckedSentence], scene: &Scene) -> String {
    let name = output::visible(&scene.scenario.header.benchmark_id);
    if found.is_empty() {
        return format!("no sentence says anything of {name}\n");
    }
    let mut lines = String::new();
    for sentence in found {
        let shown = output::visible(text.get(sentence.span.clone()).unwrap_or_default());
        lines += &format!("{}: {shown}\n", sentence.outcome.name().replace('_', " "));
        for said in &sentence.translated {
            lines += &format!("  » {}\n", output::visible(said));
        }
        for claim in &sentence.claims {
            let sign = match claim.judgement {
                Judgement::Right => "=",
                Judgement::Wrong => "≠",
                Judgement::Unknown(_) => "?",
            };
            lines += &format!("  {sign} {}\n", output::visible(&claim.line()));
        }
        for place in &sentence.invented {
            let claim = &sentence.claims[*place];
            lines += &format!("  ! {} is not in the prompt\n", claim.stated());
        }
    }
    lines + &format!("{name}: {}\n", tally(found))
}
