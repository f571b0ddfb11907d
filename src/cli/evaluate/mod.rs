//! `nearmiss evaluate`: how good the built-in judge is on many scenarios, and how long before a collision.

mod collision;
mod safety;

use std::path::PathBuf;

use rayon::prelude::*;

use super::open::{EgoChoice, found, scene, task};
use super::progress::Progress;
use super::{Failure, Outcome, output};
use crate::evaluation::{Candidate, Label, Labelled, Labels, Lead};
use crate::judge;
use crate::scenario::Entry;
use crate::system;
use crate::verdict::Task;

/// Arguments of `evaluate`.
#[derive(Debug, clap::Args)]
pub struct Evaluate {
    /// CommonRoad files or folders, or names of bundled scenarios; each with its recorded ego.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Who is evaluated, separated by commas: reference/geometry and, in the safety task, what it is compared with,
    /// reference/constant-velocity and reference/constant-acceleration [default: all that answer the task].
    #[arg(long, value_delimiter = ',', value_name = "MODEL")]
    model: Vec<String>,
    /// What is asked: safety or collision.
    #[arg(long, default_value = "safety", value_parser = task)]
    task: Task,
    /// What is true: `auto` for the exact geometry of the whole recordings, or CSV files with the columns `scenario`
    /// and `label` (or `obstacle_id`, `none` where nobody collides), separated by commas.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "auto",
        value_name = "CSV|auto"
    )]
    truth: Vec<PathBuf>,
    /// Where the windows of collisions end: seconds before the first overlap of the bodies, or `paper` for two steps
    /// before the last recorded one. Safe scenarios always have their first window.
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "paper,0.2,0.5,1,1.5,2",
        value_name = "S"
    )]
    lead: Vec<Lead>,
    /// Horizons of what the judge is compared with, seconds up to 10; its own is fixed.
    #[arg(long, value_delimiter = ',', default_value = "1,1.5,2", value_name = "S", value_parser = horizon)]
    horizon: Vec<f64>,
    /// Steps in a window.
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    history: u32,
    /// In the safety task, obstacles farther from the ego are left out, metres.
    #[arg(long, default_value_t = 30.0, value_name = "M", value_parser = radius)]
    radius: f64,
    /// How the result is written.
    #[arg(long, value_enum, default_value = "table")]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    Table,
    Csv,
    Json,
}

fn between(text: &str, most: f64) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= most => Ok(value),
        _ => Err(format!("a number above 0 and up to {most} is needed")),
    }
}

fn horizon(text: &str) -> Result<f64, String> {
    between(text, 10.0)
}

fn radius(text: &str) -> Result<f64, String> {
    between(text, 1e6)
}

/// What is true about the scenarios.
enum Truth {
    Geometry,
    Labels(Labels, Vec<String>),
}

/// A scenario that was judged.
struct Judged<T> {
    name: String,
    label: Label,
    result: T,
}

/// All scenarios that were judged, in the order of the paths, and how many were not.
struct Batch<T> {
    judged: Vec<Judged<T>>,
    failed: usize,
    unlabelled: Vec<String>,
}

/// Runs `evaluate`.
pub fn run(arguments: &Evaluate) -> Outcome {
    let candidates = candidates(arguments)?;
    let truth = truth(&arguments.truth)?;
    let entries = found(&arguments.paths)?;
    match arguments.task {
        Task::Safety => safety::run(arguments, candidates, &truth, &entries),
        Task::Collision => collision::run(arguments, &truth, &entries),
    }
}

fn candidates(arguments: &Evaluate) -> Result<Vec<Candidate>, Failure> {
    let safety = arguments.task == Task::Safety;
    let names: Vec<&str> = match (arguments.model.is_empty(), safety) {
        (false, _) => arguments.model.iter().map(String::as_str).collect(),
        (true, true) => Candidate::NAMES.to_vec(),
        (true, false) => vec![judge::MODEL],
    };
    let mut found: Vec<Candidate> = Vec::new();
    for name in names {
        let known = if safety {
            &Candidate::NAMES[..]
        } else {
            &[judge::MODEL]
        };
        let more = Candidate::named(name, &arguments.horizon).filter(|_| known.contains(&name));
        let Some(more) = more else {
            let advice = if name.starts_with("reference/") {
                String::new()
            } else {
                "; language models are not evaluated by this command, `nearmiss ask` asks one about one scenario".into()
            };
            return Err(Failure::input(format!(
                "--model {name}: for the {} task it must be one of {}{advice}",
                arguments.task.name(),
                known.join(", "),
            )));
        };
        for candidate in more {
            if !found.contains(&candidate) {
                found.push(candidate);
            }
        }
    }
    Ok(found)
}

