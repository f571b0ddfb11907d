//! `tune` with a played model: a planted weakness is found within the budget, nothing is found without one, the test
//! split stays closed, and nothing is paid for twice.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use nearmiss::evaluation::batch::Split;
use nearmiss::store::SplitPart;
use serde_json::{Value, json};

use super::remote::delta;
use super::support::program::{Ended, Home};
use super::support::server::{Recorded, Script, Server};
use super::{bundled_ego, bundled_xml};

/// Scenarios of both splits.
const SCENARIOS: usize = 40;

/// What a template has to say so that the planted model is right about all scenes.
const HINT: &str = "Mind the closing speed.";

const SPLIT: Split = Split { test: 0.3, seed: 7 };

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

fn name(number: usize) -> String {
    format!("ZAM_Planted-{number}_1_T-1")
}

fn is_test(number: usize) -> bool {
    SPLIT.part(&name(number)) == SplitPart::Test
}

/// A home with scenarios whose ids tell their numbers; even ones are collisions. The files of the test split cannot be
/// read.
fn home(url: &str) -> Home {
    let home = Home::new();
    let config = format!(
        "[provider.lab]\nbase_url = \"{url}\"\nkey_env = []\nconcurrency = 4\n\
         [[provider.lab.prices]]\nmodel = \"tiny\"\ninput = 1\noutput = 10\n"
    );
    home.write(home.config().join("config.toml"), config);
    for number in 1..=SCENARIOS {
        let of = match number % 2 {
            0 => "ZAM_HardBraking-1_1_T-1",
            _ => "ZAM_CutIn-1_1_T-1",
        };
        let text = if is_test(number) {
            "<?xml version=\"1.0\"?><commonRoad commonRoadVersion=\"2020a\" broken".into()
        } else {
            bundled_xml(of).replace("Obstacle id=\"3", &format!("Obstacle id=\"{number}3"))
        };
        let file = format!("s/{}", name(number));
        home.write(format!("{file}.xml"), text);
        home.write(format!("{file}.ego_trajectory.csv"), bundled_ego(of));
    }
    home.write("e.toml", experiment(""));
    home
}

fn experiment(more: &str) -> String {
    format!(
        "scenarios = [\"s\"]\nmodels = [\"lab/tiny\"]\ntasks = [\"collision\"]\ntechniques = [\"base\"]\n\
         max_tokens = 100\nsplit = {{ test = {}, seed = {} }}\ntruth = [\"auto\"]\n{more}\n",
        SPLIT.test, SPLIT.seed
    )
}

/// A whole answer with its usage.
fn telling(request: &Recorded, text: &str) -> Script {
    let usage = json!({ "prompt_tokens": request.body.len() / 3, "completion_tokens": 50 });
    let usage = format!("data: {}\n\n", json!({ "choices": [], "usage": usage }));
    Script::chunked_events()
        .chunk(delta(text))
        .chunk("data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n")
        .chunk(usage)
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
        .whole()
}

/// An answer that runs into the limit of tokens.
fn cut_off() -> Script {
    Script::chunked_events()
        .chunk(delta("First, the cars: "))
        .chunk("data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"length\"}]}\n\n")
        .chunk("data: {\"choices\":[],\"usage\":{\"prompt_tokens\":1000,\"completion_tokens\":50}}\n\n")
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
        .whole()
}

fn messages(request: &Recorded) -> [String; 2] {
    let body = request.json();
    [0, 1].map(|at| {
        body["messages"][at]["content"]
            .as_str()
            .unwrap()
            .to_string()
    })
}

fn is_reflection(request: &Recorded) -> bool {
    messages(request)[0].starts_with("You improve the prompt template")
}

/// The number of the scenario that a question is about: its ids begin with it.
fn number(user: &str) -> Option<usize> {
    let digits = user.split(|c: char| !c.is_ascii_digit());
    let id = digits
        .filter_map(|word| word.parse::<usize>().ok())
        .find(|id| *id >= 1000)?;
    Some(id / 1000)
}

/// Answers right, but for half of the scenes only with the hint; `takes_hints` false: never for those.
fn judged(request: &Recorded, takes_hints: bool) -> Script {
    let [system, user] = messages(request);
    let number = number(&user).unwrap_or(1);
    let (dangerous, weak) = (number.is_multiple_of(2), number % 4 < 2);
    let right = !weak || takes_hints && system.contains(HINT);
    if !right && number % 8 == 4 {
        return cut_off();
    }
    let said = dangerous == right;
    telling(
        request,
        &json!({ "collision": said, "obstacles": [], "justification": "so" }).to_string(),
    )
}

