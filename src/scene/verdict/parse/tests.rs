//! Tests of answers in many wordings, all invented.
#![allow(clippy::unwrap_used)]
use super::*;

#[test]
fn as_asked_for() {
    let answer = "Thinking {a}.\n```json\n{\"collision\": true, \"obstacles\": [{\"id\": 7, \"risk_score\": 0, \"reason\": \"hit\"}], \"justification\": \"x\"}\n```";
    let parsed = parse(Task::Collision, answer).unwrap();
    assert_eq!(parsed.how, ParseQuality::Strict);
    assert!(parsed.verdict.dangerous);
    assert_eq!(parsed.verdict.worst().unwrap().id, 7);
}

#[test]
fn critical_obstacles_and_probabilities_are_read_and_their_slips_noted() {
    let strict = r#"{"justification": "j", "obstacles": [{"id": 7, "risk_score": 4, "reason": "r"}],
        "critical_obstacles": [{"id": 7, "probability": 0.9}], "probability": 0.9, "safety_critical": true}"#;
    let parsed = parse(Task::Safety, strict).unwrap();
    assert_eq!(parsed.how, ParseQuality::Strict);
    assert_eq!(parsed.verdict.danger(), [7]);
    assert_eq!(parsed.verdict.probability, Some(0.9));
    let loose = strict.replace(": 0.9", ": \"90 %\"");
    let again = parse(Task::Safety, &loose).unwrap();
    assert_eq!(again.verdict, parsed.verdict);
    let ParseQuality::Repaired(notes) = again.how else {
        panic!("it is repaired");
    };
    let note = "the probability 0.9 was read from `90 %`";
    assert!(notes.iter().any(|n| n == note), "{notes:?}");
    // An older answer says neither, and is as it was asked for.
    let old = r#"{"safety_critical": true, "obstacles": [], "justification": "j"}"#;
    let parsed = parse(Task::Safety, old).unwrap();
    assert_eq!(parsed.how, ParseQuality::Strict);
    assert_eq!(
        (parsed.verdict.critical, parsed.verdict.probability),
        (None, None)
    );
    // Beyond its bounds it is not believed.
    let wrong = strict.replace(": 0.9", ": 1.9");
    let parsed = parse(Task::Safety, &wrong).unwrap();
    assert_eq!(
        (parsed.verdict.danger(), parsed.verdict.probability),
        (vec![7], None)
    );
}

#[test]
fn the_words_of_the_paper() {
    let answer = r#"{"CollisionObstacles": null, "ExtremeRiskObstacle": {"ObstacleID": "30674.0", "OverallRiskScore": "1"},
        "ScenarioAnalysis": {"IsCollisionScenario": false, "Justification": "none"}}"#;
    let parsed = parse(Task::Collision, answer).unwrap();
    assert!(matches!(parsed.how, ParseQuality::Repaired(_)));
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
    assert!(parsed.verdict.obstacles.is_empty() && matches!(parsed.how, ParseQuality::Repaired(_)));
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

/// What a table expects of an answer: yes or no, and the obstacles with their scores.
type Wanted<'a> = (bool, &'a [(i64, u8)]);

#[track_caller]
fn expect(task: Task, answer: &str, (dangerous, obstacles): Wanted<'_>) -> Vec<String> {
    let parsed = parse(task, answer).unwrap_or_else(|why| panic!("{answer}: {why}"));
    let found: Vec<_> = parsed
        .verdict
        .obstacles
        .iter()
        .map(|o| (o.id, o.risk_score))
        .collect();
    assert_eq!(
        (parsed.verdict.dangerous, found.as_slice()),
        (dangerous, obstacles),
        "{answer}"
    );
    match parsed.how {
        ParseQuality::Strict => Vec::new(),
        ParseQuality::Repaired(notes) => notes,
    }
}

