//! Bundles: packed on one machine, unpacked in an empty home, with the same tables to the byte.

use std::io::Read;
use std::path::Path;

use nearmiss::store::{Choice, NewRating, RatedAnswer, RunId, Store};
use nearmiss::verdict::Task;
use serde_json::Value;

use super::batches::home as home_with;
use super::reports::half_of_them;
use super::support::program::{Ended, Home};
use super::{bundled_ego, bundled_xml};

const RED_LIGHT: &str = "ZAM_RedLight-1_1_T-1";
const CUT_IN: &str = "ZAM_CutIn-1_1_T-1";
const MERGE: &str = "ZAM_Merge-1_1_T-1";

pub fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

/// A home with a batch that needs all that a bundle has to carry: files of the user's with labels, one without an ego, a
/// template and thresholds of the user's, renumbered obstacles, several leads and samples.
async fn home_with_batch() -> Home {
    let server = half_of_them().await;
    let home = home_with(server.base_url());
    for name in [RED_LIGHT, CUT_IN, MERGE] {
        home.write(format!("rec/{name}.xml"), bundled_xml(name));
        home.write(format!("rec/{name}.ego_trajectory.csv"), bundled_ego(name));
    }
    home.write("rec/deep/Egoless.xml", bundled_xml(CUT_IN));
    let labels = format!("scenario,label\n{RED_LIGHT},yes\n{CUT_IN},no\n{MERGE},no\nEgoless,no\n");
    home.write("labels.csv", labels);
    let prompts = home.config().join("prompts");
    let own = include_str!("../../prompts/collision-ego.md").to_string() + "\nBe brief.\n";
    home.write(prompts.join("collision-ego.md"), own);
    home.write(
        prompts.join("_risk.md"),
        "Give each obstacle a risk score from 0 to 5.\n",
    );
    home.write(
        home.config().join("thresholds.toml"),
        "[[level]]\nscore = 2\ndistance = 1.3\ntime = 1.15\n",
    );
    let batch = run(
        &home,
        &[
            "evaluate",
            "rec",
            RED_LIGHT,
            "--model",
            "lab/tiny",
            "--task",
            "collision,safety",
            "--techniques",
            "base,all",
            "--samples",
            "2",
            "--set",
            "leads=0.5,1",
            "--set",
            "transforms=mirror;renumber:1",
            "--truth",
            "labels.csv",
            "--set",
            "compare=ego · base · lab/tiny,ego · all · lab/tiny",
        ],
    );
    assert!(matches!(batch.status, Some(0 | 1)), "{}", batch.stderr);
    let store = Store::open(&home.data().join("runs.sqlite")).unwrap();
    let answer = |run| RatedAnswer {
        run: Some(RunId(run)),
        model: "lab/tiny".into(),
        prompt: "ego · base".into(),
        ..RatedAnswer::default()
    };
    store
        .rate(&NewRating {
            person: "ada".into(),
            scenario: CUT_IN.into(),
            task: Task::Safety,
            blind: true,
            seed: 7,
            choice: Choice::Best(1),
            notes: String::new(),
            answers: vec![answer(1), answer(2)],
        })
        .unwrap();
    home
}

/// The tables of a batch in all formats, and what is said beside them.
fn tables(home: &Home, batch: &str) -> Vec<(String, String)> {
    let mut tables = Vec::new();
    for format in ["md", "latex", "csv", "json"] {
        let pairs = home.files().join("pairs.csv");
        let name = pairs.display().to_string();
        let with = ["--format", format, "--pairs", &name, "--overwrite"];
        let report = run(home, &[&["report", "--batch", batch], &with[..]].concat()).status(0);
        tables.push((format.into(), report.stdout));
        tables.push((format!("{format}: words"), report.stderr));
        tables.push((
            format!("{format}: pairs"),
            std::fs::read_to_string(&pairs).unwrap(),
        ));
    }
    tables
}

/// All of a bundle's bytes, unpacked, and the names of its members.
pub fn opened(bundle: &Path) -> (Vec<u8>, Vec<String>) {
    let mut bytes = Vec::new();
    let file = std::fs::File::open(bundle).unwrap();
    flate2::read::GzDecoder::new(file)
        .read_to_end(&mut bytes)
        .unwrap();
    let mut tar = tar::Archive::new(bytes.as_slice());
    let names = tar
        .entries()
        .unwrap()
        .map(|entry| {
            let entry = entry.unwrap();
            entry.path().unwrap().display().to_string()
        })
        .collect();
    (bytes, names)
}

fn rows(home: &Home) -> Vec<Vec<std::collections::BTreeMap<String, Option<String>>>> {
    let tables = ["runs", "batches", "items", "ratings", "rated"];
    tables
        .map(|table| home.rows(&format!("SELECT * FROM {table}")))
        .to_vec()
}

