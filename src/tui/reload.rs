//! Reloads theme and keymap files when they change.
//!
//! Polls their times and sizes every four seconds: three or four system calls, cheaper than a watcher thread, and reliable
//! on network file systems too.

use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use nearmiss_settings::{Config, Folders};
use tokio::sync::mpsc::UnboundedSender;

use crate::keymap::{Keymap, first_mistake};
use crate::message::{Msg, Reloaded};
use crate::theme::Theme;

/// Time between two looks.
const PAUSE: Duration = Duration::from_secs(4);

/// How long a file has to stay as it is before it is read: editors write in several steps.
const SETTLED: Duration = Duration::from_millis(50);

/// Looks that a file that does not settle is waited for.
const MAX_SETTLE_CHECKS: usize = 20;

/// When a file was changed, and how long it is; `None` for a file that is not there.
type Stamp = Option<(SystemTime, u64)>;

/// Times and sizes of the files when last read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stamps {
    config: Stamp,
    keymap: Stamp,
    themes: Vec<(PathBuf, Stamp)>,
}

impl Stamps {
    /// Takes them. To be done before the files are read, so that no change is missed.
    #[must_use]
    pub fn read(folders: &Folders) -> Self {
        let files = std::fs::read_dir(folders.themes())
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| entry.path());
        let themes = files.filter(|path| path.extension().is_some_and(|x| x == "toml"));
        let mut themes: Vec<_> = themes.map(|path| (path.clone(), stamp(&path))).collect();
        themes.sort();
        Self {
            config: stamp(&folders.config_file()),
            keymap: stamp(&folders.keymap()),
            themes,
        }
    }
}

fn stamp(path: &Path) -> Stamp {
    let data = std::fs::metadata(path).ok()?;
    Some((data.modified().ok()?, data.len()))
}

/// Sends changes until the receiver is closed.
pub async fn watch(folders: Folders, mut before: Stamps, sender: UnboundedSender<Msg>) {
    loop {
        tokio::time::sleep(PAUSE).await;
        let mut now = Stamps::read(&folders);
        if now == before {
            if sender.is_closed() {
                return;
            }
            continue;
        }
        for _ in 0..MAX_SETTLE_CHECKS {
            tokio::time::sleep(SETTLED).await;
            let after = Stamps::read(&folders);
            if after == now {
                break;
            }
            now = after;
        }
        for what in changed(&folders, &before, &now) {
            if sender.send(Msg::Reloaded(what)).is_err() {
                return;
            }
        }
        before = now;
    }
}

/// Contents of the changed files; themes first, since the configuration may name a new one.
fn changed(folders: &Folders, before: &Stamps, now: &Stamps) -> Vec<Reloaded> {
    let mut found = Vec::new();
    if before.themes != now.themes {
        found.push(Reloaded::Themes(Theme::all(&folders.themes())));
    }
    if before.config != now.config {
        let read = Config::read(&folders.config_file()).map(Box::new);
        found.push(Reloaded::Config(read.map_err(|error| error.in_short())));
    }
    if before.keymap != now.keymap {
        let read = Keymap::load(&folders.keymap());
        found.push(Reloaded::Keymap(
            read.map_err(|mistakes| first_mistake(&mistakes)),
        ));
    }
    found
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn write(path: &Path, text: &str) {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    #[test]
    fn only_what_changed_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let folders = Folders {
            config: folder.path().to_path_buf(),
            data: folder.path().to_path_buf(),
        };
        let start = Stamps::read(&folders);
        assert!(changed(&folders, &start, &Stamps::read(&folders)).is_empty());
        write(&folders.keymap(), "[global]\nplay = \"hyper\"\n");
        let broken = Stamps::read(&folders);
        match &changed(&folders, &start, &broken)[..] {
            [Reloaded::Keymap(Err(error))] => {
                assert!(error.contains("keymap.toml:2: global.play"), "{error}")
            }
            other => panic!("{other:?}"),
        }
        write(&folders.themes().join("mine.toml"), "dark = true\n");
        write(&folders.config_file(), "theme = \"mine\"\nmouse = 3\n");
        match &changed(&folders, &broken, &Stamps::read(&folders))[..] {
            [Reloaded::Themes(themes), Reloaded::Config(Err(error))] => {
                assert!(themes.iter().any(|named| named.name == "mine"));
                assert!(error.contains("config.toml:2: "), "{error}");
            }
            other => panic!("{other:?}"),
        }
    }

    #[tokio::test]
    async fn a_change_is_told_and_no_change_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let folders = Folders {
            config: folder.path().to_path_buf(),
            data: folder.path().to_path_buf(),
        };
        let (sender, mut receiver) = tokio::sync::mpsc::unbounded_channel();
        let stamps = Stamps::read(&folders);
        tokio::spawn(watch(folders.clone(), stamps, sender));
        let quiet = PAUSE * 3 / 2;
        tokio::time::sleep(quiet).await;
        assert!(receiver.try_recv().is_err());
        write(&folders.keymap(), "preset = \"vim\"\n");
        let told = tokio::time::timeout(Duration::from_secs(30), receiver.recv());
        match told.await {
            Ok(Some(Msg::Reloaded(Reloaded::Keymap(Ok(map))))) => {
                assert_eq!(map.preset.name(), "vim")
            }
            other => panic!("{other:?}"),
        }
        tokio::time::sleep(quiet).await;
        assert!(receiver.try_recv().is_err());
    }
}
