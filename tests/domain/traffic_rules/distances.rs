//! Speed limits, safe distances and braking.

use nearmiss::planner::RuleMode;
use nearmiss::traffic_rules::{Rule, RuleStatus};

use super::scenes::{Crossing, fronts};
use super::{amount, status};

#[test]
fn speed_limits_are_kept_from_where_they_begin() {
    let scene = Crossing {
        signs: vec![("274", "7.0", vec![2, 3]), ("274", "13.9", vec![1])],
        speed: 13.0,
        ..Crossing::default()
    };
    let (drive, report) = scene.driven(RuleMode::Obey);
    assert_eq!(
        status(&report, Rule::SpeedLimit),
        RuleStatus::Obeyed,
        "{report:?}"
    );
    assert!(drive.largest_deceleration() < 3.0);
    let report = scene.recorded(vec![13.0; 120]);
    let finding = report.finding(Rule::SpeedLimit).unwrap();
    assert_eq!(finding.status, RuleStatus::Broken);
    let violation = finding.violations[0];
    assert!((violation.amount - 6.0).abs() < 1e-9);
    // The middle of the body passes x = -6 after 74 m.
    assert_eq!(violation.from, 57);
    assert_eq!(violation.lanelet, Some(2));
}

#[test]
fn an_ego_that_starts_too_fast_slows_down_gently() {
    let scene = Crossing {
        signs: vec![("274", "8.0", vec![1, 2, 3])],
        speed: 14.0,
        start: -140.0,
        ..Crossing::default()
    };
    let (drive, _) = scene.driven(RuleMode::Obey);
    assert!(
        drive.largest_deceleration() < 4.0,
        "{}",
        drive.largest_deceleration()
    );
    let fronts = fronts(&drive);
    let slow = fronts.iter().find(|(_, _, v)| *v <= 8.1).unwrap().0;
    assert!(slow < 50, "{slow}");
    assert!(
        fronts
            .iter()
            .filter(|(step, ..)| *step >= slow)
            .all(|(_, _, v)| *v < 8.1)
    );
}

#[test]
fn the_safe_distance_counts_from_the_vehicle_in_front() {
    let ahead = |gap: f64| Crossing {
        cars: vec![(41, (-80.0 + 4.5 + gap, 0.0), (1.0, 0.0))],
        ..Crossing::default()
    };
    // 10 m/s behind 10 m/s: 4 m for the reaction time.
    let near = ahead(3.0).recorded(vec![10.0; 60]);
    assert_eq!(status(&near, Rule::SafeDistance), RuleStatus::Broken);
    assert!(
        (amount(&near, Rule::SafeDistance) - 1.0).abs() < 0.1,
        "{near:?}"
    );
    let far = ahead(5.0).recorded(vec![10.0; 60]);
    assert_eq!(status(&far, Rule::SafeDistance), RuleStatus::Obeyed);
    let alone = Crossing::default().recorded(vec![10.0; 60]);
    assert_eq!(
        status(&alone, Rule::SafeDistance),
        RuleStatus::NotApplicable
    );
}

#[test]
fn braking_without_anything_ahead_is_unnecessary() {
    let scene = Crossing {
        intersection: false,
        start: -140.0,
        ..Crossing::default()
    };
    let braking = (0..60).map(|i| (15.0 - 0.5 * f64::from(i)).max(0.0));
    let report = scene.recorded(braking.clone());
    assert_eq!(
        status(&report, Rule::UnnecessaryBraking),
        RuleStatus::Broken
    );
    assert!((amount(&report, Rule::UnnecessaryBraking) - 3.0).abs() < 0.6);
    // Behind a vehicle that brakes it is not.
    let occupied = Crossing {
        cars: vec![(41, (-125.0, 0.0), (0.2, 0.0))],
        ..scene
    };
    let report = occupied.recorded(braking);
    assert_ne!(
        status(&report, Rule::UnnecessaryBraking),
        RuleStatus::Broken
    );
}