fn tree(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path)
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                found.push((name, std::fs::read(&path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_empty_home_prints_the_same_tables_to_the_byte() {
    let home = home_with_batch().await;
    let packed_here = tables(&home, "b1");
    run(
        &home,
        &[
            "runs",
            "export",
            "--format=bundle",
            "--batch",
            "last",
            "-o",
            "e.nearmiss",
        ],
    )
    .status(0)
    .says(&["e.nearmiss"]);
    let bundle = home.files().join("e.nearmiss");
    let (bytes, names) = opened(&bundle);
    let text = String::from_utf8_lossy(&bytes);
    let folder = home.files();
    let machine = folder.parent().unwrap().display().to_string();
    assert!(
        !text.contains(&machine),
        "no folder of this machine is in a bundle"
    );
    for name in [
        "manifest.json",
        "experiment.toml",
        "thresholds.toml",
        "templates/collision-ego.md",
        "templates/_risk.md",
        "truth/labels.csv",
        "ratings.jsonl",
        "batch.jsonl",
    ] {
        assert!(names.iter().any(|own| own == name), "{name}: {names:?}");
    }
    assert!(!names.iter().any(|name| name.starts_with("scenarios/")));

    let other = Home::new();
    std::fs::copy(&bundle, other.files().join("e.nearmiss")).unwrap();
    drop(home);
    let unpack = ["runs", "import", "e.nearmiss"];
    run(&other, &unpack).status(0).says(&["b1"]);
    for ((name, here), (_, there)) in packed_here.iter().zip(tables(&other, "last")) {
        assert_eq!(*here, there, "{name}");
    }
    let ratings = run(&other, &["runs", "ratings", "export"]).status(0);
    assert!(ratings.stdout.contains("ada"), "{}", ratings.stdout);
    // A second time nothing changes, wherever the files go.
    let (before, files) = (rows(&other), tree(&other.files().join("e")));
    run(&other, &unpack)
        .status(0)
        .says(&["0 runs", "0 files written"]);
    assert_eq!(rows(&other), before);
    assert_eq!(tree(&other.files().join("e")), files);
    run(&other, &["runs", "import", "e.nearmiss", "--into", "x"]).status(0);
    assert_eq!(rows(&other), before);
    // Packed again it gives the same tables a third time.
    run(
        &other,
        &[
            "runs",
            "export",
            "--format=bundle",
            "--batch",
            "b1",
            "-o",
            "again.nearmiss",
        ],
    )
    .status(0);
    let third = Home::new();
    let again = std::fs::read(other.files().join("again.nearmiss")).unwrap();
    third.write("again.nearmiss", again);
    run(&third, &["runs", "import", "again.nearmiss"]).status(0);
    for ((name, here), (_, there)) in packed_here.iter().zip(tables(&third, "b1")) {
        assert_eq!(*here, there, "{name}, packed twice");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn scenarios_in_a_bundle_can_be_asked_about_again_and_the_own_bundle_changes_nothing() {
    let home = home_with_batch().await;
    let pack = [
        "runs",
        "export",
        "--format=bundle",
        "--batch",
        "b1",
        "-o",
        "e.nearmiss",
        "--with-scenarios",
    ];
    run(&home, &pack).status(0);
    run(&home, &pack).status(2).says(&["--overwrite"]);
    let before = rows(&home);
    run(&home, &["runs", "import", "e.nearmiss"]).status(0);
    assert_eq!(rows(&home), before, "where it was packed");

    let show = run(
        &home,
        &["runs", "import", "--dry-run", "e.nearmiss", "--format=json"],
    )
    .status(0)
    .json();
    assert_eq!(show["provenance"]["batch"], "b1");
    let included = |one: &Value| one["included"].as_bool().unwrap();
    let scenarios = show["scenarios"].as_array().unwrap();
    assert_eq!(
        scenarios.iter().filter(|one| included(one)).count(),
        3,
        "{show}"
    );
    let listed = run(&home, &["runs", "import", "--dry-run", "e.nearmiss"]).status(0);
    let ego = format!("scenarios/rec/{RED_LIGHT}.ego_trajectory.csv");
    assert!(listed.stdout.contains(&ego), "{}", listed.stdout);

    let other = Home::new();
    let bundle = std::fs::read(home.files().join("e.nearmiss")).unwrap();
    other.write("e.nearmiss", bundle);
    // Another batch has its number there.
    let first = [
        "evaluate",
        CUT_IN,
        "--model",
        "reference/geometry",
        "--samples",
        "1",
    ];
    run(&other, &first).status(0);
    run(&other, &["runs", "import", "e.nearmiss", "--into", "d"])
        .status(0)
        .says(&["b2"]);
    let file = other
        .files()
        .join(format!("d/scenarios/rec/{RED_LIGHT}.xml"));
    assert_eq!(
        std::fs::read_to_string(file).unwrap(),
        bundled_xml(RED_LIGHT)
    );
    // With other templates and thresholds than the batch's nothing is asked.
    let again = run(&other, &["evaluate", "d/experiment.toml", "--dry-run"]);
    assert!(
        again.stderr.contains("collision-ego.md"),
        "{}",
        again.stderr
    );
    run(&other, &["evaluate", "b2"])
        .status(2)
        .says(&["thresholds.toml has changed"]);
    // With its own everything is answered, and the scenarios are found.
    let unpacked = other.files().join("d");
    let own = |name: &str| std::fs::read(unpacked.join(name)).unwrap();
    other.write(
        other.config().join("thresholds.toml"),
        own("thresholds.toml"),
    );
    for name in ["collision-ego.md", "_risk.md"] {
        let template = own(&format!("templates/{name}"));
        other.write(other.config().join("prompts").join(name), template);
    }
    let providers = std::fs::read(home.config().join("config.toml")).unwrap();
    other.write(other.config().join("config.toml"), providers);
    let resumed = run(&other, &["evaluate", "b2", "--dry-run", "--format=json"]);
    assert_eq!(resumed.status(0).json()["requests"], 0);
}
