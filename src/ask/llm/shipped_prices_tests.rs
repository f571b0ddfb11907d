//! Tests of the shipped prices: their sources, and the costs computed from them.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::llm::Usage;

fn shipped() -> Registry {
    Registry::new(&toml::Table::new()).unwrap()
}

#[test]
fn every_shipped_price_has_a_day_and_a_source() {
    let registry = shipped();
    let prices = |name: &str| registry.providers[name].prices();
    let all: Vec<_> = registry
        .providers
        .values()
        .flat_map(|p| p.prices().entries)
        .collect();
    assert!(!all.is_empty());
    let today: jiff::civil::Date = "2026-11-27".parse().unwrap();
    for entry in all {
        assert!(entry.as_of.is_some_and(|day| day <= today), "{entry:?}");
        let price = entry.price;
        assert!(
            price.output >= price.input && price.input > 0.0,
            "{entry:?}"
        );
        assert!(
            price.cached.is_none_or(|cached| cached < price.input),
            "{entry:?}"
        );
        assert!(
            price
                .cache_write
                .is_none_or(|written| written >= price.input),
            "{entry:?}"
        );
    }
    assert_eq!(prices("openai").entries, prices("openai-responses").entries);
}

/// Pages of others that quote a provider's list, where its own page could not be read with every rate of a model.
const QUOTED: [&str; 4] = [
    "github.com",
    "docs.laozhang.ai",
    "docs.apiyi.com",
    "apidog.com",
];

#[test]
fn every_source_is_a_page_of_the_provider_or_one_that_quotes_it() {
    let own = |provider: &str| match provider {
        "openai" | "openai-responses" => "developers.openai.com",
        "gemini" => "ai.google.dev",
        "deepseek" => "api-docs.deepseek.com",
        "anthropic" => "platform.claude.com",
        "xai" => "docs.x.ai",
        "mistral" => "docs.mistral.ai",
        "qwen" => "www.alibabacloud.com",
        other => panic!("{other} has prices, but no site here"),
    };
    let (mut first_hand, mut all) = (0, 0);
    for (name, provider) in shipped().providers {
        for entry in provider.prices().entries {
            let source = entry.source.clone().unwrap_or_default();
            let url = reqwest::Url::parse(&source).unwrap();
            let host = url.host_str().unwrap_or_default();
            assert_eq!(url.scheme(), "https", "{entry:?}");
            assert!(host == own(&name) || QUOTED.contains(&host), "{entry:?}");
            first_hand += usize::from(host == own(&name));
            all += 1;
        }
    }
    assert!(first_hand >= 20, "{first_hand} of {all} at first hand");
}

#[test]
fn what_is_read_from_and_written_to_the_cache_has_its_own_price() {
    let day: jiff::civil::Date = "2026-11-20".parse().unwrap();
    let prices = shipped().providers["anthropic"].prices();
    let pricing = prices.pricing_for("claude-opus-5-5", day).unwrap();
    let usage = |cached, written| Usage {
        input_tokens: Some(1000),
        output_tokens: Some(100),
        cached_tokens: Some(cached),
        cache_write_tokens: Some(written),
        ..Usage::default()
    };
    let cost = |usage| (pricing.cost(&usage, QUIET.parse().unwrap()).unwrap() * 1e6).round();
    assert_eq!(
        cost(usage(0, 800)),
        200.0 * 4.0 + 800.0 * 5.0 + 100.0 * 20.0
    );
    assert_eq!(
        cost(usage(800, 0)),
        (200.0 * 4.0_f64 + 800.0 * 0.2 + 100.0 * 20.0).round()
    );
    let words = pricing.bound_words().unwrap();
    assert!(words.contains("×1.25 of input"), "{words}");
}

const QUIET: &str = "2026-11-20T12:00:00Z";

