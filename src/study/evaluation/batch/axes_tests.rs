//! Tests of axes and splits in specifications of batches.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;

use super::tests::{matrix, techniques};
use super::*;
use crate::evaluation::{Axes, AxisValues, PromptConfig};
use nearmiss_ask::llm::Effort;
use nearmiss_formats::EgoSelection;
use nearmiss_scene::description::{Form, Frame};
use nearmiss_scene::verdict::Task;

/// The specification of a batch as versions without axes and splits stored it.
const WITHOUT_AXES: &str = r#"{"paths":["/data"],"tasks":["safety"],"frames":["ego"],"techniques":["cp+cot"],"models":["lab/a"],"samples":2,"history":null,"radius":30.0,"lead":"1","within":2.0,"temperature":0.5,"max_tokens":900,"effort":"low","truth":"geometry","truth_files":[],"templates":{"safety-ego.md":"ab"},"thresholds":[],"base_url":null}"#;

#[test]
fn specs_of_earlier_versions_keep_their_meaning_and_their_text() {
    let spec = Spec::from_json(WITHOUT_AXES).unwrap();
    let (matrix, request) = (&spec.matrix, &spec.matrix.request);
    assert_eq!(matrix.axes, Axes::default());
    assert_eq!(
        (request.effort, request.temperature),
        (Some(Effort::Low), Some(0.5))
    );
    assert_eq!(spec.subset, Subset::default());
    assert_eq!(matrix.ways().len(), 1);
    assert!(matrix.ways()[0].settings.is_empty());
    // The same text, by which a further run of an experiment finds its batch.
    assert_eq!(spec.to_json(), WITHOUT_AXES);
}

#[test]
fn each_value_of_an_axis_is_a_way_of_asking_but_not_of_the_judge() {
    let axes = Axes {
        efforts: vec![Effort::Low, Effort::High],
        forms: Form::ALL.to_vec(),
        ..Axes::default()
    };
    let matrix = Matrix {
        tasks: vec![Task::Safety],
        frames: vec![Frame::Ego],
        techniques: vec![techniques("base")],
        axes,
        ..matrix()
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
    let spec = Spec {
        title: None,
        matrix,
        subset: Subset {
            select: Some("tag:cut_in".into()),
            split: Some(Split { test: 0.5, seed: 7 }),
        },
        ..Spec::from_json(WITHOUT_AXES).unwrap()
    };
    assert_eq!(Spec::from_json(&spec.to_json()).unwrap(), spec);
}

#[test]
fn the_form_changes_the_words_and_the_effort_only_the_request() {
    let library = nearmiss_ask::prompts::Library::load(None);
    let thresholds = Arc::new(nearmiss_scene::metrics::Thresholds::shipped().clone());
    let builder = QuestionBuilder::new(
        library,
        thresholds,
        RequestSettings::default(),
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
