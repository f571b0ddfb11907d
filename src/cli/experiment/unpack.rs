//! `nearmiss experiment unpack`: answers into the store, files into a folder.

use std::path::{Path, PathBuf};

use super::super::filters::store;
use super::super::open::configuration;
use super::super::output::{self, counted};
use super::super::{Failure, Outcome};
use nearmiss_ask::prompts::Library;
use nearmiss_store::Store;
use nearmiss_study::evaluation::validate;
use nearmiss_workflow::{UnpackRequest, unpack};

/// Arguments of `experiment unpack`.
#[derive(Debug, clap::Args)]
pub struct Unpack {
    /// Bundles, FILE.nearmiss; parts of one batch (`--shard`) become one.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Folder for the experiment file, templates, labels and scenarios; of several bundles, for a folder of each
    /// [default: the name of the bundle without its ending].
    #[arg(long, value_name = "DIR")]
    into: Option<PathBuf>,
}

/// Runs `experiment unpack`.
pub fn run(arguments: &Unpack) -> Outcome {
    let folders = arguments.folders()?;
    let (own, _) = configuration()?;
    let library = validate(Library::load(Some(&own.prompts())));
    let store = store()?;
    for (file, into) in &folders {
        unpack_one(file, into, &store, &library)?;
    }
    Ok(())
}

impl Unpack {
    /// The bundles, each with its folder.
    fn folders(&self) -> Result<Vec<(&Path, PathBuf)>, Failure> {
        let mut folders: Vec<(&Path, PathBuf)> = Vec::new();
        for file in &self.files {
            let stem = file.file_stem().filter(|_| file.extension().is_some());
            let named = match (&self.into, &self.files[..]) {
                (Some(folder), [_]) => Some(folder.clone()),
                (Some(folder), _) => stem.map(|stem| folder.join(stem)),
                (None, _) => stem.map(PathBuf::from),
            };
            let into = named.ok_or_else(|| {
                Failure::input(format!(
                    "{}: name a folder with --into, and unpack it alone",
                    file.display()
                ))
            })?;
            let into =
                std::path::absolute(&into).map_err(|e| Failure::system(file.display(), &e))?;
            if let Some((other, _)) = folders.iter().find(|(_, folder)| *folder == into) {
                return Err(Failure::input(format!(
                    "{} and {} would be unpacked into the same folder; unpack them one by one with --into",
                    other.display(),
                    file.display()
                )));
            }
            folders.push((file, into));
        }
        Ok(folders)
    }
}

fn unpack_one(file: &Path, into: &Path, store: &Store, library: &Library) -> Outcome {
    let unpacked = unpack(&UnpackRequest {
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
    Ok(())
}
