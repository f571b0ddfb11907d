//! Tests of experiment files.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use toml::Table;

use super::*;
use nearmiss_ask::llm::Effort;
use nearmiss_ask::prompts::Techniques;
use nearmiss_record::fields::Fields;
use nearmiss_scene::scenario::Transform;
use nearmiss_scene::verdict::Task;
use nearmiss_study::evaluation::batch::{ContentHash, Split, TemplatePin, TruthSource};
use nearmiss_study::evaluation::report::PivotRequest;
use nearmiss_study::evaluation::{Lead, PAPER_STEPS, Protocol};

fn read(text: &str) -> Result<Experiment, String> {
    read_experiment(text, Path::new("/lab/e.toml"), &Library::load(None))
}

const WHOLE: &str = r#"
title = "Does contextual prompting help?"
scenarios = ["ZAM_CutIn-1_1_T-1", "recorded", "/data/more.xml"]
truth = ["labels.csv"]
models = ["lab/a", "lab/b"]
tasks = ["safety"]
frames = ["ego", "cartesian"]
techniques = ["base", "cp+cot"]
samples = 3
leads = [0.5, 1, "end"]
within = 1.5
transforms = ["mirror", "rotate:90"]
history = 12
radius = 40
temperature = [0, 0.7]
max_tokens = 2000
effort = "low"
log_probabilities = true
base_url = "http://localhost:8080/v1"
budget = 2.5
baseline = "lab/a"
compare = ["lab/a", "lab/b"]
select = "tag:cut_in risk<3"
split = { test = 0.3, seed = 7 }
form = ["prose", "compact"]
stride = 2
road = true
axes = "lane"
pack = "paper"
seed = [1, 2]
tools = [false, true]
tool_rounds = 3

[[tables]]
rows = "techniques"
columns = "model"
against = "base"

[[tables]]
rows = "effort"
measure = "cost_usd"

[hashes]
ZAM_CutIn-1_1_T-1 = "0123456789ab"
twice = ["0123456789ab", "0123456789ac"]
"#;

#[test]
fn a_file_is_read_and_written_and_read_the_same() {
    let whole = read(WHOLE).unwrap();
    assert_eq!(
        whole.scenarios,
        ["ZAM_CutIn-1_1_T-1", "/lab/recorded", "/data/more.xml"].map(PathBuf::from)
    );
    assert_eq!(
        whole.truth,
        Some(TruthSource::Files(vec!["/lab/labels.csv".into()]))
    );
    assert_eq!(
        whole.leads,
        [Lead::Seconds(0.5), Lead::Seconds(1.0), Lead::Paper]
    );
    assert_eq!(whole.transforms[0], Transform::Mirror);
    assert_eq!((whole.radius, whole.within), (Some(40.0), Some(1.5)));
    assert_eq!(
        whole.configurations().len(),
        128,
        "techniques, frames, models, and four axes of two values"
    );
    let axes: Vec<&str> = whole.several().map(|(key, _)| key).collect();
    assert_eq!(axes, ["form", "temperature", "seed", "tools"]);
    let asked = whole.parameters();
    assert_eq!((whole.stride.one(), asked.temperature), (Some(2), None));
    let limits = asked.tools.map(|limits| (limits.rounds, limits.calls));
    assert_eq!(limits, Some((3, 32)));
    assert_eq!(asked.effort, Some(Effort::Low));
    assert_eq!(whole.split, Some(Split { test: 0.3, seed: 7 }));
    assert_eq!(whole.hashes["twice"].iter().count(), 2);
    let tables = &whole.tables;
    let words: Vec<String> = tables.iter().map(PivotRequest::summary).collect();
    assert_eq!(
        words,
        [
            "right_of_all by techniques and model, against base",
            "cost_usd by effort"
        ]
    );
    let text = experiment_toml(&whole, Path::new("/lab")).unwrap();
    assert!(text.contains("\"recorded\", \"/data/more.xml\""), "{text}");
    assert_eq!(read(&text).unwrap(), whole, "{text}");
}

#[test]
fn what_is_not_said_is_as_on_the_command_line() {
    let small = read("scenarios = [\"ZAM_CutIn-1_1_T-1\"]\nmodels = [\"lab/a\"]\n").unwrap();
    assert_eq!(small.tasks, [Task::Safety]);
    assert_eq!(small.techniques, [Techniques::ALL]);
    assert_eq!((small.samples(), small.budget), (1, None));
    assert_eq!(
        (&small.leads[..], small.within),
        (&[Lead::Seconds(1.0)][..], Some(2.0))
    );
}

