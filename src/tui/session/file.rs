//! Files that outlive a session: the session itself, and drafts of templates.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use nearmiss_base::system;
use nearmiss_settings::{Folders, TextFile};

use super::{SavedLocation, Session};

/// Number of sessions kept: the most recently used ones.
const MAX_SESSIONS: usize = 100;

/// Writes the file of a session; the oldest files beyond the limit go.
///
/// # Errors
/// Its file cannot be written: which, and why.
pub fn write(folder: &Path, session: &Session) -> Result<(), String> {
    let path = folder.join(Session::file_name(&session.paths));
    let new = !path.exists();
    let text = session
        .text()
        .map_err(|error| format!("{}: {error}", path.display()))?;
    Folders::write(&path, &text)
        .map_err(|error| format!("{}: {}", path.display(), system::error_text(&error)))?;
    if new {
        forget_oldest(folder);
    }
    Ok(())
}

/// Session files that were not used for the longest time go. One that cannot be removed stays.
fn forget_oldest(folder: &Path) {
    let mut files = files(folder);
    files.sort_by_key(|(time, _)| std::cmp::Reverse(*time));
    for (_, path) in files.into_iter().skip(MAX_SESSIONS) {
        let _ = std::fs::remove_file(path);
    }
}

fn files(folder: &Path) -> Vec<(SystemTime, PathBuf)> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    let ours = paths.filter(|path| path.extension().is_some_and(|end| end == "json"));
    ours.filter_map(|path| Some((path.metadata().ok()?.modified().ok()?, path)))
        .collect()
}

/// Whether there is a session of any paths.
#[must_use]
pub fn any(folder: &Path) -> bool {
    !files(folder).is_empty()
}

/// The last session of these paths, if there is one.
///
/// # Errors
/// Its file cannot be used: which, and why.
pub fn read(folder: &Path, paths: &[SavedLocation]) -> Result<Option<Session>, String> {
    let path = folder.join(Session::file_name(paths));
    let Some(said) = TextFile::read_if_there(&path)? else {
        return Ok(None);
    };
    let session = Session::parse(&said.text, paths);
    session
        .map(Some)
        .map_err(|error| format!("{}: {error}", said.file))
}

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
pub fn read_drafts(folder: &Path) -> Vec<(String, Result<String, String>)> {
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
    use std::time::Duration;

    use super::*;
    use crate::model::Model;
    use crate::theme::Theme;
    use nearmiss_ask::prompts::Library;
    use nearmiss_settings::Config;

    fn session(paths: &[PathBuf]) -> Session {
        let model = Model::new(
            paths.to_vec(),
            Config::default(),
            Theme::default_theme(),
            Library::load(None),
            Vec::new(),
        );
        let mut session = crate::session::restore::capture(&model);
        session.paths = SavedLocation::of_arguments(paths, Path::new("/"));
        session
    }

    #[test]
    fn every_set_of_paths_has_a_session_of_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let sessions = folder.path().join("sessions");
        assert!(!any(&sessions));
        let (one, two) = (folder.path().join("one"), folder.path().join("two"));
        std::fs::create_dir_all(&one).unwrap();
        std::fs::create_dir_all(&two).unwrap();
        let both = [one.clone(), two.clone()];
        let mut kept = session(&both);
        kept.filter = "brem".into();
        write(&sessions, &kept).unwrap();
        assert!(any(&sessions));
        let of = |paths: &[PathBuf]| {
            read(
                &sessions,
                &SavedLocation::of_arguments(paths, Path::new("/")),
            )
            .unwrap()
        };
        assert_eq!(of(&both).as_ref(), Some(&kept));
        let turned = [two.join("../two"), one.clone(), one.clone()];
        assert_eq!(
            of(&turned).as_ref(),
            Some(&kept),
            "the same, said otherwise"
        );
        for other in [&[][..], &[one][..], &[two][..]] {
            assert_eq!(of(other), None);
        }
        write(&sessions, &session(&[])).unwrap();
        assert_eq!(of(&[]), Some(session(&[])));
        assert_eq!(of(&both), Some(kept));
    }

    #[test]
    fn a_file_that_cannot_be_used_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bundled.json");
        let good = session(&[]).text().unwrap();
        for (text, why) in [
            ("", "damaged"),
            (&good[..good.len() / 2], "damaged"),
            ("[1, 2]", "another version"),
            (
                &good.replace("\"version\": 1", "\"version\": 7"),
                "another version",
            ),
            (
                &good.replace("\"zoomed\": false", "\"zoomed\": 3"),
                "damaged",
            ),
            (&good.replace("\"zoomed\"", "\"unknown\""), "damaged"),
            (
                &good.replace("\"paths\": []", "\"paths\": [{\"bundled\": \"A\"}]"),
                "other scenarios",
            ),
        ] {
            assert_ne!(text, good);
            std::fs::write(&path, text).unwrap();
            let error = read(folder.path(), &[]).unwrap_err();
            assert!(
                error.contains("bundled.json: ") && error.contains(why),
                "{error}"
            );
        }
        std::fs::write(&path, &good).unwrap();
        assert_eq!(read(folder.path(), &[]), Ok(Some(session(&[]))));
    }

    #[test]
    fn only_so_many_are_kept() {
        let folder = tempfile::tempdir().unwrap();
        for i in 0..MAX_SESSIONS + 5 {
            let path = folder.path().join(format!("{i:03}.json"));
            let file = std::fs::File::create(&path).unwrap();
            let time = SystemTime::UNIX_EPOCH + Duration::from_secs(i as u64);
            file.set_modified(time).unwrap();
        }
        write(folder.path(), &session(&[])).unwrap();
        assert_eq!(files(folder.path()).len(), MAX_SESSIONS);
        let there = |name: &str| folder.path().join(name).exists();
        assert!(there("bundled.json") && there("104.json") && !there("005.json"));
    }

    #[test]
    fn a_draft_that_cannot_be_read_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("a.md"), "as it was").unwrap();
        std::fs::create_dir(path("b.md")).unwrap();
        std::fs::write(path("c.md"), vec![b'a'; 1 + (1 << 20)]).unwrap();
        std::fs::write(path("d.txt"), "something else").unwrap();
        let mut found = read_drafts(folder.path());
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
