//! `nearmiss corpus find`: windows of an index that fit terms, which a model writes of a sentence. They are shown before they are used.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use schemars::JsonSchema;
use serde::Serialize;

use super::ask::text_model;
use super::ending::interrupted;
use super::evaluate::runtime;
use super::open::{configuration, user_thresholds};
use super::output::Target;
use super::{Failure, Outcome, ending, json, output};
use nearmiss_drive::planner::Cancel;
use nearmiss_scene::judge;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::{Config, Folders};
use nearmiss_store::Store;
use nearmiss_workflow::{
    FilterRequest, FoundWindow, FoundWindows, IndexSearch, checked_filter, search_index,
    write_filter,
};

/// The most tokens of an answer, reasoning included, where the configuration sets no limit.
const TOKENS: u32 = 4096;

/// Arguments of `find`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
`nearmiss help corpora` lists the terms.\n\
Exit status: 0 windows found; 1 none found; 2 usage or input error, or the model wrote no terms.")]
pub struct Find {
    /// Terms that a window must match: "manoeuvre:cut_in ttc<1.5 road:highway"; with --model a sentence: "cut-ins under
    /// 1.5 s TTC on motorways".
    #[arg(required = true)]
    terms: Vec<String>,
    /// Model that translates the sentence into terms, as provider/model. The terms are printed before the search.
    #[arg(long)]
    model: Option<String>,
    /// Index folder; see `nearmiss corpus index` [default: `index` in config.toml].
    #[arg(long, value_name = "FOLDER")]
    index: Option<PathBuf>,
    /// Print the terms without searching.
    #[arg(long, conflicts_with = "number")]
    filter_only: bool,
    /// Number of windows to print, most severe first, then in index order; all matches are counted.
    #[arg(short, long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    number: u32,
    #[command(flatten)]
    format: output::FormatOption,
    #[command(flatten)]
    output: output::OutputFile,
}

/// What was found, for programs.
#[derive(Debug, Serialize, JsonSchema)]
pub struct FindDocument {
    /// The sentence; null where terms were given.
    sentence: Option<String>,
    /// Model that wrote its terms, as provider/model.
    model: Option<String>,
    /// The terms.
    filter: String,
    /// Parts of the sentence that have no term, as the model says.
    left_out: Option<String>,
    /// Windows in the index; null where nothing was searched.
    searched: Option<u64>,
    /// Windows that were found.
    windows: Option<u64>,
    /// Scenarios that they are in.
    scenarios: Option<usize>,
    /// The most severe of them.
    found: Vec<FindWindow>,
}

/// A window that was found.
#[derive(Debug, Serialize, JsonSchema)]
struct FindWindow {
    scenario: String,
    file: String,
    /// Source of the ego: recorded or obstacle.
    ego_source: &'static str,
    /// Id of the ego.
    ego_id: i64,
    obstacle: i64,
    /// Type of the obstacle.
    obstacle_type: &'static str,
    /// First and last step of the window.
    window: [i64; 2],
    /// The most severe step.
    worst_step: i64,
    /// What the obstacle does to the ego, such as cut_in, following or crossing.
    manoeuvre: &'static str,
    /// Kind of road under the ego.
    road: &'static str,
    /// Severity of the most severe step of the window, 0 (contact) to 5 (none).
    severity: u8,
    /// Values of the measures that the filter compares, by id.
    values: std::collections::BTreeMap<&'static str, Option<f64>>,
}

