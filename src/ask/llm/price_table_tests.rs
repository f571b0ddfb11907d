//! Tests of price tables: their two forms, the file, and what it is laid over.
#![allow(clippy::unwrap_used)]

use super::*;
use crate::llm::Pricing;

const DEV: &str = r#"{
    "openai": {"id": "openai", "models": {
        "flat": {"cost": {"input": 1.5, "output": 6, "cache_read": 0.15}},
        "old": {"cost": {"input": 2, "output": 3, "context_over_200k": {"input": 4, "output": 5}}},
        "dear": {"cost": {"input": 1, "output": 2, "reasoning": 8}},
        "none": {"name": "no price"}, "gift": {"cost": {"input": 0, "output": 0}},
        "all-*": {"cost": {"input": 1, "output": 2}}, "odd": {"cost": {"input": -1, "output": 2}}
    }},
    "alibaba": {"models": {"tiered": {"cost": {"input": 0.5, "output": 3, "cache_write": 0.625, "tiers": [
        {"tier": {"type": "context", "size": 256000}, "input": 2, "output": 6}]}}}},
    "elsewhere": {"models": {"m": {"cost": {"input": 1, "output": 2}}}}
}"#;

const LITE: &str = r#"{
    "sample_spec": {"litellm_provider": "one of these", "input_cost_per_token": 0.0},
    "flat": {"litellm_provider": "openai", "mode": "chat", "input_cost_per_token": 1e-07, "output_cost_per_token": 4e-07,
        "cache_read_input_token_cost": 2.5e-08},
    "gemini/long": {"litellm_provider": "gemini", "mode": "chat", "input_cost_per_token": 1.25e-06, "output_cost_per_token": 1e-05,
        "input_cost_per_token_above_200k_tokens": 2.5e-06, "output_cost_per_token_above_200k_tokens": 1.5e-05,
        "input_cost_per_token_batches": 1e-06},
    "dashscope/steps": {"litellm_provider": "dashscope", "mode": "chat", "tiered_pricing": [
        {"range": [32000, 128000.0], "input_cost_per_token": 2e-06, "output_cost_per_token": 8e-06},
        {"range": [0, 32000.0], "input_cost_per_token": 1e-06, "output_cost_per_token": 4e-06}]},
    "openrouter/a/b": {"litellm_provider": "openrouter", "input_cost_per_token": 1e-06, "output_cost_per_token": 2e-06},
    "embed": {"litellm_provider": "openai", "mode": "embedding", "input_cost_per_token": 1e-08, "output_cost_per_token": 0.0}
}"#;

fn day(text: &str) -> Date {
    text.parse().unwrap()
}

fn table(text: &str) -> Result<PriceTable, String> {
    PriceTable::read(text, |form| format!("here ({form})"), day("2026-11-28"))
}

/// A registry with a file of prices beside its configuration.
fn laid(file: &str, users: &str) -> Registry {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("config.toml");
    std::fs::write(folder.path().join(FILE), file).unwrap();
    Registry::lenient(&toml::from_str(users).unwrap(), &config)
}

fn price(registry: &Registry, id: &str, on: &str) -> Option<Pricing> {
    registry.pricing(id, day(on))
}

