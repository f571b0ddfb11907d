//! Tools for models with real tasks, a real store and a local server: the switch reaches what is sent.

use serde_json::{Value, json};

use super::asking::Whole;
use super::asking::server::{Recorded, Script, Server};
use crate::model::Model;

/// A server that calls a tool once where it may, and then answers.
async fn server() -> Server {
    Server::answering(|_, request: &Recorded| {
        let body = request.json();
        let messages = body["messages"].as_array().unwrap();
        let told = messages.iter().any(|message| message["role"] == "tool");
        let message = if body.get("tools").is_some() && !told { json!({
                "role": "assistant", "content": null, "tool_calls": [{
                    "id": "c", "type": "function",
                    "function": {"name": "list_obstacles", "arguments": "{}"},
                }],
            }) } else { json!({
                "role": "assistant",
                "content": r#"{"collision": false, "obstacles": [], "justification": "so"}"#,
            }) };
        let turn = json!({
            "model": "small", "choices": [{"index": 0, "message": message, "finish_reason": "stop"}],
            "usage": {"prompt_tokens": 100, "completion_tokens": 10},
        });
        Some(Script::json(200, &turn.to_string()))
    })
    .await
}

fn with_tools(server: &Server) -> Vec<bool> {
    let requests = server.requests();
    let bodies = requests.iter().map(Recorded::json);
    bodies
        .map(|body: Value| body.get("tools").is_some())
        .collect()
}

async fn answered(whole: &mut Whole, columns: usize) {
    let done = move |model: &Model| {
        let all = &model.answers.columns;
        all.len() == columns && all.iter().all(|column| column.answer().is_some())
    };
    whole.until("an answer", done).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_switch_reaches_the_server_and_what_was_asked_is_in_the_store() {
    let server = server().await;
    let mut whole = Whole::start(&server, "max_tokens = 100");
    let open = |model: &Model| model.list.found && model.opened.is_some();
    whole.until("scenarios", open).await;
    whole.press("r");
    answered(&mut whole, 1).await;
    whole.press("space a u r");
    answered(&mut whole, 2).await;
    assert_eq!(with_tools(&server), [false, true, true]);
    let column = whole.model.answers.column().unwrap();
    assert!(column.how.ends_with("+tools"), "{}", column.how);
    assert_eq!(column.tool_rounds.len(), 1);
    // Both are two questions, each answered by the store from now on.
    whole.press("r");
    answered(&mut whole, 2).await;
    whole.press("space a u r");
    answered(&mut whole, 2).await;
    assert_eq!(server.requests().len(), 3);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_configuration_begins_with_tools_and_attacks_use_none() {
    let server = server().await;
    let mut whole = Whole::start(&server, "tools = true\nattack_within = 300.0");
    let open = |model: &Model| model.list.found && model.opened.is_some();
    whole.until("scenarios", open).await;
    assert!(whole.model.tools);
    whole.press("r");
    answered(&mut whole, 1).await;
    assert_eq!(with_tools(&server), [true, true]);
    // As `generate` asks, which has no tools.
    whole.press("space g m enter");
    whole
        .until("the end", |model| model.jobs.asking() == 0)
        .await;
    let asked = with_tools(&server);
    assert!(asked.len() > 2 && !asked[2..].contains(&true), "{asked:?}");
}
