//! Waiting: timeouts, and closing the connection when the caller stops waiting.

use super::*;

#[tokio::test]
async fn after_done_nothing_is_awaited() {
    let server = Server::start(vec![Script::events().send(usual()).await_close()]).await;
    assert_usual(&ask(endpoint(server.base_url())).await);
    assert!(server.seen_close().await);
}

#[tokio::test]
async fn a_connection_that_is_never_made() {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let base = format!("https://{}", listener.local_addr().unwrap());
    let timeouts = Timeouts {
        connect: 100 * MS,
        ..Timeouts::default()
    };
    let answer = ask(Endpoint {
        timeouts,
        ..endpoint(&base)
    })
    .await;
    assert!(
        matches!(
            answer.error,
            Some(Error::Timeout {
                which: TimeoutKind::Connect,
                ..
            })
        ),
        "{answer:?}"
    );
    assert_eq!(answer.retries().len(), 2);
}

#[tokio::test]
async fn silence_ends_the_wait_and_comments_are_no_silence() {
    let impatient = Timeouts {
        idle: 600 * MS,
        ..Timeouts::default()
    };
    let slow = (0..6).fold(Script::events(), |s, _| {
        s.send(": keep-alive\n\n").pause(150 * MS)
    });
    let server = Server::start(vec![
        slow.send(usual()),
        Script::events().send(delta("so far")).await_close(),
        Script::silent().await_close(),
    ])
    .await;
    let endpoint = Endpoint {
        timeouts: impatient,
        ..endpoint(server.base_url())
    };
    assert_usual(&ask(endpoint.clone()).await);
    let answer = ask(endpoint.clone()).await;
    assert_eq!(answer.text, "so far");
    assert!(
        matches!(answer.error, Some(Error::Timeout { which: TimeoutKind::Idle, after, .. }) if after == 600 * MS),
        "{answer:?}"
    );
    let answer = ask(endpoint).await;
    assert!(
        matches!(
            answer.error,
            Some(Error::Timeout {
                which: TimeoutKind::Idle,
                ..
            })
        ),
        "{answer:?}"
    );
    assert_eq!(
        server.requests().len(),
        3,
        "an unanswered request may be paid for and is not repeated"
    );
}

#[tokio::test]
async fn the_total_time_does_not_start_again() {
    let script = (0..100).fold(Script::events(), |s, _| s.send(delta("a")).pause(50 * MS));
    let server = Server::start(vec![script]).await;
    let timeouts = Timeouts {
        total: 800 * MS,
        ..Timeouts::default()
    };
    let begun = Instant::now();
    let answer = ask(Endpoint {
        timeouts,
        ..endpoint(server.base_url())
    })
    .await;
    assert!(begun.elapsed() < Duration::from_millis(4000));
    assert!(!answer.text.is_empty());
    assert!(
        matches!(answer.error, Some(Error::Timeout { which: TimeoutKind::Total, after, .. }) if after == 800 * MS),
        "{answer:?}"
    );
}

#[tokio::test]
async fn a_retry_that_would_outlast_the_total_time_is_not_begun() {
    let busy = Script::answer(429, &[("Retry-After", "2")], "busy");
    let server = Server::start(vec![busy]).await;
    let timeouts = Timeouts {
        total: Duration::from_secs(1),
        ..Timeouts::default()
    };
    let answer = ask(Endpoint {
        timeouts,
        ..endpoint(server.base_url())
    })
    .await;
    assert!(
        matches!(answer.error, Some(Error::RateLimited { .. })),
        "{answer:?}"
    );
    assert_eq!(answer.retries(), []);
}

#[tokio::test]
async fn dropping_the_stream_closes_the_connection() {
    let server = Server::start(vec![Script::events().send(delta("a")).await_close()]).await;
    let mut chunks = stream(&Client::direct(), endpoint(server.base_url()), request());
    while !matches!(chunks.next().await, Some(Ok(Chunk::Text(_)))) {}
    drop(chunks);
    assert!(server.seen_close().await);
}

#[tokio::test]
async fn dropping_the_stream_before_the_answer_closes_the_connection() {
    let server = Server::start(vec![Script::silent().await_close()]).await;
    let mut chunks = stream(&Client::direct(), endpoint(server.base_url()), request());
    while server.requests().is_empty() {
        assert!(tokio::time::timeout(20 * MS, chunks.next()).await.is_err());
    }
    drop(chunks);
    assert_eq!(server.requests().len(), 1);
    assert!(server.seen_close().await);
}