/// The n-th proposal of a tune, by the number of tries that it is told: one loses the description, one copies an id, one
/// says nothing of use, one has the hint.
fn proposed(request: &Recorded) -> Script {
    let user = &messages(request)[1];
    let template = user.split("```\n").nth(1).unwrap();
    let tried = user
        .split("# Tried before")
        .nth(1)
        .map_or(0, |tries| tries.matches("\n- ").count());
    let with = |words: &str| {
        template.replacen(
            "{% block system -%}",
            &format!("{{% block system -%}}\n{words}"),
            1,
        )
    };
    let (change, text) = match tried {
        0 => (
            "Loses the scene.",
            template.replace("{{ description }}", ""),
        ),
        1 => (
            "Copies an id.",
            with(&format!("Obstacle {} is dangerous.", id(user))),
        ),
        2 => ("Be careful.", with("Be careful.")),
        3 => ("Closing speed.", with(HINT)),
        4 => ("Shorter.", shorter(template)),
        n => ("More words.", with(&format!("Take {n} looks."))),
    };
    telling(
        request,
        &json!({ "diagnosis": "d", "change": change, "template": text }).to_string(),
    )
}

/// The same without its first sentences.
fn shorter(template: &str) -> String {
    let mut lines: Vec<&str> = template.lines().collect();
    let first = lines.iter().position(|line| line.starts_with("You are"));
    lines.remove(first.unwrap());
    lines.join("\n")
}

/// An id of a shown scene.
fn id(user: &str) -> usize {
    let shown = user.split("# Wrong answer").nth(1).unwrap();
    let words = shown.split(|c: char| !c.is_ascii_digit());
    words
        .filter_map(|word| word.parse().ok())
        .find(|id| *id >= 1000)
        .unwrap()
}

fn played(request: &Recorded, takes_hints: bool) -> Option<Script> {
    Some(if is_reflection(request) {
        proposed(request)
    } else {
        judged(request, takes_hints)
    })
}

const TUNE: [&str; 7] = [
    "tune",
    "e.toml",
    "--budget",
    "3",
    "--set",
    "tune.rounds=2",
    "--format=json",
];

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn tune_finds_a_planted_weakness_within_the_budget() {
    let server = Server::answering(|_, request| played(request, true)).await;
    let home = home(server.base_url());
    let dry = run(&home, &[&TUNE[..], &["--dry-run"]].concat())
        .status(0)
        .json();
    assert!(dry["most_usd"].as_f64().unwrap() > 0.5, "{dry}");
    assert_eq!(server.requests().len(), 0);
    let all = [&TUNE[..], &["-o", "out", "--save", "closing"]].concat();
    let ended = run(&home, &all).status(0);
    let document = ended
        .says(&["closing.md; it is used for task collision", "--split test"])
        .json();
    assert_eq!(document["found"], true, "{document}");
    let best = &document["templates"][document["best"].as_u64().unwrap() as usize];
    assert!(
        best["diff"].as_str().unwrap().contains(&format!("+{HINT}")),
        "{best}"
    );
    assert_eq!(
        (&best["f1"], &best["on_front"]),
        (&json!(1.0), &json!(true))
    );
    let gain = &best["gain"];
    assert!(
        gain["low"].as_f64().unwrap() > 0.05 && gain["p"].as_f64().unwrap() < 0.05,
        "{gain}"
    );
    let spent = document["spent_usd"].as_f64().unwrap();
    assert!(spent > 0.0 && spent <= 3.0, "{spent}");
    let asked = document["answers"].as_u64().unwrap() + document["reflections"].as_u64().unwrap();
    assert_eq!(asked, server.requests().len() as u64);
    let costs = home.rows(
        "SELECT sum(cost_usd) AS usd FROM (SELECT cost_usd FROM runs UNION ALL SELECT cost_usd FROM reflections)",
    );
    let paid: f64 = costs[0]["usd"].as_ref().unwrap().parse().unwrap();
    assert!((spent - paid).abs() < 1e-9, "{spent} of {paid}");
    // The base is beaten by one that is better and by one that is cheaper and no worse.
    let front: Vec<&Value> = { document["templates"].as_array().unwrap().iter() }
        .filter(|one| one["on_front"] == true)
        .map(|one| &one["change"])
        .collect();
    assert_eq!(front, ["Closing speed.", "Shorter."], "{document}");
    let why = |kind: &str| {
        let all = document["refused"].as_array().unwrap().iter();
        let of: Vec<String> = all
            .filter(|one| one["kind"] == kind)
            .map(|one| one["why"].to_string())
            .collect();
        of.join(" ")
    };
    assert!(
        why("invalid").contains("keep {{ description }}"),
        "{document}"
    );
    assert!(why("invalid").contains("it names obstacle"), "{document}");
    assert!(
        why("not_better").contains("shown questions right"),
        "{document}"
    );
    the_test_split_is_closed(&home, &server, &document);
    fits_its_schema(&home, "tune", &document);
    fits_its_schema(&home, "tune-dry-run", &dry);
    let file = |name: &str| std::fs::read_to_string(home.files().join("out").join(name)).unwrap();
    assert!(file("template.diff").starts_with("--- collision-ego.md\n+++ collision-ego.md\n@@"));
    assert!(file("template.md").contains(HINT) && file("template.md").starts_with("+++\n"));
    assert_eq!(
        serde_json::from_str::<Value>(&file("tune.json")).unwrap(),
        document
    );
    run(&home, &all)
        .status(2)
        .says(&["out/template.diff exists", "--overwrite"]);
    let saved = home.config().join("prompts/closing.md");
    assert!(
        std::fs::read_to_string(&saved)
            .unwrap()
            .contains("name = \"closing\"")
    );
    // Again with the same base: everything is in the store.
    std::fs::remove_file(saved).unwrap();
    let before = server.requests().len();
    let mut again = run(&home, &TUNE).status(0).json();
    assert_eq!(server.requests().len(), before);
    assert_eq!(
        (&again["answers"], &again["reflections"]),
        (&json!(0), &json!(0))
    );
    assert_eq!(again["spent_usd"], 0.0);
    for key in [
        "answers",
        "answers_stored",
        "reflections",
        "reflections_stored",
        "spent_usd",
    ] {
        again[key] = document[key].clone();
    }
    assert_eq!(again, document);
    let table = run(&home, &TUNE[..6]).status(0).stdout;
    println!("{table}");
    assert!(
        table.contains("Gain: F1 +") && table.contains(&format!("\n+{HINT}\n")),
        "{table}"
    );
}

