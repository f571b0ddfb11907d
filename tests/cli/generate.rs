//! `generate`: what is written passes the gate and opens again; what is refused and told.

use nearmiss::formats::commonroad;
use nearmiss::generation::Gate;
use serde_json::{Value, json};

use super::plan::{NO_PROBLEM, lines};
use super::support::program::Home;
use super::support::server::{Script, Server};
use super::{CUT_IN, bundled_xml};

/// Few motions: the search is slow without optimisation.
const FEW: [&str; 2] = ["--candidates", "40"];

#[test]
fn a_variant_is_written_that_passes_the_gate_and_opens_again() {
    let home = Home::new();
    let told = [
        "generate",
        CUT_IN,
        "--model",
        "search",
        "--format=json",
        "-o",
        "out",
    ];
    let ended = home.run(&[&told[..], &FEW[..]].concat());
    let said = ended.json();
    let keys: Vec<&str> = { said.as_object().unwrap().keys() }
        .map(String::as_str)
        .collect();
    let first = [
        "scenario", "file", "hash", "id", "variant", "ego", "by", "outcome", "attacker",
    ];
    assert_eq!(keys[0], "schema_version");
    assert_eq!(keys[1..10], first);
    let outcome = said["outcome"].as_str().unwrap();
    let effective = matches!(outcome, "collision" | "near_miss");
    assert_eq!(ended.status, Some(i32::from(!effective)), "{outcome}");
    assert!(said["candidates"].as_u64().unwrap() <= 40);
    for refused in said["rejected"].as_array().unwrap() {
        assert!(refused["reason"].is_string() && refused["words"].is_string());
    }
    let avoidable: Vec<&String> = said["avoidable"].as_object().unwrap().keys().collect();
    assert_eq!(avoidable, ["0.0", "0.5", "1.0", "1.5"]);
    let file = |key: &str| home.files().join(said[key].as_str().unwrap());
    let variant = commonroad::read_file(&file("variant")).unwrap();
    let original = commonroad::read(bundled_xml(CUT_IN).as_bytes(), CUT_IN).unwrap();
    let compared = Gate::new(&original).compare(&variant, None);
    assert!(compared.passed(), "{compared:?}");
    let changed = &compared.changed[..];
    assert!(matches!(changed, [one] if said["attacker"] == one.change.obstacle));
    assert!(std::fs::metadata(file("ego")).unwrap().len() > 0);
    // The variant finds its ego by itself.
    let name = said["variant"].as_str().unwrap();
    let looked = home
        .run(&["inspect", name, "--format=json"])
        .status(0)
        .json();
    assert!(
        looked.to_string().contains("ego_trajectory.csv"),
        "{looked}"
    );
    what_the_manifest_claims_is_checked(&home, name);
    // Made a second time it gets another name, and the first one stays.
    let before = std::fs::read(file("variant")).unwrap();
    let again = home.run(&[&told[..], &FEW[..]].concat()).json();
    assert_ne!(again["variant"], said["variant"]);
    assert_eq!(std::fs::read(file("variant")).unwrap(), before);
}

