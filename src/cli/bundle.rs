//! Bundles: a batch with its answers as one file, for other machines. `runs export` packs, `runs import` shows and unpacks.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use nearmiss_ask::prompts::Library;
use nearmiss_base::system;
use nearmiss_record::fields::Layers;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::TextFile;
use nearmiss_store::{BatchId, MergeCounts, Store};
use nearmiss_study::evaluation::validate;
use nearmiss_workflow::{Manifest, PackRequest, UnpackRequest, batch_request, read_manifest};
use schemars::JsonSchema;
use serde::Serialize;

use super::filters::{LAST, last_batch, store_to_read};
use super::open::{configuration, found, user_thresholds};
use super::output::{self, OutputFile, Target, counted};
use super::{Failure, Outcome, knobs};

/// The ending of bundles.
pub const ENDING: &str = "nearmiss";

/// How a bundle, a file of gzip, begins.
const BEGINNING: [u8; 2] = [0x1f, 0x8b];

/// Whether a file is a bundle, or shall be one.
pub fn is_one(path: &Path) -> bool {
    let mut begun = [0; BEGINNING.len()];
    let read = system::open_file(path).and_then(|mut file| file.read_exact(&mut begun));
    path.extension().is_some_and(|ending| ending == ENDING) || read.is_ok() && begun == BEGINNING
}

/// Options of `--format bundle`.
#[derive(Debug, clap::Args)]
pub struct BundleOptions {
    /// Bundle: include the scenario files and their egos; without it, the bundle identifies them by hash.
    #[arg(long)]
    with_scenarios: bool,
    /// Bundle: leave out ratings, which contain the names of raters.
    #[arg(long)]
    without_ratings: bool,
}

impl BundleOptions {
    /// An option that is given, which other formats do not have.
    pub fn given(&self) -> Option<&'static str> {
        match self {
            Self {
                with_scenarios: true,
                ..
            } => Some("--with-scenarios"),
            Self {
                without_ratings: true,
                ..
            } => Some("--without-ratings"),
            _ => None,
        }
    }
}

/// Writes a batch (b7, `last`, or an experiment file that was run) to the file of -o, else BATCH.nearmiss.
pub fn pack(named: &str, output: &OutputFile, options: &BundleOptions) -> Outcome {
    let (folders, _) = configuration()?;
    let library = validate(Library::load(Some(&folders.prompts())));
    let thresholds = Arc::new(user_thresholds(&folders)?);
    let text = TextFile::read_if_there(&folders.thresholds()).map_err(Failure::input)?;
    let store = store_to_read()?;
    let (batch, budget) = batch(named, &store, &library, &thresholds)?;
    let default = PathBuf::from(format!("{batch}.{ENDING}"));
    let file = output.file().unwrap_or(&default);
    let mut target = Target::begin(Some(file), output.overwrites())?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let request = PackRequest {
        store: &store,
        batch,
        budget,
        library: &library,
        thresholds: (thresholds, text.map(|file| file.text)),
        with_scenarios: options.with_scenarios,
        with_ratings: !options.without_ratings,
        now_ms: now.map_or(0, |since| {
            i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
        }),
    };
    let packed = nearmiss_workflow::pack(&request, &mut target).map_err(Failure::input)?;
    target.finish()?;
    for note in &packed.notes {
        output::say(&format!("nearmiss: {note}"));
    }
    output::say(&format!(
        "nearmiss: wrote {}: {batch}, {}, {}; `nearmiss runs import {}` unpacks it",
        file.display(),
        output::counted(packed.manifest.questions as usize, "question"),
        output::counted(packed.manifest.runs as usize, "run"),
        file.display()
    ));
    Ok(())
}

/// The batch that is meant, with the budget of its experiment file.
fn batch(
    named: &str,
    store: &Store,
    library: &Library,
    thresholds: &Thresholds,
) -> Result<(BatchId, Option<f64>), Failure> {
    if named == LAST {
        return Ok((last_batch(store)?, None));
    }
    let file = Path::new(named);
    if file.extension().is_none_or(|end| end != "toml") {
        let id = named.parse().map_err(|why| {
            Failure::input(format!(
                "{named}: {why}, `last`, or an experiment file (.toml)"
            ))
        })?;
        return Ok((id, None));
    }
    let mut layers = Layers::default();
    knobs::add_file(&mut layers, file)?;
    let experiment = knobs::complete(layers, library)?;
    let entries = found(&experiment.scenarios)?;
    let wrong = |why: String| Failure::input(format!("{}: {why}", file.display()));
    let mut request = batch_request(&experiment, entries, None, library).map_err(wrong)?;
    let budget = experiment.budget;
    let stored = request.stored(store, library, thresholds);
    if let Some(id) = stored.map_err(Failure::input)? {
        return Ok((id, budget));
    }
    let parts = request.stored_parts(store, library, thresholds);
    match &parts.map_err(Failure::input)?[..] {
        [] => Err(wrong(format!(
            "no batch asks this yet; `nearmiss evaluate {}` does",
            file.display()
        ))),
        [(id, _)] => Ok((*id, budget)),
        several => {
            let named = several
                .iter()
                .map(|(id, part)| format!("{id} (part {part})"));
            let named: Vec<String> = named.collect();
            Err(wrong(format!(
                "several batches ask parts of this: {}; name one",
                named.join(", ")
            )))
        }
    }
}

