//! Detects model servers on this machine and the models they serve.

use std::time::Duration;

use futures_util::future::join_all;
use serde_json::Value;

use super::api_keys::Environment;
use super::body_text::whole;
use super::client::Client;
use super::deadlines::Deadlines;
use super::dialect::Dialect;
use super::endpoint::{Endpoint, Timeouts};
use super::error::Error;
use super::registry::Registry;

/// How long a server on this machine may take to say what it serves.
const PATIENCE: Duration = Duration::from_millis(800);

/// More than any list of models is long, in bytes.
const LONGEST: usize = 4 << 20;

/// More than any name of a model is long, in characters.
const LONGEST_NAME: usize = 256;

/// What the servers on this machine serve.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Probed {
    /// In the order of the providers' names, without doubles.
    pub models: Vec<Discovered>,
    /// What of their lists was left out, and why, a line each.
    pub notes: Vec<String>,
}

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
        let name = self
            .id
            .split_once('/')
            .map_or("", |(_, name)| name)
            .to_ascii_lowercase();
        let mut words = name.split(|c: char| !c.is_alphanumeric());
        let kinds = ["embed", "rerank", "whisper", "moderation"];
        name.contains("dall-e")
            || words.any(|word| word == "tts" || kinds.iter().any(|kind| word.starts_with(kind)))
    }
}

/// Asks the providers whose address is on this machine what they serve, all at once and without waiting long; what
/// does not answer serves nothing.
pub async fn probe(registry: &Registry, environment: &Environment) -> Probed {
    // A proxy has no business with this machine.
    let client = Client::direct();
    let asked = registry.providers.iter().filter_map(|(name, provider)| {
        let mut endpoint = provider.endpoint(name, "", environment).ok()?;
        // Without a valid base URL no server can be asked; `resolve` reports the mistake.
        endpoint.is_here().then_some(())?;
        endpoint.key = provider.key(environment).map(|found| found.key);
        let client = client.clone();
        Some(async move {
            let served = list(&client, &endpoint, PATIENCE).await.unwrap_or_default();
            (name, endpoint.dialect, served)
        })
    });
    let mut probed = Probed::default();
    for (name, dialect, served) in join_all(asked).await {
        let of = |model| Discovered {
            id: format!("{name}/{model}"),
            dialect,
        };
        probed.models.extend(served.names.into_iter().map(of));
        if served.left_out > 0 {
            let names = match served.left_out {
                1 => "1 name of its list is".into(),
                count => format!("{count} names of its list are"),
            };
            probed.notes.push(format!(
                "{name}: {names} left out: empty, longer than {LONGEST_NAME} characters, or with control characters"
            ));
        }
    }
    probed
}

/// The names of the models at an endpoint, in order.
#[derive(Debug, Default)]
pub(super) struct Served {
    pub names: Vec<String>,
    /// How many more are no names.
    pub left_out: usize,
}

/// Asks for the names of the models at an endpoint, in order, which costs nothing; waits no longer than `patience`
/// for each step.
///
/// # Errors
/// [`Error::Malformed`] if something else than a list came; else why there was no answer.
pub(super) async fn list(
    client: &Client,
    endpoint: &Endpoint,
    patience: Duration,
) -> Result<Served, Error> {
    let protocol = endpoint.dialect.protocol();
    let endpoint = &Endpoint {
        timeouts: Timeouts {
            connect: patience,
            idle: patience,
            total: patience,
        },
        ..endpoint.clone()
    };
    let no_list = || Error::Malformed {
        place: endpoint.place(),
        what: "no list of models".into(),
    };
    let mut url = endpoint.url()?;
    let root = url.path().strip_suffix(protocol.method());
    let path = format!("{}{}", root.ok_or_else(no_list)?, protocol.models_path());
    url.set_path(&path);
    endpoint.keeps_secrets()?;
    let timeouts = Deadlines::starting_now(endpoint.timeouts);
    let http = client
        .http(endpoint, patience)
        .map_err(|why| Error::Setup {
            place: endpoint.place(),
            why,
        })?;
    let mut request = http.get(url);
    for (name, value) in protocol.headers() {
        request = request.header(*name, *value);
    }
    if let Some((name, value)) = endpoint.key_header()? {
        request = request.header(name, value);
    }
    let secrets = endpoint.secrets();
    let response = match timeouts.wait(request.send()).await {
        Ok(Ok(response)) if response.status().is_success() => response,
        Ok(Ok(response)) => return Err(Error::answered(response, endpoint, "", timeouts).await),
        Ok(Err(error)) => return Err(Error::unanswered(&error, endpoint).cleared_of(&secrets)),
        Err(elapsed) => return Err(Error::silence(elapsed, endpoint)),
    };
    let body = whole(response, timeouts, LONGEST).await;
    let body: Option<Value> = body.ok().and_then(|body| serde_json::from_str(&body).ok());
    let names = body.as_ref().and_then(|body| protocol.models(body));
    let (names, left_out): (Vec<&str>, Vec<&str>) =
        names.ok_or_else(no_list)?.into_iter().partition(is_name);
    // Some servers quote the key even here.
    let names = names.into_iter().filter(|name| !secrets.are_in(name));
    let mut names: Vec<String> = names.map(str::to_owned).collect();
    names.sort();
    names.dedup();
    let left_out = left_out.len();
    Ok(Served { names, left_out })
}

/// Whether this can be the name of a model: one with control characters would reach terminals.
fn is_name(name: &&str) -> bool {
    !name.trim().is_empty()
        && name.chars().nth(LONGEST_NAME).is_none()
        && !name.chars().any(char::is_control)
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
