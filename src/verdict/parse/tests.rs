//! Answers in many words, all invented, and what is read from them.
#![allow(clippy::unwrap_used)]
use super::*;

#[test]
fn as_asked_for() {
    let answer = "Thinking {a}.\n```json\n{\"collision\": true, \"obstacles\": [{\"id\": 7, \"risk_score\": 0, \"reason\": \"hit\"}], \"justification\": \"x\"}\n```";
    let parsed = parse(Task::Collision, answer).unwrap();
    assert_eq!(parsed.how, How::Strict);
    assert!(parsed.verdict.dangerous);
    assert_eq!(parsed.verdict.worst().unwrap().id, 7);
}

#[test]
fn the_words_of_the_paper() {
    let answer = r#"{"CollisionObstacles": null, "ExtremeRiskObstacle": {"ObstacleID": "30674.0", "OverallRiskScore": "1"},
        "ScenarioAnalysis": {"IsCollisionScenario": false, "Justification": "none"}}"#;
    let parsed = parse(Task::Collision, answer).unwrap();
    assert!(matches!(parsed.how, How::Repaired(_)));
    assert!(!parsed.verdict.dangerous);
    assert_eq!(parsed.verdict.obstacles[0].id, 30674);
    assert_eq!(parsed.verdict.obstacles[0].risk_score, 1);
    assert_eq!(parsed.verdict.justification, "none");
    let safety = parse(Task::Safety, answer).unwrap();
    assert!(safety.verdict.dangerous, "an extreme risk is named");
}

#[test]
fn the_last_decision_counts() {
    let answer = r#"first {"collision": false, "obstacles": [], "justification": "a"} no: {"collision": true, "obstacles": [], "justification": "b"}"#;
    assert!(parse(Task::Collision, answer).unwrap().verdict.dangerous);
}

#[test]
fn out_of_range_scores_are_not_believed() {
    let answer = r#"{"collision": false, "obstacles": [{"id": 1, "risk_score": 9, "reason": ""}], "justification": ""}"#;
    let parsed = parse(Task::Collision, answer).unwrap();
    assert!(parsed.verdict.obstacles.is_empty() && matches!(parsed.how, How::Repaired(_)));
}

#[test]
fn answers_without_a_verdict() {
    assert_eq!(parse(Task::Collision, "  "), Err(NoVerdict::Empty));
    assert_eq!(
        parse(Task::Collision, "It is safe."),
        Err(NoVerdict::NoJson)
    );
    assert_eq!(
        parse(Task::Collision, "```json\n{\"collision\": tr"),
        Err(NoVerdict::CutOff)
    );
    assert_eq!(
        parse(Task::Collision, "{\"hello\": 1}"),
        Err(NoVerdict::NoDecision("collision"))
    );
}