/// Checks a variant of `CUT_IN` with its files as they are, with one that was changed, and with a damaged manifest.
fn what_the_manifest_claims_is_checked(home: &Home, variant: &str) {
    home.write("original.xml", bundled_xml(CUT_IN));
    let check = || {
        home.run(&[
            "generate",
            "original.xml",
            "--check",
            variant,
            "--format=json",
        ])
    };
    let said = check().status(0).json();
    assert!(said["manifest"]["files"].as_u64().unwrap() >= 3, "{said}");
    assert_eq!(said["manifest"]["changed_files"], json!([]));
    for one in said["manifest"]["certificates"].as_array().unwrap() {
        assert_eq!(one["passed"], true, "{one}");
    }
    let path = |ending: &str| home.files().join(variant.replace(".xml", ending));
    let mut manifest: Value =
        serde_json::from_slice(&std::fs::read(path(".json")).unwrap()).unwrap();
    let claimed = &manifest["preventability"];
    assert_eq!(&said["manifest"]["preventability"], claimed);
    let story = home
        .run(&["describe", variant, "--story", "--format=json"])
        .json();
    assert_eq!(&story["preventability"], claimed, "the certificates count");
    let kept = std::fs::read(path(".json")).unwrap();
    manifest["preventability"]["drivers"][0]["result"] = "mitigated".into();
    std::fs::write(path(".json"), manifest.to_string()).unwrap();
    let fault = check().status(1).json()["manifest"]["preventability_fault"].clone();
    assert!(
        fault.as_str().unwrap().contains("the manifest says"),
        "{fault}"
    );
    std::fs::write(path(".json"), kept).unwrap();
    let kept = std::fs::read(path(".solution.xml")).unwrap();
    std::fs::write(path(".solution.xml"), "other").unwrap();
    let said = check().status(1).json();
    assert_eq!(said["passed"], false);
    let changed = said["manifest"]["changed_files"][0].as_str().unwrap();
    assert!(
        changed.contains("solution.xml: it was changed"),
        "{changed}"
    );
    std::fs::write(path(".solution.xml"), kept).unwrap();
    let manifest = std::fs::read(path(".json")).unwrap();
    std::fs::write(path(".json"), &manifest[..manifest.len() / 2]).unwrap();
    assert!(check().status(2).stderr.contains("not a manifest of"));
    std::fs::write(path(".json"), manifest).unwrap();
}

#[test]
fn what_others_made_is_held_against_the_gate() {
    let home = Home::new();
    let xml = bundled_xml(CUT_IN);
    home.write("original.xml", &xml);
    home.write("same.xml", &xml);
    let same = home.run(&[
        "generate",
        "original.xml",
        "--check",
        "same.xml",
        "--format=json",
    ]);
    assert_eq!(same.status(1).json()["passed"], false);
    // An obstacle is 8 m aside for one step.
    let at = xml.rfind("<dynamicObstacle").unwrap();
    let (head, tail) = xml.split_at(at);
    let state = tail.match_indices("<state>").nth(10).unwrap().0;
    let y = state + tail[state..].find("<y>").unwrap() + 3;
    let end = y + tail[y..].find("</y>").unwrap();
    let moved: f64 = tail[y..end].parse::<f64>().unwrap() + 8.0;
    let jumped = format!("{head}{}{moved}{}", &tail[..y], &tail[end..]);
    home.write("jumped.xml", &jumped);
    let found = home
        .run(&[
            "generate",
            "original.xml",
            "--check",
            "jumped.xml",
            "--format=json",
        ])
        .status(1)
        .json();
    let one = &found["changed"][0];
    let reasons: Vec<&str> = { one["rejected"].as_array().unwrap().iter() }
        .map(|r| r["reason"].as_str().unwrap())
        .collect();
    assert!(reasons.contains(&"jump"), "{reasons:?}");
    let words = home.run(&["generate", "original.xml", "--check", "jumped.xml"]);
    assert!(words.status(1).stdout.contains("step "));
}

#[test]
fn what_cannot_be_driven_is_named_and_does_not_stop_the_others() {
    let home = Home::new();
    home.write("none.xml", NO_PROBLEM);
    let ended = home.run(&[&["generate", "none.xml", "--format=json"][..], &FEW[..]].concat());
    let said = lines(&ended.status(1));
    assert_eq!(said.len(), 1);
    assert!(said[0]["outcome"].is_null());
    assert!(
        said[0]["error"]
            .as_str()
            .unwrap()
            .contains("planning problem")
    );
    let wrong = home.run(&["generate", CUT_IN, "--attacker", "999999"]);
    assert!(wrong.status(2).stderr.contains("no obstacle 999999"));
    let early = home.run(&["generate", CUT_IN, "--survive", "-1"]).status(2);
    assert!(early.stderr.contains("--survive") && !early.stderr.contains("unexpected argument"));
    let model = home.run(&["generate", CUT_IN, "--candidates", "0"]);
    assert!(model.status(2).stderr.contains("a number from 1"));
}