/// The manifest of a bundle.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(transparent)]
pub struct BundleDocument(Manifest);

/// Checks a bundle, and prints what is in it.
pub fn show(file: &Path, format: output::FormatOption) -> Outcome {
    let manifest = read_manifest(file).map_err(Failure::input)?;
    if format.is_json() {
        return output::document(&BundleDocument(manifest));
    }
    output::text(&output::visible(&bundle_summary(&manifest)))
}

fn bundle_summary(manifest: &Manifest) -> String {
    let included = manifest.scenarios.iter().filter(|one| one.included).count();
    let mut text = format!(
        "packed {}, format {}\n{}\n{}, {}, {}, {} ({included} included)\n\n",
        output::local(manifest.created_ms),
        manifest.nearmiss_bundle,
        manifest.provenance.summary(),
        counted(manifest.questions as usize, "question"),
        counted(manifest.runs as usize, "run"),
        counted(manifest.ratings as usize, "rating"),
        counted(manifest.scenarios.len(), "scenario"),
    );
    for member in &manifest.members {
        let start = member.sha256.get(..12).unwrap_or_default();
        text += &format!("{start} {:>10}  {}\n", member.bytes, member.name);
    }
    text
}

/// Unpacks bundles, each into `into` or a folder of its own in it, else the name of the bundle without its ending.
pub fn unpack(
    files: &[&Path],
    into: Option<&Path>,
    store: &Store,
) -> Result<Vec<MergeCounts>, Failure> {
    let folders = folders(files, into)?;
    let (own, _) = configuration()?;
    let library = validate(Library::load(Some(&own.prompts())));
    let all = { folders.iter() }.map(|(file, into)| unpack_one(file, into, store, &library));
    all.collect()
}

/// The bundles, each with its folder.
fn folders<'a>(
    files: &[&'a Path],
    into: Option<&Path>,
) -> Result<Vec<(&'a Path, PathBuf)>, Failure> {
    let mut folders: Vec<(&Path, PathBuf)> = Vec::new();
    for &file in files {
        let stem = file.file_stem().filter(|_| file.extension().is_some());
        let named = match (into, files) {
            (Some(folder), [_]) => Some(folder.to_path_buf()),
            (Some(folder), _) => stem.map(|stem| folder.join(stem)),
            (None, _) => stem.map(PathBuf::from),
        };
        let into = named.ok_or_else(|| {
            Failure::input(format!(
                "{}: name a folder with --into, and import it alone",
                file.display()
            ))
        })?;
        let into = std::path::absolute(&into).map_err(|e| Failure::system(file.display(), &e))?;
        if let Some((other, _)) = folders.iter().find(|(_, folder)| *folder == into) {
            return Err(Failure::input(format!(
                "{} and {} would be unpacked into the same folder; import them one by one with --into",
                other.display(),
                file.display()
            )));
        }
        folders.push((file, into));
    }
    Ok(folders)
}

fn unpack_one(
    file: &Path,
    into: &Path,
    store: &Store,
    library: &Library,
) -> Result<MergeCounts, Failure> {
    let unpacked = nearmiss_workflow::unpack(&UnpackRequest {
        file,
        into,
        store,
        library,
    });
    let done = unpacked.map_err(Failure::input)?;
    let batch = done.batch;
    let parts = store
        .batch(batch)
        .map_err(Failure::input)?
        .and_then(|batch| batch.shard);
    let parts = parts.map_or_else(String::new, |parts| format!(" (part {parts})"));
    output::say(&format!(
        "nearmiss: {batch}{parts}: {} and {} new, {} already in the store",
        counted(done.counts.runs, "run"),
        counted(done.ratings, "rating"),
        counted(done.counts.already_there, "run"),
    ));
    output::say(&format!(
        "nearmiss: {}: {} written, {} already there; `nearmiss report --batch {batch}` prints the tables",
        into.display(),
        counted(done.written, "file"),
        done.kept
    ));
    Ok(done.counts)
}
