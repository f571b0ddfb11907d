//! Archives that depend on nothing but the files in them: no users, no order of a file system, one time for all.

use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use tar::{EntryType, Header};

/// A file of an archive.
pub struct Packed {
    /// Where it is unpacked, relative.
    pub path: String,
    /// What is in it.
    pub bytes: Vec<u8>,
    /// Who may read it and run it.
    pub mode: u32,
}

impl Packed {
    /// A file that everyone may read.
    pub fn file(path: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self {
            path: path.into(),
            bytes: bytes.into(),
            mode: 0o644,
        }
    }

    /// A file that everyone may run.
    pub fn program(path: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self {
            mode: 0o755,
            ..Self::file(path, bytes)
        }
    }
}

/// Files with their folders as `.tar.gz`, all of one time, in seconds since 1970.
///
/// # Errors
/// A path is too long.
pub fn tar_gz(files: &[Packed], time: u64) -> io::Result<Vec<u8>> {
    let mut archive = tar::Builder::new(gzip_encoder());
    let mut folders = BTreeSet::new();
    for file in files {
        let above = Path::new(&file.path).ancestors().skip(1);
        let above: Vec<_> = above.filter(|folder| *folder != Path::new("")).collect();
        for folder in above.into_iter().rev() {
            if folders.insert(folder) {
                let mut header = header(EntryType::Directory, 0o755, time);
                archive.append_data(&mut header, folder, io::empty())?;
            }
        }
        let mut header = header(EntryType::Regular, file.mode, time);
        header.set_size(file.bytes.len() as u64);
        archive.append_data(&mut header, &file.path, &file.bytes[..])?;
    }
    archive.into_inner()?.finish()
}

fn header(kind: EntryType, mode: u32, time: u64) -> Header {
    let mut header = Header::new_gnu();
    header.set_entry_type(kind);
    header.set_mode(mode);
    header.set_mtime(time);
    header.set_uid(0);
    header.set_gid(0);
    header.set_size(0);
    header
}

/// A file as `.gz`.
///
/// # Errors
/// None, as memory is written.
pub fn gzip(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = gzip_encoder();
    encoder.write_all(bytes)?;
    encoder.finish()
}

/// Without a name and a time in its header.
fn gzip_encoder() -> GzEncoder<Vec<u8>> {
    GzEncoder::new(Vec::new(), Compression::best())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn an_archive_has_folders_before_files_and_the_same_bytes_each_time() {
        let files = [
            Packed::program("usr/bin/nearmiss", "program"),
            Packed::file("usr/share/doc/nearmiss/README.md", "text"),
        ];
        let packed = tar_gz(&files, 1_700_000_000).unwrap();
        assert_eq!(packed, tar_gz(&files, 1_700_000_000).unwrap());
        let mut archive = tar::Archive::new(flate2::read::GzDecoder::new(&packed[..]));
        let entries = archive.entries().unwrap().map(|entry| {
            let entry = entry.unwrap();
            let path = entry.path().unwrap().display().to_string();
            assert_eq!(entry.header().mtime().unwrap(), 1_700_000_000);
            (path, entry.header().mode().unwrap())
        });
        let expected = [
            ("usr", 0o755),
            ("usr/bin", 0o755),
            ("usr/bin/nearmiss", 0o755),
            ("usr/share", 0o755),
            ("usr/share/doc", 0o755),
            ("usr/share/doc/nearmiss", 0o755),
            ("usr/share/doc/nearmiss/README.md", 0o644),
        ];
        let expected = expected.map(|(path, mode)| (path.to_owned(), mode));
        assert_eq!(entries.collect::<Vec<_>>(), expected);
    }
}