#[test]
fn a_wish_is_held_to() {
    let home = Home::new();
    let with = |wish: &str| {
        home.run(
            &[
                &["generate", CUT_IN, "--wish", wish, "--format=json"],
                &FEW[..],
            ]
            .concat(),
        )
    };
    let made = with("actor:car manoeuvre:cut_in");
    let line = &lines(&made)[0];
    assert_eq!(line["manoeuvre"], "cut-in", "{line}");
    assert!(
        line["by"]
            .as_str()
            .unwrap()
            .contains("wish: actor:car manoeuvre:cut-in")
    );
    // Car 301 drives on the right, and comes to the left only later.
    let from_left = with("actor:car place:left-lane");
    let line = &lines(&from_left)[0];
    let elsewhere = |one: &Value| {
        let words = one["words"].as_str().unwrap_or_default();
        one["attacker"] == 301 && words.contains("begins elsewhere than wished")
    };
    assert!(
        line["rejected"].as_array().unwrap().iter().any(elsewhere),
        "{line}"
    );
    assert_ne!(line["attacker"], 301, "{line}");
    let none = with("actor:bicycle place:from-left").status(1);
    let line = &lines(&none)[0];
    assert_eq!(
        (&line["outcome"], &line["candidates"]),
        (&json!("none"), &json!(0))
    );
    let note = line["note"].as_str().unwrap();
    assert!(
        note.contains("no obstacle fits the wish: actor:bicycle"),
        "{note}"
    );
    for (wish, said) in [
        (" ", "expected terms, such as actor:"),
        ("a car cuts in", "unknown term `a`; available: actor:"),
        ("actor:giraffe", "unknown value `giraffe` of `actor:`"),
    ] {
        let ended = with(wish).status(2);
        assert!(ended.stderr.contains(said), "{wish}: {}", ended.stderr);
    }
    let asked = [
        "generate",
        CUT_IN,
        "--wish",
        "actor:car",
        "--model",
        "lab/x",
    ];
    let model = home.run(&asked);
    assert!(model.status(2).stderr.contains("--wish is for the search"));
}

#[test]
fn an_attacker_that_vanishes_is_noted_with_step_and_seconds() {
    let home = Home::new();
    home.write("original.xml", bundled_xml(CUT_IN));
    let told = ["generate", "original.xml", "-o", "out", "--format=json"];
    let few = ["--candidates", "6", "--set=replan=10"];
    let said = home.run(&[&told[..], &few[..]].concat()).json();
    let file = home.files().join(said["variant"].as_str().unwrap());
    let xml = std::fs::read_to_string(file).unwrap();
    // The last five states of the attacker are taken away.
    let start = format!("<dynamicObstacle id=\"{}\"", said["attacker"]);
    let at = xml.find(&start).unwrap();
    let end = at + xml[at..].find("</trajectory>").unwrap();
    let states: Vec<_> = xml[at..end].match_indices("<state>").collect();
    let cut = at + states[states.len() - 5].0;
    home.write("short.xml", format!("{}{}", &xml[..cut], &xml[end..]));
    let until = said["until_step"].as_i64().unwrap();
    let check = ["generate", "original.xml", "--check", "short.xml"];
    let words = home.run(&check).status(0).stdout;
    let note = format!(
        "NOTE: obstacle {} is gone from step {}",
        said["attacker"],
        until - 4
    );
    assert!(words.contains(&note), "{words}");
    let found = home
        .run(&[&check[..], &["--format=json"]].concat())
        .status(0)
        .json();
    let one = &found["changed"][0];
    assert_eq!(one["gone_from_step"], until - 4);
    let early = one["ends_early"].as_i64().unwrap();
    assert!(early >= 5 && words.contains(&format!("{early} steps ({:.1} s)", early as f64 * 0.1)));
    assert!((one["gone_seconds_early"].as_f64().unwrap() - early as f64 * 0.1).abs() < 1e-9);
}

