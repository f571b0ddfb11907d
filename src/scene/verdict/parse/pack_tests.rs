//! Tests of answers to the pack of templates that asks as the paper asks.
#![allow(clippy::unwrap_used)]
use super::*;

#[test]
fn answers_to_the_papers_pack_are_read() {
    let of = |who: &str, rest: &str| {
        format!(
            "Obstacle 7 closes.\n```json\n{{\"CollisionObstacle\": {who}, \"ExtremeRiskObstacle\": null, {rest}, \
             \"Justification\": \"j\"}}\n```"
        )
    };
    let who = r#"{"ObstacleID": 7, "OverallRiskScore": 0}"#;
    for (task, yes, no) in [
        (
            Task::Collision,
            r#""IsCollisionScenario": true"#,
            r#""IsCollisionScenario": false"#,
        ),
        (
            Task::Safety,
            r#""HighRiskObstacle": null"#,
            r#""HighRiskObstacle": null"#,
        ),
    ] {
        let verdict = parse(task, &of(who, yes)).unwrap().verdict;
        assert!(verdict.dangerous && verdict.justification == "j");
        let worst = verdict.worst().unwrap();
        assert_eq!((worst.id, worst.risk_score), (7, 0));
        assert!(!parse(task, &of("null", no)).unwrap().verdict.dangerous);
    }
}
