//! `nearmiss experiment pack`: writes a bundle.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use super::super::filters::{LAST, last_batch, store_to_read};
use super::super::open::{configuration, found, user_thresholds};
use super::super::output::{self, Target};
use super::super::{Failure, Outcome, knobs};
use nearmiss_ask::prompts::Library;
use nearmiss_record::fields::Layers;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_settings::TextFile;
use nearmiss_store::{BatchId, Store};
use nearmiss_study::evaluation::validate;
use nearmiss_workflow::{PackRequest, pack, request_of};

/// Arguments of `experiment pack`.
#[derive(Debug, clap::Args)]
pub struct Pack {
    /// A batch (b7), the last one (last), or an experiment file that was run.
    #[arg(value_name = "BATCH|FILE.toml")]
    batch: String,
    /// The bundle to write [default: BATCH.nearmiss].
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing file.
    #[arg(long)]
    overwrite: bool,
    /// Include the scenario files with their egos; without it, they are known by their hashes.
    #[arg(long)]
    with_scenarios: bool,
    /// Leave out ratings, which name the persons who rated.
    #[arg(long)]
    without_ratings: bool,
}

/// Runs `experiment pack`.
pub fn run(arguments: &Pack) -> Outcome {
    let (folders, _) = configuration()?;
    let library = validate(Library::load(Some(&folders.prompts())));
    let thresholds = Arc::new(user_thresholds(&folders)?);
    let text = TextFile::read_if_there(&folders.thresholds()).map_err(Failure::input)?;
    let store = store_to_read()?;
    let (batch, budget) = batch(&arguments.batch, &store, &library, &thresholds)?;
    let default = PathBuf::from(format!("{batch}.nearmiss"));
    let file = arguments.output.as_deref().unwrap_or(&default);
    let mut target = Target::begin(Some(file), arguments.overwrite)?;
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let request = PackRequest {
        store: &store,
        batch,
        budget,
        library: &library,
        thresholds: (thresholds, text.map(|file| file.text)),
        with_scenarios: arguments.with_scenarios,
        with_ratings: !arguments.without_ratings,
        now_ms: now.map_or(0, |since| {
            i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
        }),
    };
    let packed = pack(&request, &mut target).map_err(Failure::input)?;
    target.finish()?;
    for note in &packed.notes {
        output::say(&format!("nearmiss: {note}"));
    }
    output::say(&format!(
        "nearmiss: wrote {}: {batch}, {}, {}; `nearmiss experiment unpack {}` unpacks it",
        file.display(),
        super::super::output::counted(packed.manifest.questions as usize, "question"),
        super::super::output::counted(packed.manifest.runs as usize, "run"),
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
    let mut request = request_of(&experiment, entries, None, library).map_err(wrong)?;
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
