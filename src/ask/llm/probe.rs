//! Detects model servers on this machine, and checks which providers are reachable and accept the key.

use std::time::Duration;

use futures_util::future::join_all;
use serde_json::Value;

use super::api_keys::Environment;
use super::body_text::{Deadlines, read_to_end};
use super::client::Client;
use super::dialect::Dialect;
use super::endpoint::{Endpoint, Timeouts};
use super::error::Error;
use super::registry::{KeyState, Registry};

/// How long a server on this machine may take to say what it serves.
const LOCAL_TIMEOUT: Duration = Duration::from_millis(800);

/// More than any list of models is long, in bytes.
const MAX_LIST_BYTES: usize = 4 << 20;

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
            let served = list(&client, &endpoint, LOCAL_TIMEOUT)
                .await
                .unwrap_or_default();
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
        Ok(Err(error)) => return Err(Error::unanswered(&error, endpoint).redacted(&secrets)),
        Err(elapsed) => return Err(Error::silence(elapsed, endpoint)),
    };
    let body = read_to_end(response, timeouts, MAX_LIST_BYTES).await;
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

/// How long a server elsewhere may take to say what it serves.
const REMOTE_TIMEOUT: Duration = Duration::from_secs(10);

/// Outcome of trying to reach a provider.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Reachability {
    /// It serves this many models.
    Serves(usize),
    /// It refused the key, with this status.
    Refused(u16),
    /// It answered with another status, or not with a list.
    Answers(Option<u16>),
    /// No answer, and why.
    Silent(String),
    /// It cannot be asked, and why.
    Wrong(String),
    /// Not asked: it is remote, and remote checks were not requested or there is no key.
    NotAsked,
}

/// A provider and what came of trying to reach it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProviderStatus {
    /// Its name.
    pub provider: String,
    /// Name and address, without secrets.
    pub place: String,
    /// Whether it is on this machine.
    pub here: bool,
    /// Whether its key is there.
    pub key: KeyState,
    /// Whether the user's configuration wants the key sent.
    pub key_wanted: bool,
    /// The outcome.
    pub reach: Reachability,
}

/// Tries every provider on this machine, all at once, and the others only where `online` and their key is there without
/// a command. What is sent is a request for the list of models, which costs nothing. In the order of the names.
pub async fn reach(
    registry: &Registry,
    environment: &Environment,
    online: bool,
) -> Vec<ProviderStatus> {
    let (here, elsewhere) = (Client::direct(), Client::new());
    let all = registry.providers.iter().map(|(name, provider)| {
        let key = provider.key_state(name, environment);
        let found = provider.endpoint(name, "", environment);
        let (client_here, client_elsewhere) = (here.clone(), elsewhere.clone());
        async move {
            let key_wanted = provider.key_wanted;
            let reached = |place: String, here: bool, reach: Reachability| ProviderStatus {
                provider: name.clone(),
                place,
                here,
                key: key.clone(),
                key_wanted,
                reach,
            };
            let mut endpoint = match found {
                Ok(endpoint) => endpoint,
                Err(error) => {
                    return reached(name.clone(), false, Reachability::Wrong(error.to_string()));
                }
            };
            let (place, is_here) = (endpoint.place().to_string(), endpoint.is_here());
            let has_key = matches!(key, KeyState::Present(_));
            if let Some(found) = provider.key(environment) {
                endpoint.key = Some(found.key);
                endpoint.key_source = Some(found.source);
            }
            if let Err(error) = endpoint.keeps_secrets() {
                return reached(place, is_here, Reachability::Wrong(error.to_string()));
            }
            if !(is_here || online && has_key) {
                return reached(place, is_here, Reachability::NotAsked);
            }
            // A proxy has no business with this machine.
            let (client, patience) = if is_here {
                (client_here, LOCAL_TIMEOUT)
            } else {
                (client_elsewhere, REMOTE_TIMEOUT)
            };
            let reach = match list(&client, &endpoint, patience).await {
                Ok(served) => Reachability::Serves(served.names.len()),
                Err(error) => unlisted(&error),
            };
            reached(place, is_here, reach)
        }
    });
    join_all(all).await
}

/// Interprets a provider's refusal to list its models.
fn unlisted(error: &Error) -> Reachability {
    match (error, error.status()) {
        (_, Some(status @ (401 | 403))) => Reachability::Refused(status),
        (_, Some(status)) => Reachability::Answers(Some(status)),
        (Error::Malformed { .. }, None) => Reachability::Answers(None),
        (Error::Setup { .. }, None) => Reachability::Wrong(error.to_string()),
        (_, None) => Reachability::Silent(error.cause().into_owned()),
    }
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
