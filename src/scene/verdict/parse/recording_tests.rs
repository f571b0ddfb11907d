//! Tests of answers about whole recordings.
#![allow(clippy::unwrap_used)]
use super::*;

#[test]
fn recordings_are_safe_or_of_high_risk() {
    let strict = r#"{"justification": "j", "obstacles": [{"id": 7, "risk_score": 1, "reason": "r"}],
        "critical_obstacles": [{"id": 7, "probability": 0.9}], "probability": 0.9, "high_risk": true}"#;
    let parsed = parse(Task::Recording, strict).unwrap();
    assert_eq!(parsed.how, ParseQuality::Strict);
    assert!(parsed.verdict.dangerous);
    assert_eq!(
        (parsed.verdict.word(), parsed.verdict.danger()),
        ("high risk", vec![7])
    );
    for (answer, wanted) in [
        (
            r#"{"classification": "High-risk", "justification": "j"}"#,
            true,
        ),
        (r#"{"result": {"Classification": "safe"}}"#, false),
        (r#"{"IsHighRisk": "yes"}"#, true),
        (
            r#"{"ExtremeRiskObstacle": {"ObstacleID": 7, "OverallRiskScore": 1}}"#,
            true,
        ),
        (r#"{"ExtremeRiskObstacle": null}"#, false),
    ] {
        let parsed = parse(Task::Recording, answer).unwrap();
        assert_eq!(parsed.verdict.dangerous, wanted, "{answer}");
        assert!(matches!(parsed.how, ParseQuality::Repaired(_)), "{answer}");
    }
    for answer in [
        r#"{"high_risk": true, "classification": "safe"}"#,
        r#"{"classification": "a truck"}"#,
        r#"{"safety_critical": true}"#,
    ] {
        assert!(parse(Task::Recording, answer).is_err(), "{answer}");
    }
}
