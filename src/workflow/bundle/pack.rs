//! Packing: a batch of the store becomes one file, with its scenarios and the recordings of their egos if asked.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_ask::prompts::Library;
use nearmiss_base::system::{self, without_folders};
use nearmiss_formats::{Entry, EntryLocation, find_recording};
use nearmiss_scene::metrics::Thresholds;
use nearmiss_store::{BatchId, Item, RatedAnswer, RunId, Store, record_line};
use nearmiss_study::evaluation::Provenance;
use nearmiss_study::evaluation::batch::{
    Experiment, Spec, TruthSource, answers, with_judge_verdicts,
};

use super::manifest::{
    EXPERIMENT, FORMAT, Manifest, Member, PackedScenario, RATINGS, SCENARIOS, TEMPLATES,
    THRESHOLDS, TRUTH, hash,
};
use super::{BatchLines, BundleError, manifest, numbers, portable_paths};
use crate::{experiment_toml, hashes_in, template_pins};

/// What is packed.
pub struct PackRequest<'a> {
    /// The store of the batch.
    pub store: &'a Store,
    /// The batch.
    pub batch: BatchId,
    /// The most that the experiment may cost, US dollars, where its file says so.
    pub budget: Option<f64>,
    /// The user's templates.
    pub library: &'a Library,
    /// The user's thresholds, and the text of their file.
    pub thresholds: (Arc<Thresholds>, Option<String>),
    /// Whether the files of the scenarios are packed, too.
    pub with_scenarios: bool,
    /// Whether ratings of the answers are packed, with the names of persons.
    pub with_ratings: bool,
    /// When, milliseconds since 1970, UTC.
    pub now_ms: i64,
}

/// A bundle that was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Packed {
    /// What is in it.
    pub manifest: Manifest,
    /// What is missing in it, in sentences.
    pub notes: Vec<String>,
}

/// A member before it is written.
enum Content {
    Bytes(Vec<u8>),
    /// A file of the user, read again when it is written.
    Path(PathBuf),
    /// A file without a name.
    File(File),
}

impl Content {
    fn reader(self) -> io::Result<Box<dyn Read>> {
        Ok(match self {
            Self::Bytes(bytes) => Box::new(io::Cursor::new(bytes)),
            Self::Path(path) => Box::new(system::open_file(&path)?),
            Self::File(mut file) => {
                file.rewind()?;
                Box::new(file)
            }
        })
    }
}

/// Writes a batch as a bundle.
///
/// # Errors
/// There is no such batch; the store or a file cannot be read; the bundle cannot be written.
pub fn pack(request: &PackRequest<'_>, out: impl Write) -> Result<Packed, BundleError> {
    let store = request.store;
    let Some(batch) = store.batch(request.batch)? else {
        let words = format!(
            "no batch {}; `nearmiss evaluate list` lists batches",
            request.batch
        );
        return Err(BundleError::Batch(words));
    };
    let spec = Spec::from_json(&batch.spec).map_err(|e| BundleError::Batch(e.to_string()))?;
    let portable = spec.portable();
    let items = store.items(batch.id)?;
    let mut answers = answers(store, batch.id)?;
    let judgements = with_judge_verdicts(&mut answers, &items, || {
        let builder = spec.builder_again(request.library, Arc::clone(&request.thresholds.0));
        builder.map_err(|error| without_folders(&error.to_string()))
    });
    let runs = numbers(store, &batch)?;
    let paths = portable_paths(&spec, &items);
    let counted: BTreeSet<RunId> = answers.plain.iter().filter_map(|one| one.run).collect();
    let mut notes = Vec::new();
    notes.extend(portable.ego.planner().map(|drives| {
        format!(
            "the egos were {}; their drives are not in the bundle, and its experiment file asks about recorded egos",
            drives.text()
        )
    }));
    let mut members: Vec<(Member, Content)> = Vec::new();
    for (name, text) in texts(request, (&spec, &portable), &items, &mut notes)? {
        members.push(of_bytes(name, text.into_bytes()));
    }
    let (scenarios, files) = collect(&items, &paths, request.with_scenarios);
    let outside = |path: &str| !is_bundled(path);
    let missing = scenarios
        .iter()
        .filter(|one| !one.included && outside(&one.path));
    if let (true, n @ 1..) = (request.with_scenarios, missing.count()) {
        notes.push(format!(
            "{n} scenarios are not in the bundle: they are not at hand as they were asked about"
        ));
    }
    for (name, path) in files {
        let bytes = system::read_file(&path, system::LARGEST)
            .map_err(|source| BundleError::io(&path, source))?;
        members.push((member(name, &bytes), Content::Path(path)));
    }
    let lines = BatchLines {
        store,
        batch: &batch,
        portable: &portable,
        items: &items,
        paths: &paths,
        judgements: &judgements.all,
        runs: &runs,
    };
    let (member, file, written) = lines.write()?;
    if written < runs.len() as u64 {
        let open = runs.len() as u64 - written;
        notes.push(format!(
            "{open} answers are still arriving and were left out"
        ));
    }
    members.push((member, Content::File(file)));
    let ratings = if request.with_ratings {
        ratings(store, &runs)?
    } else {
        Vec::new()
    };
    if !ratings.is_empty() {
        members.push(of_bytes(RATINGS.into(), ratings.concat().into_bytes()));
    }
    let manifest = Manifest {
        nearmiss_bundle: FORMAT,
        created_ms: request.now_ms,
        provenance: Provenance::of_batch(store, (batch.id, &portable, &items), &counted)?,
        questions: items.len() as u64,
        runs: written,
        ratings: ratings.len() as u64,
        scenarios,
        members: members.iter().map(|(member, _)| member.clone()).collect(),
    };
    let contents = members.into_iter().map(|(_, content)| content.reader());
    let each = manifest.members.iter().zip(contents);
    manifest::write(out, &manifest, each).map_err(|source| BundleError::Io {
        file: "the bundle".into(),
        source,
    })?;
    Ok(Packed { manifest, notes })
}

