//! Where the user's maps are, for recordings whose map does not lie with them.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

static MAPS: OnceLock<PathBuf> = OnceLock::new();

/// Says where maps are that do not lie with their recordings: a map, or a folder of them. Said once, before the first
/// recording is read, so that all readings of a recording have the same map.
pub fn look_for_maps_in(place: PathBuf) {
    // What is said again is what is said already: there is one configuration.
    let _ = MAPS.set(place);
}

/// The map or folder, where the user has one.
pub fn users_maps() -> Option<&'static Path> {
    MAPS.get().map(PathBuf::as_path)
}

/// The same as the end of a list of places that were searched.
pub fn in_words() -> String {
    users_maps().map_or_else(String::new, |maps| {
        format!(" or in {} (`maps` in config.toml)", maps.display())
    })
}

/// Whether a file has this extension, in any case.
pub fn has_extension(path: &Path, wanted: &str) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}