#[test]
fn every_mistake_is_told_with_its_line_and_key() {
    let text = "scenarios = \"a.xml\"\nmodels = [\n  \"lab/a\",\n  \"lab\",\n]\nsamples = 0\ntechnique = [\"cp\"]\n\
        tasks = [\"saftey\"]\nleads = [3]\nwithin = 2\nbaseline = \"lab/c\"\ntransforms = [\"turn\"]\ncompare = [\"lab/a\"]\n\
        templates = [\"safety-ego.md\"]\neffort = 1\ntemperature = [0.5, 3]\nstride = 0\nform = \"tabel\"\n\
        split = { test = 1 }\nselect = \"verdict:differ\"\nhashes = { a = \"xyz\" }\n\
        tables = [{ rows = \"modle\" }]\nprotocol = \"papers\"\n";
    let said = read(text).unwrap_err();
    let said: Vec<&str> = said.lines().collect();
    let starts = [
        "/lab/e.toml:1: scenarios = \"a.xml\": expected a list of texts",
        "/lab/e.toml:4: models: lab: expected provider/model",
        "/lab/e.toml:6: samples = 0: expected a whole number from 1 to 1000",
        "/lab/e.toml:7: unknown key `technique`; did you mean `techniques`",
        "/lab/e.toml:8: tasks: unknown task `saftey`; did you mean `safety`?",
        "/lab/e.toml:9: leads: 3: the contact is later than within = 2 s, which makes the window safe",
        "/lab/e.toml:11: baseline: lab/c: no such model",
        "/lab/e.toml:12: transforms: invalid transform `turn`",
        "/lab/e.toml:13: compare = a list: expected a list of two different names",
        "/lab/e.toml:14: templates: safety-ego.md: expected NAME@HASH",
        "/lab/e.toml:15: effort = 1: expected one of",
        "/lab/e.toml:16: temperature: 3: expected a number from 0 to 2, or a list of them",
        "/lab/e.toml:17: stride = 0: expected a whole number from 1 to 1000, or a list of them",
        "/lab/e.toml:18: form: unknown form `tabel`",
        "/lab/e.toml:19: split: test = 1: expected a number above 0 and below 1",
        "/lab/e.toml:20: select: `verdict:` depends on your stored answers",
        "/lab/e.toml:21: hashes: a: expected 12 hexadecimal digits or more",
        "/lab/e.toml:22: tables: rows: unknown axis `modle`; did you mean `model`?",
        "/lab/e.toml:23: protocol: unknown protocol `papers`; did you mean `paper`?",
    ];
    assert_eq!(said.len(), starts.len(), "{said:#?}");
    for (said, start) in said.iter().zip(starts) {
        assert!(said.starts_with(start), "{said}\n{start}");
    }
    let missing = read("title = \"a\"").unwrap_err();
    assert!(missing.contains("scenarios is missing") && missing.contains("models is missing"));
    let broken = read("scenarios = [").unwrap_err();
    assert!(broken.starts_with("/lab/e.toml:1: "), "{broken}");
}

#[test]
fn options_of_one_frame_need_that_frame_and_known_words() {
    let start = "scenarios = [\"ZAM_CutIn-1_1_T-1\"]\nmodels = [\"lab/a\"]\n";
    let file = |rest: &str| read(&format!("{start}{rest}"));
    let read_ok = file("frames = [\"metrics\"]\nmeasures = [\"thw\", \"ttc\"]\n").unwrap();
    let measures = read_ok.measures().unwrap();
    assert_eq!(measures.ids(), ["thw", "ttc"]);
    let again = read_experiment(
        &experiment_toml(&read_ok, Path::new("/lab")).unwrap(),
        Path::new("/lab/e.toml"),
        &Library::load(None),
    );
    assert_eq!(again.unwrap().measures(), Some(measures));
    for (rest, wrong) in [
        ("measures = [\"darc\"]\n", "did you mean `drac`"),
        (
            "frames = [\"ego\"]\nmeasures = [\"ttc\"]\n",
            "measures is an option of the metrics frame",
        ),
        ("axes = \"lain\"\n", "unknown axes `lain`"),
        (
            "tables = [{ rows = \"task\", columns = \"task\" }]\n",
            "tables: columns: the rows have this axis; choose another",
        ),
        ("pack = \"papr\"\n", "unknown pack `papr`"),
    ] {
        let error = file(rest).unwrap_err();
        assert!(error.contains(wrong), "{error}");
    }
}

#[test]
fn the_papers_protocol_has_its_own_windows() {
    let text = "scenarios = [\"a.xml\"]\nmodels = [\"recorded/gpt-4o\"]\nprotocol = \"paper\"\n";
    let paper = read(text).unwrap();
    assert_eq!(paper.protocol, Protocol::Paper);
    assert_eq!((paper.lead(), paper.within), (None, None));
    assert_eq!(paper.history, Some(PAPER_STEPS));
    let written = experiment_toml(&paper, Path::new("/lab")).unwrap();
    assert!(written.contains("protocol = \"paper\""), "{written}");
    assert_eq!(read(&written).unwrap(), paper);
    let both = read(&format!("{text}leads = [1]\nwithin = 2\n")).unwrap_err();
    assert_eq!(both.matches("has windows of its own").count(), 2, "{both}");
}

