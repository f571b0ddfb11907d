//! Checks which providers are reachable and accept the key, by requesting a model list and nothing else.

use std::time::Duration;

use futures_util::future::join_all;

use super::api_keys::Environment;
use super::client::Client;
use super::error::Error;
use super::listing::KeyState;
use super::probe::list;
use super::registry::Registry;

/// How long a server on this machine may take, and one elsewhere.
const HERE: Duration = Duration::from_millis(800);
const ELSEWHERE: Duration = Duration::from_secs(10);

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
                (client_here, HERE)
            } else {
                (client_elsewhere, ELSEWHERE)
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