fn of_bytes(name: String, bytes: Vec<u8>) -> (Member, Content) {
    (member(name, &bytes), Content::Bytes(bytes))
}

fn member(name: String, bytes: &[u8]) -> Member {
    Member {
        name,
        bytes: bytes.len() as u64,
        sha256: hash(bytes),
    }
}

pub(super) fn is_bundled(path: &str) -> bool {
    let place = Entry::of_argument(Path::new(path)).place;
    matches!(place, EntryLocation::Bundled(_))
}

/// The experiment file, templates, thresholds and labels, by name.
fn texts(
    request: &PackRequest<'_>,
    (spec, portable): (&Spec, &Spec),
    items: &[Item],
    notes: &mut Vec<String>,
) -> Result<BTreeMap<String, String>, BundleError> {
    let mut texts = BTreeMap::new();
    texts.insert(EXPERIMENT.into(), experiment(request, portable, items)?);
    let library = spec
        .library(request.library)
        .map_err(|e| BundleError::Batch(e.to_string()))?;
    for (file, pinned) in &spec.templates {
        let source = library.source(file).map(|(text, _)| text);
        let Some(source) = source.filter(|text| library.hash(text) == *pinned) else {
            notes.push(format!(
                "{file}: its text is not in the bundle, as it has changed since the batch was asked"
            ));
            continue;
        };
        texts.insert(format!("{TEMPLATES}{file}"), source.to_string());
        for name in library.included(source) {
            if let Some((text, _)) = library.source(name) {
                texts.insert(format!("{TEMPLATES}{name}"), text.to_string());
            }
        }
    }
    let (now, text) = &request.thresholds;
    match text {
        _ if spec.thresholds.is_empty() => {}
        Some(text) if Spec::threshold_changes(now) == spec.thresholds => {
            texts.insert(THRESHOLDS.into(), text.clone());
        }
        _ => notes.push("thresholds.toml is not in the bundle, as it has changed since".into()),
    }
    if let (TruthSource::Files(files), TruthSource::Files(names)) = (spec.truth(), portable.truth())
    {
        for (file, name) in files.iter().zip(names) {
            match system::read_text(file, system::LARGEST) {
                Ok(text) => {
                    texts.insert(format!("{TRUTH}{}", name.display()), text);
                }
                Err(_) => notes.push(format!(
                    "{}: the labels are not in the bundle, as the file cannot be read; the truth of each question is",
                    name.display()
                )),
            }
        }
    }
    Ok(texts)
}

