//! JSON of every command: what is printed fits the schema that `nearmiss help json --schema` prints.

use std::collections::BTreeSet;

use nearmiss::store::Choice;
use serde_json::Value;

use super::CUT_IN;
use super::ratings::rate;
use super::support::program::{Home, untimed};

const BRAKING: &str = "ZAM_HardBraking-1_1_T-1";

/// Outputs that need what a test here has not: a provider with batches, right answers of a model, a model
/// that sees, a planner's process, proposals of templates (tests/cli/tune.rs).
const ELSEWHERE: [&str; 6] = [
    "runs-batches",
    "runs-export-chat",
    "image",
    "plan-log-stderr",
    "tune",
    "tune-dry-run",
];

/// A home with a few runs, ratings, a variant, a solution and a log.
fn furnished() -> Home {
    let home = Home::new();
    home.run(&["ask", BRAKING]).status(0);
    let store = nearmiss::store::Store::open(&home.data().join("runs.sqlite")).unwrap();
    rate(&store, Choice::Best(0));
    home.write(
        "labels.csv",
        format!("scenario,label\n{BRAKING},collision\n{CUT_IN},safe\n"),
    );
    home.write(
        "requirement.toml",
        format!("id = \"1\"\ntitle = \"a\"\ntext = \"b\"\nscenarios = [\"{CUT_IN}\"]\nindex = \"index\"\n"),
    );
    home.write("said.txt", "Car 301 is approaching the ego.");
    home.write(
        "texts.jsonl",
        format!("{{\"scenario\": \"{CUT_IN}\", \"text\": \"Car 301 is approaching the ego.\"}}\n"),
    );
    let made = [
        "generate",
        CUT_IN,
        "--candidates",
        "40",
        "--report",
        "report.json",
        "-o",
        "variants",
    ];
    home.run(&made);
    let planned = [
        "plan",
        CUT_IN,
        "--log",
        "log.json",
        "--solution",
        "solution.xml",
    ];
    home.run(&planned);
    home.run(&["runs", "export", "-o", "runs.jsonl"]).status(0);
    home.run(&["corpus", "index", CUT_IN, "-o", "index"])
        .status(0);
    home
}

fn read(home: &Home, file: &str) -> String {
    std::fs::read_to_string(home.files().join(file)).unwrap()
}

