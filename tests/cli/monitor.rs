//! `plan --monitor`: warnings beside the planner, what they cost, and what braking changes.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::CUT_IN;
use super::remote::streamed;
use super::support::program::{Ended, Home};
use super::support::server::{Script, Server};

const BRAKING: &str = "ZAM_HardBraking-1_1_T-1";
const TURN: &str = "ZAM_RightTurn-1_1_T-1";

/// A planner that does not look far ahead runs into the queue.
const SHORT: [&str; 4] = [
    "--set=prediction=constant-velocity",
    "--set=horizon=1",
    "--monitor-every",
    "0.5",
];

fn run(home: &Home, arguments: &[&str]) -> Ended {
    tokio::task::block_in_place(|| home.run(arguments))
}

fn built_in(home: &Home, scenario: &str, more: &[&str], status: i32) -> Value {
    let told = [
        "plan",
        scenario,
        "--monitor",
        "reference/geometry",
        "--format=json",
    ];
    home.run(&[&told[..], more].concat()).status(status).json()
}

/// The same without what a clock measured.
fn timeless(mut line: Value) -> Value {
    let object = line.as_object_mut().unwrap();
    object.retain(|key, _| !key.ends_with("_ms"));
    let monitor = object["monitor"].as_object_mut().unwrap();
    monitor.remove("median_latency_seconds");
    monitor.remove("latency_in_force_seconds");
    for answer in monitor["answers"].as_array_mut().unwrap() {
        answer.as_object_mut().unwrap().remove("latency_seconds");
    }
    line
}

#[test]
fn the_built_in_judge_warns_before_a_contact_and_is_silent_without_danger() {
    let home = Home::new();
    let collides = built_in(&home, BRAKING, &SHORT, 1);
    assert_eq!(collides["outcome"], "collision");
    let monitor = &collides["monitor"];
    assert_eq!(monitor["model"], "reference/geometry");
    assert_eq!(monitor["incident"], "contact");
    assert_eq!(monitor["incident_step"], collides["collision_step"]);
    let lead = monitor["lead_seconds"].as_f64().unwrap();
    let first = monitor["first_warning_seconds"].as_f64().unwrap();
    let contact = monitor["incident_step"].as_i64().unwrap() as f64 * 0.1;
    assert!(lead > 0.0 && lead <= contact - first + 1e-9, "{monitor}");
    assert_eq!(monitor["braked_steps"], 0);
    assert!(monitor["median_latency_seconds"].as_f64().unwrap() > 0.0);
    for answer in monitor["answers"].as_array().unwrap() {
        let step = |key: &str| answer[key].as_i64().unwrap();
        assert!(step("step") % 5 == 0 && step("counts_from_step") > step("step"));
    }

    let safe = built_in(&home, TURN, &[], 0);
    let monitor = &safe["monitor"];
    assert_eq!(monitor["warnings"], json!([]));
    assert_eq!(monitor["false_alarms_per_minute"], 0.0);
    assert!(monitor["lead_seconds"].is_null() && monitor["incident"].is_null());
    assert!(
        home.runs().is_empty(),
        "nothing is stored of the built-in judge"
    );
    // Without a monitor, nothing is said of one.
    let alone = home.run(&["plan", TURN, "--format=json"]).status(0).json();
    assert!(alone.get("monitor").is_none());
    assert_eq!(alone["steps"], safe["steps"]);
}

#[test]
fn braking_on_warnings_avoids_the_contact_and_is_the_same_every_time() {
    let home = Home::new();
    let braking = [
        &SHORT[..],
        &["--brake-on", "critical", "--monitor-latency", "0.1"],
    ]
    .concat();
    let avoided = built_in(&home, BRAKING, &braking, 0);
    assert_eq!(avoided["outcome"], "timeout");
    assert!(avoided["monitor"]["braked_steps"].as_u64().unwrap() > 0);
    assert!(avoided["monitor"]["first_braking_seconds"].as_f64() > Some(0.0));
    assert_eq!(avoided["monitor"]["latency_in_force_seconds"], 0.1);
    // Full braking: nearly all that friction allows.
    assert!(avoided["largest_deceleration"].as_f64().unwrap() > 10.0);
    let again = built_in(&home, BRAKING, &braking, 0);
    assert_eq!(timeless(avoided), timeless(again));
    let table = ["plan", TURN, "--monitor", "reference/geometry"];
    let table = home.run(&table).status(0).stdout;
    for column in [
        "warnings",
        "lead s",
        "latency s",
        "brakes s",
        "braked s",
        "monitor: 0 warnings",
    ] {
        assert!(table.contains(column), "{table}");
    }
}