#[test]
fn models_take_the_efforts_that_their_providers_document() {
    let registry = shipped();
    let environment = Environment::from_lookup(|_| None);
    let refused = |id: &str, effort| {
        let (endpoint, model) = registry.resolve(id, &environment).unwrap();
        let request = crate::llm::Request {
            model,
            messages: Vec::new(),
            parameters: crate::llm::Parameters {
                effort: Some(effort),
                ..crate::llm::Parameters::default()
            },
            schema: None,
            tools: None,
        };
        let checked = crate::llm::effort::check(&endpoint, &request);
        checked.err().map(|error| error.to_string())
    };
    use crate::llm::Effort::{High, Low, Max, Medium, Minimal, Off, XHigh};
    for (id, taken, not) in [
        ("openai/gpt-6-luna", &[Off, XHigh, Max][..], &[Minimal][..]),
        ("openai/gpt-6.2-sol", &[Low, Max], &[Off, Minimal]),
        ("openai/gpt-6.1-sol", &[XHigh], &[Max, Off]),
        ("openai-responses/gpt-6.1-sol", &[Max], &[Off]),
        ("openai/gpt-5", &[Minimal, High], &[Off, Max]),
        ("openai/o3", &[Medium], &[Minimal]),
        (
            "anthropic/claude-opus-5-5",
            &[Low, XHigh, Max],
            &[Off, Minimal],
        ),
        ("anthropic/claude-opus-5", &[Off, XHigh], &[Minimal]),
        ("anthropic/claude-opus-4-6", &[Off, Max], &[XHigh]),
        ("anthropic/claude-opus-4-5", &[High], &[Max]),
        (
            "gemini/gemini-3.8-flash",
            &[Low, High],
            &[Off, Minimal, Max],
        ),
        ("gemini/gemini-3.5-flash-lite", &[Minimal], &[XHigh]),
        ("gemini/gemini-4-carbon", &[Low, High], &[Off, XHigh]),
        ("gemini/gemini-4-hydrogen", &[Low, XHigh], &[Minimal, Max]),
        ("xai/grok-4.7", &[Low, XHigh], &[Off, Max]),
        ("xai/grok-4.3", &[Off, High], &[XHigh]),
        ("mistral/mistral-medium-2604", &[Off, High], &[Low]),
        ("qwen/qwen3.8-max", &[Off, XHigh], &[High]),
        ("qwen/qwen3.7-flash", &[Off, High], &[]),
        ("deepseek/deepseek-flash", &[Off, Max], &[Medium]),
        ("openrouter/any/model", &[Minimal, XHigh], &[Max]),
        ("ollama/qwen3", &[Off, Max], &[Minimal]),
        // Only to be switched, or not at all: a note says so.
        ("local/default", &[Off, Minimal, Max], &[]),
        ("openai/gpt-4o", &[High], &[]),
    ] {
        for effort in taken {
            assert_eq!(refused(id, *effort), None, "{id}");
        }
        for effort in not {
            let words = refused(id, *effort).unwrap_or_default();
            let model = id.split_once('/').unwrap().1;
            let start = format!("{model} does not take effort {}; it takes ", effort.name());
            assert!(words.contains(&start), "{id} {effort:?}: {words}");
            let named = |one: &crate::llm::Effort| {
                words.split("takes").last().unwrap().contains(one.name())
            };
            assert!(taken.iter().all(named), "{words}");
        }
    }
}

#[test]
fn shipped_prices_are_worked_with_in_every_kind_of_token() {
    let registry = shipped();
    let cost = |name: &str, asked: &str, returned: &str, at: &str, usage: Usage| {
        let at: jiff::Timestamp = at.parse().unwrap();
        let day = at.to_zoned(jiff::tz::TimeZone::UTC).date();
        let prices = registry.providers[name].prices();
        let pricing = prices.of_answer(asked, Some(returned), day)?;
        Some((pricing.cost(&usage, at)? * 1e6).round())
    };
    let usage = |input, output, cached, reasoning| Usage {
        input_tokens: Some(input),
        output_tokens: Some(output),
        cached_tokens: Some(cached),
        reasoning_tokens: Some(reasoning),
        ..Usage::default()
    };
    let quiet = "2026-11-20T12:00:00Z";
    // Reasoning is within the output and is not counted again.
    let o3 = cost(
        "openai",
        "o3",
        "o3-2025-04-16",
        quiet,
        usage(1000, 500, 400, 450),
    );
    assert_eq!(o3, Some(600.0 * 2.0 + 400.0 * 0.5 + 500.0 * 8.0));
    let flash = |at| {
        cost(
            "deepseek",
            "deepseek-flash",
            "deepseek-flash",
            at,
            usage(1000, 100, 1000, 0),
        )
    };
    assert_eq!(flash(quiet), Some(63.0));
    assert_eq!(
        flash("2026-11-20T02:00:00Z"),
        Some(126.0),
        "ten in Beijing, a Friday"
    );
    let gemini = |at| {
        cost(
            "gemini",
            "gemini-3.8-flash",
            "gemini-3.8-flash",
            at,
            usage(1000, 0, 0, 0),
        )
    };
    assert_eq!(gemini("2026-12-31T12:00:00Z"), Some(750.0));
    assert_eq!(gemini("2027-01-01T12:00:00Z"), Some(1500.0));
    let argon = |at| {
        cost(
            "gemini",
            "gemini-4-argon",
            "gemini-4-argon",
            at,
            usage(1000, 100, 400, 0),
        )
    };
    assert_eq!(argon("2026-11-30T12:00:00Z"), Some(2240.0));
    assert_eq!(argon("2026-12-01T12:00:00Z"), Some(4480.0));
    // Google answers, and bills, another model in place of the one that it retires.
    let routed = cost(
        "gemini",
        "gemini-2.5-pro",
        "gemini-3.8-flash",
        "2026-12-02T12:00:00Z",
        usage(1000, 0, 0, 0),
    );
    assert_eq!(routed, Some(750.0));
    let luna = |input| {
        cost(
            "openai",
            "gpt-6-luna",
            "gpt-6-luna",
            quiet,
            usage(input, 0, 0, 0),
        )
    };
    assert_eq!(
        (luna(272_000), luna(300_000)),
        (Some(27_200.0), Some(60_000.0))
    );
}
