//! Imports runs and batches of another store, such as shards of a batch asked on other machines.

use std::io::Read;
use std::path::Path;

use super::Counts;
use crate::{Failure, output};
use nearmiss_base::system;
use nearmiss_store::Store;

/// How every SQLite file begins.
const BEGINNING: &[u8] = b"SQLite format 3\0";

/// Whether a file is a store.
pub fn is_one(path: &Path) -> bool {
    let mut begun = [0; BEGINNING.len()];
    let read = system::open_file(path).and_then(|mut file| file.read_exact(&mut begun));
    read.is_ok() && begun == BEGINNING
}

/// Adds the runs and batches of a store that are not in this one yet.
pub fn import(path: &Path, store: &Store, counts: &mut Counts) -> Result<(), Failure> {
    let other = Store::open_to_read(path).map_err(Failure::input)?;
    let merged = store
        .merge(&other)
        .map_err(|e| Failure::input(format!("{}: {e}", path.display())))?;
    if merged.running > 0 {
        output::say(&format!(
            "nearmiss: {}: skipped {} still streaming there; import it again when complete",
            path.display(),
            output::counted(merged.running, "answer")
        ));
    }
    super::merged(path, merged, counts);
    Ok(())
}
