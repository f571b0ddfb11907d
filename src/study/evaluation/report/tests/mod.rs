//! Tests of reports on small invented answers, counted by hand.
#![allow(clippy::unwrap_used)]

mod comparisons;

use nearmiss_ask::prompts::Techniques;
use nearmiss_scene::description::Frame;
use nearmiss_scene::verdict::{CriticalObstacle, ObstacleRisk, Task, Verdict};
use nearmiss_store::Consumed;

use super::*;
use crate::evaluation::{AnswerStatus, Cluster, Label};

fn json(value: &impl serde::Serialize) -> serde_json::Value {
    serde_json::to_value(value).unwrap()
}

fn verdict(task: Task, dangerous: bool, obstacles: &[(i64, u8)]) -> Verdict {
    let obstacle = |&(id, risk_score): &(i64, u8)| ObstacleRisk {
        id,
        risk_score,
        reason: String::new(),
        written_score: None,
    };
    Verdict {
        task,
        dangerous,
        obstacles: obstacles.iter().map(obstacle).collect(),
        justification: String::new(),
        critical: None,
        probability: None,
        token_probability: None,
        unknown: Vec::new(),
    }
}

fn configuration(task: Task, techniques: &str, model: &str) -> PromptConfig {
    PromptConfig {
        task,
        frame: Some(Frame::Ego),
        techniques: Some(Techniques::parse(techniques).unwrap()),
        model: model.into(),
        settings: crate::evaluation::AxisValues::default(),
        template: None,
    }
}

fn one(
    scenario: &str,
    configuration: &PromptConfig,
    truth: Option<Label>,
    status: AnswerStatus,
) -> Scored {
    Scored {
        scenario: scenario.into(),
        configuration: configuration.clone(),
        sample: 0,
        truth,
        critical: truth.map(Label::critical).unwrap_or_default(),
        status,
        reference: None,
        window: None,
        consumed: Consumed::default(),
        most_usd: None,
        superseded: Vec::new(),
        run: None,
        claims: nearmiss_store::ClaimCounts::default(),
        cluster: crate::evaluation::Cluster::default(),
    }
}

fn says(dangerous: bool, obstacles: &[(i64, u8)]) -> AnswerStatus {
    AnswerStatus::Verdict(verdict(Task::Safety, dangerous, obstacles))
}

/// Two collisions with obstacle 7, a yes to each, one of which names another obstacle, a false alarm, a right no, an answer
/// without a verdict, a failure, a scenario without a truth, and a question that was not asked.
fn answers(configuration: &PromptConfig) -> Vec<Scored> {
    let hit = Some(Label::Collision(Some(7)));
    let safe = Some(Label::Safe);
    vec![
        one("a", configuration, hit, says(true, &[(7, 0), (8, 3)])),
        one("b", configuration, hit, says(true, &[(8, 1), (7, 2)])),
        one("c", configuration, safe, says(true, &[(9, 2)])),
        one("d", configuration, safe, says(false, &[(9, 5)])),
        one(
            "e",
            configuration,
            hit,
            AnswerStatus::Unparsed("prose".into()),
        ),
        one("f", configuration, safe, AnswerStatus::Failed("429".into())),
        one("g", configuration, None, says(true, &[])),
        one(
            "h",
            configuration,
            safe,
            AnswerStatus::Unasked("not yet".into()),
        ),
    ]
}

