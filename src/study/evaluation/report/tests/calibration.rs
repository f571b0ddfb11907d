//! Tests of calibration: where probabilities are from, and those by log probabilities.

use super::*;
use nearmiss_scene::verdict::CriticalObstacle;

#[test]
fn every_verdict_has_a_probability_and_the_report_says_from_where() {
    let way = way(Task::Safety, "cp", "lab/x");
    let safe = Some(Label::Safe);
    let mut stated = verdict(Task::Safety, true, &[(7, 4)]);
    stated.critical = Some(vec![CriticalObstacle::new(7)]);
    stated.probability = Some(0.9);
    let mut listed = stated.clone();
    listed.probability = None;
    listed.critical = Some(vec![CriticalObstacle {
        id: 7,
        probability: Some(0.4),
    }]);
    let mut weighed = verdict(Task::Safety, false, &[(9, 5)]);
    weighed.token_probability = Some(0.1);
    let hit = Some(Label::Collision(Some(7)));
    stated.token_probability = Some(0.7);
    let scored = [
        one("a", &way, hit, AnswerStatus::Verdict(stated)),
        one("b", &way, safe, AnswerStatus::Verdict(listed)),
        one("c", &way, safe, says(false, &[(9, 5)])),
        one("d", &way, safe, says(false, &[])),
        one("e", &way, safe, AnswerStatus::Verdict(weighed)),
    ];
    let report = Report::from_scored(&scored);
    let cell = report.whole().next().unwrap();
    let one_each = ProbabilitySources {
        from_stated: 1,
        from_critical: 1,
        from_token: 1,
        from_score: 1,
        from_decision: 1,
    };
    assert_eq!(cell.calibration.sources, one_each);
    assert_eq!(cell.calibration.fit.n, 5);
    assert_eq!(cell.calibration.fit.auroc, Some(1.0));
    let tokens = &json(cell)["token_calibration"];
    assert_eq!((&tokens["n"], &tokens["auroc"]), (&2.into(), &1.0.into()));
    assert!(
        (tokens["brier"].as_f64().unwrap() - 0.05).abs() < 1e-12,
        "{tokens}"
    );
    // 7 is named on the collision whatever its score, and on a safe window too.
    let naming = (cell.naming_recall, cell.naming_precision);
    assert_eq!(naming, (Some(1.0), Some(0.5)));
    let text = report.document("Report").markdown();
    for words in [
        "Obstacle named",
        "| AUROC |",
        "Calibration of log probabilities",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    assert!(report.document("Report").latex().contains("Names right"));
    let csv = report.rows().csv();
    for column in [
        "naming_recall_ci_low",
        "naming_precision",
        "calibration.from_token",
        "token_calibration.auroc",
    ] {
        assert!(csv.contains(column), "{column}: {csv}");
    }
}
