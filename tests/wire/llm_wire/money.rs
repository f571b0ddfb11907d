//! Limits and money: what is spent, what is refused, and who waits.

use std::num::NonZeroU32;

use nearmiss::llm::{Budget, Cost, CostSource, Limits, Price, PriceEntry, Prices};

use super::*;

fn prices() -> Prices {
    let entry = PriceEntry {
        model: "small-*".into(),
        from: None,
        to: None,
        up_to: None,
        price: Price {
            input: 1000.0,
            output: 10_000.0,
            cached: None,
            cache_write: None,
        },
        as_of: None,
        source: None,
    };
    Prices {
        entries: vec![entry],
        ..Prices::default()
    }
}

/// What the usual answer costs: 12 tokens in, 3 out.
const USUAL: f64 = 0.042;

fn priced(base_url: &str, budget: &Budget) -> Endpoint {
    Endpoint {
        prices: prices(),
        budget: Some(budget.clone()),
        ..endpoint(base_url)
    }
}

fn cost(answer: &Answer) -> Option<Cost> {
    answer.other.iter().find_map(|chunk| match chunk {
        Chunk::Usage(usage) => Some(usage.cost),
        _ => None,
    })?
}

#[tokio::test]
async fn what_an_answer_cost_is_worked_out_or_taken_from_the_server() {
    let stated = usual().replace(
        "\"completion_tokens\":3",
        "\"completion_tokens\":3,\"cost\":0.25",
    );
    let other = usual().replace("small-1-2026", "large-2");
    let scripts = [usual(), stated, other].map(|body| Script::events().send(body));
    let server = Server::start(scripts.to_vec()).await;
    let budget = Budget::new(10.0);
    let answer = ask(priced(server.base_url(), &budget)).await;
    let first = cost(&answer).unwrap();
    assert!(
        (first.usd - USUAL).abs() < 1e-9 && first.source == CostSource::Prices,
        "{first:?}"
    );
    assert!((budget.spent() - USUAL).abs() < 1e-9);
    let answer = ask(priced(server.base_url(), &budget)).await;
    assert_eq!(
        cost(&answer),
        Some(Cost {
            usd: 0.25,
            source: CostSource::Server
        })
    );
    assert!((budget.spent() - USUAL - 0.25).abs() < 1e-9);
    let answer = ask(priced(server.base_url(), &budget)).await;
    assert_eq!(
        cost(&answer),
        None,
        "another model answered, whose price is unknown"
    );
    assert!(
        budget.spent() > 0.9,
        "so all that was set aside is counted: {budget:?}"
    );
}

#[tokio::test]
async fn nothing_is_sent_that_could_exceed_the_budget() {
    let server = Server::start(vec![Script::events().send(usual())]).await;
    let refused = |endpoint: Endpoint, words: &'static [&'static str]| async move {
        let answer = ask(endpoint).await;
        let error = answer.error.unwrap();
        assert!(matches!(error, Error::Budget { .. }), "{error:?}");
        let text = error.to_string();
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    };
    let url = server.base_url();
    refused(
        priced(url, &Budget::new(0.5)),
        &["was not asked", "$0.5000", "raise the budget"],
    )
    .await;
    let unknown = Endpoint {
        prices: Prices::default(),
        ..priced(url, &Budget::new(5.0))
    };
    refused(
        unknown,
        &["none is known for small-1", "[[provider.fixture.prices]]"],
    )
    .await;
    assert_eq!(server.requests(), []);

    let endless = Request {
        parameters: Parameters::default(),
        ..request()
    };
    let chunks: Vec<_> = stream(&Client::direct(), priced(url, &Budget::new(5.0)), endless)
        .collect()
        .await;
    assert!(
        matches!(&chunks[..], [Err(Error::Budget { why, .. })] if why.contains("set max_tokens")),
        "{chunks:?}"
    );
    assert_eq!(server.requests(), []);
}

