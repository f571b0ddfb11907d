//! `nearmiss ratings`: people's ratings of answers side by side, summed up or as a file.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::json;

use super::filters::store_to_read;
use super::metrics::{Target, file_of, no_format};
use super::output::of_csv;
use super::{Failure, Outcome, output, time};
use crate::evaluation::{Standing, Standings, StandingsBy};
use crate::store::{Choice, Rating};

/// Arguments of `ratings`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Ratings {
    #[command(subcommand)]
    what: Option<RatingsCommand>,
    /// Whose standing: that of models, or of ways of asking.
    #[arg(long, value_enum, default_value = "model")]
    by: RatingsQuery,
    /// One JSON object a line.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum RatingsQuery {
    /// Models.
    Model,
    /// Ways of asking: frame and techniques.
    Prompt,
}

#[derive(Debug, clap::Subcommand)]
enum RatingsCommand {
    /// Every rating, as a file or on standard output.
    Export(Export),
}

#[derive(Debug, clap::Args)]
struct Export {
    /// How they are written [default: as the ending of FILE says, else jsonl].
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// A file to write to, instead of standard output, which is - too.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace the file if it is there already.
    #[arg(long, requires = "output")]
    overwrite: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// One JSON object a line, a rating each.
    Jsonl,
    /// Comma-separated, with a header, a row an answer; control characters are shown as symbols.
    Csv,
}

/// Runs `ratings`.
pub fn run(arguments: &Ratings) -> Outcome {
    match &arguments.what {
        Some(RatingsCommand::Export(wanted)) => export(wanted),
        None => summary(arguments),
    }
}

fn ratings() -> Result<Vec<Rating>, Failure> {
    store_to_read()?.ratings().map_err(Failure::input)
}

fn summary(arguments: &Ratings) -> Outcome {
    let ratings = ratings()?;
    let by = match arguments.by {
        RatingsQuery::Model => StandingsBy::Model,
        RatingsQuery::Prompt => StandingsBy::Prompt,
    };
    let standings = Standings::from_ratings(&ratings, by);
    if arguments.json {
        standings.rows.iter().try_for_each(output::json)?;
    } else if !ratings.is_empty() {
        output::text(&output::visible(&table(&standings)))?;
    }
    match (&standings.without, ratings.is_empty()) {
        (_, true) => output::say("there are no ratings; B in the workbench makes some"),
        (Some(why), _) => output::say(&format!("no strengths: {why}")),
        (None, _) => {}
    }
    Ok(())
}

fn table(standings: &Standings) -> String {
    let wide = standings.rows.iter().map(|r| r.name.chars().count()).max();
    let wide = wide.unwrap_or(0).max(6);
    let mut text = format!(
        "{:wide$}  {:>5} {:>5} {:>5} {:>5} {:>6} {:>5}  strength (95 %)\n",
        "", "shown", "games", "wins", "ties", "losses", "wrong"
    );
    for row in &standings.rows {
        text.push_str(&format!(
            "{:wide$}  {:>5} {:>5} {:>5} {:>5} {:>6} {:>5}  {}\n",
            row.name,
            row.shown,
            row.games,
            row.wins,
            row.ties,
            row.losses,
            row.wrong,
            strength(row)
        ));
    }
    text
}

fn strength(row: &Standing) -> String {
    match (row.strength, row.low, row.high) {
        (Some(strength), Some(low), Some(high)) => {
            format!("{strength:+.2} ({low:+.2} to {high:+.2})")
        }
        _ => "-".into(),
    }
}

fn export(wanted: &Export) -> Outcome {
    let file = file_of(wanted.output.as_deref());
    let format = match (wanted.format, file) {
        (Some(format), _) => format,
        (None, None) => Format::Jsonl,
        (None, Some(file)) => {
            of_name(file).ok_or_else(|| no_format(file, ".jsonl, .ndjson, .json and .csv"))?
        }
    };
    let ratings = ratings()?;
    let target = Target::begin(file, wanted.overwrite)?;
    let written = match format {
        Format::Jsonl => lines(target, &ratings),
        Format::Csv => rows(target, &ratings),
    };
    match (written, file) {
        (Ok(target), _) => target.finish()?,
        // The reader of the pipe has seen enough.
        (Err(error), None) if error.kind() == io::ErrorKind::BrokenPipe => {}
        (Err(error), None) => return Err(Failure::system("standard output", &error)),
        (Err(error), Some(path)) => {
            return Err(Failure::system(path.display(), &error));
        }
    }
    if file.is_some() {
        output::say(&format!("{} ratings exported", ratings.len()));
    }
    Ok(())
}

fn of_name(file: &Path) -> Option<Format> {
    match file.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "jsonl" | "ndjson" | "json" => Some(Format::Jsonl),
        "csv" => Some(Format::Csv),
        _ => None,
    }
}

fn lines(mut target: Target, ratings: &[Rating]) -> io::Result<Target> {
    for rating in ratings {
        let line = output::escaped(&rating.to_record().to_string());
        target.write_all(line.as_bytes())?;
        target.write_all(b"\n")?;
    }
    target.flush()?;
    Ok(target)
}

/// The columns of the table, a row an answer.
const COLUMNS: [&str; 16] = [
    "rating",
    "created_ms",
    "day",
    "person",
    "scenario",
    "task",
    "blind",
    "seed",
    "choice",
    "notes",
    "place",
    "run",
    "model",
    "prompt",
    "best",
    "wrong_because",
];

fn rows(target: Target, ratings: &[Rating]) -> io::Result<Target> {
    let mut writer = csv::Writer::from_writer(target);
    writer.write_record(COLUMNS).map_err(of_csv)?;
    for rating in ratings {
        for (place, answer) in rating.answers.iter().enumerate() {
            let reason = answer.reason.as_deref().unwrap_or("wrong");
            let cells = [
                rating.id.to_string(),
                rating.created_ms.to_string(),
                time::local(rating.created_ms),
                rating.person.clone(),
                rating.scenario.clone(),
                rating.task.name().to_string(),
                json!(rating.blind).to_string(),
                rating.seed.to_string(),
                rating.choice.word().to_string(),
                rating.notes.clone(),
                place.to_string(),
                answer.run.map_or(String::new(), |run| run.to_string()),
                answer.model.clone(),
                answer.prompt.clone(),
                json!(rating.choice == Choice::Best(place)).to_string(),
                if answer.wrong {
                    reason.to_string()
                } else {
                    String::new()
                },
            ];
            let cells = cells.map(|cell| output::visible(&cell));
            writer.write_record(cells).map_err(of_csv)?;
        }
    }
    writer.flush()?;
    writer.into_inner().map_err(csv::IntoInnerError::into_error)
}
