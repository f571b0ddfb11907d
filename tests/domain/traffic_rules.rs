//! Rules of the road on a crossing written by hand: obeyed by the planner, and reported where they are broken.
#![allow(clippy::unwrap_used)]

mod distances;
mod scenes;

use nearmiss::formats::{bundled, commonroad};
use nearmiss::planner::{self, Forecast, RuleMode};
use nearmiss::simulation::{Driver, Outcome, Settings, TrafficMode};
use nearmiss::traffic_rules::{Rule, RuleReport, RuleStatus, STOP_SECONDS};
use proptest::prelude::*;
use scenes::{Crossing, DT, fronts};

/// Before the intersection, metres along x.
const LINE: f64 = -6.0;

fn status(report: &RuleReport, rule: Rule) -> RuleStatus {
    report.finding(rule).unwrap().status
}

fn amount(report: &RuleReport, rule: Rule) -> f64 {
    report.finding(rule).unwrap().violations[0].amount
}

/// The step at which a drive's front passes the line.
fn passes(fronts: &[(i64, f64, f64)]) -> Option<i64> {
    fronts
        .iter()
        .find(|(_, x, _)| *x > LINE)
        .map(|(step, ..)| *step)
}

fn red_until(step: i64) -> Crossing {
    Crossing {
        light: Some((vec![(step, "red"), (10, "redYellow"), (2000, "green")], 0)),
        ..Crossing::default()
    }
}

#[test]
fn a_red_light_is_waited_for() {
    let scene = red_until(150);
    let (drive, report) = scene.driven(RuleMode::Obey);
    let fronts = fronts(&drive);
    assert!(passes(&fronts).unwrap() >= 160, "{:?}", passes(&fronts));
    // It stands before the line, near it.
    let stood = fronts.iter().find(|(_, _, v)| *v < 0.1).unwrap();
    assert!((LINE - 3.0..=LINE).contains(&stood.1), "{stood:?}");
    assert!(
        matches!(drive.outcome, Outcome::Goal(_)),
        "{:?}",
        drive.outcome
    );
    assert!(
        drive.largest_deceleration() < 4.0,
        "{}",
        drive.largest_deceleration()
    );
    assert_eq!(status(&report, Rule::RedLight), RuleStatus::Obeyed);
    let hold = drive.cycles[60].plan.hold.unwrap();
    assert_eq!(hold.rule, Rule::RedLight);
}

#[test]
fn without_rules_it_is_driven_through_and_reported() {
    let (drive, report) = red_until(150).driven(RuleMode::Off);
    let fronts = fronts(&drive);
    let passed = passes(&fronts).unwrap();
    assert!(passed < 100, "{passed}");
    assert_eq!(status(&report, Rule::RedLight), RuleStatus::Broken);
    let violation = report.finding(Rule::RedLight).unwrap().violations[0];
    assert_eq!((violation.from, violation.lanelet), (passed, Some(1)));
    let speed = fronts.iter().find(|(step, ..)| *step == passed).unwrap().2;
    assert!((violation.amount - speed).abs() < 1e-9, "{violation:?}");
    assert!(drive.cycles.iter().all(|cycle| cycle.plan.hold.is_none()));
}

#[test]
fn green_and_lights_that_are_off_stop_no_vehicle() {
    let green = Crossing {
        light: Some((vec![(2000, "green")], 0)),
        ..Crossing::default()
    };
    let (drive, report) = green.driven(RuleMode::Obey);
    assert!(passes(&fronts(&drive)).unwrap() < 100);
    assert_eq!(status(&report, Rule::RedLight), RuleStatus::Obeyed);
    let off = Crossing {
        light: Some((vec![(2000, "inactive")], 0)),
        ..Crossing::default()
    };
    let (drive, report) = off.driven(RuleMode::Obey);
    assert!(passes(&fronts(&drive)).unwrap() < 100);
    assert_eq!(status(&report, Rule::RedLight), RuleStatus::NotApplicable);
}

#[test]
fn at_yellow_one_stops_if_that_is_comfortable() {
    // The front is at x = -77.7 + 10 t.
    let yellow_from = |step: i64| Crossing {
        light: Some((vec![(step, "green"), (400, "yellow")], 0)),
        ..Crossing::default()
    };
    // 50 m before the line: 1 m/s² are enough.
    let (drive, report) = yellow_from(22).driven(RuleMode::Obey);
    assert_eq!(passes(&fronts(&drive)), None);
    assert_eq!(status(&report, Rule::RedLight), RuleStatus::Obeyed);
    // 4 m before it: that takes more than 6 m/s².
    let (green, _) = yellow_from(400).driven(RuleMode::Obey);
    let near = fronts(&green)
        .iter()
        .find(|(_, x, _)| *x > LINE - 4.0)
        .unwrap()
        .0;
    let (drive, report) = yellow_from(near).driven(RuleMode::Obey);
    assert!(passes(&fronts(&drive)).is_some());
    assert_eq!(status(&report, Rule::RedLight), RuleStatus::Obeyed);
    // An ego that could have stopped broke the rule, one that could not did not.
    let drives_on = |step| yellow_from(step).recorded(vec![10.0; 120]);
    assert_eq!(status(&drives_on(22), Rule::RedLight), RuleStatus::Broken);
    assert_eq!(status(&drives_on(64), Rule::RedLight), RuleStatus::Obeyed);
}

