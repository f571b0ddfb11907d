//! Drivers in an encounter: panel, timeline, strip and second map.

use nearmiss_drive::driver::DRIVERS;

use crate::features::map::state::DrivenBy;
use crate::message::{Effect, Msg};
use crate::tests::bench::Bench;
use crate::tests::making::{dangerous, open, said};
use crate::update::update;

/// A line of the panel for each driver.
fn lines(frame: &str) -> Vec<String> {
    let ids = DRIVERS.iter().map(|driver| driver.id);
    let line = |id: &str| {
        let is = |line: &&str| {
            line.contains(&format!("┃▸ {id} ")) || line.contains(&format!("┃  {id} "))
        };
        frame
            .lines()
            .find(is)
            .unwrap_or_else(|| panic!("{id}\n{frame}"))
    };
    ids.map(|id| line(id).to_string()).collect()
}

#[test]
fn a_line_for_each_driver_and_the_words_of_the_record() {
    let mut bench = open("cutin");
    let found = bench.model.judged().expect("a conflict is judged").clone();
    assert_eq!(found.drivers.len(), DRIVERS.len());
    let (words, count) = (found.words(), found.short());
    assert!(bench.frame(200, 60).contains(&count), "{words}");
    bench.press("tab z");
    assert!(bench.frame(200, 60).contains(&words), "{words}");
    bench.press("esc");
    for (columns, rows) in [(80, 24), (200, 60)] {
        bench.press("space e d");
        let frame = bench.frame(columns, rows);
        assert_eq!(lines(&frame).len(), DRIVERS.len());
        assert!(frame.contains("conflict with car 301"), "{frame}");
        assert!(frame.contains("▸ ideal"), "{frame}");
        bench.press("down");
        let first = DRIVERS[0];
        let frame = bench.frame(columns, rows);
        assert!(frame.contains(&format!("▸ {}", first.id)), "{frame}");
        assert!(frame.contains(first.name), "{frame}");
        bench.press("up esc");
    }
}

#[test]
fn last_moments_stand_on_the_timeline_with_their_drivers() {
    let mut bench = open("braking");
    bench.press("tab z");
    let frame = bench.frame(200, 60);
    let row = frame.lines().find(|line| line.contains("drivers "));
    let row = row.unwrap_or_else(|| panic!("{frame}"));
    let found = bench.model.judged().unwrap();
    let with = found
        .drivers
        .iter()
        .filter(|v| v.last_moment_step.is_some());
    for verdict in with {
        assert!(row.contains(&verdict.driver), "{}\n{row}", verdict.driver);
    }
    assert!(row.contains('┤'), "{row}");
}

#[test]
fn the_driver_beside_a_recorded_ego_is_chosen() {
    let mut bench = open("cutin");
    bench.press("space m g");
    let then = |bench: &Bench| {
        bench
            .model
            .second_moment()
            .map(|m| (m.driven, m.step, m.reason))
    };
    let ideal = DRIVERS.len() - 1;
    assert_eq!(then(&bench).unwrap().0, Some(DrivenBy::Driver(ideal, None)));
    assert_eq!(then(&bench).unwrap().1, bench.model.clock.step());
    // The next one hits it.
    bench.press("space e c");
    assert!(
        said(&bench).starts_with(DRIVERS[0].name),
        "{}",
        said(&bench)
    );
    let Some(Some(DrivenBy::Driver(0, Some(speed)))) = then(&bench).map(|then| then.0) else {
        panic!("{:?}", then(&bench));
    };
    let verdict = bench.model.verdict_shown().unwrap();
    assert_eq!(verdict.closing_speed, Some(speed));
    let frame = bench.frame(260, 60);
    let words = format!("{}: X contact at {speed:.1} m/s", DRIVERS[0].name);
    assert!(frame.contains(&words), "{words}\n{frame}");
    assert!(frame.contains("recorded: no contact"), "{frame}");
    bench.press("space m g");
    assert!(then(&bench).is_some_and(|then| then.0.is_none()));
}

#[test]
fn the_strip_of_a_variant_shows_the_driver_that_is_chosen() {
    let mut bench = dangerous();
    bench.press("space g v");
    for place in 0..DRIVERS.len() - 1 {
        bench.press("space e c");
        assert_eq!(bench.model.drivers.shown, place);
        let strip = bench.model.variant_strip().unwrap();
        assert!(strip.original.is_some());
        let driven = strip.driver.and_then(|moment| moment.driven);
        let verdict = bench.model.verdict_shown().unwrap();
        let DrivenBy::Driver(shown, contact) = driven.expect("its drive") else {
            panic!("{driven:?}");
        };
        assert_eq!(shown, place);
        if verdict.not_made_for.is_none() {
            assert_eq!(contact, verdict.closing_speed, "{}", verdict.driver);
        }
    }
    let count = bench.model.judged().unwrap().short();
    let frame = bench.frame(200, 100);
    assert!(frame.contains(&count), "{count}\n{frame}");
}

#[test]
fn who_is_never_near_has_no_drivers_and_stale_verdicts_are_dropped() {
    let mut bench = open("cutin");
    bench.press("space e d");
    let severe = |bench: &Bench| bench.model.encounter().unwrap().1.grade.number() <= 2;
    while severe(&bench) {
        bench.press("n");
    }
    let frame = bench.frame(200, 60);
    assert!(
        frame.contains("drivers avoid contacts, conflicts"),
        "{frame}"
    );
    assert!(bench.model.judged().is_none());
    // What was asked before another scenario was opened is of no use then.
    bench.press("esc x");
    bench.model.drivers = Default::default();
    let effects = update(&mut bench.model, Msg::Resize(200, 60));
    let late: Vec<Msg> = effects
        .into_iter()
        .filter_map(|e: Effect| e.at_once().ok())
        .collect();
    assert!(!late.is_empty() && bench.model.judged().is_none());
    bench.model.opened = None;
    bench.model.drivers = Default::default();
    late.into_iter().for_each(|reply| bench.send(reply));
    assert!(bench.model.judged().is_none());
}
