//! Files that users name: regular ones, and no larger than anything here needs.

use std::fs::{File, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// No recording of traffic that could be worked with is larger, bytes.
pub const LARGEST: u64 = 1 << 30;

/// No text that a person writes for this program is larger (templates, themes, drafts), bytes.
pub const LARGEST_TEXT: u64 = 1 << 20;

/// Opens a file for reading; see [`words`](super::words()) for its errors.
///
/// # Errors
/// What the system says; or it is a folder, or a pipe, device or socket, where reading could wait or go on for ever.
pub fn open_file(path: &Path) -> Result<File> {
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
pub fn check_file(path: &Path) -> Result<()> {
    check(&path.metadata()?)?;
    super::opened_files::note(path);
    Ok(())
}

fn check(found: &Metadata) -> Result<()> {
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
fn opened(path: &Path) -> Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    let flags = rustix::fs::OFlags::NONBLOCK.bits().cast_signed();
    File::options().read(true).custom_flags(flags).open(path)
}

#[cfg(not(unix))]
fn opened(path: &Path) -> Result<File> {
    File::open(path)
}

/// What is in a file of up to `most` bytes.
///
/// # Errors
/// Those of [`open_file`]; or the file is larger, of which no more than that is read.
pub fn read_file(path: &Path, most: u64) -> Result<Vec<u8>> {
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
pub fn read_text(path: &Path, most: u64) -> Result<String> {
    super::text_of(read_file(path, most)?).map_err(|why| Error::new(ErrorKind::InvalidData, why))
}

fn mebibytes(bytes: u64) -> String {
    format!("{} MiB, too large to read", bytes >> 20)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::words;
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let error = |most| words(&read_file(&path, most).unwrap_err());
        assert_eq!(error(1), "no such file or folder");
        std::fs::write(&path, vec![b'a'; 1 << 20]).unwrap();
        assert_eq!(read_file(&path, 1 << 20).unwrap().len(), 1 << 20);
        std::fs::write(&path, vec![b'a'; 1 + (1 << 20)]).unwrap();
        assert!(error(1 << 20).contains("larger than 1 MiB"));
        // Sparse, so that it costs no room.
        File::create(&path).unwrap().set_len(10 << 30).unwrap();
        assert!(error(LARGEST).contains("larger than 1024 MiB"));
        let error = read_file(folder.path(), 1).unwrap_err();
        assert!(words(&error).contains("folder"));
    }

    /// Of `/proc/PID/maps` and the like nobody knows how long they are.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_has_no_size_is_read_in_bounds() {
        let mapped = Path::new("/proc/self/smaps");
        assert_eq!(mapped.metadata().unwrap().len(), 0);
        let read = |most| read_file(mapped, most).map(|bytes| bytes.len() as u64);
        let error = words(&read(100).unwrap_err());
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
        let error = words(&read_text(&path, LARGEST_TEXT).unwrap_err());
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
            let error = words(&read_file(&path(irregular), 1).unwrap_err());
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
}