/// Each output with its text: what a command prints, or a file that it writes.
fn outputs(home: &Home) -> Vec<(&'static str, String)> {
    let variants = std::fs::read_dir(home.files().join("variants")).unwrap();
    let mut files = variants.map(|entry| entry.unwrap().path());
    let variant = files
        .find(|path| path.extension().is_some_and(|x| x == "xml"))
        .expect("a variant was made");
    let batch = [
        "evaluate",
        CUT_IN,
        BRAKING,
        "--model",
        "reference/geometry",
        "--samples",
        "1",
    ];
    let with = |more: &[&'static str]| [&batch[..], more].concat();
    let labels = [
        "--task",
        "collision",
        "--truth",
        "labels.csv",
        "--format=json",
    ];
    let commands: Vec<(&str, Vec<&str>)> = vec![
        ("ask", vec!["ask", BRAKING, "--format=json"]),
        (
            "ask",
            vec![
                "ask",
                BRAKING,
                "--task",
                "safety",
                "--at",
                "worst",
                "--format=json",
            ],
        ),
        (
            "ask-dry-run",
            vec!["ask", BRAKING, "--dry-run", "--format=json"],
        ),
        (
            "generate-check",
            vec![
                "generate",
                CUT_IN,
                "--format=json",
                "--check",
                variant.to_str().unwrap(),
            ],
        ),
        (
            "prompt-describe",
            vec!["prompt", "describe", BRAKING, "--format=json"],
        ),
        (
            "prompt-describe-story",
            vec!["prompt", "describe", BRAKING, "--story", "--format=json"],
        ),
        ("doctor", vec!["doctor", "--format=json"]),
        (
            "evaluate",
            vec!["evaluate", CUT_IN, BRAKING, "--format=json"],
        ),
        (
            "evaluate",
            [&["evaluate", CUT_IN, BRAKING], &labels[..]].concat(),
        ),
        ("evaluate-questions", with(&["--dry-run=questions"])),
        (
            "evaluate-leaks",
            with(&["--dry-run=leaks", "--format=json"]),
        ),
        ("evaluate-dry-run", with(&["--dry-run", "--format=json"])),
        ("evaluate", with(&["--format=json"])),
        (
            "evaluate",
            with(&[
                "--set",
                "leads=0.5,1",
                "--set",
                "transforms=mirror",
                "--format=json",
            ]),
        ),
        ("evaluate-list", vec!["evaluate", "list", "--format=json"]),
        (
            "generate",
            vec!["generate", CUT_IN, "--candidates", "10", "--format=json"],
        ),
        (
            "runs-import",
            vec!["runs", "import", "runs.jsonl", "--format=json"],
        ),
        (
            "corpus-show",
            vec!["corpus", "show", "index", "--format=json"],
        ),
        (
            "corpus-rate",
            vec!["corpus", "rate", "index", "--format=json"],
        ),
        (
            "corpus-rate-like",
            vec!["corpus", "rate", "index", "--like", CUT_IN, "--format=json"],
        ),
        (
            "corpus-event",
            vec!["corpus", "rate", "index", "--events", "--format=json"],
        ),
        (
            "corpus-sample",
            vec!["corpus", "sample", "index", "--format=json"],
        ),
        (
            "corpus-find",
            vec![
                "corpus",
                "find",
                "manoeuvre:cut_in ttc<5",
                "--index",
                "index",
                "--format=json",
            ],
        ),
        ("inspect", vec!["inspect", CUT_IN, "--format=json"]),
        (
            "inspect-diff",
            vec!["inspect", CUT_IN, BRAKING, "--diff", "--format=json"],
        ),
        (
            "inspect-folder",
            vec!["inspect", "variants", "--format=json"],
        ),
        (
            "inspect-solution",
            vec!["inspect", "solution.xml", "--format=json"],
        ),
        ("config-keys", vec!["config", "keys", "--format=json"]),
        ("metrics", vec!["metrics", CUT_IN, "--format=json"]),
        (
            "metrics",
            vec!["metrics", CUT_IN, "--scene", "--format=json"],
        ),
        (
            "metrics",
            vec!["metrics", CUT_IN, "--convention", "paper", "--format=json"],
        ),
        ("annex", vec!["annex", "requirement.toml", "--format=json"]),
        (
            "check",
            vec![
                "check",
                "ZAM_CutIn-1_1_T-1",
                "--text",
                "said.txt",
                "--format=json",
            ],
        ),
        (
            "check-traces",
            vec!["check", "texts.jsonl", "--format=json"],
        ),
        (
            "check-labelled",
            vec!["check", "--labelled", "--format=json"],
        ),
        ("drivers", vec!["drivers", "--format=json"]),
        ("metrics-list", vec!["metrics", "--list", "--format=json"]),
        ("models", vec!["models", "--offline", "--format=json"]),
        (
            "not-driven",
            vec!["plan", CUT_IN, "--planning-problem", "99", "--format=json"],
        ),
        ("plan", vec!["plan", CUT_IN, "--format=json"]),
        (
            "plan",
            vec![
                "plan",
                CUT_IN,
                "--monitor",
                "reference/geometry",
                "--format=json",
            ],
        ),
        (
            "plan-dry-run",
            vec![
                "plan",
                CUT_IN,
                "--monitor",
                "reference/geometry",
                "--dry-run",
                "--format=json",
            ],
        ),
        (
            "prompt-show",
            vec!["prompt", "show", CUT_IN, "--format=json"],
        ),
        ("prompt-list", vec!["prompt", "list", "--format=json"]),
        ("rating", vec!["runs", "ratings", "export"]),
        ("runs-ratings", vec!["runs", "ratings", "--format=json"]),
        (
            "runs-ratings-agreement",
            vec!["runs", "ratings", "agreement", "--format=json"],
        ),
        ("report", vec!["report", "--format=json"]),
        (
            "report-axes",
            vec!["report", "--rows", "model", "--format=json"],
        ),
        ("run", vec!["runs", "show", "1", "--format=json"]),
        ("runs-list", vec!["runs", "list", "--format=json"]),
        ("config-themes", vec!["config", "themes", "--format=json"]),
    ];
    let mut all: Vec<(&str, String)> = commands
        .into_iter()
        .map(|(name, arguments)| (name, home.run(&arguments).stdout))
        .collect();
    home.run(&[
        "runs",
        "export",
        "--format=bundle",
        "--batch",
        "last",
        "-o",
        "bundle.nearmiss",
    ])
    .status(0);
    let show = home.run(&[
        "runs",
        "import",
        "--dry-run",
        "bundle.nearmiss",
        "--format=json",
    ]);
    all.push(("runs-import-dry-run", show.status(0).stdout));
    // Lines of an export say what they are.
    for line in home.run(&["runs", "export"]).stdout.lines() {
        let kinds = ["batch", "question", "run"];
        let is =
            |kind: &&str| line.contains(&format!("{{\"schema_version\":2,\"nearmiss_{kind}\":"));
        let kind = kinds.into_iter().find(is).expect("a line of a known kind");
        all.push((kind, line.to_string()));
    }
    let compared = [
        &["plan", CUT_IN, "--format=json"],
        &["--planner", "nearmiss"].repeat(2)[..],
    ]
    .concat();
    let compared = home.run(&compared).stdout;
    let (drives, comparison) = compared.trim_end().rsplit_once('\n').unwrap();
    all.push(("plan", drives.to_string()));
    all.push(("plan-comparison", comparison.to_string()));
    all.push(("plan-log", read(home, "log.json")));
    all.push(("generate-report", read(home, "report.json")));
    all
}

#[test]
fn every_output_fits_its_schema() {
    let home = furnished();
    let mut seen = BTreeSet::from(ELSEWHERE);
    for (name, text) in outputs(&home) {
        seen.insert(name);
        let schema = home
            .run(&["help", "json", "--schema", name])
            .status(0)
            .stdout;
        let schema: Value = serde_json::from_str(&schema).unwrap();
        let validator = jsonschema::validator_for(&schema).unwrap();
        assert!(!text.is_empty(), "{name} prints nothing");
        for line in text.lines() {
            let value: Value = serde_json::from_str(line).unwrap();
            assert!(line.starts_with("{\"schema_version\":2,"), "{name}: {line}");
            if let Err(error) = validator.validate(&value) {
                panic!("{name}: {error} at {}\n{line}", error.instance_path());
            }
        }
    }
    let help = home.run(&["help", "json"]).status(0).stdout;
    let (_, listed) = help.split_once("## Outputs").unwrap();
    let (listed, keys) = listed.split_once("## Keys").unwrap();
    let first = |line: &str| line.split_whitespace().next().map(str::to_string);
    let listed: BTreeSet<String> = listed.lines().filter_map(first).collect();
    let seen: BTreeSet<String> = seen.into_iter().map(str::to_string).collect();
    assert_eq!(
        listed, seen,
        "an output without a test, or without a schema"
    );
    for key in [
        "scenario",
        "techniques",
        "risk_score",
        "step",
        "cost_usd",
        "template_hash",
    ] {
        assert!(keys.contains(&format!("    {key} ")), "{key}");
    }
    home.run(&["help", "json", "--schema", "evaluat"])
        .status(2)
        .says(&["did you mean `evaluate"]);
}

#[test]
fn evaluate_has_one_table_whatever_the_option_is_called() {
    let home = Home::new();
    let paths = ["evaluate", CUT_IN, BRAKING];
    for more in [
        &[][..],
        &["--model", "reference/geometry", "--set", "frames=ego"],
    ] {
        let said = |option: &[&str]| home.run(&[&paths, more, option].concat()).json();
        let (mut short, mut long) = (said(&["--format=json"]), said(&["--format", "json"]));
        for value in [&mut short, &mut long] {
            // Another batch of the same questions.
            value["batch"] = Value::Null;
        }
        assert_eq!(untimed(short), untimed(long));
    }
}
