//! Tables over axes: what is counted where, and differences that pair what is asked alike.

use super::{AskedFacts, Axis, Measure, Pivot, PivotRequest};
use crate::evaluation::tests_scored::answer;
use crate::evaluation::{AnswerCase, Label, Lead, Scored};
use nearmiss_ask::prompts::Techniques;
use nearmiss_scene::description::Frame;
use nearmiss_store::{RunId, RunOrigin};

fn request(rows: Axis, columns: Option<Axis>) -> PivotRequest {
    PivotRequest {
        rows,
        columns,
        measure: Measure::Accuracy,
        against: None,
    }
}

/// Twelve scenarios of which half collide; `cp` is always right, `base` says yes to everything.
fn answers() -> Vec<Scored> {
    let mut all = Vec::new();
    for n in 0..12 {
        for model in ["lab/x", "lab/y"] {
            for techniques in ["base", "cp"] {
                let truth = n % 2 == 0;
                let mut one = answer(
                    &format!("DEU_A-{n}"),
                    model,
                    truth || techniques == "base",
                    &[],
                );
                one.truth = Some(if truth {
                    Label::Collision(None)
                } else {
                    Label::Safe
                });
                one.configuration.frame = Some(Frame::Ego);
                one.configuration.techniques = Techniques::parse(techniques).ok();
                one.run = Some(RunId(i64::try_from(all.len()).unwrap()));
                all.push(one);
            }
        }
    }
    all
}

#[test]
fn cells_have_their_answers_and_intervals() {
    let all = answers();
    let cases = AnswerCase::all(&all);
    let pivot = Pivot::new(
        &cases,
        AskedFacts::default(),
        request(Axis::Model, Some(Axis::Techniques)),
    )
    .unwrap();
    let [part] = &pivot.parts[..] else {
        panic!("{pivot:?}")
    };
    assert_eq!((part.counted, part.cells.len()), ((12, 48), 4));
    let shares = part.cells.iter().map(|one| one.cell.confusion.accuracy());
    assert_eq!(
        shares.collect::<Vec<_>>(),
        [Some(0.5), Some(1.0), Some(0.5), Some(1.0)]
    );
    let markdown = pivot.document().markdown();
    assert!(
        markdown.contains("Accuracy by model and techniques, safety task: 12 scenarios, n = 48"),
        "{markdown}"
    );
    assert!(
        markdown.contains("| Model | ") && markdown.contains("0.50 [0.25, 0.75], n = 12"),
        "{markdown}"
    );
    let csv = pivot.rows().csv();
    assert!(
        csv.starts_with(
            "task,model,techniques,n,answered,scenarios,accuracy,accuracy_ci_low,accuracy_ci_high,tp,"
        ),
        "{csv}"
    );
    let country = Pivot::new(&cases, AskedFacts::default(), request(Axis::Country, None)).unwrap();
    assert_eq!(country.parts[0].cells[0].row.text, "DEU");
}

#[test]
fn differences_pair_what_is_asked_alike() {
    let mut all = answers();
    // Half of the answers of one model are missing: the pairs of the other half count.
    all.retain(|one| {
        one.configuration.model == "lab/x"
            || one.scenario.len() > 7
            || one.scenario.as_str() < "DEU_A-5"
    });
    let cases = AnswerCase::all(&all);
    let against = PivotRequest {
        against: Some("base".into()),
        ..request(Axis::Techniques, Some(Axis::Model))
    };
    let pivot = Pivot::new(&cases, AskedFacts::default(), against.clone()).unwrap();
    let [x, y] = &pivot.parts[0].differences[..] else {
        panic!("{pivot:?}")
    };
    assert_eq!((x.row.text.as_str(), x.units, y.units), ("cp", 12, 7));
    assert_eq!(x.test.difference, 0.5);
    assert!(x.corrected >= x.test.p && y.corrected >= y.test.p);
    let latex = pivot.document().latex();
    assert!(
        latex.contains("\\toprule")
            && latex.contains("\\label{tab:nearmiss-safety-accuracy-techniques-model-against}"),
        "{latex}"
    );
    let wrong = PivotRequest {
        against: Some("bas".into()),
        ..against
    };
    let error = Pivot::new(&cases, AskedFacts::default(), wrong).unwrap_err();
    assert_eq!(
        error,
        "no answer has the techniques `bas`; did you mean `base`?"
    );
}

#[test]
fn leads_and_transforms_count_only_on_their_axes() {
    let mut all = answers();
    all.truncate(4);
    all[3].scenario = "DEU_A-0 [mirror]".into();
    let leads = [Some(1.0), Some(2.0), Some(1.0), Some(1.0)];
    let cases: Vec<_> = all
        .iter()
        .zip(leads)
        .map(|(scored, lead)| AnswerCase {
            scored,
            lead: lead.map(Lead::Seconds),
        })
        .collect();
    let rows = |axis| {
        let pivot = Pivot::new(&cases, AskedFacts::default(), request(axis, None)).unwrap();
        let cells = pivot.parts[0].cells.iter();
        cells
            .map(|one| (one.row.text.clone(), one.cell.n))
            .collect::<Vec<_>>()
    };
    assert_eq!(rows(Axis::Frame), [("ego".to_string(), 2)]);
    assert_eq!(
        rows(Axis::Lead),
        [("1 s".to_string(), 2), ("2 s".to_string(), 1)]
    );
    assert_eq!(
        rows(Axis::Transform),
        [("none".to_string(), 2), ("mirror".to_string(), 1)]
    );
}

#[test]
fn parameters_and_returned_models_come_from_the_runs() {
    let all = answers();
    let cases = AnswerCase::all(&all);
    let fact = |n: i64| RunOrigin {
        run: RunId(n),
        model: "lab/x".into(),
        template: String::new(),
        template_hash: String::new(),
        scenario_hash: None,
        parameters: if n % 4 == 0 {
            "{\"effort\":\"high\",\"temperature\":0.5}"
        } else {
            "{}"
        }
        .into(),
        model_returned: Some(format!("x-2024-0{}", n % 2)),
        created_ms: 1_700_000_000_000 + n * 86_400_000,
    };
    let runs: Vec<RunOrigin> = (0..48).map(fact).collect();
    let facts = AskedFacts::new(&cases, &runs);
    assert!(facts.summary().unwrap().starts_with(
        "asked 2023-11-14 to 2023-12-31; models as returned: x-2024-00, x-2024-01 (lab/x)"
    ));
    let pivot = Pivot::new(
        &cases,
        facts,
        request(Axis::Effort, Some(Axis::Temperature)),
    )
    .unwrap();
    let cells: Vec<_> = pivot.parts[0]
        .cells
        .iter()
        .map(|one| (one.row.text.as_str(), one.cell.n))
        .collect();
    assert_eq!(cells, [("default", 36), ("high", 12)]);
}