#[test]
fn at_a_stop_sign_one_stands_as_long_as_the_rule_asks() {
    let scene = Crossing {
        signs: vec![("206", "", vec![1])],
        ..Crossing::default()
    };
    let (drive, report) = scene.driven(RuleMode::Obey);
    let fronts = fronts(&drive);
    let stood = fronts
        .iter()
        .filter(|(_, x, v)| *v < 0.1 && *x > LINE - 2.5)
        .count();
    assert!(stood as f64 * DT >= STOP_SECONDS, "{stood}");
    assert!(passes(&fronts).is_some() && matches!(drive.outcome, Outcome::Goal(_)));
    assert_eq!(status(&report, Rule::StopSign), RuleStatus::Obeyed);
    let (_, report) = scene.driven(RuleMode::Off);
    assert_eq!(status(&report, Rule::StopSign), RuleStatus::Broken);
    assert_eq!(amount(&report, Rule::StopSign), STOP_SECONDS);
    // A second of standing is two too few.
    let mut speeds = vec![10.0; 60];
    speeds.extend((0..20).map(|i| 10.0 - 0.5 * f64::from(i)));
    let x: f64 = scene.start + 2.25 + speeds.iter().sum::<f64>() * DT;
    let room = LINE - 1.0 - x;
    speeds.extend(vec![room / 10.0 / DT; 10]);
    speeds.extend(vec![0.0; 11]);
    speeds.extend(vec![5.0; 40]);
    let report = scene.recorded(speeds);
    assert_eq!(status(&report, Rule::StopSign), RuleStatus::Broken);
    assert!(
        (amount(&report, Rule::StopSign) - 2.0).abs() < 0.11,
        "{}",
        amount(&report, Rule::StopSign)
    );
}

/// A car from the right that is in the intersection when an ego that does not wait is.
fn from_the_right() -> (i64, (f64, f64), (f64, f64)) {
    (41, (1.75, -78.0), (0.0, 1.0))
}

#[test]
fn right_goes_before_left() {
    let scene = Crossing {
        cars: vec![from_the_right()],
        ..Crossing::default()
    };
    let (drive, report) = scene.driven(RuleMode::Obey);
    assert!(
        matches!(drive.outcome, Outcome::Goal(_)),
        "{:?}",
        drive.outcome
    );
    assert_eq!(status(&report, Rule::RightBeforeLeft), RuleStatus::Obeyed);
    let held = drive.cycles.iter().filter_map(|cycle| cycle.plan.hold);
    assert!(
        held.map(|hold| hold.rule)
            .any(|rule| rule == Rule::RightBeforeLeft)
    );
    assert!(
        drive.largest_deceleration() < 4.5,
        "{}",
        drive.largest_deceleration()
    );
    // One that passes just before it endangers it.
    let report = scene.recorded(vec![10.5; 120]);
    let finding = report.finding(Rule::RightBeforeLeft).unwrap();
    assert_eq!(finding.status, RuleStatus::Broken);
    assert_eq!(finding.violations[0].obstacle, Some(41));
    assert!(finding.violations[0].amount > 0.0);
    // One that passes three seconds before it does not.
    let late = Crossing {
        cars: vec![(41, (1.75, -120.0), (0.0, 1.0))],
        ..Crossing::default()
    };
    assert_eq!(
        status(&late.recorded(vec![10.5; 120]), Rule::RightBeforeLeft),
        RuleStatus::Obeyed
    );
}

#[test]
fn left_waits_and_signs_turn_it_round() {
    let car = (41, (-1.75, 78.0), (0.0, -1.0));
    let from_left = |signs: Vec<(&'static str, &'static str, Vec<i64>)>| Crossing {
        signs,
        cars: vec![car],
        ..Crossing::default()
    };
    let holds = |scene: &Crossing| -> Vec<Rule> {
        let (drive, _) = scene.driven(RuleMode::Obey);
        let mut rules: Vec<Rule> = drive
            .cycles
            .iter()
            .filter_map(|c| Some(c.plan.hold?.rule))
            .collect();
        rules.dedup();
        rules
    };
    assert_eq!(holds(&from_left(vec![])), []);
    let yields = from_left(vec![("205", "", vec![1]), ("301", "", vec![21])]);
    assert_eq!(holds(&yields), [Rule::Priority]);
    assert_eq!(
        status(&yields.driven(RuleMode::Obey).1, Rule::Priority),
        RuleStatus::Obeyed
    );
    assert_eq!(
        status(&yields.recorded(vec![10.5; 120]), Rule::Priority),
        RuleStatus::Broken
    );
    // With the right of way, what comes from the right waits.
    let prior = Crossing {
        signs: vec![("306", "", vec![1]), ("205", "", vec![11])],
        cars: vec![(41, (1.75, -120.0), (0.0, 1.0))],
        ..Crossing::default()
    };
    assert_eq!(holds(&prior), []);
    assert_eq!(
        status(&prior.recorded(vec![10.5; 120]), Rule::Priority),
        RuleStatus::NotApplicable
    );
}

