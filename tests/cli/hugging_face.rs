//! A batch as a data set for Hugging Face: card, Parquet, eval.yaml, the lock of test splits, and nothing of this machine.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;

use super::batches::{home as home_with, telling};
use super::support::program::{Ended, Home, contains};
use super::support::server::{Script, Server};
use super::{BUNDLED, CUT_IN, bundled_ego, bundled_xml};

type Rows = Vec<BTreeMap<String, Field>>;

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

fn export(home: &Home, folder: &str, more: &[&str]) -> Ended {
    let form = ["runs", "export", "--format", "huggingface", "--batch", "b1"];
    run(home, &[&form[..], &["-o", folder], more].concat())
}

/// The rows of a Parquet file, and the units of its columns.
fn table(file: &Path) -> Rows {
    let reader = SerializedFileReader::new(std::fs::File::open(file).unwrap()).unwrap();
    let rows = reader.get_row_iter(None).unwrap();
    rows.map(|row| {
        let row = row.unwrap();
        let cells = row.get_column_iter();
        cells
            .map(|(name, cell)| (name.clone(), cell.clone()))
            .collect()
    })
    .collect()
}

fn text<'a>(row: &'a BTreeMap<String, Field>, column: &str) -> &'a str {
    match &row[column] {
        Field::Str(text) => text,
        Field::Null => "",
        other => panic!("{column}: {other:?}"),
    }
}

/// The files below a folder, by their names in it.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(inside) = folders.pop() {
        for entry in std::fs::read_dir(inside).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_path_buf();
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

fn names(folder: &Path) -> Vec<String> {
    let names = files(folder).into_keys();
    names.map(|name| name.display().to_string()).collect()
}

/// A word to a yes or no, half of the time yes; one of the models says nothing that can be read.
fn says(body: &[u8]) -> Script {
    if contains(body, b"\"dull\"") {
        return telling("I cannot say.");
    }
    let sum = body.iter().fold(7_u32, |sum, byte| {
        sum.wrapping_mul(31).wrapping_add(u32::from(*byte))
    });
    let yes = sum.count_ones() % 2 == 0;
    telling(&format!(
        "{{\"justification\": \"so\", \"obstacles\": [], \"critical_obstacles\": [], \"collision\": {yes}}}"
    ))
}

