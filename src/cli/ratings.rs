//! `nearmiss runs ratings`: people's ratings of answers side by side, summed up or as a file.

use schemars::JsonSchema;
use serde::Serialize;

use super::filters::store_to_read;
use super::output::{self, Encoded, OutputFile, Table, TableWriter};
use super::{Failure, Outcome};
use nearmiss_record::{columns, row_of, rows, text_table};
use nearmiss_store::{Choice, Rating, RunId};
use nearmiss_study::evaluation::{RaterAgreement, Standing, Standings, StandingsBy};

/// Arguments of `ratings`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Ratings {
    #[command(subcommand)]
    what: Option<RatingsCommand>,
    /// What to compare.
    #[arg(long, value_enum, default_value = "model")]
    by: RatingsQuery,
    #[command(flatten)]
    format: output::FormatOption,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum RatingsQuery {
    /// Models.
    Model,
    /// Prompts: frame, techniques and template version.
    Prompt,
}

#[derive(Debug, clap::Subcommand)]
enum RatingsCommand {
    /// Report inter-rater agreement on the same answers: Cohen's and Fleiss' kappa.
    Agreement {
        #[command(flatten)]
        format: output::FormatOption,
    },
    /// Export every rating.
    Export(Export),
}

#[derive(Debug, clap::Args)]
struct Export {
    /// Output format [default: from the file name, else json].
    #[arg(long, value_enum)]
    format: Option<Format>,
    #[command(flatten)]
    output: OutputFile,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// JSON lines: one object per rating.
    #[value(alias = "jsonl")]
    Json,
    /// CSV with a header: one row per answer; control characters become symbols.
    Csv,
}

/// Runs `ratings`.
pub fn run(arguments: &Ratings) -> Outcome {
    match &arguments.what {
        Some(RatingsCommand::Agreement { format }) => agreement(*format),
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
    if arguments.format.is_json() {
        standings.rows.iter().try_for_each(output::json)?;
    } else if !ratings.is_empty() {
        let rows = rows(&standings.rows).map_err(Failure::input)?;
        output::text(&text_table(&columns::<Standing>(), &rows))?;
    }
    match (&standings.without, ratings.is_empty()) {
        (_, true) => output::say("no ratings yet; rate answers in the blind mode of the workbench"),
        (Some(why), _) => output::say(&format!("no strengths: {why}")),
        (None, _) => {}
    }
    Ok(())
}

fn agreement(format: output::FormatOption) -> Outcome {
    let found = RaterAgreement::from_ratings(&ratings()?);
    if format.is_json() {
        return output::json(&found);
    }
    let kappa = |kappa: Option<f64>| kappa.map_or_else(|| "-".into(), |k| format!("{k:.2}"));
    let mut text = String::new();
    for pair in &found.pairs {
        text += &format!(
            "{} and {}: {} rated by both, {:.0} % alike, Cohen's kappa {}\n",
            pair.first,
            pair.second,
            pair.n,
            100.0 * pair.agreement,
            kappa(pair.kappa)
        );
    }
    if found.pairs.len() > 1 {
        text += &format!(
            "all: {} rated by several, Fleiss' kappa {}\n",
            found.n,
            kappa(found.kappa)
        );
    }
    if found.pairs.is_empty() {
        output::say("no answers were rated by several persons");
    }
    output::text(&output::visible(&text))
}

/// What the endings of names ask for.
const ENDINGS: &[(&str, Format)] = &[
    ("jsonl", Format::Json),
    ("ndjson", Format::Json),
    ("json", Format::Json),
    ("csv", Format::Csv),
];

fn export(wanted: &Export) -> Outcome {
    let file = wanted.output.file();
    let known = ".jsonl, .ndjson, .json and .csv";
    let format = match output::format_of(wanted.format, file, Format::Json, (ENDINGS, known))? {
        Format::Json => output::Format::Json,
        Format::Csv => output::Format::Csv,
    };
    let ratings = ratings()?;
    let target = wanted.output.begin()?;
    let table = Table::new("ratings", columns::<RatingRow<'_>>());
    let all = match format {
        output::Format::Json => {
            let lines = ratings.iter().map(|r| output::json_line(&r.to_record()));
            Encoded::Text(lines.collect::<Result<String, _>>()?.into_bytes())
        }
        _ => {
            let answers = ratings.iter().flat_map(RatingRow::all);
            let rows: Result<_, _> = answers.map(|one| row_of(&table.columns, &one)).collect();
            table.encode(format, rows.map_err(Failure::input)?)
        }
    };
    let done = TableWriter::begin(target, format, &table).and_then(|mut writer| {
        writer.write(all)?;
        writer.finish()
    });
    if let Some(target) = output::written(file, done)? {
        target.finish()?;
    }
    if file.is_some() {
        output::say(&format!("{} ratings exported", ratings.len()));
    }
    Ok(())
}

/// An answer in a rating: a row of the table.
#[derive(Serialize, JsonSchema)]
struct RatingRow<'r> {
    rating: i64,
    created_ms: i64,
    day: String,
    person: &'r str,
    scenario: &'r str,
    task: &'static str,
    blind: bool,
    seed: i64,
    choice: &'static str,
    notes: &'r str,
    place: usize,
    run: Option<RunId>,
    model: &'r str,
    prompt: &'r str,
    best: bool,
    wrong_because: Option<&'r str>,
}

impl<'r> RatingRow<'r> {
    fn all(rating: &'r Rating) -> impl Iterator<Item = Self> {
        let answers = rating.answers.iter().enumerate();
        answers.map(|(place, answer)| Self {
            rating: rating.id,
            created_ms: rating.created_ms,
            day: output::local(rating.created_ms),
            person: &rating.person,
            scenario: &rating.scenario,
            task: rating.task.name(),
            blind: rating.blind,
            seed: rating.seed,
            choice: rating.choice.word(),
            notes: &rating.notes,
            place,
            run: answer.run,
            model: &answer.model,
            prompt: &answer.prompt,
            best: rating.choice == Choice::Best(place),
            wrong_because: answer
                .wrong
                .then(|| answer.reason.as_deref().unwrap_or("wrong")),
        })
    }
}