#[test]
fn templates_of_another_text_are_refused() {
    let library = Library::load(None);
    let small = read("scenarios = [\"ZAM_CutIn-1_1_T-1\"]\nmodels = [\"lab/a\"]\n").unwrap();
    let templates = template_pins(&Spec {
        templates: Spec::templates_for(&small, &library),
        ..Spec::default()
    });
    let pinned = Experiment {
        templates,
        ..small.clone()
    };
    let text = experiment_toml(&pinned, Path::new("/lab")).unwrap();
    let pinned = read(&text).unwrap();
    assert!(batch_request(&pinned, Vec::new(), None, &library).is_ok());
    let name = &pinned.templates[0].name;
    let other = vec![TemplatePin {
        name: name.clone(),
        hash: "0123456789ab".into(),
    }];
    let other = Experiment {
        templates: other,
        ..small
    };
    let said = batch_request(&other, Vec::new(), None, &library).unwrap_err();
    assert!(
        said.contains(name.as_str()) && said.contains("0123456789ab"),
        "{said}"
    );
}

#[test]
fn the_schema_takes_what_is_read() {
    let schema = experiment_schema();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let valid = |text: &str| {
        let table: Table = toml::from_str(text).unwrap();
        validator.is_valid(&serde_json::to_value(table).unwrap())
    };
    assert!(valid(WHOLE));
    let written = experiment_toml(&read(WHOLE).unwrap(), Path::new("/lab")).unwrap();
    assert!(valid(&written));
    for wrong in [
        "samples = 0",
        "tasks = [\"saftey\"]",
        "technique = []",
        "compare = [\"a\"]",
        "leads = [\"later\"]",
        "effort = [\"lazy\"]",
        "stride = [0]",
        "split = { seed = 7 }",
        "split = { test = 1.5 }",
    ] {
        let text = format!("scenarios = [\"a\"]\nmodels = [\"lab/a\"]\n{wrong}\n");
        assert!(!valid(&text) && read(&text).is_err(), "{wrong}");
    }
    let properties = schema["properties"].as_object().unwrap();
    assert_eq!(properties.len(), Experiment::rows().len());
}

#[test]
fn scenarios_with_other_contents_are_named_before_anything_is_asked() {
    let library = Library::load(None);
    let small = read("scenarios = [\"ZAM_CutIn-1_1_T-1\"]\nmodels = [\"lab/a\"]\n").unwrap();
    let entries = || vec![Entry::of_argument(Path::new("ZAM_CutIn-1_1_T-1"))];
    let right = Experiment {
        hashes: scenario_hashes(&entries()),
        ..small.clone()
    };
    let text = experiment_toml(&right, Path::new("/lab")).unwrap();
    assert!(text.contains("[hashes]\nZAM_CutIn-1_1_T-1 = \""), "{text}");
    assert!(batch_request(&read(&text).unwrap(), entries(), None, &library).is_ok());
    let refused = |name: &str| {
        let hashes = BTreeMap::from([(
            name.to_string(),
            Some(ContentHash("0123456789ab".into())).into(),
        )]);
        let other = Experiment {
            hashes,
            ..small.clone()
        };
        batch_request(&other, entries(), None, &library).unwrap_err()
    };
    let said = refused("ZAM_CutIn-1_1_T-1");
    assert!(
        said.contains("ZAM_CutIn-1_1_T-1")
            && said.contains("has the hash")
            && said.contains("0123456789ab"),
        "{said}"
    );
    assert!(refused("gone").contains("gone is not among the scenarios"));
}

#[test]
fn too_many_ways_are_counted_and_not_made() {
    let list = |count: usize| {
        (0..count)
            .map(|i| i.to_string())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let text = |seeds: usize, more: &str| {
        format!(
            "scenarios = [\"ZAM_CutIn-1_1_T-1\"]\nmodels = [\"lab/a\"]\ntasks = [\"collision\"]\n\
             effort = [\"low\", \"medium\", \"high\"]\nseed = [{}]\nstride = [{}]\n{more}",
            list(seeds),
            (1..=30)
                .map(|i| i.to_string())
                .collect::<Vec<_>>()
                .join(", ")
        )
    };
    let begun = std::time::Instant::now();
    let why = read(&text(9000, "compare = [\"lab/a\", \"lab/b\"]\n")).unwrap_err();
    for words in [
        "models: 810000 ways of asking",
        "3 of effort",
        "9000 of seed",
        "30 of stride",
        "at most 100000",
    ] {
        assert!(why.contains(words), "{words}: {why}");
    }
    let why = read(&text(20_000, "")).unwrap_err();
    assert!(why.contains("seed: 20000 values, at most 10000"), "{why}");
    assert!(begun.elapsed() < std::time::Duration::from_secs(10));
    // Each is made once, without looking at all others.
    assert_eq!(
        read(&text(1000, "")).unwrap().configurations().len(),
        90_000
    );
}