/// The experiment as a file beside the folders of the bundle.
fn experiment(
    request: &PackRequest<'_>,
    portable: &Spec,
    items: &[Item],
) -> Result<String, BundleError> {
    let below = |folder: &str, path: &PathBuf| {
        if is_bundled(&path.display().to_string()) {
            path.clone()
        } else {
            Path::new(folder).join(path)
        }
    };
    let scenarios = portable.experiment.scenarios.iter();
    let experiment = Experiment {
        scenarios: scenarios.map(|path| below(SCENARIOS, path)).collect(),
        truth: Some(match portable.truth() {
            TruthSource::Files(files) => {
                let files = files.iter().map(|file| Path::new(TRUTH).join(file));
                TruthSource::Files(files.collect())
            }
            other => other.clone(),
        }),
        budget: request.budget,
        templates: template_pins(portable),
        hashes: hashes_in(items),
        ..portable.experiment.clone()
    };
    experiment_toml(&experiment, Path::new("")).map_err(BundleError::Batch)
}

/// The ratings of these runs, a line each.
fn ratings(store: &Store, runs: &BTreeSet<RunId>) -> Result<Vec<String>, BundleError> {
    let known = |answer: &RatedAnswer| answer.run.is_some_and(|run| runs.contains(&run));
    let mut lines = Vec::new();
    for mut rating in store.ratings()? {
        if !rating.answers.iter().any(known) {
            continue;
        }
        for answer in &mut rating.answers {
            answer.run = answer.run.filter(|run| runs.contains(run));
        }
        lines.push(record_line(&rating.to_record())?);
    }
    Ok(lines)
}

/// The scenarios of a batch, and the files to pack by their names in the bundle. Those that have changed since they were
/// asked about are left out.
pub(super) fn collect(
    items: &[Item],
    paths: &BTreeMap<String, String>,
    with_files: bool,
) -> (Vec<PackedScenario>, BTreeMap<String, PathBuf>) {
    let mut files = BTreeMap::new();
    let mut hashes: BTreeMap<&str, Option<&String>> = BTreeMap::new();
    for item in items {
        let hash = hashes.entry(item.asked.path.as_str()).or_default();
        *hash = hash.or(item.asked.scenario_hash.as_ref());
    }
    let each = hashes.into_iter().map(|(path, hash)| {
        let name = paths.get(path).cloned().unwrap_or_default();
        let entry = Entry::of_argument(Path::new(path));
        let own = match (&entry.place, with_files) {
            // Recordings are not passed on: their licences do not let them be.
            (EntryLocation::File(_), true) if entry.is_recording() => Vec::new(),
            (EntryLocation::File(file), true) if is_same(&entry, hash) => of_entry(&entry, file),
            _ => Vec::new(),
        };
        let folder = Path::new(&name).parent().unwrap_or(Path::new(""));
        let included = !own.is_empty();
        for (at, (below, file)) in own.into_iter().enumerate() {
            // The scenario itself comes first, under the name that its questions have.
            let place = match at {
                0 => name.clone(),
                _ => super::manifest::safe(&folder.join(below).display().to_string()),
            };
            files.insert(format!("{SCENARIOS}{place}"), file);
        }
        PackedScenario {
            path: name,
            sha256: hash.cloned(),
            included,
        }
    });
    let scenarios = each.collect();
    (scenarios, files)
}

fn is_same(entry: &Entry, hash: Option<&String>) -> bool {
    let read = entry.read();
    read.is_ok_and(|scenario| hash == Some(&scenario.hash.to_string()))
}

/// The file of a scenario and those that belong to it, each with its place beside it.
fn of_entry(entry: &Entry, file: &Path) -> Vec<(PathBuf, PathBuf)> {
    let name = |path: &Path| PathBuf::from(path.file_name().unwrap_or_default());
    let mut found = vec![(name(file), file.to_path_buf())];
    let is_protobuf = file.extension().is_some_and(|end| end == "pb");
    let beside = file.parent().filter(|_| is_protobuf).map(std::fs::read_dir);
    if let Some(Ok(beside)) = beside {
        let parts = beside.flatten().map(|one| one.path()).filter(|path| {
            let own = path.extension().is_some_and(|end| end == "pb") && path != file;
            own && name(path).to_string_lossy().starts_with(&entry.name)
        });
        let mut parts: Vec<PathBuf> = parts.collect();
        parts.sort();
        found.extend(parts.into_iter().map(|path| (name(&path), path)));
    }
    if let Some(recording) = find_recording(file) {
        let own = name(&recording);
        let place = if own.to_string_lossy().ends_with("ego_trajectory.csv") {
            PathBuf::from(format!("{}.ego_trajectory.csv", entry.name))
        } else if recording.parent() == file.parent() {
            own
        } else {
            Path::new(&entry.name).join(own)
        };
        found.push((place, recording));
    }
    found
}
