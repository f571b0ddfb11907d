//! Input scenarios to attack: each file once, and no variants that lie in a searched folder.

use std::collections::HashSet;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::{Failure, output};
use nearmiss_base::system;
use nearmiss_drive::generation::MARK;
use nearmiss_formats::{Entry, EntryLocation};

/// The attributes of the root element, and with them its `source`, lie within so many bytes.
const HEAD: u64 = 1 << 16;

/// More variants are not named each.
const NAMED: usize = 5;

/// What of `entries`, found at `paths`, is to be attacked.
///
/// # Errors
/// Nothing but variants was found.
pub fn originals(mut entries: Vec<Entry>, paths: &[PathBuf]) -> Result<Vec<Entry>, Failure> {
    let mut seen = HashSet::new();
    // The same file by two ways: `a.xml` and `./a.xml`.
    entries.retain(|entry| match &entry.place {
        EntryLocation::File(path) => path.canonicalize().map_or(true, |real| seen.insert(real)),
        EntryLocation::Bundled(_) => true,
    });
    let mut variants = Vec::new();
    entries.retain(|entry| {
        let EntryLocation::File(path) = &entry.place else {
            return true;
        };
        let kept = paths.contains(path) || !is_variant(path);
        if !kept {
            variants.push(entry.name.clone());
        }
        kept
    });
    if variants.is_empty() {
        return Ok(entries);
    }
    let mut words = variants[..variants.len().min(NAMED)].join(", ");
    if variants.len() > NAMED {
        words = format!("{words} and {} more", variants.len() - NAMED);
    }
    if entries.is_empty() {
        return Err(Failure::input(format!(
            "all scenarios are variants made by nearmiss ({words}); name a file to use it as an original"
        )));
    }
    let (count, are) = match variants.len() {
        1 => ("1 variant".into(), "is"),
        n => (format!("{n} variants"), "are"),
    };
    output::say(&format!(
        "nearmiss: {count} of earlier runs {are} skipped: {words}; name a file to use it as an original"
    ));
    Ok(entries)
}

/// Whether the head of a file says that nearmiss has made it. One that cannot be read is named when it is its turn.
fn is_variant(path: &Path) -> bool {
    let Ok(file) = system::open_file(path) else {
        return false;
    };
    let mut head = Vec::new();
    let read = file.take(HEAD).read_to_end(&mut head);
    read.is_ok() && head.windows(MARK.len()).any(|part| part == MARK.as_bytes())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use nearmiss_formats::find;

    #[test]
    fn variants_in_a_folder_are_left_out_unless_they_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let variant = format!("<commonRoad source=\"a field; {MARK}1.0: b\"/>");
        std::fs::write(path("original.xml"), "<commonRoad/>").unwrap();
        std::fs::write(path("variant.xml"), variant).unwrap();
        let names = |paths: &[PathBuf]| {
            let kept = originals(find(paths).unwrap().entries, paths);
            kept.map(|kept| kept.into_iter().map(|e| e.name).collect::<Vec<_>>())
        };
        let all = [folder.path().to_path_buf()];
        assert_eq!(names(&all).unwrap(), ["original"]);
        let both = [folder.path().to_path_buf(), path("variant.xml")];
        assert_eq!(names(&both).unwrap(), ["original", "variant"]);
        // The same file by another way is there once.
        let twice = [path("original.xml"), folder.path().join("./original.xml")];
        assert_eq!(names(&twice).unwrap(), ["original"]);
        std::fs::remove_file(path("original.xml")).unwrap();
        let failure = names(&all).unwrap_err();
        assert_eq!(failure.status, 2);
        assert!(failure.message.contains("all scenarios are variants"));
    }
}