fn truth(paths: &[PathBuf]) -> Result<Truth, Failure> {
    if let [only] = paths
        && only.as_os_str() == "auto"
    {
        return Ok(Truth::Geometry);
    }
    let (mut labels, mut files) = (Labels::default(), Vec::new());
    for path in paths {
        let file = path.display().to_string();
        let bytes = system::read_file(path, system::LARGEST).map_err(|e| {
            Failure::input(format!(
                "--truth {file}: {}; it takes CSV files, or `auto` alone for the exact geometry",
                system::words(&e)
            ))
        })?;
        labels.read(&bytes, &file).map_err(Failure::input)?;
        files.push(output::visible(&file));
    }
    Ok(Truth::Labels(labels, files))
}

impl Truth {
    /// What is true, in words for people.
    fn words(&self) -> String {
        match self {
            Self::Geometry => {
                "exact geometry of the whole recordings: real bodies that overlap at a recorded step".into()
            }
            Self::Labels(_, files) => format!("labels of {}", files.join(", ")),
        }
    }

    fn json(&self) -> serde_json::Value {
        match self {
            Self::Geometry => "geometry".into(),
            Self::Labels(_, files) => files.clone().into(),
        }
    }
}

/// Judges every scenario with `ask`; what cannot be opened or has no label is said and counted.
fn batch<T: Send>(
    truth: &Truth,
    entries: &[Entry],
    ask: impl Fn(&Labelled<'_>) -> T + Sync,
) -> Batch<T> {
    let mut batch = Batch {
        judged: Vec::new(),
        failed: 0,
        unlabelled: Vec::new(),
    };
    let progress = Progress::new(entries.len(), "scenarios", true);
    // A part at a time keeps all cores busy and the memory bounded.
    for part in entries.chunks(64) {
        let judge_one = |entry: &Entry| {
            let result = one(truth, entry, &ask);
            progress.step();
            result
        };
        let results: Vec<_> = part.par_iter().map(judge_one).collect();
        for (entry, result) in part.iter().zip(results) {
            match result {
                Ok(Some((judged, doubt))) => {
                    if let Some(doubt) = doubt {
                        progress.suspend(|| output::say(&doubt));
                    }
                    batch.judged.push(judged);
                }
                Ok(None) => batch.unlabelled.push(entry.name.clone()),
                Err(failure) => {
                    batch.failed += 1;
                    progress.suspend(|| failure.say());
                }
            }
        }
    }
    batch
}

type One<T> = Option<(Judged<T>, Option<String>)>;

fn one<T>(
    truth: &Truth,
    entry: &Entry,
    ask: impl Fn(&Labelled<'_>) -> T,
) -> Result<One<T>, Failure> {
    let label = match truth {
        Truth::Geometry => None,
        Truth::Labels(labels, _) => match labels.of(&entry.name) {
            None => return Ok(None),
            label => label,
        },
    };
    let scene = scene(entry, &EgoChoice::default())?;
    let case = Labelled::new(&scene, label);
    let doubt = match (case.label, case.contact) {
        (Label::Collision(_), None) => Some(
            "labelled a collision, but no bodies overlap; the last recorded step stands for the collision",
        ),
        (Label::Safe, Some(_)) => Some("labelled safe, but bodies overlap"),
        _ => None,
    };
    let judged = Judged {
        name: entry.name.clone(),
        label: case.label,
        result: ask(&case),
    };
    let doubt = doubt.map(|words| format!("nearmiss: {}: {words}", entry.name));
    Ok(Some((judged, doubt)))
}

impl<T> Batch<T> {
    fn collisions(&self) -> usize {
        self.judged.iter().filter(|j| j.label.collides()).count()
    }

    fn safe(&self) -> usize {
        self.judged.len() - self.collisions()
    }

    /// How it ends, when everything is written.
    fn outcome(&self) -> Outcome {
        if self.failed + self.unlabelled.len() == 0 {
            return Ok(());
        }
        let all = self.judged.len() + self.failed + self.unlabelled.len();
        let mut reasons = Vec::new();
        if self.failed > 0 {
            reasons.push(format!("{} could not be opened", self.failed));
        }
        if let Some(first) = self.unlabelled.first() {
            let n = self.unlabelled.len();
            reasons.push(format!(
                "{n} have no label ({first}{})",
                if n > 1 { ", …" } else { "" }
            ));
        }
        Err(Failure {
            message: format!("of {all} scenarios, {}", reasons.join(", and ")),
            status: if self.judged.is_empty() { 2 } else { 1 },
        })
    }
}

/// With two decimals, or a dash where there is no value.
fn share(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), |v| format!("{v:.3}"))
}

/// One line of CSV for a row of cells.
fn csv(rows: &[Vec<String>]) -> Result<String, Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.write_record(row).map_err(Failure::input)?;
    }
    let bytes = writer.into_inner().map_err(|e| Failure::input(e.error()))?;
    String::from_utf8(bytes).map_err(Failure::input)
}
