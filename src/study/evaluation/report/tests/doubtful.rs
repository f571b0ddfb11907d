//! Verdicts that contradict themselves, or name obstacles twice or that are not there.

use super::*;

#[test]
fn doubtful_verdicts_are_counted_and_said_first() {
    let says = |scenario: &str, change: fn(&mut Verdict)| {
        let mut verdict = verdict(Task::Safety, true, &[(7, 1)]);
        change(&mut verdict);
        let way = way(Task::Safety, "cp", "lab/a");
        one(scenario, &way, None, AnswerStatus::Verdict(verdict))
    };
    let all = [
        says("A", |verdict| verdict.probability = Some(0.01)),
        says("B", |verdict| {
            verdict.obstacles.push(verdict.obstacles[0].clone())
        }),
        says("C", |verdict| verdict.unknown.push(429)),
        says("D", |verdict| verdict.probability = Some(0.99)),
    ];
    let report = Report::from_scored(&all).about(ReportSubject::default());
    let json = json(&report.json());
    let note = json["notes"][0].to_string();
    let words = "of 4: 1 contradictory, 1 with an obstacle that the scene does not have, 1 with an obstacle named twice.";
    assert!(note.contains(words), "{note}");
    let cell = json["cells"].as_array().unwrap().last().unwrap();
    for key in ["contradictory", "named_twice", "unknown_obstacles"] {
        assert_eq!(cell[key], 1, "{key}");
    }
}
