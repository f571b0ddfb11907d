//! Any bytes give a solution, a recorded ego, or an error; a solution is written and read back.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use nearmiss::formats::commonroad::{read_solution, write_solution};
use nearmiss::formats::{bundled, read_ego};
use nearmiss::scenario::Scenario;

static SCENARIO: LazyLock<Scenario> = LazyLock::new(|| {
    let scenario = bundled()[0].read().expect("a bundled scenario");
    (*scenario).clone()
});

fuzz_target!(|bytes: &[u8]| {
    if let Ok(solution) = read_solution(bytes, "fuzz")
        && let Ok(written) = write_solution(&solution)
    {
        let again = read_solution(&written, "written").expect("what was written can be read");
        assert_eq!(solution.problems, again.problems);
    }
    let _ = read_ego(bytes, "fuzz", &SCENARIO, None);
});
