//! Finds scenarios; of long recordings the most severe windows.

use std::path::PathBuf;

use nearmiss_formats::{
    self as formats, Entry, LibraryError, LongRecording, PassedOver, SearchResults,
};
use nearmiss_scene::corpus::worst_moments;
use nearmiss_scene::metrics::Thresholds;

/// Pairs farther apart are not measured, metres: as far as `nearmiss corpus index` looks where nothing else is said.
pub const INDEX_RADIUS: f64 = 50.0;

/// The scenarios at `paths`, as [`formats::find`] finds them; of long recordings the windows around the most severe
/// moments, those first.
///
/// # Errors
/// As [`formats::find`].
pub fn find(paths: &[PathBuf]) -> Result<SearchResults, LibraryError> {
    formats::find_ranked(paths, &worst_windows)
}

/// The same in pieces, as [`formats::find_in_pieces`].
///
/// # Errors
/// As [`formats::find`].
pub fn find_in_pieces(
    paths: &[PathBuf],
    give: &mut dyn FnMut(Vec<Entry>),
) -> Result<Vec<PassedOver>, LibraryError> {
    formats::find_in_pieces(paths, &worst_windows, give)
}

/// The windows of a long recording that are listed. They are the same for all users: their own thresholds grade windows
/// that are open, and do not change what can be named.
fn worst_windows(recording: &LongRecording) -> Vec<String> {
    let moments = worst_moments(
        &recording.scenario,
        &recording.egos(),
        INDEX_RADIUS,
        Thresholds::shipped(),
    );
    let windows = recording.windows(moments.iter().map(|m| (m.ego, m.moment.step)));
    if windows.is_empty() {
        recording.beginnings()
    } else {
        windows
    }
}
