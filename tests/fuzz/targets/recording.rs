//! Any bytes as the files of a recording of each kind give scenarios or errors; what is read is written and read back.
#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../../hostile/recordings/one_entry.rs"]
mod one_entry;

fuzz_target!(|bytes: &[u8]| {
    one_entry::open(bytes);
});
