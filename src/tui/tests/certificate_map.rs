//! The good driver beside the planner on two maps, and attacks against a planner that is a process.

use super::bench::Bench;
use super::making::{arrive, asked, dangerous, made, open, said};

/// The line with the titles of both maps.
fn titles(bench: &mut Bench) -> String {
    bench
        .frame(200, 60)
        .lines()
        .nth(1)
        .map_or(String::new(), Into::into)
}

#[test]
fn the_good_driver_stands_beside_the_planner_with_verdict_and_gap() {
    let mut bench = dangerous();
    let survived = made(&bench)
        .avoidability
        .certificates
        .iter()
        .rev()
        .filter(|(_, c)| c.avoidance().is_some());
    let longest = survived.map(|(delay, _)| *delay).next();
    let Some(longest) = longest else {
        bench.press("space m g");
        assert!(
            said(&bench).contains("no good driver survives"),
            "{}",
            said(&bench)
        );
        return;
    };
    bench.press("space m g");
    assert!(bench.model.map.second.on);
    let then = bench.model.second_moment().expect("two maps");
    let now = bench.model.moment().expect("the clock's moment");
    assert_eq!(then.step, now.step);
    assert_eq!(then.opened.scenario.hash, now.opened.scenario.hash);
    let place = |ego: Option<nearmiss_base::geometry::Pose>| ego.unwrap().position;
    assert_ne!(place(then.ego()), place(now.ego()));
    let judged = |opened: &crate::loaded::Opened| {
        opened
            .collision
            .as_ref()
            .is_some_and(|j| j.verdict.dangerous)
    };
    assert!(!judged(then.opened), "the good driver touches nothing");
    let line = titles(&mut bench);
    let planner = line.find("nearmiss: X collision · ");
    let driver = line.find("good driver");
    assert!(planner.is_some() && planner < driver, "{line}");
    assert!(line.contains(": no contact · "), "{line}");
    assert!(said(&bench).contains(&format!("good driver {longest:.1} s: no contact · gap ")));
    // Both are stepped together.
    let at = bench.model.clock.step();
    bench.press("left left");
    let then = bench.model.second_moment().expect("two maps");
    assert_eq!(then.step, at - 2);
    // Again shows the original.
    bench.press("space m g");
    assert!(!titles(&mut bench).contains("good driver"));
    assert!(bench.model.map.second.on);
}

#[test]
fn what_is_no_variant_has_no_certificate() {
    let mut bench = open("rightturn");
    bench.press("space m g");
    assert!(
        said(&bench).contains("only a variant has a certificate"),
        "{}",
        said(&bench)
    );
    assert!(!bench.model.map.second.on);
}

#[test]
fn the_chosen_planner_is_attacked() {
    let mut bench = open("rightturn");
    bench.model.driver.planners = vec!["lab".into()];
    bench.press("space g g");
    assert_eq!(asked(&bench)[0].1.planner, 0);
    arrive(&mut bench);
    bench.press("space e r");
    bench.press("space e n");
    assert_eq!(bench.model.driver.planner_name(), "lab");
    // The variant against the built-in planner is none against this one.
    bench.press("space g g");
    let all = asked(&bench);
    assert_eq!(all.len(), 2, "{}", said(&bench));
    assert_eq!(all[1].1.planner, 1);
    assert!(
        said(&bench).contains("ego planned by lab with"),
        "{}",
        said(&bench)
    );
}
