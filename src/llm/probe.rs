//! Which model servers run on this machine, and what they serve.

use std::time::Duration;

use futures_util::future::join_all;
use serde_json::Value;

use super::client::{Client, deepest};
use super::deadlines::Deadlines;
use super::dialect::Dialect;
use super::endpoint::{Endpoint, Timeouts};
use super::environment::Environment;
use super::registry::Registry;
use super::text::whole;

/// How long a server on this machine may take to say what it serves.
const PATIENCE: Duration = Duration::from_millis(800);

/// More than any list of models is long, in bytes.
const LONGEST: usize = 4 << 20;

/// A model that a server on this machine serves.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Discovered {
    /// `provider/model`.
    pub id: String,
    /// The protocol it is asked in.
    pub dialect: Dialect,
}

impl Discovered {
    /// Whether the model's name says that it answers no questions: it embeds, ranks, hears, speaks, draws or moderates.
    #[must_use]
    pub fn is_no_chat(&self) -> bool {
        let name = self.id.split_once('/').map_or("", |(_, name)| name);
        let name = name.to_ascii_lowercase();
        let mut words = name.split(|c: char| !c.is_alphanumeric());
        let kinds = ["embed", "rerank", "whisper", "moderation"];
        name.contains("dall-e")
            || words.any(|word| word == "tts" || kinds.iter().any(|kind| word.starts_with(kind)))
    }
}

/// Asks the providers whose address is on this machine what they serve, all at once and without waiting long; what does not
/// answer serves nothing. The result is in the order of the providers' names, without doubles.
pub async fn probe(registry: &Registry, environment: &Environment) -> Vec<Discovered> {
    // A proxy has no business with this machine.
    let client = Client::direct();
    let asked = registry.providers.iter().filter_map(|(name, provider)| {
        let mut endpoint = provider.endpoint(name, "", environment).ok()?;
        // Without a base URL that can be read there is nobody to ask; `resolve` says what is wrong with it.
        endpoint.is_here().then_some(())?;
        endpoint.key = provider.key(environment).map(|found| found.key);
        let client = client.clone();
        Some(async move {
            let models = served(&client, &endpoint).await.unwrap_or_default();
            let dialect = endpoint.dialect;
            let of = move |model| Discovered {
                id: format!("{name}/{model}"),
                dialect,
            };
            models.into_iter().map(of).collect::<Vec<_>>()
        })
    });
    join_all(asked).await.into_iter().flatten().collect()
}

/// The names of the models at an endpoint; nothing if it does not say.
async fn served(client: &Client, endpoint: &Endpoint) -> Option<Vec<String>> {
    list(client, endpoint, PATIENCE).await.ok()
}

/// Why a server did not say what it serves.
pub(super) enum Unlisted {
    /// Its address or key cannot be used.
    Setup(String),
    /// It answered with this status.
    Status(u16),
    /// Nothing answered, in words; or not in time.
    Silent(String),
    /// It answered with something else than a list.
    NoList,
}

/// Asks for the names of the models at an endpoint, which costs nothing; waits no longer than `patience` for each step.
pub(super) async fn list(
    client: &Client,
    endpoint: &Endpoint,
    patience: Duration,
) -> Result<Vec<String>, Unlisted> {
    let setup = |error: super::Error| Unlisted::Setup(error.to_string());
    let mut url = endpoint.request_url("m").map_err(setup)?;
    let (ending, listing) = match endpoint.dialect {
        Dialect::OpenAiChat => ("/chat/completions", "/models"),
        Dialect::OpenAiResponses => ("/responses", "/models"),
        Dialect::Anthropic => ("/messages", "/models"),
        Dialect::Ollama => ("/api/chat", "/api/tags"),
        Dialect::Gemini => ("/models/m:streamGenerateContent", "/models"),
    };
    let path = url.path().strip_suffix(ending).ok_or(Unlisted::NoList)?;
    let path = format!("{path}{listing}");
    url.set_path(&path);
    if endpoint.dialect == Dialect::Gemini {
        // It belongs to the streamed answer.
        url.set_query(None);
    }
    let timeouts = Deadlines::starting_now(Timeouts {
        connect: patience,
        idle: patience,
        total: patience,
    });
    endpoint.keeps_secrets().map_err(setup)?;
    let mut request = client
        .http(endpoint, patience)
        .map_err(Unlisted::Setup)?
        .get(url);
    if let Some((name, value)) = endpoint.key_header().map_err(setup)? {
        request = request.header(name, value);
    }
    if endpoint.dialect == Dialect::Anthropic {
        request = request.header("anthropic-version", "2023-06-01");
    }
    let late = || Unlisted::Silent(format!("no answer in {} s", patience.as_secs_f64()));
    let secrets = endpoint.secrets();
    let sent = timeouts.wait(request.send()).await.map_err(|_| late())?;
    let response = sent.map_err(|error| Unlisted::Silent(secrets.redact(&deepest(&error))))?;
    let status = response.status();
    if !status.is_success() {
        return Err(Unlisted::Status(status.as_u16()));
    }
    let body = whole(response, timeouts, LONGEST).await;
    let body = body.map_err(|_| Unlisted::NoList)?;
    let mut names = names(endpoint.dialect, &body).ok_or(Unlisted::NoList)?;
    // Some servers quote the key even here; that is no model.
    names.retain(|name| !secrets.are_in(name));
    Ok(names)
}

/// The names in a list of models, in order.
fn names(dialect: Dialect, body: &str) -> Option<Vec<String>> {
    let value: Value = serde_json::from_str(body).ok()?;
    let name = |entry: &Value, key: &str| entry.get(key).and_then(Value::as_str).map(str::to_owned);
    let (list, key) = match dialect {
        Dialect::Ollama | Dialect::Gemini => (value.get("models")?.as_array()?, "name"),
        _ => (value.get("data")?.as_array()?, "id"),
    };
    // Several protocols list their models at the same path, each in its own form.
    let theirs = |entry: &&Value| {
        let anthropic = entry.get("type").and_then(Value::as_str) == Some("model");
        match dialect {
            Dialect::Anthropic => anthropic,
            Dialect::OpenAiChat | Dialect::OpenAiResponses => {
                !anthropic || entry.get("object").is_some()
            }
            _ => true,
        }
    };
    let list = list.iter().filter(theirs);
    let mut names: Vec<String> = list.filter_map(|entry| name(entry, key)).collect();
    // Names with control characters are no names, and would reach terminals.
    names.retain(|name| !name.trim().is_empty() && !name.chars().any(char::is_control));
    names.sort();
    names.dedup();
    Some(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_what_answers_no_questions() {
        let is = |id: &str| {
            let discovered = Discovered {
                id: format!("lab/{id}"),
                dialect: Dialect::default(),
            };
            discovered.is_no_chat()
        };
        for id in [
            "nomic-embed-text:latest",
            "text-embedding-3-small",
            "embeddinggemma",
            "bge-reranker-v2",
            "whisper-large",
            "gpt-4o-mini-tts",
            "dall-e-3",
            "omni-moderation-latest",
        ] {
            assert!(is(id), "{id}");
        }
        for id in ["gpt-4o", "qwen3:8b", "watts-7b", "org/llama-3", "…"] {
            assert!(!is(id), "{id}");
        }
    }
}
