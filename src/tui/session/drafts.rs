//! Drafts of templates in the editor, kept from one start to the next: a file each.

use std::path::{Path, PathBuf};

use nearmiss_base::system;
use nearmiss_settings::Folders;

/// Writes a draft, or removes it where there is none any more.
///
/// # Errors
/// It cannot be written: the file and why.
pub fn keep(folder: &Path, file: &str, draft: Option<&str>) -> Result<(), String> {
    let path = folder.join(file);
    let kept = match draft {
        Some(text) => Folders::write(&path, text),
        None => remove(&path),
    };
    kept.map_err(|error| format!("{}: {}", path.display(), system::error_text(&error)))
}

fn remove(path: &Path) -> std::io::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Drafts that an earlier session left in the editor, by file; or why they cannot be read.
pub fn read(folder: &Path) -> Vec<(String, Result<String, String>)> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let read = |path: PathBuf| {
        let name = path
            .file_name()?
            .to_str()
            .filter(|n| n.ends_with(".md"))?
            .to_string();
        let text = system::read_text(&path, system::LARGEST_TEXT)
            .map_err(|e| format!("{}: {}", path.display(), system::error_text(&e)));
        Some((name, text))
    };
    entries.filter_map(|e| read(e.path())).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_draft_that_cannot_be_read_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("a.md"), "as it was").unwrap();
        std::fs::create_dir(path("b.md")).unwrap();
        std::fs::write(path("c.md"), vec![b'a'; 1 + (1 << 20)]).unwrap();
        std::fs::write(path("d.txt"), "something else").unwrap();
        let mut found = read(folder.path());
        found.sort();
        assert_eq!(found[0], ("a.md".to_string(), Ok("as it was".to_string())));
        let error = |i: usize| found[i].1.clone().unwrap_err();
        assert!(
            error(1).contains("b.md") && error(1).contains("folder"),
            "{found:?}"
        );
        assert!(error(2).contains("larger than 1 MiB"));
        assert_eq!(found.len(), 3);
    }
}