/// Runs `find`.
pub fn run(arguments: &Find) -> Outcome {
    let words = arguments.terms.join(" ");
    arguments.format.is_json_in(arguments.output.file())?;
    let (folders, config) = configuration()?;
    let mut document = match &arguments.model {
        Some(model) => written(model, &words, arguments, &folders, &config)?,
        None => FindDocument::of(&words).map_err(|failure| {
            Failure::input(format!(
                "{}; `nearmiss help corpora` lists the terms, --model MODEL writes those of a sentence",
                failure.message
            ))
        })?,
    };
    if arguments.filter_only {
        let text = format!("{}\n", document.filter);
        return write(arguments, &document, &text);
    }
    output::say(&format!("nearmiss: filter: {}", document.filter));
    let folder = folder(arguments, &config)?;
    let thresholds = user_thresholds(&folders)?;
    let number = usize::try_from(arguments.number).map_err(Failure::input)?;
    let found = search(
        &folder,
        &document.filter,
        number,
        &thresholds,
        &interrupted(true),
    )?;
    if found.unreadable > 0 {
        output::say(&format!(
            "nearmiss: {} of the index cannot be read here; terms about them hold for none",
            output::counted(found.unreadable, "scenario")
        ));
    }
    document.take(&found);
    write(arguments, &document, &table(&document, &found))?;
    match found.count {
        0 => {
            if checked_filter(&document.filter).is_ok_and(|filter| filter.has_words()) {
                output::say(
                    "nearmiss: words are parts of names, folders or tags of scenarios; `nearmiss help corpora` lists the terms",
                );
            }
            for measure in &found.nowhere {
                output::say(&format!(
                    "nearmiss: no window of this kind has the measure {}; `nearmiss help measures` says what has it",
                    measure.id
                ));
            }
            Err(Failure::finding(format!("none of {} windows", found.of)))
        }
        count => {
            output::say(&format!(
                "nearmiss: {count} of {} windows, in {}",
                found.of,
                output::counted(found.scenarios, "scenario")
            ));
            Ok(())
        }
    }
}

fn folder(arguments: &Find, config: &Config) -> Result<PathBuf, Failure> {
    let folder = arguments.index.as_ref().or(config.index.as_ref());
    folder.cloned().ok_or_else(|| {
        Failure::input(
            "no index: name one with --index FOLDER or `index` in config.toml; `nearmiss corpus index PATH… -o FOLDER` makes one",
        )
    })
}

/// Searches an index until `stop` becomes true, for the windows that a filter lets through, the most severe ones.
pub fn search(
    folder: &Path,
    filter: &str,
    most: usize,
    thresholds: &Thresholds,
    stop: &Arc<AtomicBool>,
) -> Result<FoundWindows, Failure> {
    // Without a store there are no answers.
    let folders = Folders::find().ok();
    let store = folders.and_then(|folders| Store::open_to_read(&folders.store()).ok());
    let answers = store
        .map(|store| store.verdicts(judge::MODEL, None))
        .transpose()
        .map_err(Failure::input)?
        .unwrap_or_default();
    let request = IndexSearch {
        folder,
        filter,
        most,
        answers,
        thresholds,
    };
    let found = search_index(request, &Cancel::from_flag(stop), &mut |_| {});
    found
        .map_err(Failure::input)?
        .ok_or_else(|| Failure::interrupted(""))
}

/// Asks a model for the terms of a sentence.
fn written(
    model: &str,
    sentence: &str,
    arguments: &Find,
    folders: &Folders,
    config: &Config,
) -> Result<FindDocument, Failure> {
    let index = folder(arguments, config)?;
    let reader = text_model(model, (folders, config), (TOKENS, config.budget))?;
    let store = Store::open(&folders.store()).map_err(Failure::input)?;
    let request = FilterRequest {
        sentence,
        index: &index,
        model: &reader,
        store: &store,
    };
    let written = runtime()?.block_on(async {
        tokio::select! {
            written = write_filter(request) => {
                written.map_err(|why| Failure::input(output::visible(&why.to_string())))
            }
            () = ending::signal() => Err(Failure::interrupted("")),
        }
    })?;
    let left_out = written.left_out.map(|words| output::visible(&words));
    if let Some(words) = &left_out {
        output::say(&format!("nearmiss: {model} has no term for: {words}"));
    }
    Ok(FindDocument {
        sentence: Some(output::visible(sentence)),
        model: Some(model.to_string()),
        left_out,
        ..FindDocument::of(&written.filter)?
    })
}