/// No question is about a scenario of the test split, and no run is.
fn the_test_split_is_closed(home: &Home, server: &Server, document: &Value) {
    let tests: Vec<usize> = (1..=SCENARIOS).filter(|number| is_test(*number)).collect();
    assert!(tests.len() > 5 && tests.len() < 20, "{tests:?}");
    assert_eq!(document["test_scenarios"], tests.len());
    let requests = server.requests();
    let asked: Vec<usize> = requests
        .iter()
        .filter(|request| !is_reflection(request))
        .filter_map(|request| number(&messages(request)[1]))
        .collect();
    assert!(asked.len() > 30 && asked.iter().all(|number| !tests.contains(number)));
    for row in home.runs() {
        let scenario = row["scenario"].clone().unwrap();
        assert!(
            !tests.iter().any(|number| scenario == name(*number)),
            "{scenario}"
        );
    }
    let parts = &document["parts"];
    let count = |at: usize| parts[at]["scenarios"].as_u64().unwrap() as usize;
    // A safe scenario has no window where no dangerous one is left for it.
    let dev = SCENARIOS - tests.len();
    let counted = count(0) + count(1);
    assert!(counted <= dev && counted + 3 > dev, "{parts}");
}

fn fits_its_schema(home: &Home, output: &str, document: &Value) {
    let schema = run(home, &["help", "json", "--schema", output]).status(0);
    let schema = serde_json::from_str(&schema.stdout).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    if let Err(error) = validator.validate(document) {
        panic!("{output}: {error} at {}", error.instance_path());
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_template_that_says_yes_to_every_window_is_no_gain() {
    let server = Server::answering(|_, request| {
        if is_reflection(request) {
            return Some(proposed(request));
        }
        let [system, user] = messages(request);
        let said = number(&user).unwrap_or(1) % 8 == 4 || system.contains(HINT);
        let answer = json!({ "collision": said, "obstacles": [], "justification": "so" });
        Some(telling(request, &answer.to_string()))
    })
    .await;
    let home = home(server.base_url());
    let document = run(&home, &TUNE).status(1).json();
    let templates = document["templates"].as_array().unwrap();
    let always: Vec<&Value> = { templates.iter() }
        .filter(|one| one["always"] == "yes")
        .collect();
    let f1 = |one: &Value| one["f1"].as_f64().unwrap();
    let better = always.iter().any(|one| f1(one) > f1(&templates[0]));
    assert!(better, "it has the larger F1: {document}");
    assert!(always.iter().all(|one| one["specificity"] == 0.0));
    assert_eq!(
        (&document["best"], &document["found"]),
        (&Value::Null, &json!(false))
    );
    let table = run(&home, &TUNE[..6]).status(1).stdout;
    for words in [
        "Closing speed. (always yes)",
        "no proposal that tells windows apart",
    ] {
        assert!(table.contains(words), "{table}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn tune_finds_nothing_where_no_template_helps() {
    // First the same model without an ear for hints, then one that answers by chance, another one for each template.
    let by_chance = Arc::new(AtomicBool::new(false));
    let chance = Arc::clone(&by_chance);
    let server = Server::answering(move |_, request| {
        if is_reflection(request) || !chance.load(Ordering::SeqCst) {
            return played(request, false);
        }
        // By what is asked, and not by the form of the answer.
        let mut asked = request.json();
        let _ = asked.as_object_mut().unwrap().remove("response_format");
        let sum = asked.to_string().bytes().fold(7_u32, |sum, byte| {
            sum.wrapping_mul(31).wrapping_add(u32::from(byte))
        });
        let said = sum.count_ones().is_multiple_of(2);
        Some(telling(
            request,
            &json!({ "collision": said, "obstacles": [], "justification": "so" }).to_string(),
        ))
    })
    .await;
    let home = home(server.base_url());
    let ended = run(&home, &[&TUNE[..], &["-o", "out"]].concat()).status(1);
    let document = ended.says(&["no gain found"]).json();
    assert_eq!(
        (&document["found"], &document["best"]),
        (&json!(false), &Value::Null),
        "{document}"
    );
    assert!(!home.files().join("out/template.diff").exists());
    assert!(home.files().join("out/tune.json").exists());
    by_chance.store(true, Ordering::SeqCst);
    for seed in ["1", "2"] {
        let other = experiment(&format!("temperature = 0.{seed}"));
        home.write("e.toml", other);
        let seed = format!("tune.seed={seed}");
        let ended = run(&home, &[&TUNE[..], &["--set", &seed]].concat()).status(1);
        assert_eq!(ended.json()["found"], false, "{}", ended.stdout);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_budget_holds_and_ends_a_tune() {
    let server = Server::answering(|_, request| played(request, true)).await;
    let home = home(server.base_url());
    // A proposal costs 0.1 USD at most.
    let ended = run(
        &home,
        &["tune", "e.toml", "--budget", "0.01", "--format=json"],
    )
    .status(2);
    ended.says(&[
        "lab/tiny: a proposal cannot be asked for",
        "$0.0100 is left",
    ]);
    assert_eq!(server.requests().len(), 0);
    // The windows are those of the experiment, so that its answers count.
    run(&home, &["evaluate", "e.toml", "--split", "dev"]);
    let dev = server.requests().len();
    assert!(dev > 25, "{dev}");
    let ended = run(
        &home,
        &["tune", "e.toml", "--budget", "0.11", "--format=json"],
    )
    .status(1);
    let document = ended
        .says(&["ended in round ", "of the budget of $0.1100 is left"])
        .json();
    let count = |key: &str| document[key].as_u64().unwrap() as usize;
    let spent = document["spent_usd"].as_f64().unwrap();
    assert!(spent > 0.0 && spent <= 0.11, "{document}");
    assert_eq!(
        count("answers") + count("reflections"),
        server.requests().len() - dev
    );
    assert!(
        count("reflections") > 0 && count("answers_stored") >= 18,
        "{document}"
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_server_that_refuses_ends_a_tune_which_goes_on_later() {
    let refuses = Arc::new(AtomicBool::new(true));
    let is_refusing = Arc::clone(&refuses);
    let server = Server::answering(move |_, request| {
        if is_reflection(request) && is_refusing.load(Ordering::SeqCst) {
            Some(Script::json(401, "{\"error\":{\"message\":\"no key\"}}"))
        } else {
            played(request, true)
        }
    })
    .await;
    let home = home(server.base_url());
    let ended = run(&home, &TUNE).status(1);
    let document = ended.says(&["ended in round 1 of 2", "lab/tiny"]).json();
    assert_eq!(
        (&document["found"], &document["reflections"]),
        (&json!(false), &json!(0)),
        "{document}"
    );
    refuses.store(false, Ordering::SeqCst);
    let document = run(&home, &TUNE).status(0).json();
    assert_eq!(document["found"], true);
    assert!(
        document["answers_stored"].as_u64().unwrap() >= 18,
        "{document}"
    );
}

/// Requests by their bodies, those to which the whole answer was sent.
fn repeated(server: &Server) -> usize {
    let mut bodies = server.whole();
    let all = bodies.len();
    bodies.sort();
    bodies.dedup();
    all - bodies.len()
}

#[cfg(unix)]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_tune_that_is_killed_or_interrupted_goes_on_and_pays_nothing_twice() {
    let server = Server::answering(|_, request| {
        let answer = played(request, true)?;
        Some(
            Script::silent()
                .pause(Duration::from_millis(30))
                .append(answer),
        )
    })
    .await;
    let home = home(server.base_url());
    let mut stopped = 0;
    for (after, signal) in [(5, "KILL"), (25, "INT"), (45, "KILL"), (60, "INT")] {
        let mut child = home.start(&TUNE);
        let ended = loop {
            tokio::time::sleep(Duration::from_millis(5)).await;
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            if server.requests().len() >= after {
                let pid = child.id().to_string();
                std::process::Command::new("kill")
                    .args(["-s", signal, &pid])
                    .status()
                    .unwrap();
                stopped += 1;
                break tokio::task::block_in_place(|| child.wait().unwrap());
            }
        };
        assert_eq!(
            ended.code(),
            (signal == "INT").then_some(130),
            "{signal} after {after}"
        );
    }
    assert_eq!(stopped, 4);
    let document = run(&home, &TUNE).status(0).json();
    assert_eq!(document["found"], true);
    // What was on its way when it was killed may be asked again: four at once, two kills.
    assert!(repeated(&server) <= 8, "{}", repeated(&server));
    let twice = home.rows(
        "SELECT key FROM runs WHERE state = 'answered' GROUP BY key, sample HAVING count(*) > 1",
    );
    assert!(twice.is_empty(), "{twice:?}");
    let twice = home.rows("SELECT key FROM reflections WHERE answer IS NOT NULL GROUP BY key, sample HAVING count(*) > 1");
    assert!(twice.is_empty(), "{twice:?}");
    let before = server.requests().len();
    run(&home, &TUNE).status(0);
    assert_eq!(server.requests().len(), before);
}

#[test]
fn what_cannot_be_tuned_is_said_before_anything_is_asked() {
    let home = Home::new();
    let bundled =
        "scenarios = [\"ZAM_CutIn-1_1_T-1\", \"ZAM_RedLight-1_1_T-1\", \"ZAM_Merge-1_1_T-1\"]\n";
    let file = |more: &str| home.write("e.toml", format!("{bundled}{more}\n"));
    let split = "split = { test = 0.5, seed = 1 }";
    let tune = |more: &[&str]| home.run(&[&["tune", "e.toml"], more].concat()).status(2);
    file("models = [\"local/default\"]");
    tune(&[]).says(&["no budget given"]);
    tune(&["--budget", "1"]).says(&["no split", "add `split = { test = 0.5 }`"]);
    file(&format!("models = [\"local/a\", \"local/b\"]\n{split}"));
    tune(&["--budget", "1"]).says(&["several models: local/a, local/b", "--set models=local/a"]);
    tune(&["--budget", "1", "--set", "models=nowhere/c"]).says(&["nowhere"]);
    file(&format!("models = [\"reference/geometry\"]\n{split}"));
    tune(&["--budget", "1"]).says(&["not asked with a template"]);
    file(&format!(
        "models = [\"local/a\"]\ntemperature = [0, 1]\n{split}"
    ));
    tune(&["--budget", "1"]).says(&["several values of temperature"]);
    file(&format!("models = [\"local/a\"]\n{split}"));
    tune(&["--budget", "1"]).says(&["at least two of each"]);
    tune(&["--budget", "1", "--save", "safety-ego"]).says(&["shipped template"]);
    tune(&["--budget", "1", "--set", "tune.reflect=reference/geometry"])
        .says(&["proposals need a language model"]);
    let ended = home.run(&["tune", "ZAM_CutIn-1_1_T-1", "--budget", "1"]);
    ended.status(2).says(&["expected an experiment file"]);
}
