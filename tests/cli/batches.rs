//! `evaluate` with language models: batches that are killed, gone on with, extended, rescored and merged.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::remote::delta;
use super::support::program::{Ended, Home, untimed};
use super::support::server::{Recorded, Script, Server};
use super::{BUNDLED, CUT_IN};

const HARD_BRAKING: &str = "ZAM_HardBraking-1_1_T-1";
pub const FINISH: &str =
    "data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n";

/// What the server says to a request: the same to the same, half of the time yes.
fn said(request: &Recorded) -> String {
    let sum = request.body.iter().fold(7_u32, |sum, byte| {
        sum.wrapping_mul(31).wrapping_add(u32::from(*byte))
    });
    let yes = sum.count_ones() % 2 == 0;
    let key = if String::from_utf8_lossy(&request.body).contains("safety_critical") {
        "safety_critical"
    } else {
        "collision"
    };
    json!({ key: yes, "obstacles": [], "justification": format!("answer {sum}.") }).to_string()
}

/// A whole answer in pieces.
fn whole(request: &Recorded) -> Script {
    telling(&said(request))
}

/// This text as a whole answer in pieces.
pub fn telling(text: &str) -> Script {
    let characters: Vec<char> = text.chars().collect();
    let pieces = characters.chunks(20);
    let begun = Script::chunked_events();
    let said = pieces.fold(begun, |script, piece| {
        let piece = delta(&piece.iter().collect::<String>());
        script.chunk(piece).pause(Duration::from_millis(5))
    });
    said.chunk(FINISH)
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
        .whole()
}

/// One in ten too many, one in twenty cut off, one in fifty stalls.
fn rough(number: usize, request: &Recorded) -> Script {
    match number % 60 {
        n if n % 10 == 3 => Script::answer(429, &[("Retry-After", "0")], "{}"),
        n if n % 20 == 8 => Script::chunked_events().chunk(delta("{\"collision\"")),
        n if n % 50 == 5 => {
            let begun = Script::chunked_events().chunk(": wait\n\n");
            begun
                .pause(Duration::from_millis(300))
                .append(whole(request))
        }
        _ => whole(request),
    }
}

pub fn home(url: &str) -> Home {
    let home = Home::new();
    let config = format!("[provider.lab]\nbase_url = \"{url}\"\nkey_env = []\nconcurrency = 4\n");
    home.write(home.config().join("config.toml"), config);
    home
}

const MATRIX: [&str; 10] = [
    "--model",
    "lab/tiny",
    "--task",
    "collision",
    "--set",
    "frames=ego,cartesian",
    "--techniques",
    "base,cp+cot",
    "--samples",
    "4",
];

fn begin<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let names = BUNDLED.map(|(name, _)| name);
    [&["evaluate"], &names[..], &MATRIX[..], more].concat()
}

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

/// The table without times, and without what counts answers that were cut off, which cost something, too.
fn cells(ended: &Ended) -> Value {
    let mut cells = untimed(ended.json()["cells"].clone());
    for cell in cells.as_array_mut().unwrap() {
        for counted in ["cost_of", "cost_unknown", "superseded"] {
            cell.as_object_mut().unwrap().remove(counted).unwrap();
        }
    }
    cells
}

fn total(cells: &Value, of: &[&str]) -> u64 {
    let cells = cells.as_array().unwrap().iter();
    cells
        .flat_map(|cell| of.iter().map(|name| cell[name].as_u64().unwrap()))
        .sum()
}

/// How often the server answered each body wholly.
fn answered(server: &Server) -> BTreeMap<Vec<u8>, usize> {
    let mut counts = BTreeMap::new();
    for body in server.whole() {
        *counts.entry(body).or_default() += 1;
    }
    counts
}

