//! `nearmiss inspect`: prints the contents and the problems of a scenario or solution, of several a row for each, or what
//! differs between two.

mod difference;
mod document;
mod rows;
mod solution;

pub use difference::DifferenceDocument;
pub use document::ScenarioDocument;
pub use solution::SolutionDocument;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_formats::commonroad::{Root, root_of_file};
use nearmiss_formats::{EgoError, Entry, EntryLocation};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{Ego, Scenario, Scene, in_short};
use nearmiss_settings::Folders;
use nearmiss_workflow::{MissingEgo, OpenedScene, Overview, ScenarioRow, Verdicts};

use super::open::{self, EgoChoice, stand_in, user_thresholds};
use super::output::PageFormat;
use super::{Failure, Outcome, output};

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
pub struct Inspect {
    /// Scenarios, recordings, solutions, names of bundled scenarios, or folders; several scenarios print a row each,
    /// most severe first.
    #[arg(required = true, value_name = "PATH")]
    files: Vec<PathBuf>,
    /// Show only matching scenarios: filter terms such as 'ttc < 1.5 tag:urban' or 'severity<=1'; see `nearmiss help
    /// corpora`.
    #[arg(long = "where", value_name = "TERMS")]
    terms: Option<String>,
    /// Show only the N most severe scenarios.
    #[arg(long, value_name = "N")]
    top: Option<NonZeroUsize>,
    /// Compare two scenarios and the moment that matters in each; exit status 1 if they differ.
    #[arg(long, conflicts_with_all = ["terms", "top"])]
    diff: bool,
    /// Output format; for one scenario, `table` prints its page and `json` everything in it [default: from the file
    /// name, else table].
    #[arg(long, value_enum)]
    format: Option<PageFormat>,
    #[command(flatten)]
    output: output::OutputFile,
    #[command(flatten)]
    ego: EgoChoice,
}

impl Inspect {
    /// Whether rows are asked for, and not the page of the only file.
    fn asks_for_rows(&self, format: PageFormat) -> bool {
        let several = self.files.len() > 1 || self.files.iter().any(|file| file.is_dir());
        let selects = self.terms.is_some() || self.top.is_some() || self.output.file().is_some();
        several
            || selects
            || matches!(
                format,
                PageFormat::Csv | PageFormat::Parquet | PageFormat::Arrow
            )
    }

    /// Whether the only file is listed by the scenarios in it, of which no ego is chosen.
    fn is_of_several(&self) -> bool {
        let [file] = self.files.as_slice() else {
            return false;
        };
        let has_parts = || {
            let found = nearmiss_formats::find(&self.files).map(|found| found.entries);
            let whole = EntryLocation::File(file.clone());
            found.is_ok_and(|all| all.iter().any(|entry| entry.place != whole))
        };
        self.ego.is_beside() && file.is_file() && has_parts()
    }
}

/// Runs `inspect`.
pub fn run(arguments: &Inspect) -> Outcome {
    let file = arguments.output.file();
    let format = PageFormat::of(arguments.format, file)?;
    open::check_reading(&arguments.files, file)?;
    if arguments.diff {
        return difference::run(arguments, format);
    }
    if arguments.asks_for_rows(format) || arguments.is_of_several() {
        return match arguments.files.as_slice() {
            _ if arguments.ego.is_beside() => rows::run(arguments, format),
            [folder] if folder.is_dir() => Err(Failure::input(format!(
                "{} is a folder; --ego needs one scenario",
                folder.display()
            ))),
            _ => Err(Failure::input(
                "--ego needs the page of one scenario; leave out the other files, --where, --top and -o",
            )),
        };
    }
    let (file, as_json) = (&arguments.files[0], format == PageFormat::Json);
    let entry = open::entry(file)?;
    if let EntryLocation::File(path) = &entry.place
        && root_of_file(path) == Root::Solution
    {
        if !arguments.ego.is_beside() {
            return Err(Failure::input(format!(
                "{0} is a solution; name its scenario instead, with --ego {0}",
                path.display()
            )));
        }
        return solution::inspect(path, as_json);
    }
    let looked = of_entry(entry, arguments)?;
    let row = looked.ego().map(|_| looked.row()).transpose()?;
    let Looked {
        entry,
        scenario,
        ego,
        ..
    } = &looked;
    if as_json {
        let document = ScenarioDocument::new(entry, scenario, ego, row.as_ref());
        output::document(&document)?;
    } else {
        let moment = row.as_ref().and_then(moment_words);
        output::text(&summary(&looked, moment.as_deref()))?;
    }
    // The scenario is shown all the same.
    looked.ego.map(|_| ()).map_err(open::advised)
}

