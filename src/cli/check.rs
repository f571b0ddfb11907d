//! `nearmiss check`: the sentences of a text about a scenario, each held against the scene.

use std::io::Read;
use std::path::{Path, PathBuf};

use nearmiss_base::system;
use nearmiss_scene::scenario::Scene;
use nearmiss_study::evaluation::claims::{
    CheckedSentence, Judgement, SentenceOutcome, SentenceRecord, Subject, TimeOrigin, sentences,
};

use super::open::{EgoChoice, entry, scene_and_doubts, thresholds_in_use};
use super::output::{self, FormatOption};
use super::span::{AT, At, history};
use super::{Failure, Outcome};

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct Check {
    /// A scenario file, or the name of a bundled scenario.
    scenario: PathBuf,
    /// The text: a file, or - for standard input.
    #[arg(long, value_name = "FILE")]
    text: PathBuf,
    #[command(flatten)]
    ego: EgoChoice,
    /// The present of the text: a time step (32), seconds (3.2s) or worst [default: the last step].
    #[arg(long, value_name = AT, allow_negative_numbers = true)]
    at: Option<At>,
    /// Steps until then that the text was told of.
    #[arg(long, value_name = "N", default_value = "10", value_parser = history)]
    history: u32,
    /// Times in the text count from its present: "0.5 s ago", "at -0.5 s".
    #[arg(long)]
    relative: bool,
    #[command(flatten)]
    format: FormatOption,
}

/// Runs `check`.
pub fn run(arguments: &Check) -> Outcome {
    let entry = entry(&arguments.scenario)?;
    let ego = arguments.ego.wanted(std::slice::from_ref(&entry))?;
    let (scene, doubts) = scene_and_doubts(&entry, &ego)?;
    doubts.iter().for_each(|said| output::say(said));
    let text = text(&arguments.text)?;
    let span = nearmiss_workflow::span::Span {
        at: arguments.at,
        history: Some(arguments.history as usize),
        obstacle: None,
    };
    let window = span
        .window(
            &scene,
            &thresholds_in_use()?,
            None,
            arguments.history as usize,
        )
        .map_err(|why| Failure::input(format!("{}: {why}", entry.display())))?;
    let subject = Subject {
        scene: &scene,
        times: if arguments.relative {
            TimeOrigin::WindowEnd
        } else {
            TimeOrigin::Recording
        },
        window: Some((window.first(), window.last())),
    };
    let found = sentences(&text, &subject);
    if arguments.format.is_json() {
        return { found.iter() }
            .map(|sentence| SentenceRecord::new(&text, sentence, scene.ego.id))
            .try_for_each(|record| output::json(&record));
    }
    output::text(&words(&text, &found, &scene))
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
    let mut lines = String::new();
    for sentence in found {
        let shown = output::visible(text.get(sentence.span.clone()).unwrap_or_default());
        lines += &format!("{}: {shown}\n", sentence.outcome.name().replace('_', " "));
        for claim in &sentence.claims {
            let sign = match claim.judgement {
                Judgement::Right => "=",
                Judgement::Wrong => "≠",
                Judgement::Unknown(_) => "?",
            };
            lines += &format!("  {sign} {}\n", output::visible(&claim.line()));
        }
    }
    let count =
        |outcome: SentenceOutcome| found.iter().filter(|one| one.outcome == outcome).count();
    let counts = SentenceOutcome::ALL
        .iter()
        .map(|outcome| format!("{} {}", outcome.name().replace('_', " "), count(*outcome)));
    let counts: Vec<String> = counts.collect();
    let named = output::counted(found.len(), "sentence");
    lines
        + &format!(
            "{named} about {}: {}\n",
            output::visible(&scene.scenario.header.benchmark_id),
            counts.join(", ")
        )
}