const TRUE_AND_FALSE: [&str; 4] = ["tp", "fp", "fn", "tn"];

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_batch_that_is_killed_comes_to_the_same_table_and_pays_for_nothing_twice() {
    let calm = Server::answering(|_, request| Some(whole(request))).await;
    let undisturbed = home(calm.base_url());
    let ended = run(&undisturbed, &begin(&["--format=json"])).status(0);
    assert_eq!(ended.json()["batch"], "b1");
    let wanted = cells(&ended);
    assert_eq!(total(&wanted, &["n"]), 64);
    assert_eq!(total(&wanted, &TRUE_AND_FALSE), 64);
    assert!(total(&wanted, &["tp", "fp"]) > 8 && total(&wanted, &["tn", "fn"]) > 8);
    let counts = answered(&calm);
    // Four windows: of the two collisions and of two safe scenarios.
    assert_eq!(counts.len(), 16);
    assert!(
        counts.values().all(|count| *count == 4),
        "four samples of each"
    );

    let server = Server::answering(|number, request| Some(rough(number, request))).await;
    let home = home(server.base_url());
    for kill in [8, 24, 40] {
        let arguments = match kill {
            8 => begin(&[]),
            _ => vec!["evaluate", "last"],
        };
        let mut child = home.start(&arguments);
        let begun = Instant::now();
        while server.requests().len() < kill {
            assert!(
                begun.elapsed() < Duration::from_secs(60),
                "no {kill} requests"
            );
            tokio::time::sleep(Duration::from_millis(3)).await;
        }
        child.kill().unwrap();
        tokio::task::block_in_place(|| child.wait()).unwrap();
    }
    let mut ended = run(&home, &["evaluate", "b1", "--format=json"]);
    for _ in 0..5 {
        if ended.status == Some(0) {
            break;
        }
        // Streams that were cut off are asked for again.
        ended = run(&home, &["evaluate", "b1", "--format=json"]);
    }
    assert_eq!(cells(&ended.status(0)), wanted);

    let runs = home.runs();
    let mut whole: BTreeMap<(String, String), usize> = BTreeMap::new();
    let mut killed: BTreeMap<String, usize> = BTreeMap::new();
    for run in &runs {
        let column = |name: &str| run[name].clone().unwrap_or_default();
        match column("state").as_str() {
            "answered" => *whole.entry((column("key"), column("sample"))).or_default() += 1,
            "interrupted" => *killed.entry(column("messages")).or_default() += 1,
            "failed" => {}
            other => panic!("{other}"),
        }
    }
    assert_eq!(whole.len(), 64);
    assert!(
        whole.values().all(|count| *count == 1),
        "asked for twice: {whole:?}"
    );
    let interrupted: usize = killed.values().sum();
    assert!(interrupted > 0, "the kills came between the requests only");
    let counts = answered(&server);
    assert_eq!(counts.len(), 16);
    let twice: usize = counts.values().map(|count| count.saturating_sub(4)).sum();
    // What the server had said wholly when the program was killed before it could hear it.
    assert!(
        twice <= interrupted,
        "{twice} paid twice, {interrupted} killed"
    );
    let requests = server.requests().len();
    let again = run(&home, &["evaluate", "b1", "--format=json"]).status(0);
    assert_eq!(cells(&again), wanted);
    assert_eq!(server.requests().len(), requests, "nothing is asked again");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_it_takes_is_said_before_and_what_is_there_is_not_asked() {
    let server = Server::answering(|_, request| Some(whole(request))).await;
    let home = home(server.base_url());
    let small = |more: &[&'static str]| {
        [
            &["evaluate", CUT_IN, HARD_BRAKING, "--model", "lab/tiny"],
            more,
        ]
        .concat()
    };
    let dry = run(&home, &small(&["--task", "collision,safety", "--dry-run"])).status(0);
    for words in [
        "requests         4",
        "in the store     0",
        "nothing is paid",
    ] {
        assert!(dry.stdout.contains(words), "{words}: {}", dry.stdout);
    }
    assert_eq!(server.requests().len(), 0);
    assert_eq!(home.rows("SELECT * FROM batches").len(), 0);

    let ended = run(&home, &small(&["--model", "reference/geometry"])).status(0);
    assert!(ended.stdout.contains("lab/tiny") && ended.stdout.contains("reference/geometry"));
    let ended = ended.says(&["b1: 2 requests", "2 by the built-in judge"]);
    // What it took, and the report to read.
    assert_eq!(ended.stderr.lines().count(), 2, "{}", ended.stderr);
    assert_eq!(server.requests().len(), 2);
    let dry = run(
        &home,
        &small(&["--samples", "3", "--dry-run", "--format=json"]),
    )
    .status(0)
    .json();
    assert_eq!((&dry["requests"], &dry["stored"]), (&4.into(), &2.into()));

    // A technique and a sample more: only those are asked, and the answers that are there count.
    let more = ["evaluate", "b1", "--techniques", "base", "--samples", "2"];
    let more = run(&home, &[&more[..], &["--format=json"]].concat()).status(0);
    assert_eq!(total(&cells(&more), &["n"]), 2 * 2 * 2 + 2);
    assert_eq!(server.requests().len(), 8);
    let list = run(&home, &["evaluate", "list"]).status(0).stdout;
    assert!(
        list.contains("b1") && list.contains("10 of 10 answered"),
        "{list}"
    );
    run(&home, &["evaluate", "b1", "--samples", "1"])
        .status(2)
        .says(&["already has 2"]);
    run(&home, &["evaluate", "b9"])
        .status(2)
        .says(&["no batch b9", "list"]);

    // Another truth changes the table without asking.
    let truth = home
        .write(
            "truth.csv",
            format!("scenario,label\n{CUT_IN},yes\n{HARD_BRAKING},no\n"),
        )
        .display()
        .to_string();
    let turned = run(
        &home,
        &["evaluate", "b1", "--truth", &truth, "--format=json"],
    )
    .status(0);
    let (before, after) = (cells(&more), cells(&turned));
    assert_eq!(before[0]["n"], after[0]["n"]);
    assert_ne!(before, after);
    assert_eq!(server.requests().len(), 8);

    // A changed template would be another batch.
    run(&home, &["prompt", "copy", "safety-ego"]).status(0);
    let template = home.config().join("prompts/safety-ego.md");
    let text = std::fs::read_to_string(&template).unwrap();
    std::fs::write(&template, format!("{text}\nBe brief.\n")).unwrap();
    run(&home, &["evaluate", "b1"])
        .status(2)
        .says(&["safety-ego.md", "start a new batch"]);
}

/// One that cuts its first answer off and has no verdict in the second.
async fn stumbling() -> Server {
    Server::answering(|number, request| {
        Some(match number {
            0 => Script::chunked_events().chunk(delta("half")),
            1 => Script::chunked_events()
                .chunk(delta("I cannot say."))
                .chunk(FINISH)
                .end_of_chunks(),
            _ => whole(request),
        })
    })
    .await
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_batch_may_ask_again_by_itself() {
    let server = stumbling().await;
    let home = home(server.base_url());
    let names = BUNDLED.map(|(name, _)| name);
    let options = [
        "--model",
        "lab/tiny",
        "--set",
        "concurrency=1",
        "--retry",
        "3",
        "--format=json",
    ];
    let arguments = [&["evaluate"], &names[..4], &options[..]].concat();
    let ended = run(&home, &arguments)
        .status(0)
        .says(&["b1: 2 questions without a verdict asked again"]);
    assert_eq!(total(&cells(&ended), &["failed", "unparsed"]), 0);
    assert_eq!(total(&cells(&ended), &["n"]), 4);
    // Nothing is asked a third time.
    assert_eq!(server.requests().len(), 6);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn failed_and_unparsed_answers_are_counted_and_asked_again() {
    let server = stumbling().await;
    let home = home(server.base_url());
    let names = BUNDLED.map(|(name, _)| name);
    let options = [
        "--model",
        "lab/tiny",
        "--set",
        "concurrency=1",
        "--format=json",
    ];
    let arguments = [&["evaluate"], &names[..4], &options[..]].concat();
    let ended = run(&home, &arguments)
        .status(1)
        .says(&["of 4 questions, 1 without a complete answer", "evaluate b1"]);
    let cell = &cells(&ended)[0];
    let of = |name: &str| cell[name].as_u64().unwrap();
    assert_eq!((of("n"), of("failed"), of("unparsed")), (4, 1, 1));
    let again = run(
        &home,
        &["evaluate", "b1", "--retry-failed", "--format=json"],
    )
    .status(0);
    assert_eq!(total(&cells(&again), &["failed", "unparsed"]), 0);
    assert_eq!(total(&cells(&again), &["n"]), 4);
    assert_eq!(server.requests().len(), 6);
}

#[cfg(unix)]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_interrupt_ends_in_good_order() {
    for signal in super::interrupted::signals() {
        interrupted_and_resumed(signal).await;
    }
}

#[cfg(unix)]
async fn interrupted_and_resumed(signal: &str) {
    let server = Server::answering(|number, request| {
        Some(match number {
            0 | 1 => Script::chunked_events()
                .chunk(": wait\n\n")
                .pause(Duration::from_millis(200))
                .append(whole(request)),
            _ => whole(request),
        })
    })
    .await;
    let home = home(server.base_url());
    let child = home.start(&begin(&["--set", "concurrency=2"]));
    while server.requests().len() < 2 {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let id = child.id().to_string();
    let sent = std::process::Command::new("kill")
        .args([signal, &id])
        .status();
    assert!(sent.unwrap().success());
    let output = tokio::task::block_in_place(|| child.wait_with_output()).unwrap();
    let ended = Ended::of(&output)
        .status(130)
        .says(&["interrupted", "`nearmiss evaluate b1`"]);
    assert_eq!(ended.stdout, "");
    assert_eq!(server.requests().len(), 2, "nothing more was begun");
    assert!(
        home.runs()
            .iter()
            .all(|run| run["state"].as_deref() == Some("answered"))
    );
    let ended = run(&home, &["evaluate", "last", "--format=json"]).status(0);
    assert_eq!(total(&cells(&ended), &["n"]), 64);
    assert_eq!(
        server.requests().len(),
        64,
        "{signal}: nothing is paid for twice"
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn parts_of_a_batch_are_merged() {
    let server = Server::answering(|_, request| Some(whole(request))).await;
    let homes = [
        home(server.base_url()),
        home(server.base_url()),
        home(server.base_url()),
    ];
    let ended = run(&homes[0], &begin(&["--format=json"])).status(0);
    let wanted = cells(&ended);
    let mut asked = server.requests().len();
    for (part, home) in ["1/2", "2/2"].iter().zip(&homes[1..]) {
        let ended = run(home, &begin(&["--format=json", "--shard", part])).status(0);
        let n = total(&cells(&ended), &["n"]);
        assert!(n > 0 && n < 64, "{n} of 64");
    }
    assert_eq!(server.requests().len(), 2 * asked);
    asked *= 2;
    let other = homes[2].data().join("runs.sqlite").display().to_string();
    let merged = run(&homes[1], &["runs", "import", &other]).status(0);
    assert!(merged.stdout.contains("imported"), "{}", merged.stdout);
    let ended = run(&homes[1], &["evaluate", "b1", "--format=json"]).status(0);
    assert_eq!(total(&cells(&ended), &["n"]), 64);
    let sorted = |cells: &Value| {
        let mut cells: Vec<_> = cells
            .as_array()
            .unwrap()
            .iter()
            .map(Value::to_string)
            .collect();
        cells.sort();
        cells
    };
    assert_eq!(sorted(&cells(&ended)), sorted(&wanted));
    assert_eq!(
        server.requests().len(),
        asked,
        "merged answers are not asked for again"
    );
    let batches = homes[1].rows("SELECT shard FROM batches");
    assert_eq!(batches.len(), 1);
    assert_eq!(batches[0]["shard"], None, "it is whole");
}
