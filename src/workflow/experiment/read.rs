//! Reads an experiment from TOML.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::file::Reading;
use super::{Experiment, HASH_DIGITS, each_once};
use crate::Selector;
use nearmiss_ask::llm::{Effort, ToolLimits};
use nearmiss_ask::prompts::{Library, Pack, Techniques};
use nearmiss_base::system::unknown;
use nearmiss_formats::{Entry, EntryLocation};
use nearmiss_scene::description::{EgoAxes, Form, Frame};
use nearmiss_scene::metrics::MeasureList;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::batch::{Matrix, RequestSettings, Split, Subset, TruthSource};
use nearmiss_study::evaluation::report::Comparison;
use nearmiss_study::evaluation::windows::WITHIN;
use nearmiss_study::evaluation::{Axes, Lead, Protocol, default_frame};

impl Experiment {
    /// Reads an experiment; what it leaves open is as without options on the command line, whatever the user's
    /// configuration says: it means the same for everybody.
    ///
    /// # Errors
    /// Every mistake in the text, each with `file` and line.
    pub fn from_toml(text: &str, file: &Path, library: &Library) -> Result<Self, String> {
        let mut reading = Reading::new(text);
        let folder = file.parent().unwrap_or(Path::new(""));
        reading.needed("scenarios", "files, folders, or names of bundled scenarios");
        reading.needed("models", "the models, as provider/model");
        let paths = reading.list("scenarios", |path| Ok(place(folder, path)));
        let truth = reading.list("truth", |word| Ok(word.to_string()));
        let tasks = or(
            reading.list("tasks", |word| {
                let known = Task::VERDICTS.map(Task::name);
                let task = Task::parse(word).filter(|task| Task::VERDICTS.contains(task));
                task.ok_or_else(|| unknown("task", word, known))
            }),
            Task::Safety,
        );
        let frames = reading.list("frames", |word| {
            Frame::parse(word).ok_or_else(|| unknown("frame", word, Frame::ALL.map(Frame::name)))
        });
        let leads = reading.leads("leads");
        let within = reading.number("within");
        let protocol = protocol(&mut reading, !leads.is_empty(), within.is_some());
        let horizon = within.unwrap_or(WITHIN);
        if let Some(lead) = beyond(&leads, horizon) {
            let words = format!(
                "{lead}: the contact is later than within = {horizon} s, which makes the window safe"
            );
            reading.mistake("leads", &words);
        }
        if leads.len() > 1 && !tasks.contains(&Task::Safety) {
            reading.mistake("leads", "several leads are for the safety task");
        }
        let mut leads = each_once(leads).into_iter();
        let (effort, efforts) = Axes::one_or_several(reading.list("effort", |word| {
            Effort::parse(word)
                .ok_or_else(|| unknown("effort", word, Effort::ALL.map(Effort::name)))
        }));
        let (temperature, temperatures) = Axes::one_or_several(reading.numbers("temperature"));
        let (form, forms) = Axes::one_or_several(reading.list("form", |word| {
            Form::parse(word).ok_or_else(|| unknown("form", word, Form::ALL.map(Form::name)))
        }));
        let steps = |steps: u64| usize::try_from(steps).unwrap_or(usize::MAX);
        let strides = reading.wholes("stride").into_iter().map(steps);
        let (stride, strides) = Axes::one_or_several(strides.collect());
        let tools = reading.booleans("tools");
        let (with_tools, tools) = Axes::one_or_several(tools);
        let limits = ToolLimits::default();
        let limits = ToolLimits {
            rounds: reading.whole("tool_rounds").unwrap_or(limits.rounds),
            calls: reading.whole("tool_calls").unwrap_or(limits.calls),
        };
        let (seed, seeds) = Axes::one_or_several(reading.wholes("seed"));
        let ego_axes = word(
            &mut reading,
            "axes",
            EgoAxes::parse,
            &EgoAxes::ALL.map(EgoAxes::name),
        );
        let pack = word(
            &mut reading,
            "pack",
            Pack::parse,
            &Pack::ALL.map(Pack::name),
        )
        .unwrap_or_default();
        let measures = measures(&mut reading);
        let select = reading.text("select");
        if let Some(Err(why)) = select.as_deref().map(Selector::read) {
            reading.mistake("select", &why);
        }
        let split = reading.split("split").map(|(test, seed)| Split {
            test,
            seed: seed.unwrap_or(Split::SEED),
        });
        let hashes = hashes(&mut reading);
        let templates = reading.list("templates", |word| match word.split_once('@') {
            Some((name, hash)) if hash.len() >= HASH_DIGITS => {
                Ok((name.to_string(), hash.to_string()))
            }
            _ => Err(format!(
                "{word}: expected NAME@HASH, with {HASH_DIGITS} digits of the hash or more"
            )),
        });
        let experiment = Self {
            title: reading.text("title"),
            truth: truth_of(&truth, folder),
            matrix: Matrix {
                frames: or(frames, default_frame(library, tasks[0])),
                techniques: or(
                    reading.list("techniques", Techniques::parse),
                    Techniques::ALL,
                ),
                models: reading.list("models", model),
                samples: reading.whole("samples").unwrap_or(1),
                transforms: reading.list("transforms", |word| {
                    word.parse()
                        .map_err(|error: nearmiss_scene::scenario::TransformError| {
                            error.to_string()
                        })
                }),
                request: RequestSettings {
                    every_scenario: false,
                    protocol,
                    history: reading.whole("history").map(|steps| steps as usize),
                    radius: reading.number("radius"),
                    lead: leads.next(),
                    within,
                    temperature,
                    max_tokens: reading.whole("max_tokens"),
                    effort,
                    log_probabilities: reading.boolean("log_probabilities").unwrap_or(false),
                    tools: (with_tools == Some(true) || !tools.is_empty()).then_some(limits),
                    form,
                    stride,
                    road: reading.boolean("road"),
                    axes: ego_axes,
                    measures,
                    pack,
                    seed,
                }
                .drawn(&tasks),
                more_leads: leads.collect(),
                axes: Axes {
                    forms,
                    strides,
                    efforts,
                    temperatures,
                    seeds,
                    tools,
                },
                tasks,
            },
            base_url: reading.text("base_url"),
            budget: reading.number("budget"),
            comparison: Comparison {
                baseline: reading.text("baseline"),
                primary: reading.pair("compare"),
                tables: reading.tables("tables"),
            },
            templates: templates.into_iter().collect(),
            subset: Subset { select, split },
            hashes,
            paths,
        };
        let asked = &experiment.matrix;
        if let Some(why) = asked.request.settings(None).misplaced(&asked.frames, "") {
            reading.mistake("frames", &why);
        }
        if let Err(why) = asked.check_size() {
            reading.mistake("models", &why);
        } else if let Some(name) = unknown_name(&experiment) {
            let key = if experiment.comparison.baseline.as_ref() == Some(&name) {
                "baseline"
            } else {
                "compare"
            };
            reading.mistake(
                key,
                &format!("{name}: no such model or prompt configuration in this experiment"),
            );
        }
        reading.checked(&file.display().to_string())?;
        Ok(experiment)
    }
}