fn answer(dangerous: bool) -> Script {
    let text = json!({"safety_critical": dangerous, "obstacles": [], "justification": "j"});
    let wait = Script::silent().pause(Duration::from_millis(150));
    wait.append(streamed(&text.to_string()))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn answers_of_a_model_count_from_their_arrival_and_are_paid_for_once() {
    let home = Home::new();
    let server = Server::answering(|number, _| Some(answer(number == 1))).await;
    let url = server.base_url();
    let told = ["plan", TURN, "--monitor", "lab/tiny", "--base-url", url];
    let told = [&told[..], &["--monitor-every", "2"]].concat();
    let planned = |more: &[&str]| run(&home, &[&told[..], more].concat());

    let counted = planned(&["--dry-run", "--format=json"]).status(0).json();
    assert_eq!(
        (&counted["questions"], server.requests().len()),
        (&json!(4), 0)
    );

    let first = planned(&["--format=json"])
        .status(0)
        .says(&["lab/tiny: 4 questions"])
        .json();
    let monitor = &first["monitor"];
    assert_eq!(server.requests().len(), 4);
    let answers = monitor["answers"].as_array().unwrap();
    assert_eq!(answers.len(), 4);
    for (i, answer) in answers.iter().enumerate() {
        let step = 20 * (i as i64 + 1);
        let latency = answer["latency_seconds"].as_f64().unwrap();
        assert!(latency >= 0.15);
        let from = step + (latency / 0.1).ceil() as i64;
        assert_eq!(answer["step"], step);
        assert_eq!(answer["counts_from_step"], from, "{answer}");
    }
    // Dangerous was the second; the third took that back.
    let counts = |i: usize| answers[i]["counts_from_step"].as_i64().unwrap();
    assert_eq!(monitor["warnings"], json!([[counts(1), counts(2) - 1]]));
    assert_eq!(monitor["false_alarms"], 1);
    let runs = home.runs();
    assert_eq!(runs.len(), 4);
    assert!(
        runs.iter()
            .all(|run| run["task"].as_deref() == Some("safety"))
    );

    // The same again asks nothing, and counts the stored latencies.
    let again = planned(&["--format=json"]).status(0).json();
    assert_eq!(server.requests().len(), 4);
    assert_eq!(again["monitor"]["warnings"], monitor["warnings"]);
    let stored = again["monitor"]["answers"].as_array().unwrap();
    for (stored, asked) in stored.iter().zip(answers) {
        assert_eq!(stored["stored"], true);
        assert_eq!(stored["latency_seconds"], asked["latency_seconds"]);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn costs_are_bounded_and_mistakes_are_named() {
    let home = Home::new();
    let server = Server::answering(|_, _| Some(answer(false))).await;
    let prices = "[[provider.lab.prices]]\nmodel = \"tiny*\"\ninput = 100\noutput = 1000\n";
    let url = server.base_url();
    let config = format!("max_tokens = 1000\n[provider.lab]\nbase_url = \"{url}\"\n{prices}");
    home.write(home.config().join("config.toml"), config);
    let plan = |more: &[&str]| run(&home, &[&["plan", CUT_IN, "--set=replan=5"], more].concat());
    let lab = ["--monitor", "lab/tiny"];
    let refused = plan(&[&lab[..], &["--budget", "0.000001"]].concat()).status(2);
    refused.says(&["at most $", "budget $0.000001", "nothing was sent"]);
    assert!(server.requests().is_empty() && home.runs().is_empty());
    let counted = plan(&[&lab[..], &["--dry-run"]].concat()).status(0);
    assert!(counted.stdout.contains("at most $"), "{}", counted.stdout);
    assert!(server.requests().is_empty());

    plan(&["--monitor", "recorded/x"])
        .status(2)
        .says(&["recorded answers"]);
    plan(&["--monitor-every", "1"])
        .status(2)
        .says(&["--monitor"]);
    plan(&["--brake-on", "critical"])
        .status(2)
        .says(&["--monitor"]);
    let never = ["--monitor", "reference/geometry", "--monitor-every", "0"];
    plan(&never).status(2).says(&["0.05 to 60"]);
    let late = ["--monitor", "reference/geometry", "--monitor-latency", "-1"];
    plan(&late).status(2);
    let gone = ["--monitor", "far/x", "--base-url", "http://127.0.0.1:9"];
    plan(&gone).status(2).says(&["cannot reach far"]);
}

#[cfg(unix)]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_interrupt_ends_a_question_that_is_on_its_way() {
    let home = Home::new();
    let server = Server::answering(|_, _| Some(Script::chunked_events().await_close())).await;
    let url = server.base_url();
    let told = [
        "plan",
        TURN,
        "--set=replan=10",
        "--monitor",
        "lab/tiny",
        "--base-url",
        url,
    ];
    let child = home.start(&told);
    let begun = Instant::now();
    while server.requests().is_empty() {
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "nothing is asked"
        );
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let id = child.id().to_string();
    let kill = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(kill.unwrap().success());
    let output = tokio::task::block_in_place(|| child.wait_with_output()).unwrap();
    Ended::of(&output).status(130);
}
