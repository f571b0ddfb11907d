//! Reading a file takes a few times its size at most.

use super::{MEMORY, alone};
use crate::support::recorded::shared;
use std::path::Path;

use nearmiss::formats::commonroad::read;

/// The most memory in use while `bytes` are read, themselves included, in parts of their size.
fn peak(bytes: &[u8]) -> f64 {
    let before = MEMORY.current_usage() - bytes.len();
    MEMORY.reset_peak_usage();
    let scenario = read(bytes, "memory").unwrap();
    assert!(!scenario.obstacles.is_empty());
    (MEMORY.peak_usage() - before) as f64 / bytes.len() as f64
}

fn check(folder: &Path) {
    let files = std::fs::read_dir(folder).unwrap().flatten();
    for file in files.filter(|e| e.path().extension().is_some_and(|x| x == "xml")) {
        let bytes = std::fs::read(file.path()).unwrap();
        let times = peak(&bytes);
        let name = file.file_name();
        println!("{name:?}: {times:.2} times its {} bytes", bytes.len());
        assert!(times < 4.0, "{name:?}: {times:.2}");
    }
}

// One test, as two at once would measure each other.
#[test]
fn a_scenario_takes_at_most_four_times_its_file() {
    let _turn = alone();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    check(&root.join("scenarios"));
    let Some(published) = shared("from-words-to-collisions/Scenarios") else {
        return;
    };
    for folder in std::fs::read_dir(published).unwrap().flatten() {
        check(&folder.path());
    }
}