/// The protocol, and mistakes of keys that it leaves no place for.
fn protocol(reading: &mut Reading<'_>, leads: bool, within: bool) -> Protocol {
    let word = reading.text("protocol");
    let known = Protocol::ALL.map(Protocol::name);
    let protocol = match word.as_deref().map(|word| (word, Protocol::parse(word))) {
        None => Protocol::default(),
        Some((_, Some(protocol))) => protocol,
        Some((word, None)) => {
            reading.mistake("protocol", &unknown("protocol", word, known));
            Protocol::default()
        }
    };
    for (key, given) in [("leads", leads), ("within", within)] {
        if given && protocol == Protocol::Paper {
            reading.mistake(
                key,
                "protocol = \"paper\" has windows of its own; remove one of the two",
            );
        }
    }
    protocol
}

/// The value of a key that takes one of some words.
fn word<T>(
    reading: &mut Reading<'_>,
    key: &'static str,
    parse: fn(&str) -> Option<T>,
    known: &[&str],
) -> Option<T> {
    let word = reading.text(key)?;
    let read = parse(&word);
    if read.is_none() {
        reading.mistake(key, &unknown(key, &word, known.iter().copied()));
    }
    read
}

/// The measures of the metrics frame.
fn measures(reading: &mut Reading<'_>) -> Option<MeasureList> {
    let ids = reading.list("measures", |id| Ok(id.to_string()));
    if ids.is_empty() {
        return None;
    }
    let list = MeasureList::of(ids.iter().map(String::as_str));
    list.map_err(|why| reading.mistake("measures", &why)).ok()
}