#[test]
fn collisions_in_many_words() {
    let cases: &[(&str, Wanted<'_>, &str)] = &[
        // The form asked for, not quite.
        (
            r#"{"collision": "yes", "obstacles": [], "justification": "j"}"#,
            (true, &[]),
            "read from `collision`",
        ),
        (
            r#"{"Collision": true, "Obstacles": [{"ID": "4", "RiskScore": "1"}]}"#,
            (true, &[(4, 1)]),
            "read from `Collision`",
        ),
        (
            r#"{"collision": true, "obstacles": [{"id": 4, "risk_score": 0}], "justification": "j"}"#,
            (true, &[(4, 0)]),
            "against the schema, /obstacles/0",
        ),
        (
            r#"{"collision": true, "obstacles": [], "justification": "j", "confidence": 0.9}"#,
            (true, &[]),
            "against the schema, the object",
        ),
        (
            r#"{"answer": {"collision": false, "obstacles": {"id": 4, "risk_score": 3}}}"#,
            (false, &[(4, 3)]),
            "read from `collision`",
        ),
        (
            r#"{"collision": false, "obstacles": {"4": 3, "5": {"risk_score": 2}}, "justification": ""}"#,
            (false, &[(4, 3), (5, 2)]),
            "against the schema",
        ),
        (
            r#"{"collision": false, "obstacles": [{"id": "4, 5", "risk_score": 3}], "justification": ""}"#,
            (false, &[]),
            "is not an obstacle id",
        ),
        (
            "{'collision': True, 'obstacles': [{'id': 4, 'risk_score': 0, 'reason': None},], /* sure */}",
            (true, &[(4, 0)]),
            "comments were skipped",
        ),
        // Drafts, one object for each obstacle, and an end that is missing.
        (
            "{\"id\": 4, \"risk_score\": 2}\n{\"id\": 5, \"risk_score\": 0}\n{\"collision\": true, \"justification\": \"j\"}",
            (true, &[(4, 2), (5, 0)]),
            "several objects were merged",
        ),
        (
            r#"{"collision": true, "obstacles": [{"id": 4, "risk_score": 0, "reason": "r"}, {"id": 5, "ri"#,
            (true, &[(4, 0)]),
            "breaks off",
        ),
        (
            r#"{"collision": true, "obstacles": [], "justification": "a"} {"collision": false, "obstacles": [], "justification": "b"}"#,
            (false, &[]),
            "an earlier object",
        ),
        // The words of the paper.
        (
            r#"{{"CollisionObstacle": {{"ObstacleID": "None"}}, "ExtremeRiskObstacle": {{"ObstacleID": ["4", 5.0], "OverallRiskScore": 1}}, "IsCollisionScenario": false}}"#,
            (false, &[(4, 1), (5, 1)]),
            "doubled braces",
        ),
        (
            r#"{"collision_obstacles": [{"obstacle_id": "vehicle_4", "overall_risk_score": 0}], "scenario_analysis": {"is_collision_scenario": true, "reasoning": "r"}}"#,
            (true, &[(4, 0)]),
            "read from `is_collision_scenario`",
        ),
        (
            r#"{"CollisionObstacles": [], "HighRiskObstacle": {"ObstacleID": 4, "OverallRiskScore": 2}}"#,
            (false, &[(4, 2)]),
            "read from the obstacles named",
        ),
        (
            r#"{"CollisionObstacles": ["Obstacle 4"]}"#,
            (true, &[(4, 0)]),
            "read from the obstacles named",
        ),
    ];
    for (answer, wanted, note) in cases {
        let notes = expect(Task::Collision, answer, *wanted);
        assert!(
            notes.iter().any(|n| n.contains(note)),
            "{answer}: {notes:#?}"
        );
    }
}

#[test]
fn dangers_in_many_words() {
    let cases: &[(&str, Wanted<'_>)] = &[
        (
            r#"{"safety_critical": true, "obstacles": [], "justification": ""}"#,
            (true, &[]),
        ),
        (
            r#"{"CollisionObstacles": null, "ExtremeRiskObstacle": null, "HighRiskObstacle": {"ObstacleID": "4", "OverallRiskScore": 2}}"#,
            (false, &[(4, 2)]),
        ),
        (
            r#"{"CollisionObstacles": [], "ExtremeRiskObstacle": {"ObstacleID": "", "OverallRiskScore": "N/A"}}"#,
            (false, &[]),
        ),
        (
            r#"{"ExtremeRiskObstacle": {"ObstacleID": "4.0", "OverallRiskScore": 2}}"#,
            (true, &[(4, 1)]),
        ),
        (
            r#"{"PredictedCollisionObstacle": {"ObstacleID": 4, "OverallRiskScore": "0"}}"#,
            (true, &[(4, 1)]),
        ),
        (
            r#"{"CollisionObstacles": [], "PredictedExtremeRiskObstacle": {"ObstacleID": 4, "OverallRiskScore": 1}}"#,
            (false, &[(4, 2)]),
        ),
        (
            r#"{"ExtremeRiskObstacle": {"ObstacleID": "4, 5"}}"#,
            (true, &[]),
        ),
        // Each group in an object of its own.
        (
            r#"{"CollisionObstacle": {"ObstacleID": "4"}} {"ExtremeRiskObstacle": null}"#,
            (true, &[(4, 0)]),
        ),
        // A draft, and the same again otherwise.
        (
            r#"{"CollisionObstacle": {"ObstacleID": "4"}} no: {"CollisionObstacle": null}"#,
            (false, &[]),
        ),
        // In two groups: the worse one.
        (
            r#"{"HighRiskObstacle": "4", "ExtremeRiskObstacle": "4"}"#,
            (true, &[(4, 1)]),
        ),
    ];
    for (answer, wanted) in cases {
        expect(Task::Safety, answer, *wanted);
    }
}

#[test]
fn what_cannot_be_read_says_why() {
    let c = Task::Collision;
    let cases = [
        (
            c,
            r#"{"collision": true, "is_collision": false}"#,
            "`collision` and `is_collision` disagree",
        ),
        (c, "```json\n{", "breaks off"),
        (c, r#"{"obstacles": [{"id": 4"#, "breaks off"),
        (c, r#"{"collision": "perhaps"}"#, "has no `collision`"),
        (
            Task::Safety,
            r#"{"HighRiskObstacle": {"ObstacleID": "4"}}"#,
            "has no `safety_critical`",
        ),
        (
            Task::Attacker,
            r#"{"collision": true}"#,
            "has no `attacker`",
        ),
        (Task::Trajectory, r#"{"obstacle": 4}"#, "has no `obstacle`"),
        (
            Task::Trajectory,
            r#"{"waypoints": [[0, 1, 2], [1, 2, 3]]}"#,
            "no obstacle to move",
        ),
        (
            Task::Trajectory,
            r#"{"obstacle": 4, "waypoints": [[1, 1, 2], [0, 2, 3]]}"#,
            "in time order",
        ),
        (
            Task::Trajectory,
            r#"{"obstacle": 4, "waypoints": [[1, 1, 2]]}"#,
            "at least two",
        ),
        (
            Task::Trajectory,
            r#"{"obstacle": 4, "waypoints": [{"step": 1, "x": 1}]}"#,
            "waypoint 1: no position",
        ),
        (
            Task::Trajectory,
            r#"{"obstacle": 4, "manoeuvre": {"kind": "fly", "start": 1, "duration": 1}}"#,
            "unknown manoeuvre `fly`",
        ),
        (
            Task::Trajectory,
            r#"{"obstacle": 4, "waypoints": null, "manoeuvre": {"kind": "drift", "start": 1, "duration": 0, "gap": null, "speed": null}, "justification": ""}"#,
            "duration above 0",
        ),
    ];
    for (task, answer, words) in cases {
        let why = read(task, answer)
            .map(|r| format!("{r:?}"))
            .unwrap_err()
            .to_string();
        assert!(why.contains(words), "{answer}: {why}");
    }
}

#[test]
fn large_answers_take_no_long_time_and_give_no_long_notes() {
    let many = |text: &str| text.repeat(4_000);
    let answers = [
        format!(
            r#"{{"collision": true, "obstacles": [{}]}}"#,
            many(r#"{"id": "x", "a": 1},"#)
        ),
        format!(
            r#"{} {{"collision": true}}"#,
            many(r#"{"id": 1, "risk_score": 9} "#)
        ),
        many(r#"{"collision": true} "#),
        many(r#"{"attacker": "x", "obstacle": 1, "step": 1, "x": 1, "y": 1} "#),
        (0..4_000).fold("{\"collision\": true".to_string(), |t, i| {
            format!("{t}, \"k{i}\": {{}}")
        }),
    ];
    for answer in answers {
        for task in Task::ALL {
            let begun = std::time::Instant::now();
            let read = read(task, &answer);
            assert!(begun.elapsed().as_secs() < 10, "{task:?} {}", &answer[..40]);
            if let Ok(Reading {
                how: ParseQuality::Repaired(notes),
                ..
            }) = read
            {
                assert!(notes.iter().map(String::len).sum::<usize>() < 20_000);
            }
        }
    }
}

#[test]
fn the_score_that_was_written_stays_beside_that_of_the_group() {
    let answer = r#"{"HighRiskObstacles": [{"id": 7, "risk_score": 4, "reason": "far"}, {"id": 8, "risk_score": 2}],
        "safety_critical": false, "justification": "j"}"#;
    let parsed = parse(Task::Safety, answer).unwrap();
    let scores: Vec<_> = parsed
        .verdict
        .obstacles
        .iter()
        .map(|o| (o.id, o.risk_score, o.written_score, o.stated_score()))
        .collect();
    assert_eq!(scores, [(7, 2, Some(4), 4), (8, 2, None, 2)]);
    let ParseQuality::Repaired(notes) = &parsed.how else {
        panic!("{:?}", parsed.how)
    };
    assert!(
        notes.iter().any(|note| note.contains("obstacle 7 differs")),
        "{notes:?}"
    );
    // It comes back from the store, and is not asked for.
    let json = serde_json::to_string(&parsed.verdict).unwrap();
    assert_eq!(
        serde_json::from_str::<Verdict>(&json).unwrap(),
        parsed.verdict
    );
    let schema = crate::verdict::schema(Task::Safety).to_string();
    assert!(!schema.contains("written_score") && !schema.contains("token_probability"));
}
