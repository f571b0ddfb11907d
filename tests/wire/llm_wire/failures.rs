//! Requests that get no answer, and which of them are repeated.

use tokio::io::AsyncWriteExt;

use super::*;

#[tokio::test]
async fn refusals_of_the_request() {
    let error = format!("{{\"error\":{{\"message\":\"bad key {KEY}\\u001b[2J\"}}}}");
    for status in [401, 403] {
        let answer = ask_script(Script::json(status, &error)).await;
        let error = answer.error.unwrap();
        assert!(
            matches!(&error, Error::Unauthorized { message, key_sent: true, .. } if message == "bad key [key] [2J"),
            "{error:?}"
        );
        assert!(error.to_string().contains("TEST_API_KEY"), "{error}");
    }
    let answer = ask_script(Script::json(
        404,
        r#"{"error":{"message":"no such model"}}"#,
    ))
    .await;
    let error = answer.error.unwrap();
    assert!(
        matches!(&error, Error::NotFound { model, message, .. } if model == "small-1" && message == "no such model")
    );
    assert!(
        error.to_string().contains("/v1/chat/completions"),
        "{error}"
    );
    for status in [400, 413, 422] {
        let answer = ask_script(Script::json(status, r#"{"detail":"seed is unknown"}"#)).await;
        match answer.error {
            Some(Error::BadRequest {
                status: s, message, ..
            }) => assert_eq!((s, message.as_str()), (status, "seed is unknown")),
            other => panic!("{other:?}"),
        }
    }
    let redirect = Script::answer(
        307,
        &[("Location", "https://elsewhere.example/v1?key=x")],
        "",
    );
    let answer = ask_script(redirect).await;
    assert!(
        matches!(answer.error, Some(Error::Redirected { to, .. }) if to == "https://elsewhere.example/v1")
    );
    let answer = ask_script(Script::answer(
        200,
        &[("Content-Type", "text/html")],
        "<html>",
    ))
    .await;
    assert!(matches!(answer.error, Some(Error::Malformed { .. })));
}

#[tokio::test]
async fn a_long_explanation_is_cut() {
    let answer = ask_script(Script::answer(400, &[], &"x".repeat(1 << 20))).await;
    match answer.error {
        Some(Error::BadRequest { message, .. }) => assert_eq!(message.chars().count(), 301),
        other => panic!("{other:?}"),
    }
}

#[tokio::test]
async fn a_busy_server_is_asked_again_when_it_says() {
    let busy = Script::answer(
        429,
        &[("Retry-After", "1")],
        r#"{"error":{"message":"slow down"}}"#,
    );
    let server = Server::start(vec![busy, Script::events().send(usual())]).await;
    let begun = Instant::now();
    let mut answer = ask(endpoint(server.base_url())).await;
    assert!(begun.elapsed() >= Duration::from_secs(1));
    assert_eq!(
        answer.retries(),
        [(2, Duration::from_secs(1), "429: slow down")]
    );
    answer.other.remove(0);
    assert_usual(&answer);
    let requests = server.requests();
    assert_eq!(requests.len(), 2);
    assert_eq!(
        requests[0].body, requests[1].body,
        "nothing is dropped from a repeated request"
    );
}

#[tokio::test]
async fn a_server_that_stays_busy() {
    let busy = Script::json(
        429,
        r#"{"error":{"message":"slow down","code":"rate_limit_exceeded"}}"#,
    );
    let server = Server::start(vec![busy.clone(), busy.clone(), busy.clone(), busy]).await;
    let answer = ask(endpoint(server.base_url())).await;
    assert!(
        matches!(
            answer.error,
            Some(Error::RateLimited {
                retry,
                exhausted: false,
                ..
            }) if retry.after().is_none()
        ),
        "{answer:?}"
    );
    assert_eq!(
        answer.retries().iter().map(|r| r.0).collect::<Vec<_>>(),
        [2, 3]
    );
    assert_eq!(server.requests().len(), 3);
}

#[tokio::test]
async fn what_cannot_pass_is_asked_once() {
    let answer = ask_script(Script::json(
        429,
        r#"{"error":{"message":"pay","type":"insufficient_quota","code":"insufficient_quota"}}"#,
    ))
    .await;
    assert!(
        matches!(
            answer.error,
            Some(Error::RateLimited {
                exhausted: true,
                ..
            })
        ),
        "{answer:?}"
    );
    let answer = ask_script(Script::json(
        402,
        r#"{"error":{"message":"Insufficient Balance"}}"#,
    ))
    .await;
    assert!(
        matches!(
            answer.error,
            Some(Error::RateLimited {
                exhausted: true,
                status: 402,
                ..
            })
        ),
        "{answer:?}"
    );
    let answer = ask_script(Script::answer(
        429,
        &[("Retry-After", "121")],
        "{\"error\":\"later\"}",
    ))
    .await;
    assert!(
        matches!(&answer.error, Some(Error::RateLimited { retry, message, .. }) if retry.after().is_some_and(|wait| wait.as_secs() == 121) && message == "later"),
        "{answer:?}"
    );
    assert_eq!(answer.retries(), []);
    let answer = ask_script(Script::answer(500, &[("X-Should-Retry", "false")], "no")).await;
    assert!(
        matches!(answer.error, Some(Error::Server { status: 500, .. })),
        "{answer:?}"
    );
}

#[tokio::test]
async fn a_server_that_stumbles() {
    let loading = Script::json(
        503,
        r#"{"error":{"code":503,"message":"Loading model","type":"unavailable_error"}}"#,
    );
    let server = Server::start(vec![
        Script::answer(500, &[], "oops"),
        loading,
        Script::events().send(usual()),
    ])
    .await;
    let mut answer = ask(endpoint(server.base_url())).await;
    assert_eq!(
        answer.retries().iter().map(|r| r.2).collect::<Vec<_>>(),
        ["500: oops", "503: Loading model"]
    );
    answer.other.drain(..2);
    assert_usual(&answer);
    assert_eq!(server.requests().len(), 3);
    let broken = Script::answer(502, &[], "");
    let server = Server::start(vec![broken.clone(), broken.clone(), broken]).await;
    let answer = ask(endpoint(server.base_url())).await;
    assert!(
        matches!(answer.error, Some(Error::Server { status: 502, .. })),
        "{answer:?}"
    );
}

#[tokio::test]
async fn a_server_that_does_not_run() {
    let unused = std::net::TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    let answer = ask(endpoint(&format!("http://{unused}"))).await;
    assert_eq!(answer.other, [], "no retries");
    let error = answer.error.unwrap();
    assert!(matches!(error, Error::Refused { .. }), "{error:?}");
    assert!(
        error
            .to_string()
            .contains(&format!("fixture (http://{unused}/v1/chat/completions)")),
        "{error}"
    );
}

#[tokio::test]
async fn encryption_with_a_server_that_has_none() {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let base = format!("https://{}", listener.local_addr().unwrap());
    let server = tokio::spawn(async move {
        let (mut stream, _) = listener.accept().await.unwrap();
        stream
            .write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n")
            .await
            .unwrap();
        tokio::time::sleep(Duration::from_secs(5)).await;
    });
    let answer = ask(endpoint(&base)).await;
    assert!(
        matches!(answer.error, Some(Error::Tls { .. })),
        "{answer:?}"
    );
    assert_eq!(answer.other, [], "no retries");
    server.abort();
}

#[tokio::test]
async fn a_connection_that_breaks_before_the_request_is_tried_again() {
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    // Encryption is asked for, so the connection is not made before the server has spoken.
    let base = format!("https://{}", listener.local_addr().unwrap());
    let server = tokio::spawn(async move {
        for _ in 0..3 {
            drop(listener.accept().await.unwrap());
        }
    });
    let answer = ask(endpoint(&base)).await;
    assert!(
        matches!(answer.error, Some(Error::Unreachable { .. })),
        "{answer:?}"
    );
    assert_eq!(answer.retries().len(), 2);
    server.await.unwrap();
}

#[tokio::test]
async fn a_wrong_address_or_key_is_found_before_anything_is_sent() {
    let answer = ask(endpoint("localhost:8080")).await;
    assert!(
        matches!(answer.error, Some(Error::Setup { .. })),
        "{answer:?}"
    );
    let server = Server::start(vec![]).await;
    let answer = ask(Endpoint {
        key: Some(format!("{KEY}\u{7}x").into()),
        ..endpoint(server.base_url())
    })
    .await;
    assert!(answer.error.unwrap().to_string().contains("TEST_API_KEY"));
    assert_eq!(server.requests(), []);
}
