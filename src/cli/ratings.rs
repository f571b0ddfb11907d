//! `nearmiss runs ratings`: people's ratings of answers side by side, summed up or as a file.

use super::filters::store_to_read;
use super::output::{
    self, Align, Cell, Column, Encoded, Kind, OutputFile, Row, Table, TableWriter,
};
use super::{Failure, Outcome, time};
use nearmiss_store::{Choice, Rating};
use nearmiss_study::evaluation::{RaterAgreement, Standing, Standings, StandingsBy};

/// Arguments of `ratings`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Ratings {
    #[command(subcommand)]
    what: Option<RatingsCommand>,
    /// Compare models or prompts.
    #[arg(long, value_enum, default_value = "model")]
    by: RatingsQuery,
    #[command(flatten)]
    format: output::FormatOption,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum RatingsQuery {
    /// Models.
    Model,
    /// Prompts: frame, techniques, and the version of the template.
    Prompt,
}

#[derive(Debug, clap::Subcommand)]
enum RatingsCommand {
    /// How far persons who rated the same answers agree: Cohen's and Fleiss' kappa.
    Agreement {
        #[command(flatten)]
        format: output::FormatOption,
    },
    /// Export every rating.
    Export(Export),
}

#[derive(Debug, clap::Args)]
struct Export {
    /// Format [default: from the file name, else json].
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
    /// CSV with a header, one row an answer; control characters become symbols.
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
        standings.rows.iter().try_for_each(output::document)?;
    } else if !ratings.is_empty() {
        output::text(&output::visible(&table(&standings)))?;
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

fn table(standings: &Standings) -> String {
    let wide = standings.rows.iter().map(|r| r.name.chars().count()).max();
    let mut columns = [Align::Right(5); 8];
    columns[0] = Align::Left(wide.unwrap_or(0).max(6) + 1);
    columns[5] = Align::Right(6);
    columns[7] = Align::Left(0);
    let line = |cells: [&str; 8]| output::line(" ", &columns, &cells);
    let mut text = line([
        "",
        "shown",
        "games",
        "wins",
        "ties",
        "losses",
        "wrong",
        " strength (95 %)",
    ]);
    for row in &standings.rows {
        let counts = [
            row.shown, row.games, row.wins, row.ties, row.losses, row.wrong,
        ];
        let [shown, games, wins, ties, losses, wrong] = counts.map(|n| n.to_string());
        let strength = format!(" {}", strength(row));
        text += &line([
            &row.name, &shown, &games, &wins, &ties, &losses, &wrong, &strength,
        ]);
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
    let columns = COLUMNS.map(|(name, kind)| Column::new(name, kind, "", ""));
    let table = Table::new("ratings", columns.into());
    let all = match format {
        output::Format::Json => {
            let lines = ratings.iter().map(|r| output::json_line(&r.to_record()));
            Encoded::Text(lines.collect::<Result<String, _>>()?.into_bytes())
        }
        _ => table.encode(format, ratings.iter().flat_map(rows).collect()),
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

/// The columns of the table, a row an answer.
const COLUMNS: [(&str, Kind); 16] = [
    ("rating", Kind::Integer),
    ("created_ms", Kind::Integer),
    ("day", Kind::Text),
    ("person", Kind::Text),
    ("scenario", Kind::Text),
    ("task", Kind::Text),
    ("blind", Kind::Truth),
    ("seed", Kind::Integer),
    ("choice", Kind::Text),
    ("notes", Kind::Text),
    ("place", Kind::Integer),
    ("run", Kind::Integer),
    ("model", Kind::Text),
    ("prompt", Kind::Text),
    ("best", Kind::Truth),
    ("wrong_because", Kind::Text),
];

fn rows(rating: &Rating) -> impl Iterator<Item = Row> {
    let answers = rating.answers.iter().enumerate();
    answers.map(|(place, answer)| {
        let reason = answer.reason.as_deref().unwrap_or("wrong");
        vec![
            Cell::Integer(rating.id),
            Cell::Integer(rating.created_ms),
            time::local(rating.created_ms).into(),
            rating.person.clone().into(),
            rating.scenario.clone().into(),
            rating.task.name().into(),
            Cell::Truth(rating.blind),
            Cell::Integer(rating.seed),
            rating.choice.word().into(),
            rating.notes.clone().into(),
            Cell::Integer(place as i64),
            answer
                .run
                .map_or(Cell::None(""), |run| Cell::Integer(run.0)),
            answer.model.clone().into(),
            answer.prompt.clone().into(),
            Cell::Truth(rating.choice == Choice::Best(place)),
            if answer.wrong {
                reason.to_string().into()
            } else {
                Cell::None("")
            },
        ]
    })
}
