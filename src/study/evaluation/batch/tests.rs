//! Tests of matrix order, shards, axes, splits, and later additions.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_ask::llm::Effort;
use nearmiss_ask::prompts::{Pack, Techniques};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_scene::description::{EgoAxes, Form, Frame};
use nearmiss_scene::judge;
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::Task;

use super::*;
use crate::evaluation::report::{Axis, Measure, PivotRequest};
use crate::evaluation::{AxisValues, Label, Lead, PromptConfig, Protocol};

pub(super) fn techniques(words: &str) -> Techniques {
    Techniques::parse(words).unwrap()
}

pub(super) fn experiment() -> Experiment {
    Experiment {
        tasks: vec![Task::Collision, Task::Safety],
        frames: vec![Frame::Ego, Frame::Cartesian],
        techniques: vec![techniques("base"), techniques("cp+cot")],
        models: vec!["lab/a".into(), judge::MODEL.into()],
        samples: Some(3),
        ..Experiment::default()
    }
}

fn words(configuration: &PromptConfig) -> String {
    let frame = configuration.frame.map_or("-", Frame::name);
    let techniques = configuration
        .techniques
        .map_or("-".into(), |t| t.to_string());
    format!(
        "{} {frame} {techniques} {}",
        configuration.task.name(),
        configuration.model
    )
}

#[test]
fn ways_come_in_the_order_they_were_named_and_the_judge_once_for_each_task() {
    let configurations = experiment().configurations();
    let said: Vec<String> = configurations.iter().map(words).collect();
    let wanted = [
        "collision ego base lab/a",
        "collision - - reference/geometry",
        "collision ego cp+cot lab/a",
        "collision cartesian base lab/a",
        "collision cartesian cp+cot lab/a",
        "safety ego base lab/a",
        "safety - - reference/geometry",
        "safety ego cp+cot lab/a",
        "safety cartesian base lab/a",
        "safety cartesian cp+cot lab/a",
    ];
    assert_eq!(said, wanted);
    let samples: u32 = configurations
        .iter()
        .map(|configuration| experiment().samples_for(configuration))
        .sum();
    assert_eq!(samples, 8 * 3 + 2, "the judge always says the same");
}

#[test]
fn leads_and_changes_are_asked_beside_the_original_not_of_each_other() {
    let mut matrix = experiment();
    matrix.leads = vec![Lead::Seconds(0.5), Lead::Seconds(1.0)];
    matrix.transforms = vec![Transform::Mirror];
    let variants = |task| {
        let configurations = matrix.configurations();
        let configuration = configurations
            .iter()
            .find(|configuration| configuration.task == task)
            .unwrap();
        let words = matrix
            .variants(configuration)
            .into_iter()
            .map(|v| v.stored());
        words.collect::<Vec<_>>()
    };
    let word = |word: &str| Some(word.to_string());
    let wanted = [
        (word("0.5"), None),
        (word("1"), None),
        (word("0.5"), word("mirror")),
    ];
    assert_eq!(variants(Task::Safety), wanted);
    let wanted = [(None, None), (None, word("mirror"))];
    assert_eq!(variants(Task::Collision), wanted, "no leads");
}

#[test]
fn what_is_added_stands_behind_what_is_there_and_nothing_twice() {
    let mut more = experiment();
    more.extend(&Experiment {
        models: vec!["lab/a".into(), "lab/b".into()],
        techniques: vec![techniques("cot+cp")],
        samples: Some(2),
        ..Experiment::default()
    });
    assert_eq!(more.models, ["lab/a", judge::MODEL, "lab/b"]);
    assert_eq!(more.techniques, experiment().techniques);
    assert_eq!(more.samples(), 3, "samples are not taken away");
    more.extend(&Experiment {
        techniques: vec![techniques("all")],
        samples: Some(5),
        ..Experiment::default()
    });
    assert_eq!((more.techniques.len(), more.samples()), (3, 5));
    let (before, after) = (experiment().configurations(), more.configurations());
    assert!(
        before
            .iter()
            .all(|configuration| after.contains(configuration))
    );
    assert_eq!(after.len(), 2 * (2 * 3 * 2 + 1));
}

#[test]
fn leads_and_changes_are_added_beside_the_first_lead() {
    let mut more = experiment();
    more.leads = vec![Lead::Seconds(0.5)];
    let added = Experiment {
        leads: vec![Lead::Seconds(0.5), Lead::Seconds(1.0), Lead::Seconds(1.0)],
        transforms: vec![Transform::Mirror, Transform::Mirror],
        ..Experiment::default()
    };
    more.extend(&added);
    more.extend(&added);
    assert_eq!(more.more_leads(), [Lead::Seconds(1.0)]);
    assert_eq!(more.transforms, [Transform::Mirror]);
}

