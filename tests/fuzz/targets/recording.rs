//! Any bytes as a recording of each data set give scenarios or errors; what is read is written and read back.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nearmiss::formats::commonroad::{read, write};
use nearmiss::formats::Entry;
use nearmiss::workflow::find;

fuzz_target!(|bytes: &[u8]| {
    let folder = tempfile::tempdir().expect("a folder");
    // The contents decide which format it is; the name decides what lies beside it.
    let (which, bytes) = bytes.split_first().unwrap_or((&0, &[]));
    let names = ["x.tfrecord", "scenario_x.parquet", "01_tracks.csv", "fcd.xml"];
    let path = folder.path().join(names[usize::from(*which) % names.len()]);
    std::fs::write(&path, bytes).expect("written");
    let mut entries = vec![Entry::of_file(&path)];
    entries.extend(find(&[path]).map(|found| found.entries).unwrap_or_default());
    for entry in entries.iter().take(4) {
        match entry.read() {
            Err(error) => assert!(!error.message.is_empty()),
            Ok(scenario) => {
                let written = write(&scenario).expect("writing goes to memory");
                let again = read(&written, "written").expect("what was written can be read");
                assert_eq!(scenario.obstacles.len(), again.obstacles.len());
            }
        }
    }
});