#[test]
fn a_left_turn_waits_for_oncoming_traffic() {
    let scene = Crossing {
        cars: vec![(41, (70.0, 3.5), (-1.0, 0.0))],
        light: Some((vec![(2000, "green")], 0)),
        goal: (13, 300),
        ..Crossing::default()
    };
    let (drive, report) = scene.driven(RuleMode::Obey);
    assert!(
        matches!(drive.outcome, Outcome::Goal(_)),
        "{:?}",
        drive.outcome
    );
    assert_eq!(
        status(&report, Rule::LeftTurn),
        RuleStatus::Obeyed,
        "{report:?}"
    );
    // Cross traffic has red: it is not waited for.
    assert_eq!(
        status(&report, Rule::RightBeforeLeft),
        RuleStatus::NotApplicable
    );
}

#[test]
fn what_the_map_does_not_say_is_not_decided() {
    let scene = Crossing {
        intersection: false,
        cars: vec![from_the_right()],
        ..Crossing::default()
    };
    let report = scene.recorded(vec![10.5; 120]);
    for rule in [
        Rule::RightBeforeLeft,
        Rule::Priority,
        Rule::LeftTurn,
        Rule::SpeedLimit,
    ] {
        assert_eq!(status(&report, rule), RuleStatus::Undecided, "{rule:?}");
        assert!(report.finding(rule).unwrap().reason.is_some());
    }
    assert_eq!(report.findings.len(), Rule::ALL.len());
    let order: Vec<Rule> = report.findings.iter().map(|f| f.rule).collect();
    assert_eq!(order, Rule::ALL);
}

/// The bundled intersection with the ego's light red until `step`.
fn bundled_light(step: i64, rules: RuleMode) -> (Option<i64>, RuleReport) {
    let entries = bundled();
    let entry = entries
        .iter()
        .find(|e| e.name.contains("RedLight"))
        .unwrap();
    let offset = |steps: i64| format!("<timeOffset>{steps}</timeOffset>");
    let xml = entry
        .source()
        .unwrap()
        // The first of the two lights with this offset is the ego's: red lasts until it begins.
        .replacen(&offset(320), &offset(step), 1);
    let scenario = std::sync::Arc::new(commonroad::read(xml.as_bytes(), "red.xml").unwrap());
    let settings = Settings {
        planner: planner::Settings {
            rules,
            ..planner::Settings::default()
        },
        forecast: Forecast::Lane,
        replan: 1,
        without: None,
        traffic: TrafficMode::Recorded,
        policy: None,
    };
    let problem = &scenario.planning_problems[0];
    let driver = Driver::new(&scenario, problem, &settings).unwrap();
    let drive = driver.drive(&scenario, &driver.full_span());
    let report = drive.rules(&scenario, problem, &settings);
    let light = &driver.guide().regulations.lights[0];
    let path = &driver.guide().path;
    let passed = drive.states.iter().find(|(_, state)| {
        let centre = state.centre(&drive.limits).pose;
        let front = centre.position + centre.forward() * drive.limits.length / 2.0;
        use nearmiss::geometry::Frenet;
        let at: Result<Frenet, _> = path.project(&front);
        at.is_ok_and(|at| at.s > light.s)
    });
    (passed.map(|(step, _)| *step), report)
}

#[test]
fn the_light_of_the_bundled_intersection_is_obeyed() {
    // Red all the time: it is never passed.
    let (passed, report) = bundled_light(95, RuleMode::Obey);
    assert_eq!(passed, None);
    assert_eq!(status(&report, Rule::RedLight), RuleStatus::Obeyed);
    // Green from step 50 on.
    let (passed, report) = bundled_light(40, RuleMode::Obey);
    assert!(passed.is_none_or(|step| step >= 50), "{passed:?}");
    assert_eq!(status(&report, Rule::RedLight), RuleStatus::Obeyed);
    let (passed, report) = bundled_light(95, RuleMode::Off);
    assert!(passed.is_some());
    assert_eq!(status(&report, Rule::RedLight), RuleStatus::Broken);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn no_red_light_is_passed_whatever_the_speed_and_the_phases(
        speed in 3.0..16.0_f64,
        start in -140.0..-60.0_f64,
        red in 20..200_i64,
    ) {
        // Room to stop with 4 m/s².
        prop_assume!(speed * speed / 8.0 < -start - 12.0);
        let scene = Crossing { speed, start, ..red_until(red) };
        let (drive, report) = scene.driven(RuleMode::Obey);
        prop_assert_eq!(status(&report, Rule::RedLight), RuleStatus::Obeyed);
        if let Some(passed) = passes(&fronts(&drive)) {
            prop_assert!(passed >= red + 10, "{} {}", passed, red);
        }
    }
}