#[test]
fn shards_have_every_scenario_once_whatever_the_order() {
    let names: Vec<String> = (0..500).map(|n| format!("DEU_Town-{n}_1_T-1")).collect();
    for of in [1, 2, 7, 16] {
        let mut owners: BTreeMap<&str, Vec<u32>> = BTreeMap::new();
        for number in 1..=of {
            let shard: Shard = format!("{number}/{of}").parse().unwrap();
            for name in names.iter().rev().filter(|name| shard.has(name)) {
                owners.entry(name).or_default().push(number);
            }
        }
        assert_eq!(owners.len(), names.len(), "all of them");
        assert!(owners.values().all(|owners| owners.len() == 1), "each once");
        let first = owners.values().filter(|owners| owners[0] == 1).count();
        assert!(
            first > 500 / of as usize / 2,
            "about as many each: {first} of 1/{of}"
        );
    }
    // By `printf ZAM_A-1 | sha256sum`: the first eight bytes are odd or even.
    assert!(
        "1/2".parse::<Shard>().unwrap().has("ZAM_A-1")
            != "2/2".parse::<Shard>().unwrap().has("ZAM_A-1")
    );
    for wrong in ["0/2", "3/2", "1", "1/0", "a/b", "-1/2"] {
        assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
    }
}

#[test]
fn a_spec_comes_back_from_the_store_as_it_was() {
    for truth in [
        TruthSource::Geometry,
        TruthSource::Layout,
        TruthSource::Files(vec!["/t.csv".into()]),
    ] {
        let spec = Spec {
            experiment: Experiment {
                scenarios: vec![PathBuf::from("/data"), PathBuf::from("ZAM_CutIn-1_1_T-1")],
                truth: Some(truth),
                history: Some(7),
                radius: Some(25.5),
                leads: vec![Lead::Seconds(1.5)],
                within: Some(2.5),
                every_scenario: true,
                protocol: Protocol::Paper,
                temperature: Some(0.0).into(),
                max_tokens: Some(900),
                effort: Some(Effort::Low).into(),
                log_probabilities: true,
                tools: Some(true).into(),
                tool_rounds: 3,
                tool_calls: 9,
                form: Some(Form::Prose).into(),
                stride: Some(2).into(),
                road: Some(true),
                axes: Some(EgoAxes::Lane),
                measures: vec!["thw".into(), "ttc".into()],
                pack: Pack::Paper,
                seed: Some(7).into(),
                base_url: Some("http://127.0.0.1:1".into()),
                ..experiment()
            },
            templates: BTreeMap::from([("collision-ego.md".into(), "ab".into())]),
            thresholds: vec!["risk 1 distance = 3 m".into()],
            drawn_from: vec!["/data/a.xml".into()],
            ..Spec::default()
        };
        let json = spec.to_json();
        assert!(
            ["transforms", "ego\":", "drafts", "baseline"]
                .iter()
                .all(|name| !json.contains(name)),
            "defaults are not written"
        );
        assert_eq!(Spec::from_json(&json), Ok(spec.clone()));
        let mut varied = spec;
        varied.experiment.leads = vec![Lead::Seconds(1.5), Lead::Paper, Lead::Seconds(0.5)];
        varied.experiment.transforms = vec![Transform::Mirror, Transform::Move(1000.0, -500.0)];
        varied.ego = EgoSelection::File {
            path: "/data/ego.csv".into(),
            planning_problem: Some(3),
        };
        varied.experiment.baseline = Some("lab/x".into());
        varied.experiment.compare = Some(("lab/x".into(), "lab/y".into()));
        varied.experiment.split = Some(Split { test: 0.5, seed: 7 });
        varied.drafts = BTreeMap::from([("collision-ego.md".into(), "my text".into())]);
        assert_eq!(Spec::from_json(&varied.to_json()), Ok(varied));
    }
    let error = Spec::from_json("{}").unwrap_err().to_string();
    assert!(error.contains("start a new batch"), "{error}");
}