#[test]
fn both_forms_become_prices_with_their_steps() {
    let registry = laid(&table(DEV).unwrap().to_toml(), "");
    let at = |id: &str, input| {
        let pricing = price(&registry, id, "2026-11-28")?;
        let price = pricing.at(input)?.price;
        Some((price.input, price.output, price.cached, price.cache_write))
    };
    for name in ["openai", "openai-responses"] {
        assert_eq!(
            at(&format!("{name}/flat"), 1),
            Some((1.5, 6.0, Some(0.15), None))
        );
    }
    assert_eq!(at("openai/old", 200_000), Some((2.0, 3.0, None, None)));
    assert_eq!(at("openai/old", 200_001), Some((4.0, 5.0, None, None)));
    assert_eq!(
        at("qwen/tiered", 256_000),
        Some((0.5, 3.0, None, Some(0.625)))
    );
    assert_eq!(at("qwen/tiered", 256_001), Some((2.0, 6.0, None, None)));
    for left_out in ["dear", "none", "gift", "all-x", "odd"] {
        assert_eq!(at(&format!("openai/{left_out}"), 1), None, "{left_out}");
    }
    let summary = table(DEV).unwrap().summary();
    for words in [
        "2026-11-28",
        "here (models.dev)",
        "openai 2",
        "qwen 1",
        "5 left out",
    ] {
        assert!(summary.contains(words), "{words}: {summary}");
    }

    let registry = laid(&table(LITE).unwrap().to_toml(), "");
    let at = |id: &str, input| Some(price(&registry, id, "2026-11-28")?.at(input)?.price);
    let flat = at("openai/flat", 1).unwrap();
    assert_eq!(
        (flat.input, flat.output, flat.cached),
        (0.1, 0.4, Some(0.025))
    );
    assert_eq!(at("gemini/long", 200_000).unwrap().input, 1.25);
    assert_eq!(at("gemini/long", 200_001).unwrap().output, 15.0);
    assert_eq!(at("qwen/steps", 32_000).unwrap().input, 1.0);
    assert_eq!(at("qwen/steps", 32_001).unwrap().input, 2.0);
    assert_eq!(at("openrouter/a/b", 1).unwrap().output, 2.0);
    assert_eq!(at("openai/embed", 1), None);
    let known = price(&registry, "openai/flat", "2026-11-28").unwrap();
    assert_eq!(known.origin().unwrap(), "as of 2026-11-28, here (litellm)");
    assert_eq!(registry.unlisted("openai/flat"), None, "a table knows it");
}

#[test]
fn the_file_lies_between_the_shipped_prices_and_the_users() {
    let file = |as_of: &str| {
        format!(
            "as_of = {as_of}\nsource = \"here\"\n[provider.gemini]\nprices = [\n\
             {{ model = \"gemini-4-argon\", input = 9, output = 90 }},\n{{ model = \"gemini-4-neon\", input = 9, output = 90 }},\n]\n"
        )
    };
    let input = |registry: &Registry, model: &str, on: &str| {
        let pricing = price(registry, &format!("gemini/{model}"), on).unwrap();
        (pricing.price.input, pricing.source.unwrap_or_default())
    };
    let registry = laid(&file("2026-11-28"), "");
    assert_eq!(
        input(&registry, "gemini-4-argon", "2026-11-28"),
        (9.0, "here".into())
    );
    // The table of a day knows nothing of the price that begins after it.
    assert_eq!(input(&registry, "gemini-4-argon", "2026-12-01").0, 4.0);
    assert_eq!(
        input(&registry, "gemini-3.5-flash-lite", "2026-11-28").0,
        0.3
    );
    let older = laid(&file("2026-01-01"), "");
    assert_eq!(
        input(&older, "gemini-4-neon", "2026-11-28").0,
        3.0,
        "known since later"
    );
    let users = "[[gemini.prices]]\nmodel = \"gemini-4-*\"\ninput = 1\noutput = 2\n";
    let registry = laid(&file("2026-11-28"), users);
    assert_eq!(
        input(&registry, "gemini-4-argon", "2026-11-28"),
        (1.0, String::new())
    );
}

#[test]
fn what_is_no_table_is_refused_in_words() {
    for (text, words) in [
        ("{\"a\": ", "not JSON"),
        ("[1]", "neither a table of models.dev"),
        ("{\"a\": {\"b\": 1}}", "nor one of litellm"),
        (
            r#"{"groq": {"models": {"m": {"cost": {"input": 1, "output": 1}}}}}"#,
            "no price",
        ),
        (r#"{"openai": {"models": 3}}"#, "no price"),
    ] {
        let error = table(text).unwrap_err();
        assert!(error.contains(words), "{text}: {error}");
    }
    let registry = laid(
        "as_of = 2026-11-28\nsource = \"x\"\n[provider.openai]\nprice = []\n",
        "",
    );
    let (name, why) = registry.broken().next().unwrap();
    let why = why.to_string();
    assert_eq!(name, FILE);
    for words in ["prices.toml: line 4", "`price`", "--update", "delete it"] {
        assert!(why.contains(words), "{words}: {why}");
    }
    assert!(price(&registry, "openai/gpt-6-luna", "2026-11-28").is_some());
}