/// Checks the indentation and the form of each line: `key: value`, `key:` before deeper lines, `- …`; gives the lines.
fn yaml(text: &str) -> Vec<&str> {
    let mut before: Option<(usize, bool)> = None;
    for line in text.lines().filter(|line| !line.is_empty()) {
        let content = line.trim_start();
        let is_item = content.starts_with("- ");
        let depth = line.len() - content.len();
        let rest = content.strip_prefix("- ").unwrap_or(content);
        let (key, value) = rest.split_once(':').unwrap_or((rest, "plain"));
        assert!(!line.contains('\t') && depth % 2 == 0, "{line}");
        assert!(
            key.chars()
                .all(|c| c.is_ascii_alphanumeric() || "_<-".contains(c)),
            "{line}"
        );
        if let Some(quoted) = value.strip_prefix(" \"") {
            serde_json::from_str::<String>(&format!("\"{quoted}")).unwrap();
        }
        if let Some((above, opens)) = before {
            assert!(depth <= above || opens, "{line}");
        }
        let deep = if is_item { depth + 2 } else { depth };
        before = Some((deep, value.is_empty() || is_item));
    }
    text.lines().collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_batch_becomes_card_questions_answers_and_benchmark() {
    let server = Server::answering(|_, request| Some(says(&request.body))).await;
    let home = home_with(server.base_url());
    let mut labels = String::from("scenario,label\n");
    for (name, collides) in &BUNDLED[..5] {
        home.write(format!("scenes/{name}.xml"), bundled_xml(name));
        home.write(
            format!("scenes/{name}.ego_trajectory.csv"),
            bundled_ego(name),
        );
        if *name == BUNDLED[4].0 {
            // It loses its label afterwards.
            home.write("labels.csv", &labels);
        }
        labels += &format!("{name},{}\n", if *collides { "collision" } else { "safe" });
    }
    home.write("all.csv", labels);
    let asked = [
        "evaluate",
        "scenes",
        "--model",
        "lab/tiny,lab/dull,reference/geometry",
        "--task",
        "collision",
        "--techniques",
        "base,cot",
        "--samples",
        "2",
        "--truth",
        "all.csv",
        "--set",
        "protocol=paper",
    ];
    run(&home, &asked).status(0);
    run(&home, &["evaluate", "b1", "--truth", "labels.csv"]).status(1);
    export(&home, "out", &[]).status(0).says(&[
        "left out 5 questions to the built-in judge",
        "left out 8 questions without a known truth",
        "8 questions and 32 answers in out",
    ]);
    let out = home.files().join("out");
    let wanted = [
        "README.md",
        "answers/test.parquet",
        "data/test.parquet",
        "eval.yaml",
    ];
    assert_eq!(names(&out), wanted);

    let questions = table(&out.join("data/test.parquet"));
    let answers = table(&out.join("answers/test.parquet"));
    assert_eq!((questions.len(), answers.len()), (8, 32));
    let truth: BTreeMap<&str, &str> = questions
        .iter()
        .map(|row| (text(row, "id"), text(row, "target")))
        .collect();
    assert_eq!(truth.len(), 8, "each once");
    for row in &questions {
        let collides = BUNDLED
            .iter()
            .find(|(name, _)| *name == text(row, "scenario"));
        assert_eq!(text(row, "target"), collides.unwrap().1.to_string());
        assert_eq!(text(row, "answer_key"), "collision");
        assert_eq!(text(row, "scenario_hash").len(), 64);
        assert!(text(row, "system").contains("\"collision\""));
        assert!(text(row, "user").contains("Did the ego's body touch"));
        assert_eq!(row["image"], Field::Null);
        let (Field::Long(first), Field::Long(last)) = (&row["window_first"], &row["window_last"])
        else {
            panic!("{row:?}");
        };
        assert!(first <= last);
    }
    let mut models = BTreeSet::new();
    for row in &answers {
        let (verdict, target) = (text(row, "verdict"), truth[text(row, "question")]);
        assert_eq!(row["right"], Field::Bool(verdict == target));
        let state = if text(row, "model") == "lab/dull" {
            "unparsed"
        } else {
            "answered"
        };
        assert_eq!(
            (text(row, "state"), verdict.is_empty()),
            (state, state == "unparsed")
        );
        assert_eq!(row["with_tools"], Field::Bool(false));
        models.insert((text(row, "model"), format!("{}", row["sample"])));
    }
    assert_eq!(models.len(), 4, "{models:?}");
    assert!(answers.iter().any(|row| row["right"] == Field::Bool(true)));

    let card = std::fs::read_to_string(out.join("README.md")).unwrap();
    let front = card.strip_prefix("---\n").unwrap();
    let (front, body) = front.split_once("---\n").unwrap();
    let lines = yaml(front);
    for line in [
        "pretty_name: \"Driving scenes: collision\"",
        "- n<1K",
        "- config_name: default",
        "- config_name: answers",
        "  - split: test",
    ] {
        assert!(lines.contains(&line), "{line}: {front}");
    }
    assert!(!front.contains("license"), "nobody said which");
    let paths = lines
        .iter()
        .filter_map(|line| line.trim().strip_prefix("path: "));
    let paths: Vec<&str> = paths.collect();
    assert_eq!(paths, ["data/test.parquet", "answers/test.parquet"]);
    for column in questions[0].keys().chain(answers[0].keys()) {
        assert!(body.contains(&format!("| {column} ")), "{column}: {body}");
    }
    let speed = body
        .lines()
        .find(|line| line.starts_with("| speed "))
        .unwrap();
    assert!(
        speed.contains("| m/s ") && speed.contains("The ego's speed"),
        "{speed}"
    );
    for words in [
        "Source: labels from labels.csv",
        "Left out",
        "scenarios\\_sha256",
        "nearmiss 0",
    ] {
        let words = words.replace("\\_", "_");
        assert!(body.contains(&words), "{words}: {body}");
    }

    let benchmark = std::fs::read_to_string(out.join("eval.yaml")).unwrap();
    let lines = yaml(&benchmark);
    for line in [
        "name: \"Driving scenes: collision\"",
        "evaluation_framework: inspect-ai",
        "  - id: test",
        "    config: default",
        "    split: test",
        "      input: user",
        "      target: target",
        "          template: \"{system}\"",
        "      - name: generate",
        "      - name: pattern",
    ] {
        assert!(lines.contains(&line), "{line}: {benchmark}");
    }
    assert!(!benchmark.contains("input_image"), "{benchmark}");
    let pattern = lines
        .iter()
        .find_map(|line| line.trim().strip_prefix("pattern: "));
    let pattern: String = serde_json::from_str(pattern.unwrap()).unwrap();
    assert_eq!(pattern, r#"[\s\S]*"(?:collision)"\s*:\s*"?(true|false)"#);

    // Nothing of this machine, and the same bytes again.
    let here = home.files().parent().unwrap().display().to_string();
    for (name, bytes) in files(&out) {
        for secret in [here.as_str(), "127.0.0.1", server.base_url()] {
            assert!(
                !contains(&bytes, secret.as_bytes()),
                "{}: {secret}",
                name.display()
            );
        }
    }
    export(&home, "again", &[]).status(0);
    assert_eq!(files(&out), files(&home.files().join("again")));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_folder_with_files_and_other_runs_are_refused_and_overwriting_leaves_nothing_old() {
    let server = Server::answering(|_, request| Some(says(&request.body))).await;
    let home = home_with(server.base_url());
    let asked = [
        "evaluate",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--task",
        "collision",
    ];
    run(&home, &asked).status(0);
    let mine = home.write("out/mine.txt", "mine");
    let old = home.write("out/answers/dev.parquet", "old");
    export(&home, "out", &[])
        .status(2)
        .says(&["out: is not empty", "--overwrite"]);
    assert_eq!(std::fs::read(&old).unwrap(), b"old");
    export(&home, "out/mine.txt", &[])
        .status(2)
        .says(&["is a file"]);
    export(&home, "out", &["--overwrite"]).status(0);
    assert!(!old.exists() && mine.exists());
    export(&home, "new", &["verdict:dangerous"])
        .status(2)
        .says(&["one whole batch"]);
    let form = ["runs", "export", "--format", "huggingface"];
    run(&home, &[&form[..], &["-o", "new"]].concat())
        .status(2)
        .says(&["--batch ID"]);
    run(&home, &[&form[..], &["--batch", "b1"]].concat())
        .status(2)
        .says(&["-o FOLDER"]);
    export(&home, "new", &["--no-pictures"]).status(2);
    // The built-in judge alone says nothing that a data set has, and no folder stays behind.
    let judge = [
        "evaluate",
        CUT_IN,
        "--model",
        "reference/geometry",
        "--task",
        "collision,safety",
    ];
    run(&home, &judge).status(0);
    let of_judge = [&form[..], &["--batch", "b2", "-o", "new"]].concat();
    run(&home, &of_judge)
        .status(1)
        .says(&["nothing was written"]);
    assert!(!home.files().join("new").exists());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_a_locked_test_split_nothing_is_told() {
    let server = Server::answering(|_, request| {
        Some(if contains(&request.body, b"\"broken\"") {
            Script::json(400, "{\"error\":{\"message\":\"no\"}}")
        } else {
            says(&request.body)
        })
    })
    .await;
    let home = home_with(server.base_url());
    let part = |seed: u64, name: &str| {
        let split = nearmiss::evaluation::batch::Split { test: 0.5, seed };
        split.part(name) == nearmiss::store::SplitPart::Test
    };
    let count = |seed: &u64| BUNDLED.iter().filter(|(name, _)| part(*seed, name)).count();
    let seed = (1..100).find(|seed| count(seed) == 4).unwrap();
    let names: Vec<String> = BUNDLED
        .iter()
        .map(|(name, _)| format!("\"{name}\""))
        .collect();
    home.write(
        "e.toml",
        format!(
            "scenarios = [{}]\nmodels = [\"lab/tiny\", \"lab/broken\"]\ntasks = [\"collision\"]\n\
             techniques = [\"base\"]\ntruth = [\"auto\"]\nprotocol = \"paper\"\n\
             split = {{ test = 0.5, seed = {seed} }}\n",
            names.join(", ")
        ),
    );
    run(&home, &["evaluate", "e.toml"]).status(1);
    export(&home, "locked", &[]).status(0).says(&[
        "left out 8 answers of test splits that are not complete",
        "4 questions and 8 answers",
    ]);
    let locked = home.files().join("locked");
    let dev = [
        "README.md",
        "answers/dev.parquet",
        "data/dev.parquet",
        "eval.yaml",
    ];
    assert_eq!(self::names(&locked), dev);
    for (name, bytes) in files(&locked) {
        for (scenario, _) in BUNDLED.iter().filter(|(scenario, _)| part(seed, scenario)) {
            assert!(
                !contains(&bytes, scenario.as_bytes()),
                "{}: {scenario}",
                name.display()
            );
        }
    }
    let benchmark = std::fs::read_to_string(locked.join("eval.yaml")).unwrap();
    assert!(benchmark.contains("split: dev") && !benchmark.contains("split: test"));
    assert!(home.rows("SELECT * FROM looks").is_empty());
    // What failed is an answer without a verdict, and its error, which names the server, is not told.
    let answers = table(&locked.join("answers/dev.parquet"));
    let failed = answers.iter().filter(|row| text(row, "state") == "failed");
    assert_eq!(failed.count(), 4);

    export(&home, "open", &["--unlock"])
        .status(0)
        .says(&["8 questions and 16 answers"]);
    assert_eq!(home.rows("SELECT * FROM looks").len(), 1);
    let open = home.files().join("open");
    assert_eq!(table(&open.join("data/test.parquet")).len(), 4);
    let card = std::fs::read_to_string(open.join("README.md")).unwrap();
    assert!(
        card.contains("looked at once before it was complete"),
        "{card}"
    );
    // Over that folder, the locked part is gone again.
    export(&home, "open", &["--overwrite"]).status(0);
    assert_eq!(self::names(&open), dev);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_picture_stands_in_its_row_and_the_benchmark_shows_it() {
    let server = Server::answering(|_, request| Some(says(&request.body))).await;
    let home = home_with(server.base_url());
    let asked = [
        "evaluate",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--task",
        "collision",
        "--techniques",
        "base",
        "--set",
        "frames=ego,picture",
    ];
    run(&home, &asked).status(0);
    export(&home, "out", &[]).status(0);
    let out = home.files().join("out");
    let questions = table(&out.join("data/test.parquet"));
    let of = |frame: &str| {
        questions
            .iter()
            .find(|row| text(row, "frame") == frame)
            .unwrap()
    };
    assert!(text(of("picture"), "image").starts_with("data:image/png;base64,iVBOR"));
    assert_eq!(of("ego")["image"], Field::Null);
    let benchmark = std::fs::read_to_string(out.join("eval.yaml")).unwrap();
    assert!(
        benchmark.contains("\n      input_image: image\n"),
        "{benchmark}"
    );
    let card = std::fs::read_to_string(out.join("README.md")).unwrap();
    assert!(card.contains("\n- visual-question-answering\n"), "{card}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn answers_without_a_key_for_yes_and_no_make_no_benchmark() {
    let told = telling(
        "{\"CollisionObstacle\": null, \"ExtremeRiskObstacle\": null, \"HighRiskObstacle\": null}",
    );
    let server = Server::answering(move |_, _| Some(told.clone())).await;
    let home = home_with(server.base_url());
    let asked = [
        "evaluate",
        CUT_IN,
        "--model",
        "lab/tiny",
        "--task",
        "safety",
        "--techniques",
        "base",
        "--set",
        "pack=paper",
    ];
    run(&home, &asked).status(0);
    export(&home, "out", &[])
        .status(0)
        .says(&["no eval.yaml: 1 question without the key"]);
    let wanted = ["README.md", "answers/test.parquet", "data/test.parquet"];
    assert_eq!(names(&home.files().join("out")), wanted);
}
