//! Which files are opened: for work on behalf of others, who may see only some.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

thread_local! {
    static OPENED: RefCell<Option<Vec<PathBuf>>> = const { RefCell::new(None) };
}

/// What `work` gives, and the files whose contents it used on this thread, also those that were in memory already.
pub fn files_opened_by<T>(work: impl FnOnce() -> T) -> (T, Vec<PathBuf>) {
    let before = OPENED.replace(Some(Vec::new()));
    let done = work();
    let opened = OPENED.replace(before).unwrap_or_default();
    (done, opened)
}

/// Notes a file for [`files_opened_by`].
pub(super) fn note(path: &Path) {
    OPENED.with_borrow_mut(|opened| {
        if let Some(opened) = opened {
            opened.push(path.to_path_buf());
        }
    });
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::{FileCache, read_file};
    use super::*;

    #[test]
    fn files_are_noted_also_where_they_were_read_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["a", "b", "c"] {
            std::fs::write(path(name), "x").unwrap();
        }
        let kept: FileCache<Vec<u8>> = FileCache::new(1 << 10);
        let cached = || {
            let file = path("b");
            kept.get(&[&file], || read_file(&file, 9).map(|read| (read, 1)))
        };
        cached().unwrap();
        let (inner, opened) = files_opened_by(|| {
            read_file(&path("a"), 9).unwrap();
            assert!(read_file(&path("gone"), 9).is_err());
            let (_, inner) = files_opened_by(|| read_file(&path("c"), 9));
            cached().unwrap();
            inner
        });
        let names = |files: &[PathBuf]| -> std::collections::BTreeSet<PathBuf> {
            files.iter().cloned().collect()
        };
        assert_eq!(names(&opened), [path("a"), path("b")].into());
        assert_eq!(inner, [path("c")]);
        read_file(&path("a"), 9).unwrap();
        assert_eq!(files_opened_by(|| ()).1, [] as [PathBuf; 0]);
    }
}