#[test]
fn every_question_is_in_one_place() {
    let configuration = configuration(Task::Safety, "cp,cot", "lab/x");
    let mut scored = answers(&configuration);
    scored[0].reference = Some(verdict(Task::Safety, true, &[]));
    scored[3].reference = Some(verdict(Task::Safety, true, &[]));
    scored[0].consumed.cost_usd = Some(0.5);
    scored[0].consumed.duration_ms = Some(2000);
    let report = Report::from_scored(&scored);
    let names: Vec<_> = report.cells.iter().map(|c| c.half.name()).collect();
    assert_eq!(names, ["collision", "normal", "unknown", "all"]);
    let all = json(report.full_cells().next().unwrap());
    let number = |name: &str| all[name].as_u64().unwrap();
    let counts = [
        "n",
        "tp",
        "fp",
        "fn",
        "tn",
        "unparsed",
        "failed",
        "unasked",
        "unlabelled",
    ]
    .map(number);
    assert_eq!(counts, [8, 2, 1, 0, 1, 1, 1, 1, 1]);
    assert_eq!(counts[0], counts[1..].iter().sum::<u64>());
    assert_eq!(
        (&all["techniques"], &all["frame"]),
        (&"cp+cot".into(), &"ego".into())
    );
    assert_eq!(
        (number("named"), number("named_of"), number("named_first")),
        (1, 2, 1)
    );
    // Obstacles 7 and 8 were named on the collisions, 9 on a safe scenario.
    assert_eq!(
        (&all["naming_recall"], number("obstacles_named")),
        (&0.5.into(), 3)
    );
    assert!(
        all["naming_precision"]
            .as_f64()
            .is_some_and(|p| (p - 1.0 / 3.0).abs() < 1e-12)
    );
    // Risk scores 0, 1 (collisions), 2 and 5 (normal): (0 + 0.04 + 0.36 + 0) / 4.
    let brier = all["calibration"]["brier"].as_f64().unwrap();
    assert!((brier - 0.1).abs() < 1e-12, "{brier}");
    let calibration = &all["calibration"];
    assert_eq!(
        (
            &calibration["from_score"],
            &calibration["from_stated"],
            &calibration["auroc"]
        ),
        (&4.into(), &0.into(), &1.0.into())
    );
    assert_eq!(all["agreement_with_reference"], 0.5);
    assert_eq!((number("cost_unknown"), number("timed")), (6, 1));
    assert_eq!(
        (&all["cost_usd"], &all["seconds_median"]),
        (&0.5.into(), &2.0.into())
    );
    let half = json(&report.cells[0]);
    assert_eq!(
        (&half["precision"], &half["f1"]),
        (&serde_json::Value::Null, &serde_json::Value::Null)
    );
    assert_eq!((&half["recall"], &half["n"]), (&1.0.into(), &3.into()));
}

#[test]
fn samples_are_summed_up_by_scenario() {
    let configuration = configuration(Task::Collision, "all", "lab/x");
    let mut scored = Vec::new();
    for (scenario, truth, votes) in [
        ("a", Label::Collision(None), [true, true, false]),
        ("b", Label::Safe, [false, false, false]),
    ] {
        for (sample, said) in (0_u32..).zip(votes) {
            let mut answer = one(scenario, &configuration, Some(truth), says(said, &[]));
            answer.sample = sample;
            scored.push(answer);
        }
    }
    let mut tie = one("c", &configuration, Some(Label::Safe), says(true, &[]));
    scored.push(tie.clone());
    tie.status = says(false, &[]);
    scored.push(tie);
    let all = json(Report::from_scored(&scored).full_cells().next().unwrap());
    assert_eq!(
        (&all["techniques"], &all["n"], &all["scenarios"]),
        (&"cp+cot+icl".into(), &8.into(), &3.into())
    );
    let samples = &all["samples"];
    assert_eq!(
        samples["majority"],
        serde_json::json!({"tp": 1, "fp": 0, "fn": 0, "tn": 1})
    );
    assert_eq!(
        (&samples["unanimous"], &samples["undecided"]),
        (&1.into(), &1.into())
    );
}

