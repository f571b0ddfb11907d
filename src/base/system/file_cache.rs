//! What was read of files, kept as long as they stay as they are and there is room.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

/// A file that changed this shortly before it was read may change again within a tick of the file system's clock.
const TICK: Duration = Duration::from_secs(1);

/// A file as it was: its size and when it changed; `None` where it was not there.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Stamp {
    path: PathBuf,
    state: Option<(u64, Option<SystemTime>)>,
}

impl Stamp {
    fn read(path: &Path) -> Self {
        let found = path.metadata().ok();
        Self {
            path: path.to_path_buf(),
            state: found.map(|found| (found.len(), found.modified().ok())),
        }
    }

    /// Whether a change from now on would be seen in it.
    fn is_settled(&self) -> bool {
        match self.state {
            Some((_, Some(changed))) => changed.elapsed().is_ok_and(|since| since >= TICK),
            Some((_, None)) => false,
            None => true,
        }
    }
}

/// What is read of some files, by one thread at a time.
type Slot<T> = Arc<Mutex<Option<Arc<T>>>>;

#[derive(Debug)]
struct CacheEntry<T> {
    files: Vec<Stamp>,
    slot: Slot<T>,
    /// Bytes; 0 while it is read.
    size: usize,
}

/// Keeps what was read of files. Threads that want the same wait for the first one.
#[derive(Debug)]
pub struct FileCache<T> {
    /// The one used last is at the end.
    kept: Mutex<Vec<CacheEntry<T>>>,
    most: usize,
}

impl<T> FileCache<T> {
    /// Keeps up to so many bytes; what was not used for longest goes first.
    #[must_use]
    pub const fn new(most: usize) -> Self {
        Self {
            kept: Mutex::new(Vec::new()),
            most,
        }
    }

    /// What `read` gives of these files, with its size in bytes, or gave when they were the same.
    ///
    /// # Errors
    /// Those of `read`, which are not kept.
    pub fn get<E>(
        &self,
        files: &[&Path],
        read: impl FnOnce() -> Result<(T, usize), E>,
    ) -> Result<Arc<T>, E> {
        files.iter().for_each(|path| super::read_file::note(path));
        let files: Vec<Stamp> = files.iter().map(|path| Stamp::read(path)).collect();
        let settled = files.iter().all(Stamp::is_settled);
        let slot = self.slot(files);
        let mut value = slot.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(value) = &*value {
            return Ok(Arc::clone(value));
        }
        let found = read().map(|(found, size)| (Arc::new(found), size));
        if let Ok((found, _)) = &found {
            *value = Some(Arc::clone(found));
        }
        drop(value);
        match &found {
            Ok((_, size)) if settled && *size <= self.most => self.make_room(&slot, *size),
            _ => self.list().retain(|kept| !Arc::ptr_eq(&kept.slot, &slot)),
        }
        found.map(|(found, _)| found)
    }

    fn list(&self) -> MutexGuard<'_, Vec<CacheEntry<T>>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The slot of these files, used last from now on.
    fn slot(&self, files: Vec<Stamp>) -> Slot<T> {
        let mut list = self.list();
        let same = list.iter().position(|kept| kept.files == files);
        let kept = match same {
            Some(place) => list.remove(place),
            None => {
                // What they were before is of no more use.
                let paths = |stamps: &[Stamp]| -> Vec<PathBuf> {
                    stamps.iter().map(|stamp| stamp.path.clone()).collect()
                };
                let now = paths(&files);
                list.retain(|kept| paths(&kept.files) != now);
                CacheEntry {
                    files,
                    slot: Arc::default(),
                    size: 0,
                }
            }
        };
        let slot = Arc::clone(&kept.slot);
        list.push(kept);
        slot
    }

    fn make_room(&self, slot: &Slot<T>, size: usize) {
        let mut list = self.list();
        if let Some(kept) = list.iter_mut().find(|kept| Arc::ptr_eq(&kept.slot, slot)) {
            kept.size = size;
        }
        while list.iter().map(|kept| kept.size).sum::<usize>() > self.most {
            let oldest = list
                .iter()
                .position(|kept| kept.size > 0 && !Arc::ptr_eq(&kept.slot, slot));
            let Some(oldest) = oldest else { break };
            list.remove(oldest);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::fs::{File, write};
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// Writes a file that changed so many seconds ago.
    fn file(folder: &Path, name: &str, text: &str, ago: u64) -> PathBuf {
        let path = folder.join(name);
        write(&path, text).unwrap();
        let changed = SystemTime::now() - Duration::from_secs(ago);
        let opened = File::options().write(true).open(&path).unwrap();
        opened.set_modified(changed).unwrap();
        path
    }

    /// What of a file is kept, and whether it was read now.
    fn get(cache: &FileCache<String>, path: &Path, size: usize) -> (String, bool) {
        let mut read = false;
        let found = cache.get(&[path], || {
            read = true;
            Ok::<_, ()>((std::fs::read_to_string(path).unwrap(), size))
        });
        (found.unwrap().to_string(), read)
    }

    #[test]
    fn a_file_is_read_again_when_it_changes() {
        let folder = tempfile::tempdir().unwrap();
        let cache = FileCache::new(100);
        let path = file(folder.path(), "a", "one", 20);
        assert_eq!(get(&cache, &path, 10), ("one".into(), true));
        assert_eq!(get(&cache, &path, 10), ("one".into(), false));
        file(folder.path(), "a", "two", 10);
        assert_eq!(get(&cache, &path, 10), ("two".into(), true));
        assert_eq!(get(&cache, &path, 10), ("two".into(), false));
        // Just changed: it may do so again, unseen.
        file(folder.path(), "a", "six", 0);
        assert_eq!(get(&cache, &path, 10), ("six".into(), true));
        assert_eq!(get(&cache, &path, 10), ("six".into(), true));
    }

    #[test]
    fn there_is_a_bound() {
        let folder = tempfile::tempdir().unwrap();
        let cache = FileCache::new(100);
        let [a, b, c] = ["a", "b", "c"].map(|name| file(folder.path(), name, name, 20));
        let read = |path: &Path, size| get(&cache, path, size).1;
        assert!(read(&a, 40) && read(&b, 40) && !read(&a, 40));
        // The one used least lately makes room.
        assert!(read(&c, 40) && !read(&a, 40) && read(&b, 40));
        let large = file(folder.path(), "large", "large", 20);
        assert!(read(&large, 101) && read(&large, 101));
    }

    #[test]
    fn errors_are_not_kept_and_threads_share_a_reading() {
        let folder = tempfile::tempdir().unwrap();
        let cache = FileCache::new(100);
        let path = file(folder.path(), "a", "one", 20);
        let failed = cache.get(&[&path], || Err::<(String, usize), _>("no"));
        assert_eq!(failed.unwrap_err(), "no");
        let reads = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    let read = || {
                        reads.fetch_add(1, Ordering::Relaxed);
                        std::thread::sleep(Duration::from_millis(20));
                        Ok::<_, ()>(("one".to_string(), 3))
                    };
                    assert_eq!(*cache.get(&[&path], read).unwrap(), "one");
                });
            }
        });
        assert_eq!(reads.load(Ordering::Relaxed), 1);
    }
}