/// The first of `leads` that is longer than the horizon of the truth, seconds.
fn beyond(leads: &[Lead], within: f64) -> Option<Lead> {
    let longer = |lead: &&Lead| matches!(lead, Lead::Seconds(lead) if *lead > within);
    leads.iter().find(longer).copied()
}

/// A path of a file: names of bundled scenarios stay as they are.
fn place(folder: &Path, path: &str) -> PathBuf {
    let path = Path::new(path);
    if matches!(Entry::of_argument(path).place, EntryLocation::Bundled(_)) {
        path.to_path_buf()
    } else {
        folder.join(path)
    }
}

fn truth_of(words: &[String], folder: &Path) -> Option<TruthSource> {
    match words {
        [] => None,
        [one] if one == "auto" => Some(TruthSource::Geometry),
        [one] if one == "layout" => Some(TruthSource::Layout),
        [one] if TruthSource::score(one).is_some() => {
            TruthSource::score(one).map(TruthSource::Score)
        }
        // Absolute as the scenarios of a batch, so that it asks the same wherever it is gone on with.
        files => Some(TruthSource::Files(
            files
                .iter()
                .map(|file| absolute(folder.join(file)))
                .collect(),
        )),
    }
}

fn absolute(path: PathBuf) -> PathBuf {
    std::path::absolute(&path).unwrap_or(path)
}

fn model(id: &str) -> Result<String, String> {
    match id.split_once('/') {
        Some((provider, model)) if !provider.is_empty() && !model.is_empty() => Ok(id.to_string()),
        _ => Err(format!(
            "{id}: expected provider/model, such as openai/gpt-6-luna"
        )),
    }
}

/// The first declared name that no way of asking has.
fn unknown_name(experiment: &Experiment) -> Option<String> {
    let ways = experiment.matrix.ways();
    let ways: Vec<_> = ways.iter().collect();
    let unknown = experiment.comparison.unknown(&ways);
    unknown.first().map(|name| (*name).to_string())
}

/// Each once, or the default where there are none.
fn or<T: PartialEq>(values: Vec<T>, default: T) -> Vec<T> {
    if values.is_empty() {
        vec![default]
    } else {
        each_once(values)
    }
}

/// The contents of scenarios, by name; each hash in small letters.
fn hashes(reading: &mut Reading<'_>) -> BTreeMap<String, Vec<String>> {
    let found = reading.texts_by_name("hashes");
    let is_hash = |hash: &String| {
        hash.len() >= HASH_DIGITS && hash.bytes().all(|digit| digit.is_ascii_hexdigit())
    };
    let wrong = found
        .iter()
        .find(|(_, all)| all.is_empty() || !all.iter().all(is_hash));
    if let Some((name, _)) = wrong {
        let words = format!("{name}: expected {HASH_DIGITS} hexadecimal digits or more");
        reading.mistake("hashes", &words);
    }
    let small = |hash: String| hash.to_lowercase();
    let found = found.into_iter();
    found
        .map(|(name, all)| (name, all.into_iter().map(small).collect()))
        .collect()
}
