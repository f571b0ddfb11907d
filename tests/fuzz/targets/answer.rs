//! Any text gives an answer to each task, or a reason why not; what was read is written and read back.
#![no_main]

use libfuzzer_sys::fuzz_target;
use nearmiss::verdict::{ParseQuality, ParsedAnswer, Task, read};

fuzz_target!(|text: &str| {
    for task in Task::ALL {
        let Ok(reading) = read(task, text) else {
            continue;
        };
        assert_eq!(reading.said.task(), task);
        let written = serde_json::to_string(&reading.said).expect("what was read can be written");
        let again: ParsedAnswer =
            serde_json::from_str(&written).expect("what was written can be read");
        assert_eq!(again, reading.said);
        let strict = read(task, &written).expect("what was written is an answer");
        assert_eq!(
            (strict.said, strict.how),
            (reading.said, ParseQuality::Strict)
        );
    }
});