#[tokio::test]
async fn what_was_refused_costs_nothing_and_what_broke_off_costs_all() {
    let broken = Script::json(500, "{}");
    let scripts = vec![
        Script::json(400, "{}"),
        broken.clone(),
        broken.clone(),
        broken,
        Script::events().send(delta("so far")),
        Script::events().send(delta("a")).await_close(),
    ];
    let server = Server::start(scripts).await;
    let budget = Budget::new(3.0);
    for _ in 0..2 {
        assert!(
            ask(priced(server.base_url(), &budget))
                .await
                .error
                .is_some()
        );
        assert_eq!((budget.spent(), budget.left()), (0.0, 3.0));
    }
    ask(priced(server.base_url(), &budget)).await;
    let once = budget.spent();
    assert!(once > 0.64, "64 tokens at most: {once}");
    let mut chunks = stream(
        &Client::direct(),
        priced(server.base_url(), &budget),
        request(),
    );
    while !matches!(chunks.next().await, Some(Ok(Chunk::Text(_)))) {}
    assert!(
        budget.left() < 3.0 - 1.9 * once,
        "what is on its way is set aside"
    );
    drop(chunks);
    assert!(
        (budget.spent() - 2.0 * once).abs() < 1e-9,
        "cancelled, but it may be paid for"
    );
}

#[tokio::test]
async fn a_budget_is_shared_by_those_who_ask_at_once() {
    let slow = Script::events().pause(100 * MS).send(usual());
    let server = Server::start(vec![slow.clone(), slow.clone(), slow]).await;
    let budget = Budget::new(1.0);
    let asked = (0..3).map(|_| ask(priced(server.base_url(), &budget)));
    let answers = futures_util::future::join_all(asked).await;
    let refused = answers
        .iter()
        .filter(|a| matches!(a.error, Some(Error::Budget { .. })));
    assert_eq!(
        refused.count(),
        2,
        "one may cost 0.7, so a second does not fit"
    );
    assert_eq!(server.requests().len(), 1);
}

#[tokio::test]
async fn no_more_than_allowed_are_on_their_way() {
    let slow = Script::events().pause(150 * MS).send(usual());
    let server = Server::start(vec![slow; 4]).await;
    let client = Client::direct();
    let limits = Limits {
        concurrency: NonZeroU32::new(2),
        ..Limits::default()
    };
    let asked = (0..4).map(|_| {
        let endpoint = Endpoint {
            limits,
            ..endpoint(server.base_url())
        };
        stream(&client, endpoint, request()).collect::<Vec<_>>()
    });
    let all = futures_util::future::join_all(asked);
    let watched = async {
        tokio::time::sleep(75 * MS).await;
        server.requests().len()
    };
    let (answers, on_their_way) = tokio::join!(all, watched);
    assert_eq!(on_their_way, 2);
    assert_eq!(server.requests().len(), 4);
    assert!(
        answers
            .iter()
            .all(|a| a.last() == Some(&Ok(Chunk::Finished(Finish::Stop))))
    );
}

#[tokio::test]
async fn who_is_over_the_limit_of_a_minute_waits() {
    let good = Script::events().send(usual());
    let server = Server::start(vec![good.clone(), good]).await;
    let client = Client::direct();
    let limited = |limits| Endpoint {
        limits,
        ..endpoint(server.base_url())
    };
    let one = Limits {
        requests_per_minute: NonZeroU32::new(1),
        ..Limits::default()
    };
    let first: Vec<_> = stream(&client, limited(one), request()).collect().await;
    assert_eq!(first.last(), Some(&Ok(Chunk::Finished(Finish::Stop))));
    let mut second = stream(&client, limited(one), request());
    assert!(tokio::time::timeout(200 * MS, second.next()).await.is_err());
    assert_eq!(server.requests().len(), 1);
    let few = Limits {
        tokens_per_minute: NonZeroU32::new(20),
        ..Limits::default()
    };
    let third: Vec<_> = stream(&client, limited(few), request()).collect().await;
    assert!(
        matches!(&third[..], [Err(Error::Setup { why, .. })] if why.contains("tokens_per_minute is 20")),
        "{third:?}"
    );
}
