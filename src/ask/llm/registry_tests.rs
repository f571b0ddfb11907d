//! Tests of the registry: ids, layers, model data, and the shipped prices with their sources.
#![allow(clippy::unwrap_used)]

use secrecy::ExposeSecret;

use super::*;
use crate::llm::{Dialect, Efforts, KeyCommand, KeyState, Temperature, Usage};

fn registry(user: &str) -> Result<Registry, RegistryError> {
    Registry::new(&toml::from_str(user).unwrap())
}

fn variables(list: &'static [(&str, &str)]) -> Environment {
    Environment::from_lookup(move |name| {
        let found = list.iter().find(|(known, _)| *known == name);
        found.map(|(_, value)| value.to_string())
    })
}

fn nothing() -> Environment {
    variables(&[])
}

#[test]
fn the_built_in_file_is_right() {
    let registry = registry("").unwrap();
    let keys = variables(&[("OPENAI_API_KEY", "k")]);
    let offers = registry.offers(&keys, "2026-11-20".parse().unwrap());
    let gpt = offers.iter().find(|o| o.id == "openai/gpt-4o").unwrap();
    assert_eq!(gpt.key, Some(("OPENAI_API_KEY".into(), true)));
    let warning = gpt.warning.as_deref().unwrap();
    assert!(warning.contains("2027-01-14"), "{warning}");
    let dialects: std::collections::BTreeSet<_> = registry
        .models(&keys, "2026-11-20".parse().unwrap())
        .into_iter()
        .map(|listed| listed.dialect)
        .collect();
    use Dialect::{Anthropic, Gemini, Ollama, OpenAiChat, OpenAiResponses};
    let shipped = [OpenAiChat, OpenAiResponses, Gemini, Anthropic, Ollama];
    assert_eq!(dialects, shipped.into(), "what built-in providers speak");
    for (name, provider) in &registry.providers {
        let endpoint = provider.endpoint(name, "m", &nothing()).unwrap();
        assert!(endpoint.request_url("m").is_ok(), "{name}");
    }
}

#[test]
fn ids_become_endpoints() {
    let registry = registry("[lab]\nbase_url = \"http://127.0.0.1:9\"\nkey_env = \"K\"").unwrap();
    let (endpoint, model) = registry.resolve("lab/a/b", &nothing()).unwrap();
    assert_eq!(
        (endpoint.base_url.as_str(), model.as_str()),
        ("http://127.0.0.1:9", "a/b")
    );
    let error = |id| registry.resolve(id, &nothing()).unwrap_err();
    assert!(matches!(error("gpt-4o"), RegistryError::NotAnId { .. }));
    assert!(matches!(error("x/y"), RegistryError::NoProvider { .. }));
    let words = error("opnai/gpt-4o").to_string();
    assert!(words.contains("did you mean `openai`?"), "{words}");
    let meant = registry.unlisted("openai/gtp-4o").unwrap();
    assert!(meant.contains("openai/gpt-4o"), "{meant}");
    assert_eq!(registry.unlisted("lab/anything"), None);
    let moved = variables(&[("OPENAI_BASE_URL", "http://b"), ("OPENAI_API_KEY", "key")]);
    let (endpoint, _) = registry.resolve("openai/a", &moved).unwrap();
    assert_eq!(endpoint.base_url, "http://b");
}

#[test]
fn the_key_is_looked_for_in_order() {
    let registry =
        registry("[lab]\nbase_url = \"http://h\"\nkey_command = [\"pass\", \"lab key\"]").unwrap();
    let both = variables(&[("GEMINI_API_KEY", "gem"), ("GOOGLE_API_KEY", "goo")]);
    let (endpoint, _) = registry.resolve("gemini/x", &both).unwrap();
    assert_eq!(endpoint.key.unwrap().expose_secret(), "goo");
    assert_eq!(endpoint.key_source.as_deref(), Some("GOOGLE_API_KEY"));
    let one = variables(&[("GEMINI_API_KEY", "gem"), ("GOOGLE_API_KEY", " ")]);
    let (endpoint, _) = registry.resolve("gemini/x", &one).unwrap();
    assert_eq!(endpoint.key.unwrap().expose_secret(), "gem");
    let (endpoint, _) = registry.resolve("gemini/x", &nothing()).unwrap();
    let missing = endpoint.missing_key.unwrap();
    assert!(
        missing.contains("set GOOGLE_API_KEY or GEMINI_API_KEY"),
        "{missing}"
    );
    let (endpoint, _) = registry.resolve("lab/x", &nothing()).unwrap();
    let words = vec!["pass".to_string(), "lab key".to_string()];
    assert_eq!(endpoint.key_command, Some(KeyCommand::Program(words)));
    let source = endpoint.key_source.unwrap();
    assert_eq!(source, "the command `pass`");
}

