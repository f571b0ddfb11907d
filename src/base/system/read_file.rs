//! Files that users name: regular ones, no larger than anything here needs, as text, and kept while they stay as they are.

use std::cell::RefCell;
use std::fs::{File, Metadata};
use std::io::{self, Error, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

/// No recording of traffic that could be worked with is larger, bytes.
pub const LARGEST: u64 = 1 << 30;

/// No text that a person writes for this program is larger (templates, themes, drafts), bytes.
pub const LARGEST_TEXT: u64 = 1 << 20;

/// Opens a file for reading; see [`words`](super::error_text()) for its errors.
///
/// # Errors
/// What the system says; or it is a folder, or a pipe, device or socket, where reading could wait or go on for ever.
pub fn open_file(path: &Path) -> io::Result<File> {
    check_file(path)?;
    let file = opened(path)?;
    // It may be another one by now.
    check(&file.metadata()?)?;
    Ok(file)
}

/// Whether a file can be opened for reading without waiting, for readers that open it by themselves.
///
/// # Errors
/// Those of [`open_file`].
pub fn check_file(path: &Path) -> io::Result<()> {
    check(&path.metadata()?)?;
    note(path);
    Ok(())
}

fn check(found: &Metadata) -> io::Result<()> {
    if found.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    if !found.is_file() {
        return Err(Error::other(
            "a pipe, device or socket, not a regular file; save its data to a file first",
        ));
    }
    Ok(())
}

/// A pipe that took the place of a file is opened without waiting for who writes into it.
#[cfg(unix)]
fn opened(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let flags = rustix::fs::OFlags::NONBLOCK.bits().cast_signed();
    File::options().read(true).custom_flags(flags).open(path)
}

#[cfg(not(unix))]
fn opened(path: &Path) -> io::Result<File> {
    File::open(path)
}

/// What is in a file of up to `most` bytes.
///
/// # Errors
/// Those of [`open_file`]; or the file is larger, of which no more than that is read.
pub fn read_file(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open_file(path)?;
    let size = file.metadata()?.len();
    // What has no size is empty, or made by the system while it is read, of any length.
    let most = match size {
        0 => most.min(LARGEST_TEXT),
        _ => most,
    };
    let too_large = || Error::other(format!("the file is larger than {}", mebibytes(most)));
    if size > most {
        return Err(too_large());
    }
    let mut bytes = Vec::with_capacity(usize::try_from(size).unwrap_or_default());
    // It may have grown.
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(too_large());
    }
    Ok(bytes)
}

/// The text in a file of up to `most` bytes.
///
/// # Errors
/// Those of [`read_file`]; or those of [`text_of`](super::text_of).
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    super::text_of(read_file(path, most)?).map_err(|why| Error::new(ErrorKind::InvalidData, why))
}

fn mebibytes(bytes: u64) -> String {
    format!("{} MiB, too large to read", bytes >> 20)
}

