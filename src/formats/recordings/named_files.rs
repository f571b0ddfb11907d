//! Files that a file names: by paths from its folder, also as they are written on Windows, or beside it where it was moved
//! to another machine with them.

use std::path::{Path, PathBuf};

/// Where a file or folder is that `by` names: the first place at which there is one, else as it is named.
pub fn named_file(by: &Path, name: &str) -> PathBuf {
    let folder = by.parent().unwrap_or_else(|| Path::new(""));
    let plain = name.replace('\\', "/");
    let mut places = vec![folder.join(name), folder.join(&plain)];
    // The folders of another machine are not here.
    let is_elsewhere = plain.starts_with('/') || plain.get(1..3) == Some(":/");
    if let Some(last) = Path::new(&plain).file_name().filter(|_| is_elsewhere) {
        places.push(folder.join(last));
    }
    let found = places.iter().position(|place| place.exists());
    places.swap_remove(found.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn files_are_found_as_windows_and_other_machines_name_them() {
        let folder = tempfile::tempdir().unwrap();
        let (roads, scenarios) = (folder.path().join("roads"), folder.path().join("scenarios"));
        std::fs::create_dir_all(&roads).unwrap();
        std::fs::create_dir_all(&scenarios).unwrap();
        std::fs::write(roads.join("a.xodr"), "").unwrap();
        std::fs::write(scenarios.join("b.xodr"), "").unwrap();
        let by = scenarios.join("x.xosc");
        for name in ["../roads/a.xodr", r"..\roads\a.xodr", r".\..\roads/a.xodr"] {
            assert!(named_file(&by, name).is_file(), "{name}");
        }
        for name in [
            "b.xodr",
            r"C:\maps\b.xodr",
            "/home/somebody/maps/b.xodr",
            "C:/b.xodr",
        ] {
            assert_eq!(named_file(&by, name), scenarios.join("b.xodr"), "{name}");
        }
        // What is nowhere is called as it was named; a file of the same name elsewhere is another one.
        assert_eq!(named_file(&by, r"..\c.xodr"), scenarios.join(r"..\c.xodr"));
        assert!(!named_file(&by, "maps/b.xodr").exists());
    }
}