#[test]
fn what_is_known_of_a_model_reaches_its_endpoint() {
    let registry = registry(
        "[openai]\nmodels = [\"mine\", {name = \"gpt-5-mini\", quirks = {seed = false}}]\nquirks = {max_tokens = 77}",
    )
    .unwrap();
    let keys = variables(&[("OPENAI_API_KEY", "k"), ("OPENAI_ORG_ID", "org-1")]);
    let resolve = |model: &str| {
        registry
            .resolve(&format!("openai/{model}"), &keys)
            .unwrap()
            .0
    };
    let quirks = resolve("gpt-5-mini").quirks;
    assert_eq!(
        (quirks.temperature, quirks.seed),
        (Temperature::Fixed, false)
    );
    assert_eq!(
        (quirks.max_completion_tokens, quirks.max_tokens),
        (true, Some(77))
    );
    let quirks = resolve("gpt-4o").quirks;
    assert_eq!(
        (quirks.temperature, quirks.seed),
        (Temperature::Taken, true)
    );
    assert_eq!(quirks.efforts, Some(Efforts::Untaken));
    let header = ("OpenAI-Organization".to_string(), "org-1".to_string());
    assert_eq!(resolve("mine").headers, [header]);
    let offers = registry.offers(&keys, "2026-11-20".parse().unwrap());
    let offered: Vec<_> = offers
        .iter()
        .filter(|o| o.id.starts_with("openai/"))
        .collect();
    assert_eq!(offered.len(), 2, "the user's list is the list: {offered:?}");
}

#[test]
fn prices_are_the_users_until_one_is_known() {
    let registry = registry(
        "[[deepseek.prices]]\nmodel = \"deepseek-*\"\ninput = 0.5\noutput = 2\ncached = 0.05\nfrom = 2026-05-01\n",
    )
    .unwrap();
    let keys = variables(&[("DEEPSEEK_API_KEY", "k"), ("OPENAI_API_KEY", "k")]);
    let day = "2026-11-20".parse().unwrap();
    let prices = |id: &str| registry.resolve(id, &keys).unwrap().0.prices;
    let pricing = prices("deepseek/deepseek-flash")
        .pricing_for("deepseek-flash", day)
        .unwrap();
    assert_eq!(pricing.price.cached, Some(0.05));
    assert_eq!(pricing.peak.unwrap().factor, 2.0);
    assert_eq!(
        prices("openai/gpt-7").pricing_for("gpt-7", day),
        None,
        "unknown, not nothing"
    );
}

#[test]
fn the_end_of_a_model_is_told_in_time() {
    let registry = registry("").unwrap();
    let warning = |id: &str, day: &str| {
        let retirement = registry.retirement(id)?;
        retirement.warning(day.parse().unwrap())
    };
    let near = warning("openai/gpt-4o-mini", "2026-11-20").unwrap();
    assert!(
        near.contains("2027-01-14") && near.contains("55 days") && near.contains("gpt-6-luna"),
        "{near}"
    );
    assert_eq!(warning("openai/gpt-4o-mini", "2026-06-01"), None, "not yet");
    let past = warning("deepseek/deepseek-chat", "2026-11-20").unwrap();
    assert!(past.starts_with("shut down since 2026-07-24"), "{past}");
    let routed = warning("gemini/gemini-2.5-pro", "2026-12-24").unwrap();
    assert!(routed.contains("answered by gemini-3.8-flash"), "{routed}");
    let unsure = self::registry(
        "[lab]\nmodels = [{name = \"old\", routed = 2026-12-01, replacement = \"new\", unconfirmed = true}]",
    ).unwrap().retirement("lab/old").unwrap().warning("2026-12-24".parse().unwrap()).unwrap();
    assert!(unsure.ends_with("(unconfirmed)"), "{unsure}");
    assert!(
        warning("gemini/gemini-1.5-pro", "2026-11-20")
            .unwrap()
            .contains("gone")
    );
    assert_eq!(warning("openai/gpt-6-luna", "2026-11-20"), None);
}