#[test]
fn a_changed_template_is_noticed() {
    let library = nearmiss_ask::prompts::Library::load(None);
    let thresholds = nearmiss_scene::metrics::Thresholds::shipped();
    let mut spec = Spec {
        experiment: experiment(),
        templates: Spec::templates_for(&experiment(), &library),
        ..Spec::default()
    };
    assert_eq!(spec.templates.len(), 4, "two tasks, two frames");
    assert_eq!(spec.ensure_unchanged(&library, thresholds), Ok(()));
    spec.templates
        .insert("collision-ego.md".into(), "0".repeat(64));
    let error = spec
        .ensure_unchanged(&library, thresholds)
        .unwrap_err()
        .to_string();
    for words in [
        "template collision-ego.md",
        "(000000000000…)",
        "`nearmiss prompt text collision-ego.md`",
        "or start a new batch",
    ] {
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn a_draft_is_part_of_its_batch() {
    let library = nearmiss_ask::prompts::Library::load(None);
    let file = "collision-ego.md";
    let shipped = nearmiss_ask::prompts::Library::shipped(file).unwrap();
    let drafts = BTreeMap::from([(
        file.to_string(),
        shipped.replace("Did the", "Be brief. Did the"),
    )]);
    let mut spec = Spec {
        experiment: experiment(),
        drafts,
        ..Spec::default()
    };
    spec.templates = Spec::templates_for(&spec.experiment, &spec.library(&library).unwrap());
    assert_ne!(
        spec.templates,
        Spec::templates_for(&spec.experiment, &library)
    );
    let thresholds = nearmiss_scene::metrics::Thresholds::shipped();
    assert_eq!(spec.ensure_unchanged(&library, thresholds), Ok(()));
    let builder = spec
        .builder(&library, Arc::new(thresholds.clone()))
        .unwrap();
    let (entry, configuration) = (
        &nearmiss_formats::bundled()[0],
        &spec.experiment.configurations()[0],
    );
    let question = builder
        .question(entry, configuration, &Variant::default(), None)
        .unwrap();
    assert!(question.prompt.user.contains("Be brief. Did the"));
    assert_eq!(question.template_hash, spec.templates[file]);
    spec.drafts.insert(file.into(), "no front matter".into());
    let error = spec
        .ensure_unchanged(&library, thresholds)
        .unwrap_err()
        .to_string();
    assert!(error.contains(file), "{error}");
}

#[test]
fn what_templates_decide_is_told_in_numbers() {
    let library = nearmiss_ask::prompts::Library::load(None);
    let mut spec = Spec {
        experiment: experiment(),
        templates: Spec::templates_for(&experiment(), &library),
        ..Spec::default()
    };
    let described = spec.described(&library).unwrap();
    assert_eq!(described.history, [10], "as the paper");
    let radius = described.radius[0];
    assert!(described.radius.len() == 1 && radius > 0.0, "{described:?}");
    let asked = spec.asked(Some(&described));
    assert_eq!(
        (&asked["history"], &asked["radius"]),
        (&10.into(), &radius.into())
    );
    assert_eq!(
        asked["of_templates"],
        serde_json::json!(["history", "radius"])
    );
    let words = spec.request_summary(Some(&described));
    assert!(words.contains("history 10 (from the templates)"), "{words}");
    // What the batch says itself is no matter of the templates.
    spec.experiment.history = Some(5);
    let described = spec.described(&library).unwrap();
    let asked = spec.asked(Some(&described));
    assert_eq!(
        (&asked["history"], &asked["of_templates"]),
        (&5.into(), &serde_json::json!(["radius"]))
    );
    let words = spec.request_summary(Some(&described));
    assert!(words.contains("history 5 steps, radius"), "{words}");
    // Other templates would tell other numbers.
    spec.templates
        .insert("collision-ego.md".into(), "0".repeat(64));
    assert_eq!(spec.described(&library), None);
    assert!(spec.asked(None)["radius"].is_null());
    assert!(!spec.request_summary(None).contains("(from the templates)"));
}

#[test]
fn folders_say_which_half_and_annotations_whom() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("Results/LLM/Scenario_Collision/ego");
    std::fs::create_dir_all(&folder).unwrap();
    let csv = "Scenario_Name,Obstacle_ID\nA,30308\nC,none\n";
    std::fs::write(folder.join("annotations.csv"), csv).unwrap();
    let entry = |path: &str| Entry::of_file(&root.path().join("Scenarios").join(path));
    let entries = [
        entry("collision_scenarios/A.xml"),
        entry("collision_scenarios/deep/B.xml"),
        entry("collision_scenarios/C.xml"),
        entry("normal_scenarios/D.xml"),
        Entry::of_file(Path::new("elsewhere/E.xml")),
    ];
    assert_eq!(TruthSource::default_for(&entries), TruthSource::Layout);
    assert_eq!(
        TruthSource::default_for(&entries[4..]),
        TruthSource::Geometry
    );
    let (truth, doubts) = Truth::open(&TruthSource::Layout, &entries).unwrap();
    let found: Vec<_> = entries
        .iter()
        .map(|entry| truth.label(entry, None))
        .collect();
    let wanted = [
        Some(Label::Collision(Some(30308))),
        Some(Label::Collision(None)),
        Some(Label::Collision(None)),
        Some(Label::Safe),
        None,
    ];
    assert_eq!(found, wanted);
    assert_eq!(doubts.len(), 1, "{doubts:?}");
    assert!(doubts[0].starts_with("C: "), "{doubts:?}");
}

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
    let configurations = matrix.configurations();
    let names: Vec<String> = configurations
        .iter()
        .map(crate::evaluation::report::configuration_name)
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
        let configuration = PromptConfig {
            task: Task::Safety,
            frame: Some(Frame::Ego),
            techniques: Some(techniques("base")),
            model: "lab/a".into(),
            settings,
            template: None,
        };
        let question = builder.question(entry, &configuration, &Variant::default(), None);
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
