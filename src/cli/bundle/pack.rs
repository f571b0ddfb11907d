//! `nearmiss runs export --format bundle`: writes a bundle.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use super::super::filters::{LAST, last_batch, store_to_read};
use super::super::open::{configuration, found, user_thresholds};
use super::super::output::{self, OutputFile, Target};
use super::super::{Failure, Outcome, knobs};
use super::ENDING;
use nearmiss_ask::prompts::Library;
use nearmiss_record::fields::Layers;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::TextFile;
use nearmiss_store::{BatchId, Store};
use nearmiss_study::evaluation::validate;
use nearmiss_workflow::{PackRequest, batch_request};

/// Options of `--format bundle`.
#[derive(Debug, clap::Args)]
pub struct BundleOptions {
    /// Bundle: include the scenario files with their egos; without it, they are known by their hashes.
    #[arg(long)]
    with_scenarios: bool,
    /// Bundle: leave out ratings, which name the persons who rated.
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