#[test]
fn pairs_differ_in_one_thing_and_are_compared_by_scenario() {
    let (base, cp) = (
        configuration(Task::Safety, "base", "lab/x"),
        configuration(Task::Safety, "cp", "lab/x"),
    );
    let other = configuration(Task::Safety, "cp", "lab/y");
    let mut scored = answers(&base);
    scored.extend(answers(&cp));
    scored.extend(answers(&other));
    // With cp the false alarm is none.
    let at = scored
        .iter()
        .position(|s| s.configuration == cp && s.scenario == "c")
        .unwrap();
    scored[at].status = says(false, &[]);
    let report = Report::from_scored(&scored);
    let pairs: Vec<_> = report
        .pairs
        .iter()
        .map(|p| {
            (
                p.differs,
                p.n,
                p.left_out,
                p.mcnemar.only_first,
                p.mcnemar.only_second,
            )
        })
        .collect();
    // Four scenarios have a truth and verdicts, two have a truth and no verdict, one was not asked about; base with
    // lab/y differs in two things.
    assert_eq!(pairs, [("techniques", 6, 1, 0, 1), ("model", 6, 1, 1, 0)]);
    let csv = report.pair_rows().csv();
    let line = "safety,ego,base,lab/x,,,,safety,ego,cp,lab/x,,,,techniques,pairs,6,1,0,-0.16666666666666666,,,0.46693";
    let found = csv.lines().nth(1).unwrap();
    assert!(found.starts_with(line), "{csv}");
    // p, exact, p (Holm), McNemar's test, and no claims.
    assert!(found.contains(",1.0,true,1.0,0,1,,1.0,0,,,,"), "{csv}");
    assert_eq!(csv.lines().count(), 3, "{csv}");
}

#[test]
fn nothing_from_outside_is_obeyed() {
    let hostile = "lab/<script>alert(1)</script>|`a`\u{1b}[31m_&%$";
    let configuration = configuration(Task::Safety, "cp", hostile);
    let report = Report::from_scored(&answers(&configuration)).about(ReportSubject {
        notes: vec!["<b>note</b> \\input{x}".into()],
        ..ReportSubject::default()
    });
    let first = report.json().about.notes[0].clone();
    assert!(first.contains(": 2 of 6 (33 %)"), "{first}");
    let document = report.document("A & B");
    let html = document.html(&AnswerPage::default());
    assert!(
        !html.contains("<script") && !html.contains("<b>") && !html.contains('\u{1b}'),
        "{html}"
    );
    assert!(html.contains("&lt;script&gt;") && html.contains("prefers-color-scheme"));
    for outside in ["http:", "https:", "src=", "@import", "url("] {
        assert!(!html.contains(outside), "{outside}");
    }
    assert!(!html.contains("<figcaption></figcaption>"), "{html}");
    let latex = document.latex();
    // Beneath the table, not only as a comment.
    let printed: Vec<&str> = latex.lines().filter(|l| !l.starts_with('%')).collect();
    assert!(
        printed.contains(&"\\par $<$b$>$note$<$/b$>$ \\textbackslash{}input\\{x\\}"),
        "{latex}"
    );
    let first = |line: &&str| line.starts_with("\\emph{Notes.} Without a verdict");
    assert!(printed.iter().any(first), "{latex}");
    assert_eq!(
        latex.matches("\\begin{minipage}").count(),
        latex.matches("\\end{minipage}").count()
    );
    let explained = |line: &&str| line.starts_with("\\par Intervals are of 95 \\%");
    assert!(printed.iter().any(explained), "{latex}");
    assert!(
        latex.contains("\\_\\&\\%\\$") && latex.contains("\\toprule"),
        "{latex}"
    );
    let markdown = document.markdown();
    assert!(
        markdown.contains("\\<script") && markdown.contains("\\|\\`a\\`"),
        "{markdown}"
    );
    let mut lines = markdown.lines().filter(|l| l.contains("\\<script"));
    let line = lines.find(|l| l.starts_with('|')).unwrap();
    assert!(line.starts_with("| ego "), "{line}");
    let csv = report.rows().csv();
    assert_eq!(csv.lines().count(), 5, "a header and four cells");
    assert!(
        csv.lines().next().unwrap().ends_with(",batch,truth"),
        "{csv}"
    );
    assert!(
        csv.starts_with(
            "label,task,frame,techniques,model,settings,template,template_hash,n,tp,fp,fn,tn,unparsed,failed,"
        ),
        "{csv}"
    );
}