/// A scenario with its ego, or why it has none.
struct Looked {
    entry: Entry,
    scenario: Arc<Scenario>,
    ego: Result<Option<Ego>, EgoError>,
    /// Why none lies beside it.
    lacks: String,
}

/// The scenario that an argument means.
fn look(file: &Path, arguments: &Inspect) -> Result<Looked, Failure> {
    of_entry(open::entry(file)?, arguments)
}

fn of_entry(entry: Entry, arguments: &Inspect) -> Result<Looked, Failure> {
    let wanted = arguments.ego.wanted(std::slice::from_ref(&entry))?;
    let scenario = entry.read().map_err(Failure::input)?;
    let mut lacks = String::from("no recording found");
    let ego = match wanted.resolve(&entry, &scenario) {
        Ok(None) if arguments.ego.is_beside() => {
            let scene = stand_in().scene(&entry, &scenario);
            if let Err(why) = &scene {
                lacks = format!("{why}{}", open::looked_for(&scenario));
            }
            Ok(scene.ok().map(|scene| scene.ego.clone()))
        }
        ego => ego,
    };
    Ok(Looked {
        entry,
        scenario,
        ego,
        lacks,
    })
}

impl Looked {
    fn ego(&self) -> Option<&Ego> {
        self.ego.as_ref().ok().and_then(Option::as_ref)
    }

    /// The row that it has among several.
    fn row(&self) -> Result<ScenarioRow, Failure> {
        let thresholds = match Folders::find() {
            Ok(folders) => user_thresholds(&folders)?,
            Err(_) => Thresholds::shipped().clone(),
        };
        let scenario = &self.scenario;
        let scene = |ego: &Ego| Arc::new(Scene::new(Arc::clone(scenario), ego.clone()));
        let missing = || match &self.ego {
            Err(error) => MissingEgo::Unusable(error.to_string()),
            Ok(_) => MissingEgo::NotRecorded,
        };
        let opened = OpenedScene {
            scenario: Arc::clone(scenario),
            scene: self.ego().map(scene).ok_or_else(missing),
            stands_in: false,
        };
        Ok(Overview::new(
            &self.entry,
            &opened,
            &thresholds,
            &Verdicts::default(),
            None,
        )
        .row)
    }
}

/// The moment that matters: `1.2 s (step 12), near miss with car 30640 (crossing): crosses 0.4 s apart, 0.1 m`.
fn moment_words(row: &ScenarioRow) -> Option<String> {
    let severity = match row.severity_name? {
        "none" => "nothing severe",
        name => name,
    };
    Some(format!(
        "{:.1} s (step {}), {severity}, with {} ({}): {}",
        row.moment?,
        row.step?,
        row.with.as_deref()?,
        row.manoeuvre?,
        row.what.as_deref()?,
    ))
}

fn summary(looked: &Looked, moment: Option<&str>) -> String {
    let Looked {
        entry,
        scenario,
        ego,
        lacks,
    } = looked;
    let id = match scenario.header.benchmark_id.as_str() {
        "" => "(no benchmark id)",
        id => id,
    };
    let mut text = format!("{id}\n");
    let mut line = |word: &str, said: &str| text.push_str(&format!("  {word:<11} {said}\n"));
    line("file", &entry.display());
    line("hash", &scenario.hash.to_string());
    for (word, said) in scenario.summary() {
        line(word, &said);
    }
    let possible = scenario.possible_egos();
    match ego {
        Ok(Some(ego)) => {
            let (first, last) = (ego.track.steps().start, ego.track.steps().end - 1);
            line(
                "ego",
                &format!("{}, {}, steps {first} to {last}", ego.id, ego.source),
            );
            for (_, doubt) in in_short(&ego.diagnostics) {
                line("", &doubt);
            }
        }
        Ok(None) => line("ego", lacks),
        Err(error) => line("ego", &format!("cannot be read: {error}")),
    }
    if let Some(moment) = moment {
        line("moment", moment);
    }
    if possible.is_empty() {
        line("as ego", "no obstacle has a trajectory");
    } else {
        let ids: Vec<String> = possible.iter().map(i64::to_string).collect();
        line(
            "as ego",
            &format!("--ego takes obstacle {}", ids.join(", ")),
        );
    }
    text.push_str(&document::summary(scenario));
    if scenario.diagnostics.is_empty() {
        text.push_str("  diagnostics none\n");
    }
    for (_, diagnostic) in in_short(&scenario.diagnostics) {
        text.push_str(&format!("  {diagnostic}\n"));
    }
    output::visible(&text)
}
