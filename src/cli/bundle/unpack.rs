//! `nearmiss runs import BUNDLE`: answers into the store, files into a folder.

use std::path::{Path, PathBuf};

use super::super::Failure;
use super::super::open::configuration;
use super::super::output::{self, counted};
use nearmiss_ask::prompts::Library;
use nearmiss_store::{MergeCounts, Store};
use nearmiss_study::evaluation::validate;
use nearmiss_workflow::UnpackRequest;

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