#[test]
fn wrong_entries_are_named_with_their_key() {
    for (entry, key) in [
        ("[lab]\nurl = \"x\"", "url"),
        ("[lab]\nresponse_format = \"xml\"", "xml"),
        ("[lab]\ndialect = \"soap\"", "soap"),
        ("[lab]\nrequests_per_minute = 0", "requests_per_minute"),
        ("[lab]\nquirks = {seeds = true}", "seeds"),
        ("[lab]\nkey_command = 5", "key_command"),
        (
            "[lab]\nmodels = [{name = \"a\", shutdwn = 2026-01-01}]",
            "shutdwn",
        ),
        (
            "[lab]\nmodels = [{name = \"a\", shutdown = \"soon\"}]",
            "soon",
        ),
        (
            "[[lab.prices]]\nmodel = \"a\"\ninput = -1\noutput = 1",
            "-1",
        ),
        ("[[lab.prices]]\nmodel = \"a\"\ninput = 1", "output"),
        (
            "[lab]\npeak = {factor = 2.0, hours = [\"9 to 12\"], utc_offset = 8}",
            "9 to 12",
        ),
    ] {
        let error = registry(entry).unwrap_err().to_string();
        assert!(
            error.contains("[provider.lab]") && error.contains(key),
            "{entry}: {error}"
        );
        assert!(!error.contains('\n'), "{error}");
    }
}

#[test]
fn ollama_is_found_however_its_variable_is_written() {
    for (written, url) in [
        ("0.0.0.0", "http://127.0.0.1:11434/api/chat"),
        ("127.0.0.1:9", "http://127.0.0.1:9/api/chat"),
        ("[::1]", "http://[::1]:11434/api/chat"),
        ("http://box", "http://box/api/chat"),
        ("http://box?token=a/b", "http://box/api/chat?token=a/b"),
        ("https://ollama.com/", "https://ollama.com/api/chat"),
    ] {
        let endpoint = Endpoint {
            dialect: Dialect::Ollama,
            ..Endpoint::new("ollama", Dialect::Ollama.protocol().base_url(written))
        };
        assert_eq!(
            endpoint.request_url("m").unwrap().as_str(),
            url,
            "{written}"
        );
    }
}

#[test]
fn keys_go_unencrypted_only_where_that_is_allowed() {
    let own = registry(
        "[lab]\nbase_url = \"http://h\"\nallow_http = true\n[other]\nbase_url = \"http://h\"",
    )
    .unwrap();
    let allowed = |id: &str| own.resolve(id, &nothing()).unwrap().0.allow_http;
    assert!(allowed("lab/x") && !allowed("other/x") && !allowed("openai/x"));
    let wrong = registry("[lab]\nallow_http = \"yes\"").unwrap_err();
    assert!(wrong.to_string().contains("allow_http"), "{wrong}");
}

#[test]
fn known_models_are_listed_once() {
    let registry = registry("").unwrap();
    let listed = registry.models(&nothing(), "2026-11-20".parse().unwrap());
    let ids: Vec<&str> = listed.iter().map(|l| l.id.as_str()).collect();
    let once: std::collections::BTreeSet<&str> = ids.iter().copied().collect();
    assert_eq!(once.len(), ids.len(), "{ids:?}");
    // An entry that only says how a model is asked does not offer it.
    for quiet in ["anthropic/claude-fable-5", "openai/gpt-6-astra"] {
        assert!(!ids.contains(&quiet), "{quiet}");
    }
    for provider in ["xai", "mistral", "qwen", "openrouter"] {
        assert!(ids.iter().any(|id| id.starts_with(provider)), "{provider}");
    }
}

