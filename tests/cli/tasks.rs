//! `ask` for more than yes or no: attackers and trajectories, with templates of the user.

use serde_json::{Value, json};

use super::CUT_IN;
use super::remote::{ask, streamed};
use super::support::program::Home;
use super::support::server::Server;

const TEMPLATE: &str = "+++
name = \"mine\"
version = \"1\"
task = \"TASK\"
frame = \"ego\"
summary = \"s\"
+++
{% block system %}Answer in JSON.{% endblock %}
{% block user %}{{ description }}{% endblock %}
";

fn home(task: &str) -> Home {
    let home = Home::new();
    let file = home.config().join(format!("prompts/{task}-ego.md"));
    home.write(file, TEMPLATE.replace("TASK", task));
    home
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_attacker_is_printed_and_kept() {
    let home = home("attacker");
    let choice = json!({
        "attacker": 301,
        "obstacles": [{"id": 301, "risk_score": 2, "reason": "close"}, {"id": 9999, "risk_score": 4, "reason": "far"}],
        "justification": "It could cut in.",
    });
    let server = Server::start(vec![
        streamed(&choice.to_string()),
        streamed(&choice.to_string()),
    ])
    .await;
    let ended = ask(
        &home,
        server.base_url(),
        &["--task", "attacker", "--format=json"],
    )
    .status(0);
    let document = ended.json();
    assert_eq!(
        (&document["task"], &document["verdict"]["attacker"]),
        (&json!("attacker"), &json!(301))
    );
    assert_eq!(document["verdict"]["obstacles"], choice["obstacles"]);
    assert_eq!(
        (&document["reading"], &document["repaired"]),
        (&json!("strict"), &json!([]))
    );
    assert_eq!(
        document["flags"][0],
        "names obstacle 9999, which is not in the scene"
    );
    let kept: Value = serde_json::from_str(home.runs()[0]["verdict"].as_deref().unwrap()).unwrap();
    assert_eq!(
        (&kept["task"], &kept["attacker"]),
        (&json!("attacker"), &json!(301))
    );
    assert_eq!(home.runs()[0]["reading"].as_deref(), Some("strict"));
    let words = ask(&home, server.base_url(), &["--task", "attacker"])
        .status(0)
        .stdout;
    assert!(
        words.contains("attacker      301 (lab/tiny)") && words.contains("risk 2      301  close"),
        "{words}"
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_trajectory_is_printed_and_kept() {
    let home = home("trajectory");
    let points = "{'attacker': 301, 'trajectory': [[0, 1.5, 2], [5, 2.5, 2, 0.1, 7]],} // so";
    let manoeuvre = json!({
        "obstacle": 301,
        "waypoints": null,
        "manoeuvre": {"kind": "cut-in", "start": 1.5, "duration": 2.0, "gap": 3.0, "speed": null},
        "justification": "It leaves no room.",
    });
    let answers = vec![streamed(points), streamed(&manoeuvre.to_string())];
    let server = Server::start(answers).await;
    let document = ask(
        &home,
        server.base_url(),
        &["--task", "trajectory", "--format=json"],
    )
    .status(0)
    .json();
    assert_eq!(document["verdict"]["waypoints"][1]["step"], 5);
    assert_eq!(document["verdict"]["waypoints"][1]["velocity"], 7.0);
    let repaired = document["repaired"].to_string();
    assert!(
        repaired.contains("read as steps") && repaired.contains("quotation marks"),
        "{repaired}"
    );
    let fresh = ["--task", "trajectory", "--fresh"];
    let words = ask(&home, server.base_url(), &fresh).status(0).stdout;
    assert!(
        words.contains("manoeuvre     cut-in from 1.50 s for 2.00 s, gap 3.00 m\n"),
        "{words}"
    );
    let schema = &server.requests()[0].json();
    assert!(schema["messages"].is_array());
}

#[test]
fn the_built_in_judge_says_what_it_does_not_answer() {
    let home = home("attacker");
    let arguments = ["ask", CUT_IN, "--task", "attacker"];
    home.run(&arguments)
        .status(2)
        .says(&["built-in judge", "collision, safety or recording only"]);
    assert!(home.runs().is_empty());
    let arguments = ["evaluate", CUT_IN, "--task", "attacker"];
    home.run(&arguments).status(2).says(&[
        "--task: attacker cannot be evaluated",
        "use collision, safety or recording",
    ]);
    home.run(&["ask", CUT_IN, "--task", "flight"])
        .status(2)
        .says(&["collision, safety, recording, attacker, trajectory"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn obstacles_that_are_not_there_are_told_wherever_the_verdict_names_them() {
    let home = Home::new();
    let answer = json!({
        "collision": true,
        "obstacles": [{"id": 8_888, "risk_score": 0, "reason": ""}, {"id": 301, "risk_score": 1, "reason": ""}],
        "critical_obstacles": [{"id": 9_999, "probability": 0.9}, {"id": 8_888, "probability": 0.8}],
        "probability": 0.9,
        "justification": "",
    });
    let server = Server::start(vec![streamed(&answer.to_string())]).await;
    let asked = ask(&home, server.base_url(), &[]).status(0).stdout;
    for id in [8888, 9999] {
        let flag = format!("doubtful      names obstacle {id}, which is not in the scene");
        assert!(asked.contains(&flag), "{asked}");
    }
}
