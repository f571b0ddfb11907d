//! Any bytes give a scenario or an error; a scenario is written and read back.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nearmiss::formats::commonroad::{conform, read, write};

fuzz_target!(|bytes: &[u8]| {
    match read(bytes, "fuzz") {
        Err(error) => assert!(!error.message.is_empty()),
        Ok(scenario) => {
            let written = write(&scenario).expect("writing goes to memory");
            let again = read(&written, "written").expect("what was written can be read");
            assert_eq!(scenario.network, again.network);
            assert_eq!(scenario.planning_problems, again.planning_problems);
            assert_eq!(scenario.obstacles.len(), again.obstacles.len());
            let _ = conform(&scenario);
        }
    }
});