#[test]
fn tools_go_to_responses_where_chat_refuses_them_unless_the_user_states_the_dialect() {
    let tools = |user: &str, model: &str| {
        let (endpoint, _) = registry(user).unwrap().resolve(model, &nothing()).unwrap();
        endpoint.quirks.tools_dialect
    };
    for (model, dialect) in [
        ("openai/gpt-6.2-sol", Some(Dialect::OpenAiResponses)),
        ("openai/gpt-6-luna", Some(Dialect::OpenAiResponses)),
        ("openai/gpt-5.4", Some(Dialect::OpenAiResponses)),
        ("openai/gpt-5", None),
        ("openai/gpt-4o", None),
        ("openrouter/openai/gpt-6-luna", None),
    ] {
        assert_eq!(tools("", model), dialect, "{model}");
    }
    let user = "[openai]\ndialect = \"openai_chat\"";
    assert_eq!(tools(user, "openai/gpt-6-luna"), None);
}

#[test]
fn a_limit_that_does_not_count_reasoning_bounds_no_budget() {
    let registry = registry("").unwrap();
    let (endpoint, model) = registry.resolve("qwen/qwen3.8-max", &nothing()).unwrap();
    let bound = |effort| {
        let parameters = crate::llm::Parameters {
            max_tokens: Some(100),
            effort,
            ..Default::default()
        };
        endpoint.worst_case(&model, &parameters)
    };
    let why = bound(None).unwrap_err().to_string();
    assert!(why.contains("effort off"), "{why}");
    assert!(bound(Some(crate::llm::Effort::Off)).is_ok());
}

#[test]
fn whether_a_key_is_there_is_told() {
    let registry = registry("[lab]\nbase_url = \"http://h\"\nkey_command = \"pass lab\"").unwrap();
    let listed = registry.models(
        &variables(&[("OPENAI_API_KEY", "k")]),
        "2026-11-20".parse().unwrap(),
    );
    let key = |provider: &str| {
        let id = format!("{provider}/");
        let found = listed.iter().find(|l| l.id.starts_with(&id));
        found.unwrap().key.clone()
    };
    assert_eq!(key("openai"), KeyState::Present("OPENAI_API_KEY".into()));
    assert_eq!(
        key("anthropic"),
        KeyState::Missing("ANTHROPIC_API_KEY".into())
    );
    assert_eq!(key("ollama"), KeyState::NotNeeded);
    assert_eq!(key("lab"), KeyState::Command("`pass`".into()));
}

#[test]
fn a_key_that_the_user_names_is_missed_on_this_machine_too() {
    let own = registry(
        "[lab]\nbase_url = \"http://127.0.0.1:9\"\nkey_env = \"LAB_KEY\"\n[plain]\nbase_url = \"http://127.0.0.1:9\"\n\
         [local]\nkey_env = [\"MINE\", \"OURS\"]\n[ollama]\nkey_env = []",
    )
    .unwrap();
    let missing = |registry: &Registry, name: &str, environment: &Environment| {
        let id = format!("{name}/x");
        let (endpoint, _) = registry.resolve(&id, environment).unwrap();
        let listed = registry.models(environment, "2026-11-20".parse().unwrap());
        let beginning = format!("{name}/");
        let listed = listed.into_iter().find(|l| l.id.starts_with(&beginning));
        (endpoint.missing_key, listed.unwrap().key)
    };
    let (words, state) = missing(&own, "lab", &nothing());
    assert!(words.unwrap().contains("set LAB_KEY"));
    assert_eq!(state, KeyState::Missing("LAB_KEY".into()));
    let (words, state) = missing(&own, "local", &nothing());
    assert!(words.unwrap().contains("set MINE or OURS"));
    assert_eq!(state, KeyState::Missing("MINE or OURS".into()));
    for name in ["plain", "ollama", "vllm"] {
        assert_eq!(
            missing(&own, name, &nothing()),
            (None, KeyState::NotNeeded),
            "{name}"
        );
    }
    let (words, state) = missing(&own, "lab", &variables(&[("LAB_KEY", "k")]));
    assert_eq!((words, state), (None, KeyState::Present("LAB_KEY".into())));
    let shipped = registry("").unwrap();
    assert_eq!(missing(&shipped, "local", &nothing()).0, None);
    let (words, _) = missing(&shipped, "openai", &nothing());
    assert!(words.unwrap().contains("set OPENAI_API_KEY"));
}

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
    let words = pricing.bound_note().unwrap();
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
        let checked = crate::llm::quirks::check(&endpoint, &request);
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
