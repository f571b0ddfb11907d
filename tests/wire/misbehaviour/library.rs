//! Misbehaving servers asked through the library: limits shared by all dialects, and endless lists of batches.

use std::time::{Duration, Instant};

use nearmiss::llm::batch::{Batches, SubmissionMark};
use nearmiss::llm::{Chunk, Client, Dialect, Endpoint, Error, Finish, MAX_ANSWER_BYTES, decode};
use serde_json::json;

use super::support::dialects::piece;
use super::support::server::{Script, Server};

#[test]
fn every_dialect_is_cut_off_at_the_same_size_between_characters() {
    let (thoughts, words) = ("hmé".repeat(1000), "só ".repeat(1000));
    for dialect in Dialect::ALL {
        let both = piece(dialect, &thoughts, true) + &piece(dialect, &words, false);
        let bytes = thoughts.len() + words.len();
        let body = both.repeat(MAX_ANSWER_BYTES / bytes + 2);
        let items = decode(dialect, body.as_bytes().chunks(10_000));
        let size: usize = items
            .iter()
            .map(|item| match item {
                Ok(Chunk::Text(text) | Chunk::Reasoning(text)) => text.len(),
                _ => 0,
            })
            .sum();
        assert!(
            (MAX_ANSWER_BYTES - 1..=MAX_ANSWER_BYTES).contains(&size),
            "{dialect:?}: {size}"
        );
        let last = items.last();
        assert_eq!(
            last,
            Some(&Ok(Chunk::Finished(Finish::TooLong))),
            "{dialect:?}"
        );
    }
}

#[test]
fn what_came_before_an_endless_line_is_kept() {
    let body = piece(Dialect::OpenAiChat, "so far", false) + &"x".repeat(9 << 20);
    let items = decode(Dialect::OpenAiChat, [body.as_bytes()]);
    assert!(
        items.contains(&Ok(Chunk::Text("so far".into()))),
        "{items:?}"
    );
    assert_eq!(items.last(), Some(&Ok(Chunk::Finished(Finish::TooLong))));
}

/// A page of batches, all of which are others; `next` asks for the one behind it.
fn page(dialect: Dialect, next: &str) -> Script {
    let document = match dialect {
        Dialect::Gemini => json!({"operations": [{"name": "batches/a"}], "nextPageToken": next}),
        _ => json!({"data": [{"id": next, "processing_status": "ended"}], "has_more": true}),
    };
    Script::json(200, &document.to_string())
}

async fn looked_up(dialect: Dialect, server: &Server) -> Result<(), Error> {
    let endpoint = Endpoint {
        dialect,
        ..Endpoint::new("lab", server.base_url())
    };
    let batches = Batches::new(&Client::direct(), &endpoint, "m").await?;
    let ids = ["q-1".to_string(), "q-2".to_string()];
    let mark = SubmissionMark {
        tag: "ours",
        since: jiff::Timestamp::UNIX_EPOCH,
        ids: &ids,
        others: &[],
    };
    batches.look_up(mark).await.map(drop)
}

const LISTING: [Dialect; 3] = [Dialect::OpenAiChat, Dialect::Anthropic, Dialect::Gemini];

#[tokio::test]
async fn a_list_of_batches_that_repeats_itself_is_an_error() {
    for dialect in LISTING {
        let server = Server::answering(move |_, _| Some(page(dialect, "batch_1"))).await;
        let error = looked_up(dialect, &server).await.unwrap_err().to_string();
        assert!(error.contains("endless list"), "{dialect:?}: {error}");
        assert_eq!(server.requests().len(), 2, "{dialect:?}");
    }
}

#[tokio::test]
async fn a_list_of_batches_that_goes_on_for_ever_is_an_error() {
    for dialect in LISTING {
        let begun = Instant::now();
        let server =
            Server::answering(move |n, _| Some(page(dialect, &format!("batch_{n}")))).await;
        let error = looked_up(dialect, &server).await.unwrap_err().to_string();
        assert!(
            error.contains("more than 200 pages"),
            "{dialect:?}: {error}"
        );
        assert_eq!(server.requests().len(), 200, "{dialect:?}");
        assert!(begun.elapsed() < Duration::from_secs(60));
    }
}
