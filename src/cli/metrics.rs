//! `nearmiss metrics`: every measure of every obstacle at every step, as a table.

use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::open::{EgoChoice, scene};
use super::{Failure, Outcome, output};
use crate::metrics::{Context, MEASURES, Reading};
use crate::scenario::{Scene, find};

/// Arguments of `metrics`.
#[derive(Debug, clap::Args)]
pub struct Metrics {
    /// CommonRoad files or folders, or names of bundled scenarios.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    #[command(flatten)]
    ego: EgoChoice,
    /// How the table is written. JSON is one object a line.
    #[arg(long, value_enum, default_value = "csv")]
    format: Format,
    /// A file to write to, instead of standard output; it must not exist yet.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Format {
    Csv,
    Json,
}

/// Runs `metrics`.
pub fn run(arguments: &Metrics) -> Outcome {
    let entries = find(&arguments.paths).map_err(Failure::input)?;
    let out: Box<dyn Write> = match &arguments.output {
        None => Box::new(io::stdout().lock()),
        Some(path) => Box::new(std::fs::File::create_new(path).map_err(|e| {
            let advice = match e.kind() {
                io::ErrorKind::AlreadyExists => "; choose another name or remove it first",
                io::ErrorKind::NotFound => "; its folder does not exist",
                _ => "",
            };
            Failure::input(format!("{}: {e}{advice}", path.display()))
        })?),
    };
    let mut table = Table {
        out: BufWriter::new(out),
        format: arguments.format,
    };
    let mut failed = 0;
    let written = table.head().and_then(|()| {
        // A batch at a time keeps all cores busy and the memory bounded.
        for batch in entries.chunks(64) {
            let tables: Vec<_> = batch
                .par_iter()
                .map(|entry| {
                    scene(entry, &arguments.ego).map(|s| rows(&entry.name, &s, arguments.format))
                })
                .collect();
            for rows in tables {
                match rows {
                    Ok(rows) => table.out.write_all(rows.as_bytes())?,
                    Err(failure) => {
                        failed += 1;
                        failure.say();
                    }
                }
            }
        }
        table.out.flush()
    });
    match written {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::input(error)),
        _ if failed == entries.len() => Err(Failure::input("no scenario could be measured")),
        _ if failed > 0 => Err(Failure {
            message: format!(
                "{failed} of {} scenarios could not be measured",
                entries.len()
            ),
            status: 1,
        }),
        _ => Ok(()),
    }
}

struct Table<W: Write> {
    out: BufWriter<W>,
    format: Format,
}

impl<W: Write> Table<W> {
    fn head(&mut self) -> io::Result<()> {
        match self.format {
            Format::Json => Ok(()),
            Format::Csv => {
                let ids: Vec<&str> = MEASURES.iter().map(|m| m.id).collect();
                writeln!(
                    self.out,
                    "scenario,timestep,time,obstacle_id,relative_direction,{}",
                    ids.join(",")
                )
            }
        }
    }
}

/// The rows of one scene; an empty cell (CSV) or a reason (JSON) stands where there is no value.
fn rows(name: &str, scene: &Scene, format: Format) -> String {
    let name = output::visible(name);
    let mut text = String::new();
    let mut writer = csv::Writer::from_writer(Vec::new());
    let context = Context::new(scene);
    for step in scene.steps() {
        for (place, participant) in context.participants().iter().enumerate() {
            let Some(encounter) = context.encounter(place, step) else {
                continue;
            };
            let readings = MEASURES.iter().map(|m| (m.id, (m.compute)(&encounter)));
            let direction = encounter.relation().direction.name();
            let time = (scene.time_of(step) * 1e6).round() / 1e6;
            match format {
                Format::Json => {
                    let mut row = Map::new();
                    row.insert("scenario".into(), json!(name));
                    row.insert("timestep".into(), json!(step));
                    row.insert("time".into(), json!(time));
                    row.insert("obstacle_id".into(), json!(participant.obstacle.id));
                    row.insert("relative_direction".into(), json!(direction));
                    for (id, reading) in readings {
                        row.insert(id.into(), cell(reading));
                    }
                    text.push_str(&Value::Object(row).to_string());
                    text.push('\n');
                }
                Format::Csv => {
                    let mut row = vec![
                        name.to_string(),
                        step.to_string(),
                        time.to_string(),
                        participant.obstacle.id.to_string(),
                        direction.to_string(),
                    ];
                    row.extend(readings.map(|(_, r)| r.value().map_or(String::new(), number)));
                    // Writing to memory does not fail.
                    let _ = writer.write_record(&row);
                }
            }
        }
    }
    if let Ok(bytes) = writer.into_inner() {
        text.push_str(&String::from_utf8_lossy(&bytes));
    }
    text
}

fn cell(reading: Reading) -> Value {
    match reading {
        Reading::Value(value) => json!(rounded(value)),
        Reading::None(why) => json!({ "none": why.reason() }),
    }
}

/// Micrometres and microseconds are beyond what the files carry.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6 + 0.0
}

fn number(value: f64) -> String {
    rounded(value).to_string()
}
