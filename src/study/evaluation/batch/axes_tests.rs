//! Tests of axes and splits in specifications of batches.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use super::tests::{experiment, techniques};
use super::*;
use crate::evaluation::report::{Axis, Measure, PivotRequest};
use crate::evaluation::{AxisValues, Lead, PromptConfig, Protocol};
use nearmiss_ask::llm::Effort;
use nearmiss_ask::prompts::Pack;
use nearmiss_formats::EgoSelection;
use nearmiss_scene::description::{EgoAxes, Form, Frame};
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::Task;

/// A specification that was stored before batches had the keys of experiments.
const STORED: &str = r#"{"paths":["/data"],"tasks":["safety","collision"],"frames":["cartesian","ego","metrics"],"techniques":["cp+cot+icl"],"models":["reference/geometry"],"samples":1,"history":12,"radius":40.0,"lead":"0.5","within":1.5,"temperature":null,"max_tokens":500,"effort":"low","log_probabilities":true,"tools":{"rounds":3,"calls":32},"more_leads":["paper"],"transforms":["mirror","rotate:90"],"truth":"geometry","truth_files":[],"templates":{"safety-ego.md":"4042"},"thresholds":[],"base_url":null,"comparison":{"baseline":"reference/geometry","primary":["lab/a","lab/b"],"tables":[{"rows":"techniques","measure":"f1"}]},"form":"prose","stride":2,"ego_axes":"lane","measures":"ttc,thw","pack":"paper","protocol":"paper","axes":{"temperature":[0.0,0.7],"seed":[1,2],"tools":[false,true]},"select":"risk<6","split":{"test":0.5,"seed":2},"drawn_from":["/data/ZAM_CutIn-1_1_T-1.xml"]}"#;

#[test]
fn specs_that_are_stored_already_keep_their_meaning() {
    let spec = Spec::from_json(STORED).unwrap();
    let wanted = Experiment {
        scenarios: vec!["/data".into()],
        select: Some("risk<6".into()),
        split: Some(Split { test: 0.5, seed: 2 }),
        truth: Some(TruthSource::Geometry),
        models: vec!["reference/geometry".into()],
        samples: Some(1),
        tasks: vec![Task::Safety, Task::Collision],
        frames: vec![Frame::Cartesian, Frame::Ego, Frame::Metrics],
        techniques: vec![techniques("all")],
        leads: vec![Lead::Seconds(0.5), Lead::Paper],
        transforms: vec![Transform::Mirror, "rotate:90".parse().unwrap()],
        protocol: Protocol::Paper,
        within: Some(1.5),
        history: Some(12),
        radius: Some(40.0),
        form: Some(Form::Prose).into(),
        stride: Some(2).into(),
        axes: Some(EgoAxes::Lane),
        measures: vec!["ttc".into(), "thw".into()],
        pack: Pack::Paper,
        temperature: [0.0, 0.7].into_iter().collect(),
        max_tokens: Some(500),
        effort: Some(Effort::Low).into(),
        seed: [1, 2].into_iter().collect(),
        log_probabilities: true,
        tools: [false, true].into_iter().collect(),
        tool_rounds: 3,
        baseline: Some("reference/geometry".into()),
        compare: Some(("lab/a".into(), "lab/b".into())),
        tables: vec![PivotRequest {
            rows: Axis::Techniques,
            measure: Measure::F1,
            ..PivotRequest::default()
        }],
        ..Experiment::default()
    };
    assert_eq!(spec.experiment, wanted);
    assert_eq!(spec.templates["safety-ego.md"], "4042");
    assert_eq!(spec.drawn_from, ["/data/ZAM_CutIn-1_1_T-1.xml"]);
    assert_eq!(Spec::from_json(&spec.to_json()), Ok(spec));
    let files = STORED.replace(
        r#""truth":"geometry","truth_files":[]"#,
        r#""truth":"files","truth_files":["/a.csv"]"#,
    );
    let truth = Spec::from_json(&files).unwrap().experiment.truth;
    assert_eq!(truth, Some(TruthSource::Files(vec!["/a.csv".into()])));
}

#[test]
fn each_value_of_an_axis_is_a_way_of_asking_but_not_of_the_judge() {
    let matrix = Experiment {
        tasks: vec![Task::Safety],
        frames: vec![Frame::Ego],
        techniques: vec![techniques("base")],
        effort: [Effort::Low, Effort::High].into_iter().collect(),
        form: Form::ALL.into_iter().collect(),
        ..experiment()
    };
    let ways = matrix.ways();
    let names: Vec<String> = ways
        .iter()
        .map(crate::evaluation::report::name_of)
        .collect();
    assert_eq!(
        names,
        [
            "ego · base · lab/a · form prose, effort low",
            "ego · base · lab/a · form prose, effort high",
            "ego · base · lab/a · form compact, effort low",
            "ego · base · lab/a · form compact, effort high",
            "reference/geometry",
        ]
    );
}

#[test]
fn the_form_changes_the_words_and_the_effort_only_the_request() {
    let library = nearmiss_ask::prompts::Library::load(None);
    let thresholds = Arc::new(nearmiss_scene::metrics::Thresholds::shipped().clone());
    let builder = QuestionBuilder::new(
        library,
        thresholds,
        Experiment::default(),
        EgoSelection::Beside,
    );
    let entry = &nearmiss_formats::bundled()[0];
    let asked = |settings: AxisValues| {
        let way = PromptConfig {
            task: Task::Safety,
            frame: Some(Frame::Ego),
            techniques: Some(techniques("base")),
            model: "lab/a".into(),
            settings,
            template: None,
        };
        let question = builder.question(entry, &way, &Variant::default(), None);
        question.unwrap().description.clone()
    };
    let form = |form| AxisValues {
        form: Some(form),
        ..AxisValues::default()
    };
    let low = AxisValues {
        effort: Some(Effort::Low),
        ..AxisValues::default()
    };
    assert_ne!(asked(form(Form::Prose)), asked(form(Form::Compact)));
    assert_eq!(asked(low), asked(AxisValues::default()));
    let usual = nearmiss_ask::llm::Parameters::default();
    assert_eq!(low.parameters(usual).effort, Some(Effort::Low));
}