impl FindDocument {
    /// Terms; nothing is searched yet.
    ///
    /// # Errors
    /// They are wrong.
    pub fn of(filter: &str) -> Result<Self, Failure> {
        checked_filter(filter)
            .map_err(|why| Failure::input(format!("filter: {}", output::visible(&why))))?;
        Ok(Self {
            sentence: None,
            model: None,
            filter: output::visible(filter),
            left_out: None,
            searched: None,
            windows: None,
            scenarios: None,
            found: Vec::new(),
        })
    }

    /// Takes over what was found.
    pub fn take(&mut self, found: &FoundWindows) {
        self.searched = Some(found.of);
        self.windows = Some(found.count);
        self.scenarios = Some(found.scenarios);
        self.found = found.windows.iter().map(|one| line(one, found)).collect();
    }

    /// Calls each file, and its scenario, otherwise.
    pub fn rename(&mut self, name: impl Fn(&str) -> Option<String>) {
        for one in &mut self.found {
            if let Some(name) = name(&one.file) {
                (one.scenario, one.file) = (name.clone(), name);
            }
        }
    }
}

fn line(one: &FoundWindow, found: &FoundWindows) -> FindWindow {
    let (window, place) = (&one.window, &one.window.example);
    let values = found.measures.iter().zip(&one.values);
    FindWindow {
        scenario: output::visible(&one.scenario),
        // A bundled scenario is meant by its name.
        file: output::visible(one.file.trim_end_matches(" (bundled)")),
        ego_source: match place.ego {
            nearmiss_scene::corpus::WindowEgo::Recorded => "recorded",
            nearmiss_scene::corpus::WindowEgo::Obstacle(_) => "obstacle",
        },
        ego_id: place.ego_id,
        obstacle: place.obstacle,
        obstacle_type: window.actor.name(),
        window: [place.steps.0, place.steps.1],
        worst_step: place.worst_step,
        manoeuvre: window.manoeuvre.name(),
        road: window.road.name(),
        severity: window.severity,
        values: values
            .map(|(measure, value)| (measure.id, *value))
            .collect(),
    }
}

fn table(document: &FindDocument, found: &FoundWindows) -> String {
    let head = [
        "file",
        "ego",
        "obstacle",
        "type",
        "steps",
        "manoeuvre",
        "road",
        "severity",
    ];
    let measures = found.measures.iter().map(|measure| match measure.unit {
        "" => measure.id.to_string(),
        unit => format!("{} {unit}", measure.id),
    });
    let head: Vec<String> = head.map(String::from).into_iter().chain(measures).collect();
    let rows = document.found.iter().map(|one| {
        let ego = match one.ego_source {
            "recorded" => "recorded".to_string(),
            _ => one.ego_id.to_string(),
        };
        let known = [
            // A row is one line, whatever a file is called.
            one.file.replace('\n', "\u{240a}"),
            ego,
            one.obstacle.to_string(),
            one.obstacle_type.to_string(),
            format!("{}-{}", one.window[0], one.window[1]),
            one.manoeuvre.to_string(),
            one.road.to_string(),
            one.severity.to_string(),
        ];
        let values = found.measures.iter().map(|measure| {
            let value = one.values.get(measure.id).copied().flatten();
            value.map_or_else(|| "–".to_string(), |value| format!("{value:.2}"))
        });
        known.into_iter().chain(values).collect::<Vec<String>>()
    });
    let rows: Vec<Vec<String>> = std::iter::once(head).chain(rows).collect();
    output::table_lines(&rows, &[]).collect()
}

fn write(arguments: &Find, document: &FindDocument, text: &str) -> Outcome {
    let text = if arguments.format.is_json_in(arguments.output.file())? {
        let document = json::Output::document(document).map_err(Failure::input)?;
        output::json_line(&document)?
    } else {
        text.to_string()
    };
    match arguments.output.file() {
        None => output::text(&text),
        Some(file) => {
            Target::begin(Some(file), arguments.output.overwrites())?.save(text.as_bytes())
        }
    }
}
