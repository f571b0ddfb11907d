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
    let today: jiff::civil::Date = "2026-11-21".parse().unwrap();
    for entry in all {
        assert!(entry.as_of.is_some_and(|day| day <= today), "{entry:?}");
        assert!(
            entry
                .source
                .as_ref()
                .is_some_and(|s| s.starts_with("https://")),
            "{entry:?}"
        );
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
