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

/// A draft of a template as this instance of the program keeps it.
#[derive(Debug)]
pub struct KeptDraft {
    path: PathBuf,
    /// What this instance read or wrote there.
    text: Option<String>,
}

impl KeptDraft {
    /// Of the template in a file; `found` is what was there at the start.
    #[must_use]
    pub fn new(folder: &Path, file: &str, found: Option<String>) -> Self {
        let path = folder.join(file);
        Self { path, text: found }
    }

    /// Writes a draft, or removes it where there is none any more. What another instance wrote there since stays: this
    /// draft goes to a file beside it from now on, which is returned then.
    ///
    /// # Errors
    /// It cannot be written: the file and why.
    pub fn keep(&mut self, draft: Option<&str>) -> Result<Option<&Path>, String> {
        // No other instance writes between reading and writing, where folders can be locked.
        let parent = self.path.parent();
        let folder = parent.and_then(|folder| std::fs::File::open(folder).ok());
        let _locked = folder.as_ref().map(std::fs::File::lock);
        let there = std::fs::read(&self.path).ok();
        let is = |text: Option<&str>| there.as_deref() == text.map(str::as_bytes);
        let is_foreign = there.is_some() && !is(self.text.as_deref()) && !is(draft);
        if is_foreign && draft.is_some() {
            self.path = beside(&self.path);
        }
        let kept = match draft {
            Some(text) => Folders::write(&self.path, text),
            None if is_foreign => Ok(()),
            None => remove(&self.path),
        };
        let why = |error| format!("{}: {}", self.path.display(), system::error_text(&error));
        kept.map_err(why)?;
        self.text = draft.map(Into::into);
        Ok((is_foreign && draft.is_some()).then_some(&self.path))
    }
}

/// A file beside another one that is not there yet: `a.md.2`.
#[must_use]
pub fn beside(path: &Path) -> PathBuf {
    let numbered = |number: u32| {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".{number}"));
        PathBuf::from(name)
    };
    let mut all = (2..).map(numbered);
    all.find(|path| !path.exists()).unwrap_or_default()
}

fn remove(path: &Path) -> std::io::Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Drafts that another instance of the program kept beside another one; where that is gone, they take its place.
pub fn second_drafts(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    let is_number = |path: &Path| {
        let end = path.extension().and_then(|end| end.to_str());
        end.is_some_and(|end| end.parse::<u32>().is_ok())
    };
    found.retain(|path| {
        is_number(path) && path.with_extension("").extension() == Some("md".as_ref())
    });
    found.sort();
    let takes_place = |path: &PathBuf| {
        let first = path.with_extension("");
        !first.exists() && std::fs::rename(path, first).is_ok()
    };
    found.retain(|path| !takes_place(path));
    found
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
    fn two_instances_lose_no_draft() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let read = |name: &str| std::fs::read_to_string(at.join(name)).ok();
        std::fs::write(at.join("a.md"), "old").unwrap();
        let start = || KeptDraft::new(at, "a.md", Some("old".into()));
        let (mut one, mut two) = (start(), start());
        assert_eq!(one.keep(Some("one")), Ok(None));
        let second = at.join("a.md.2");
        assert_eq!(two.keep(Some("two")), Ok(Some(second.as_path())));
        // Each goes on in its own file, and is told once.
        assert_eq!(one.keep(Some("one more")), Ok(None));
        assert_eq!(two.keep(Some("two more")), Ok(None));
        assert_eq!(read("a.md").unwrap(), "one more");
        assert_eq!(read("a.md.2").unwrap(), "two more");
        // An instance without a draft removes none of others.
        assert_eq!(start().keep(None), Ok(None));
        assert_eq!(KeptDraft::new(at, "a.md", None).keep(None), Ok(None));
        assert_eq!(read("a.md").unwrap(), "one more");
        let third = at.join("a.md.3");
        assert_eq!(start().keep(Some("three")), Ok(Some(third.as_path())));
        assert_eq!(second_drafts(at), [second.clone(), third.clone()]);
        // The first is saved as a template: the next start has the second.
        assert_eq!(one.keep(None), Ok(None));
        assert_eq!(second_drafts(at), [third]);
        assert_eq!(read("a.md").unwrap(), "two more");
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
