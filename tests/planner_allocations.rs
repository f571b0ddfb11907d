//! Once warm, planning allocates as often for many candidates as for few.
#![allow(clippy::unwrap_used)]

#[path = "support/planned.rs"]
mod planned;

use nearmiss::planner::{Planner, Sampling, Settings};

/// Candidates and allocations of a cycle that comes after one like it.
fn warm(sampling: Sampling, bodies: usize) -> (usize, u64) {
    let place = planned::place();
    let settings = planned::settings(sampling);
    let traffic = planned::traffic(&place, settings.steps(place.dt), bodies);
    let mut planner = Planner::new(settings, &place.guide, &place.road, place.dt);
    for _ in 0..3 {
        let plan = planner.plan(&place.start, 0, &traffic);
        assert_eq!(plan.emergency, None, "{plan:?}");
    }
    let mut candidates = 0;
    let counted = allocation_counter::measure(|| {
        candidates = planner.plan(&place.start, 0, &traffic).candidates;
    });
    (candidates, counted.count_total)
}

#[test]
fn no_candidate_is_allocated_for() {
    let usual = Settings::default().sampling;
    let few = Sampling {
        offsets: 5,
        changes: 1,
        ..usual
    };
    let (least, once) = warm(few, 20);
    let more = [
        Sampling { changes: 4, ..few },
        Sampling { offsets: 19, ..few },
        Sampling {
            speeds: 2 + 4 * usual.speeds,
            ..few
        },
        Sampling {
            durations: 4 * usual.durations,
            ..few
        },
        usual,
    ];
    println!("{least} candidates: {once} allocations");
    for sampling in more {
        let (candidates, allocations) = warm(sampling, 20);
        println!("{candidates} candidates: {allocations} allocations");
        assert!(candidates > 3 * least, "{candidates}");
        assert_eq!(allocations, once, "{sampling:?}");
    }
}