/// A byte order mark in UTF-8, which some editors write in front of a text.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// The text in `bytes`, without the byte order marks that it may begin with.
///
/// # Errors
/// What it is instead, with the line of the first byte that is no text.
pub fn text_of(bytes: Vec<u8>) -> Result<String, String> {
    let mut marks = 0;
    while bytes[marks..].starts_with(MARK) {
        marks += MARK.len();
    }
    let rest = &bytes[marks..];
    let wide = match rest {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Some("UTF-32"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("UTF-16"),
        _ => None,
    };
    if let Some(wide) = wide {
        return Err(format!("the file is {wide}; save it as UTF-8"));
    }
    let line = |at: usize| 1 + rest[..at].iter().filter(|b| **b == b'\n').count();
    if let Some(at) = rest.iter().position(|b| *b == 0) {
        return Err(format!(
            "line {}: a zero byte; not a text file, or not UTF-8: save it as UTF-8",
            line(at)
        ));
    }
    if let Err(error) = std::str::from_utf8(rest) {
        let at = error.valid_up_to();
        return Err(format!(
            "line {}: not UTF-8 text (byte 0x{:02x}); save the file as UTF-8",
            line(at),
            rest[at]
        ));
    }
    let mut text = String::from_utf8(bytes).map_err(|error| error.to_string())?;
    text.drain(..marks);
    Ok(text)
}

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
fn note(path: &Path) {
    OPENED.with_borrow_mut(|opened| {
        if let Some(opened) = opened {
            opened.push(path.to_path_buf());
        }
    });
}

/// Whether a folder is one of them, such as `/proc` and what is in it.
#[cfg(target_os = "linux")]
#[must_use]
pub fn is_of_kernel(folder: &Path) -> bool {
    // statfs(2): procfs, sysfs, both kinds of cgroups, debugfs and tracefs.
    const MAGIC: [u64; 6] = [
        0x9fa0,
        0x6265_6572,
        0x27_e0eb,
        0x6367_7270,
        0x6462_6720,
        0x7472_6163,
    ];
    let kind = rustix::fs::statfs(folder).map(|found| found.f_type);
    kind.is_ok_and(|kind| u64::try_from(kind).is_ok_and(|kind| MAGIC.contains(&kind)))
}

/// Elsewhere there is none.
#[cfg(not(target_os = "linux"))]
#[must_use]
pub fn is_of_kernel(_: &Path) -> bool {
    false
}

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
        files.iter().for_each(|path| note(path));
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

    use std::fs::write;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::super::{FileCache, error_text, read_file};
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let error = |most| error_text(&read_file(&path, most).unwrap_err());
        assert_eq!(error(1), "no such file or folder");
        std::fs::write(&path, vec![b'a'; 1 << 20]).unwrap();
        assert_eq!(read_file(&path, 1 << 20).unwrap().len(), 1 << 20);
        std::fs::write(&path, vec![b'a'; 1 + (1 << 20)]).unwrap();
        assert!(error(1 << 20).contains("larger than 1 MiB"));
        // Sparse, so that it costs no room.
        File::create(&path).unwrap().set_len(10 << 30).unwrap();
        assert!(error(LARGEST).contains("larger than 1024 MiB"));
        let error = read_file(folder.path(), 1).unwrap_err();
        assert!(error_text(&error).contains("folder"));
    }

    /// The length of `/proc/PID/maps` and the like is unknown.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_has_no_size_is_read_in_bounds() {
        let mapped = Path::new("/proc/self/smaps");
        assert_eq!(mapped.metadata().unwrap().len(), 0);
        let read = |most| read_file(mapped, most).map(|bytes| bytes.len() as u64);
        let error = error_text(&read(100).unwrap_err());
        assert!(error.contains("larger than"), "{error}");
        assert!(read(LARGEST).is_ok_and(|length| length <= LARGEST_TEXT));
    }

    #[test]
    fn text_is_utf_8() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, "µ").unwrap();
        assert_eq!(read_text(&path, LARGEST_TEXT).unwrap(), "µ");
        std::fs::write(&path, [b'a', 0xb5]).unwrap();
        let error = error_text(&read_text(&path, LARGEST_TEXT).unwrap_err());
        assert!(error.contains("UTF-8"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn what_could_wait_for_ever_is_not_opened() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let made = std::process::Command::new("mkfifo")
            .arg(path("pipe"))
            .status();
        assert!(made.unwrap().success());
        let _socket = std::os::unix::net::UnixListener::bind(path("socket")).unwrap();
        for (link, target) in [("gone", "nothing"), ("loop", "loop"), ("to-pipe", "pipe")] {
            std::os::unix::fs::symlink(target, path(link)).unwrap();
        }
        for (irregular, why) in [
            ("/dev/zero", "not a regular file"),
            ("/dev/tty", "not a regular file"),
            ("pipe", "not a regular file"),
            ("to-pipe", "not a regular file"),
            ("socket", "not a regular file"),
            ("gone", "no such file"),
            ("loop", "symbolic links"),
        ] {
            let error = error_text(&read_file(&path(irregular), 1).unwrap_err());
            assert!(error.contains(why), "{irregular}: {error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_in_the_place_of_a_file_is_not_waited_for() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        // As between the look and the opening; this would never come back otherwise.
        let file = opened(&pipe).unwrap();
        assert!(check(&file.metadata().unwrap()).is_err());
    }

    #[test]
    fn marks_are_passed_over_and_other_encodings_named() {
        for marks in 0..4 {
            let text = format!("{}a = \"µ\"\n", "\u{feff}".repeat(marks));
            assert_eq!(text_of(text.into_bytes()).unwrap(), "a = \"µ\"\n");
        }
        assert_eq!(text_of(Vec::new()).unwrap(), "");
        // Elsewhere a mark is a character like others.
        assert_eq!(text_of("a\u{feff}".into()).unwrap(), "a\u{feff}");
        let wide = |text: &str, unit: fn(u16) -> [u8; 2]| -> Vec<u8> {
            text.encode_utf16().flat_map(unit).collect()
        };
        for (bytes, words) in [
            (wide("\u{feff}a", u16::to_le_bytes), "UTF-16; save"),
            (wide("\u{feff}a", u16::to_be_bytes), "UTF-16; save"),
            (wide("a\nb", u16::to_le_bytes), "line 1: a zero byte"),
            (wide("a\nb", u16::to_be_bytes), "line 1: a zero byte"),
            (b"\xff\xfe\0\0a\0\0\0".to_vec(), "UTF-32"),
            (b"a\nb\n\0".to_vec(), "line 3: a zero byte"),
            (b"a\ncaf\xe9".to_vec(), "line 2: not UTF-8 text (byte 0xe9"),
        ] {
            let said = text_of(bytes).unwrap_err();
            assert!(said.contains(words), "{said}");
        }
    }

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
