//! Tables that were read, kept for other windows of them.

use std::path::Path;
use std::sync::Arc;

use nearmiss_base::system::FileCache;

use super::Table;
use super::said::is_own_reading;
use crate::commonroad::ReadError;

/// Recordings that are kept for other windows of them, bytes: more than most tables take that are not read in stretches.
const MAX_CACHED: usize = 256 << 20;

static TABLES: FileCache<Table> = FileCache::new(MAX_CACHED);

/// The data in files, which `read` reads where they are not known yet.
pub fn cached(
    files: &[&Path],
    read: impl FnOnce() -> Result<Table, ReadError>,
) -> Result<Arc<Table>, ReadError> {
    if is_own_reading() {
        return read().map(Arc::new);
    }
    TABLES.get(files, || {
        let table = read()?;
        let size = table.recorded.size();
        Ok((table, size))
    })
}
