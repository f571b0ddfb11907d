//! All readers of recordings through one entry: a kind, and its files one after the other. The fuzz target `recording`
//! has no other.

use std::path::{Path, PathBuf};

use nearmiss::formats::Entry;
use nearmiss::formats::commonroad::{read, write};
use nearmiss::workflow::find;

/// The files of each kind; the first one is opened.
pub const KINDS: &[&[&str]] = &[
    &["x.tfrecord"],
    &["scenario_x.parquet", "log_map_archive_x.json"],
    &["01_tracks.csv", "01_tracksMeta.csv", "01_recordingMeta.csv"],
    &[
        "07_tracks.csv",
        "07_tracksMeta.csv",
        "07_recordingMeta.csv",
        "07.osm",
    ],
    &["fcd.xml", "cross.net.xml", "cross.rou.xml"],
    &["x.xosc", "x.xodr", "x.csv"],
    &["x.xodr"],
    &["x.db", "map.gpkg"],
];

/// What is between two files.
const BETWEEN: &[u8] = b"\n--next file--\n";

/// Parts of a file that are opened at most.
const PARTS: usize = 4;

/// A kind with its files, as [`open`] takes them.
#[allow(dead_code)]
pub fn packed(kind: u8, files: &[Vec<u8>]) -> Vec<u8> {
    [vec![kind], files.join(BETWEEN)].concat()
}

/// Opens what is packed, as a search finds it; how many scenarios there are. Each one that is read is written as
/// CommonRoad and read again.
pub fn open(bytes: &[u8]) -> usize {
    let (kind, mut rest) = bytes.split_first().unwrap_or((&0, &[]));
    let names = KINDS[usize::from(*kind) % KINDS.len()];
    let folder = tempfile::tempdir().expect("a folder");
    for (i, name) in names.iter().enumerate() {
        let next = rest.windows(BETWEEN.len()).position(|w| w == BETWEEN);
        let (file, after) = match next.filter(|_| i + 1 < names.len()) {
            Some(at) => (&rest[..at], Some(&rest[at + BETWEEN.len()..])),
            None => (rest, None),
        };
        std::fs::write(folder.path().join(name), file).expect("written");
        match after {
            Some(after) => rest = after,
            None => break,
        }
    }
    opened(&folder.path().join(names[0]))
}

fn opened(path: &Path) -> usize {
    let mut entries = vec![Entry::of_file(path)];
    let found = find(&[PathBuf::from(path)]);
    entries.extend(found.map(|found| found.entries).unwrap_or_default());
    let mut count = 0;
    for entry in entries.iter().take(PARTS) {
        match entry.read() {
            Err(error) => assert!(!error.message.is_empty()),
            Ok(scenario) => {
                let written = write(&scenario).expect("writing goes to memory");
                let again = read(&written, "written").expect("what was written can be read");
                assert_eq!(scenario.obstacles.len(), again.obstacles.len());
                count += 1;
            }
        }
    }
    count
}