/// A model that says `words` to whatever it is asked, up to `times`.
pub fn says(words: &str, times: usize) -> Vec<Script> {
    let chunk = json!({"choices": [{"index": 0, "delta": {"content": words}}]});
    let end = json!({"choices": [{"index": 0, "delta": {}, "finish_reason": "stop"}]});
    let body = format!("data: {chunk}\n\ndata: {end}\n\ndata: [DONE]\n\n");
    vec![Script::events().send(body); times]
}

/// `generate` by the model of a server.
fn by_model<'a>(url: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let model = [
        "generate",
        CUT_IN,
        "--model",
        "local/any",
        "--base-url",
        url,
    ];
    model.into_iter().chain(more.iter().copied()).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_failing_server_is_no_rejected_motion() {
    let home = Home::new();
    let mut scripts = says("I like trains.", 3);
    scripts.extend(vec![Script::json(404, "{}"); 9]);
    let server = Server::start(scripts).await;
    let url = server.base_url().to_owned();
    let told = by_model(
        &url,
        &["--set=samples=2", "--set=retries=1", "--format=json"],
    );
    let ended = tokio::task::block_in_place(|| home.run(&told))
        .status(1)
        .says(&["answer 1, try 1: failed: ", "stopped: "]);
    let said = ended.json();
    assert_eq!(said["candidates"], 0, "{said}");
    assert_eq!(said["refused"], json!({}));
    assert_eq!(said["model"]["tries"]["conversations"], 0);
    assert_eq!(said["note"], "the model gave no motion");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_model_that_answers_nonsense_exports_nothing() {
    let home = Home::new();
    let server = Server::start(says("I like trains.", 12)).await;
    let url = server.base_url().to_owned();
    let more = [
        "--set=samples=2",
        "--set=retries=1",
        "--format=json",
        "-o",
        "out",
    ];
    let told = by_model(&url, &more);
    let ended = tokio::task::block_in_place(|| home.run(&told));
    let said = ended.status(1).json();
    assert_eq!(said["outcome"], "none");
    assert!(said["variant"].is_null() && said["ego"].is_null());
    assert_eq!(said["candidates"], 4);
    let rejected = said["rejected"].as_array().unwrap();
    assert!(rejected.len() >= 4, "{rejected:?}");
    // Three votes, and two conversations of two answers.
    assert_eq!(said["model"]["requests"], 7);
    assert_eq!(said["model"]["votes"].as_array().unwrap().len(), 3);
    let tries =
        json!({"conversations": 2, "first_admitted": 0, "first_effective": 0, "effective": 0});
    assert_eq!(said["model"]["tries"], tries);
    assert_eq!(said["model"]["attacker_by"], "reference");
    assert_eq!(
        std::fs::read_dir(home.files().join("out")).unwrap().count(),
        0
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_dry_run_counts_votes_motions_and_grades_and_asks_nothing() {
    let home = Home::new();
    let server = Server::start(Vec::new()).await;
    let url = server.base_url().to_owned();
    let told = by_model(&url, &["--dry-run"]);
    let run = |more: &[&str]| {
        let told = [&told[..], &["--set=replan=10"], more].concat();
        let ended = tokio::task::block_in_place(|| home.run(&told)).status(0);
        let row = ended.stdout.lines().nth(1).unwrap().to_string();
        let cells: Vec<String> = row.split_whitespace().skip(1).map(str::to_string).collect();
        cells
    };
    // Three votes, five conversations of three answers, and a grade of each motion.
    assert_eq!(run(&[])[..4], ["33", "3", "15", "15"]);
    let least = [
        "--set=votes=1",
        "--set=samples=2",
        "--set=retries=0",
        "--set=grades=off",
    ];
    let least = run(&least);
    assert_eq!(least[..4], ["3", "1", "2", "0"]);
    assert!(least[4].parse::<usize>().unwrap() > 3000);
    let named = ["--attacker", "301", "--set=feedback=off"];
    assert_eq!(run(&named)[..4], ["20", "0", "15", "5"]);
    assert!(server.requests().is_empty() && home.runs().is_empty());
    let search = home.run(&["generate", CUT_IN, "--dry-run"]).status(2);
    assert!(search.stderr.contains("--model"), "{}", search.stderr);
}
