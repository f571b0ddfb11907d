//! Generation by a model, with real tasks, a real store and a local server.

use std::time::Duration;

use super::asking::Whole;
use super::asking::server::{Script, Server};
use super::written::found;
use crate::loaded::GenerationStage;
use crate::model::{JobKind, JobState, Model, Notice};
use nearmiss_scene::verdict::Motion;
use nearmiss_store::RunId;

/// An answer as a server streams it.
fn says(answer: &serde_json::Value) -> Script {
    let delta = serde_json::json!({
        "model": "small",
        "choices": [{ "index": 0, "delta": { "content": answer.to_string() } }],
    });
    Script::chunked_events()
        .chunk(format!("data: {delta}\n\n"))
        .chunk("data: {\"choices\":[{\"index\":0,\"delta\":{},\"finish_reason\":\"stop\"}]}\n\n")
        .chunk("data: {\"choices\":[],\"usage\":{\"prompt_tokens\":9000,\"completion_tokens\":100}}\n\n")
        .chunk("data: [DONE]\n\n")
        .end_of_chunks()
}

fn chooses(attacker: i64) -> Script {
    says(&serde_json::json!({
        "attacker": attacker,
        "obstacles": [{ "id": attacker, "risk_score": 2, "reason": "near" }],
        "justification": "It is the nearest.",
    }))
}

/// Grades an obstacle.
fn grades(obstacle: i64) -> Script {
    says(&serde_json::json!({
        "justification": "It closes in.",
        "obstacles": [{ "id": obstacle, "risk_score": 1, "reason": "near" }],
        "critical_obstacles": [{ "id": obstacle, "probability": 0.9 }],
        "probability": 0.9,
        "safety_critical": true,
    }))
}

/// Moves an obstacle as the search found it.
fn moves(attacker: i64, motion: &Motion) -> Script {
    let asked = serde_json::json!(nearmiss_drive::generation::RequestedMotion::from(motion));
    says(&serde_json::json!({
        "obstacle": attacker,
        "waypoints": null,
        "manoeuvre": asked["manoeuvre"],
        "justification": "It leaves no room.",
    }))
}

/// The planner of [`coarse`], one request at a time.
const COARSE: &str = "concurrency = 1\nmax_tokens = 500\n[planner]\nhorizon = 3.0\n[planner.sampling]\ndurations = 2\n\
                      speeds = 4\noffsets = 5\nchanges = 1\nrefinements = 0";

impl Whole {
    /// Opens the right turn, and lets the model attack.
    async fn attack(&mut self) {
        self.until("scenarios", |model| model.list.found).await;
        self.press("/ r i g h t t u r n enter");
        let open = |model: &Model| {
            let opened = model.opened.as_ref();
            model.opening.is_none() && opened.is_some_and(|o| o.name.contains("RightTurn"))
        };
        self.until("the right turn", open).await;
        self.press("space g m enter");
    }

    async fn end(&mut self) -> JobState {
        self.until("the end", |model| model.jobs.asking() == 0)
            .await;
        let job = self.model.jobs.all.iter().rev().find(|job| job.asks());
        job.unwrap().state.clone()
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_server_writes_it_and_nothing_is_paid_for_twice() {
    let (id, motion) = found();
    let server = Server::answering(move |_, request| {
        let body = request.json().to_string();
        Some(if body.contains("Which obstacle should be the attacker") {
            chooses(id)
        } else if body.contains("Write a new motion for obstacle") {
            moves(id, &motion)
        } else {
            grades(id)
        })
    })
    .await;
    let far = format!("attack_within = 300.0\n{COARSE}");
    let mut whole = Whole::start(&server, &far);
    whole.attack().await;
    let state = whole.end().await;
    assert!(
        matches!(&state, JobState::Done(words) if words.starts_with("collision, attacker")),
        "{state:?} {:?}",
        whole.model.toasts
    );
    let job = whole.model.jobs.all.last().unwrap();
    // Three votes and at least five motions; all motions are the same, so one grade is asked for, and the rest is in the
    // store.
    let asked = server.requests().len();
    assert!((9..=19).contains(&asked), "{asked}");
    assert_eq!(job.tokens, asked as u64 * 9100);
    assert!(
        (job.cost - asked as f64 * 9200e-6).abs() < 1e-9,
        "{}",
        job.cost
    );
    assert_eq!(whole.states(), vec!["answered".to_string(); asked]);
    let made = whole.model.variant().unwrap().made.clone();
    let wrote = made.authorship.as_ref().unwrap();
    let papers = made.variant().author.unwrap();
    assert!(
        papers["justification"].is_string() && papers["requests"].as_u64() > Some(0),
        "{papers}"
    );
    assert_eq!(
        (made.by.as_str(), wrote.authored.attacks.len()),
        ("lab/small", asked - 4)
    );
    let run = wrote.taken.unwrap().run;
    assert!(run.is_some_and(|run| run > RunId(1)), "{run:?}");
    assert_eq!(made.effect.main().obstacle, id);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_cancelled_is_closed_and_written_down() {
    let held = Script::chunked_events().await_close();
    let server = Server::start(vec![held]).await;
    let mut whole = Whole::start(&server, COARSE);
    whole.attack().await;
    let asked = |model: &Model| {
        let search = model.maker.under_way.as_ref();
        search.is_some_and(|s| matches!(s.at, Some(GenerationStage::Writing(_))))
    };
    whole.until("a question", asked).await;
    while server.requests().is_empty() {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    whole.press("esc esc");
    assert!(matches!(whole.end().await, JobState::Cancelled(_)));
    assert!(server.seen_close().await);
    assert_eq!(whole.states(), ["cancelled"]);
    assert!(whole.model.variant().is_none() && !whole.model.jobs.is_stopping(JobKind::Generate));
    // Who leaves in the middle of it pays for nothing that is not written down.
    whole.press("space g m enter");
    whole.until("a question", asked).await;
    whole.tasks.finish().await;
    assert!(
        !whole.states().contains(&"running".to_string()),
        "{:?}",
        whole.states()
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn that_nothing_can_be_asked_is_said() {
    let fault = Script::json(401, r#"{"error":{"message":"no such key"}}"#);
    let server = Server::start(vec![fault]).await;
    let mut whole = Whole::start(&server, COARSE);
    whole.attack().await;
    let state = whole.end().await;
    assert!(
        matches!(&state, JobState::Failed(why) if why.contains("401")),
        "{state:?}"
    );
    let errors = whole
        .model
        .toasts
        .iter()
        .filter(|t| t.kind == Notice::Error);
    let errors: Vec<&str> = errors.map(|t| t.text.as_str()).collect();
    assert!(
        errors.len() == 1 && errors[0].contains("no such key"),
        "{errors:?}"
    );
    assert_eq!(server.requests().len(), 1);

    // More than the budget allows, and an unknown model.
    let server = Server::start(Vec::new()).await;
    let mut whole = Whole::start(&server, &format!("budget = 0.00001\n{COARSE}"));
    whole.attack().await;
    let state = whole.end().await;
    assert!(
        matches!(&state, JobState::Failed(why) if why.contains("budget")),
        "{state:?}"
    );
    assert!(server.requests().is_empty());
    whole.model.model = "nobody/knows".into();
    whole.press("space g m enter");
    let state = whole.end().await;
    assert!(
        matches!(&state, JobState::Failed(why) if why.contains("nobody")),
        "{state:?}"
    );
}
