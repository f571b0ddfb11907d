//! Tests of attackers and trajectories in many wordings, all invented.
#![allow(clippy::unwrap_used)]
use super::*;

#[test]
fn attackers() {
    let strict = r#"{"attacker": 4, "obstacles": [{"id": 4, "risk_score": 1, "reason": "r"}], "justification": "j"}"#;
    let none = r#"{"attacker": null, "obstacles": [], "justification": "j"}"#;
    let paper = r#"{"CollisionObstacle": null, "ExtremeRiskObstacle": {"ObstacleID": "5", "OverallRiskScore": "1"},
        "PotentialAttackers": [{"ObstacleID": "4", "AttackPotential": "High", "RiskScore": "2", "AttackReason": "r"}]}"#;
    let cases: &[(&str, Option<i64>, &[i64], bool)] = &[
        (strict, Some(4), &[4], true),
        (none, None, &[], true),
        (paper, Some(4), &[4, 5], false),
        (
            r#"{"CollisionObstacle": null, "ExtremeRiskObstacle": {"ObstacleID": "5"}}"#,
            Some(5),
            &[5],
            false,
        ),
        (
            r#"{"CollisionObstacle": null, "ExtremeRiskObstacle": null}"#,
            None,
            &[],
            false,
        ),
        (
            r#"{"EgoAttacker": "Obstacle 4", "ranking": [{"id": 5, "risk_score": 0}]}"#,
            Some(4),
            &[5],
            false,
        ),
        (
            r#"{"attacker": {"id": 4, "risk_score": 3, "reason": "r"}}"#,
            Some(4),
            &[4],
            false,
        ),
        (
            r#"{"ranking": [{"id": 5, "risk_score": 3}, {"id": 6, "risk_score": 1}]}"#,
            Some(6),
            &[5, 6],
            false,
        ),
    ];
    for (answer, who, listed, as_asked) in cases {
        let reading = read(Task::Attacker, answer).unwrap();
        let ParsedAnswer::Attacker(choice) = &reading.said else {
            panic!("{reading:?}")
        };
        let ids: Vec<_> = choice.obstacles.iter().map(|o| o.id).collect();
        assert_eq!(
            (choice.attacker, ids.as_slice()),
            (*who, *listed),
            "{answer}"
        );
        assert_eq!(
            reading.how == ParseQuality::Strict,
            *as_asked,
            "{answer}: {:?}",
            reading.how
        );
    }
}

#[test]
fn the_answer_to_another_task_names_no_attacker() {
    let obstacles =
        r#""obstacles": [{"id": 4, "risk_score": 1, "reason": "r"}], "justification": "j""#;
    let others = [
        format!(r#"{{"collision": true, {obstacles}}}"#),
        format!(r#"{{"safety_critical": false, {obstacles}}}"#),
        format!(r#"{{"answer": {{"Safety_Critical": "yes", {obstacles}}}}}"#),
        format!(r#"{{"collision": true, "is_collision": false, {obstacles}}}"#),
        format!(r#"{{{obstacles}}} {{"collision": true}}"#),
        r#"{"CollisionObstacle": {"ObstacleID": "4"}, "IsCollisionScenario": true}"#.to_string(),
    ];
    for answer in others {
        assert_eq!(
            read(Task::Attacker, &answer),
            Err(NoVerdict::NoDecision("attacker")),
            "{answer}"
        );
    }
    let both = [
        format!(r#"{{"collision": true, "attacker": 4, {obstacles}}}"#),
        format!(r#"{{"collision": false}} {{"attacker": 4, {obstacles}}}"#),
        r#"{"safety_critical": true, "PotentialAttackers": [{"ObstacleID": "4", "RiskScore": "2"}]}"#.to_string(),
    ];
    for answer in both {
        let said = read(Task::Attacker, &answer).unwrap().said;
        assert!(
            matches!(&said, ParsedAnswer::Attacker(choice) if choice.attacker == Some(4)),
            "{answer}: {said:?}"
        );
    }
}

#[test]
fn trajectories() {
    use crate::verdict::{ManoeuvreKind, Moment, Motion};
    let point = r#""y": 2.0, "heading": null, "velocity": 3.0"#;
    let strict = format!(
        r#"{{"obstacle": 4, "waypoints": [{{"step": 1, "time": null, "x": 1.0, {point}}}, {{"step": 2, "time": null, "x": 2.0, {point}}}],
            "manoeuvre": null, "justification": "j"}}"#
    );
    let others = [
        r#"{"attacker": "car 4", "trajectory": [[1, 1.0, 2.0, 0.0, 3.0], [2, 2.0, 2.0, 0.0, 3.0]]}"#,
        r#"{"obstacle_id": 4, "trajectory": {"points": [{"timestep": 1, "position": [1.0, 2.0], "velocity": "3 m/s"}, {"timestep": 2, "position": {"x": 2, "y": 2}, "speed": 3}]}}"#,
        "Attacker: {\"attacker\": 4}\n{\"step\": 1, \"x\": 1, \"y\": 2, \"v\": 3}\n{\"step\": 2, \"x\": 2, \"y\": 2, \"v\": 3}",
        "{'obstacle': 4} [(1, 1.0, 2.0, 0, 3), (2, 2.0, 2.0, 0, 3)]",
    ];
    for answer in others.into_iter().chain([strict.as_str()]) {
        let reading =
            read(Task::Trajectory, answer).unwrap_or_else(|why| panic!("{answer}: {why}"));
        let ParsedAnswer::Trajectory(new) = &reading.said else {
            panic!("{reading:?}")
        };
        let Motion::Waypoints(points) = &new.motion else {
            panic!("{new:?}")
        };
        let found: Vec<_> = points
            .iter()
            .map(|p| (p.at, p.x, p.y, p.velocity))
            .collect();
        let wanted = [
            (Moment::Step(1), 1.0, 2.0, Some(3.0)),
            (Moment::Step(2), 2.0, 2.0, Some(3.0)),
        ];
        assert_eq!(
            (new.obstacle, found.as_slice()),
            (4, wanted.as_slice()),
            "{answer}"
        );
        assert_eq!(
            reading.how == ParseQuality::Strict,
            answer == strict,
            "{:?}",
            reading.how
        );
    }
    let by_time =
        r#"{"obstacle": 4, "waypoints": {"0.5": {"x": 1, "y": 2}, "1.0": {"x": 2, "y": 2}}}"#;
    let ParsedAnswer::Trajectory(new) = read(Task::Trajectory, by_time).unwrap().said else {
        panic!()
    };
    assert!(matches!(&new.motion, Motion::Waypoints(p) if p[1].at == Moment::Seconds(1.0)));
    for kind in ManoeuvreKind::ALL {
        for word in [
            kind.name().to_string(),
            kind.name().replace('-', " ").to_uppercase(),
        ] {
            let answer = format!(
                r#"{{"obstacle": 4, "waypoints": null, "manoeuvre": {{"kind": "{word}", "start": 1.0, "duration": 2.5, "gap": 3.0, "speed": null}}, "justification": "j"}}"#
            );
            let reading = read(Task::Trajectory, &answer).unwrap();
            assert_eq!(
                reading.how == ParseQuality::Strict,
                word == kind.name(),
                "{answer}"
            );
            let ParsedAnswer::Trajectory(new) = reading.said else {
                panic!()
            };
            assert!(
                matches!(new.motion, Motion::Manoeuvre(m) if m.kind == kind && m.gap == Some(3.0))
            );
        }
    }
}