#[test]
fn ends_of_intervals_have_columns_of_their_own() {
    let csv = Report::from_scored(&answers(&configuration(Task::Safety, "cp", "lab/x")))
        .rows()
        .csv();
    let mut reader = ::csv::Reader::from_reader(csv.as_bytes());
    let heads = reader.headers().unwrap().clone();
    let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
    let value = |row: &::csv::StringRecord, name: &str| {
        let at = heads.iter().position(|head| head == name);
        row[at.unwrap_or_else(|| panic!("no {name} in {heads:?}"))].to_string()
    };
    let ends = [
        "precision",
        "recall",
        "specificity",
        "accuracy",
        "f1",
        "kappa",
    ];
    for row in &rows {
        for name in ends {
            let end = |which: &str| value(row, &format!("{name}_ci_{which}"));
            let (low, high) = (end("low"), end("high"));
            assert_eq!(low.is_empty(), high.is_empty(), "{name}");
            if !low.is_empty() {
                let (low, high): (f64, f64) = (low.parse().unwrap(), high.parse().unwrap());
                assert!(low <= high, "{name}: {low} {high}");
            }
        }
    }
    let all = rows
        .iter()
        .find(|row| value(row, "label") == "all")
        .unwrap();
    // Of fewer than ten answers there is no interval.
    for name in ["recall_ci_low", "f1_ci_high", "kappa_ci_low"] {
        assert!(heads.iter().any(|head| head == name) && value(all, name).is_empty());
    }
    assert!(!heads.iter().any(|head| head.ends_with("_ci")), "{heads:?}");
    // The rows of the labels are parts of that of all.
    let sum = |name: &str| -> u32 {
        let parts = rows.iter().filter(|row| value(row, "label") != "all");
        parts
            .map(|row| value(row, name).parse::<u32>().unwrap())
            .sum()
    };
    assert_eq!(sum("n").to_string(), value(all, "n"));
}

#[test]
fn what_is_known_to_cost_nothing_is_no_unknown_cost() {
    let models = configuration(Task::Safety, "cp", "lab/x");
    let judges = PromptConfig {
        frame: None,
        techniques: None,
        ..configuration(Task::Safety, "cp", nearmiss_scene::judge::MODEL)
    };
    let safe = Some(Label::Safe);
    let unsent = "nothing was sent: it may cost $0.10, and of the budget there is $0.01 left";
    let scored = [
        one("a", &models, safe, says(true, &[])),
        one("b", &models, safe, AnswerStatus::Failed(unsent.into())),
        one("c", &models, safe, AnswerStatus::Unasked("no ego".into())),
        one("d", &models, safe, AnswerStatus::Failed("cut".into())),
        one("a", &judges, safe, says(true, &[])),
    ];
    let report = Report::from_scored(&scored);
    let of = |configuration: &PromptConfig| {
        json(
            report
                .full_cells()
                .find(|c| c.configuration == *configuration)
                .unwrap(),
        )
    };
    let (model, judge) = (of(&models), of(&judges));
    assert_eq!(model["cost_unknown"], 2, "an answer and one that was cut");
    assert_eq!(
        (&judge["cost_unknown"], &judge["cost_usd"]),
        (&0.into(), &0.0.into())
    );
}

#[test]
fn every_verdict_has_a_probability_and_the_report_says_from_where() {
    let configuration = configuration(Task::Safety, "cp", "lab/x");
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
        one("a", &configuration, hit, AnswerStatus::Verdict(stated)),
        one("b", &configuration, safe, AnswerStatus::Verdict(listed)),
        one("c", &configuration, safe, says(false, &[(9, 5)])),
        one("d", &configuration, safe, says(false, &[])),
        one("e", &configuration, safe, AnswerStatus::Verdict(weighed)),
    ];
    let report = Report::from_scored(&scored);
    let cell = report.full_cells().next().unwrap();
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

#[test]
fn doubtful_verdicts_are_counted_and_said_first() {
    let says = |scenario: &str, change: fn(&mut Verdict)| {
        let mut verdict = verdict(Task::Safety, true, &[(7, 1)]);
        change(&mut verdict);
        let configuration = configuration(Task::Safety, "cp", "lab/a");
        one(
            scenario,
            &configuration,
            None,
            AnswerStatus::Verdict(verdict),
        )
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
