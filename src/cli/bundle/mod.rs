//! Bundles: a batch with its answers as one file, for other machines. `runs export` packs, `runs import` unpacks.

mod pack;
mod show;
mod unpack;

use std::io::Read;
use std::path::Path;

use nearmiss_base::system;
pub use pack::{BundleOptions, pack};
pub use show::{Document, show};
pub use unpack::unpack;

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
