//! The HTTP client shared by all requests, and the meaning of its errors.

use std::collections::{BTreeMap, BTreeSet};
use std::error::Error as StdError;
use std::fmt;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use secrecy::SecretString;

use super::api_keys::KeyCommand;
use super::endpoint::Endpoint;
use super::limits::{Gate, Limits};
use nearmiss_base::system;

/// A pool of connections; build one and clone it, clones share the pool and the limits of providers.
///
/// Proxies are taken from the environment (`HTTPS_PROXY`, `HTTP_PROXY`, `NO_PROXY`) except for servers on this machine,
/// certificates from the system.
#[derive(Clone, Default)]
pub struct Client {
    // reqwest fixes the connect timeout when a client is built, while ours belongs to the endpoint: one client for each
    // timeout in use, which in practice is one, with proxies and without.
    built: Arc<Mutex<BTreeMap<(Duration, bool), reqwest::Client>>>,
    gates: Arc<Mutex<Gates>>,
    keys: Arc<Mutex<BTreeMap<KeyCommand, SecretString>>>,
    /// What models of providers refused.
    refused: Arc<Mutex<BTreeSet<(String, String, Dispensable)>>>,
    direct: bool,
}

/// A part of requests that they can do without.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Dispensable {
    /// Bounds in the form of the answer.
    Bounds,
    /// The form of the answer.
    Form,
    /// That the usage is told at the end of the stream.
    StreamOptions,
}

type Gates = BTreeMap<(String, Limits), Arc<Gate>>;

impl Client {
    /// A client; connections are made on first use.
    pub fn new() -> Self {
        Self::default()
    }

    /// A client that ignores the proxies of the environment.
    pub fn direct() -> Self {
        Self {
            direct: true,
            ..Self::default()
        }
    }

    /// The HTTP client for an endpoint, with this connect timeout; an error says why none can be built.
    pub(super) fn http(
        &self,
        endpoint: &Endpoint,
        connect: Duration,
    ) -> Result<reqwest::Client, String> {
        // Requests to this machine are unencrypted, and a proxy would carry them elsewhere with their key.
        let direct = self.direct || endpoint.is_here();
        let mut built = self.built.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(client) = built.get(&(connect, direct)) {
            return Ok(client.clone());
        }
        // Fails if the program has installed one already, which serves as well.
        let _ = rustls::crypto::ring::default_provider().install_default();
        // Without system certificates reqwest builds no client at all, not even for a local server without encryption;
        // with an explicit empty list only https fails, with a clear error.
        let client = builder(connect, direct)
            .build()
            .or_else(|_| {
                builder(connect, direct)
                    .tls_certs_only(std::iter::empty())
                    .build()
            })
            .map_err(|e| deepest(&e))?;
        built.insert((connect, direct), client.clone());
        Ok(client)
    }

    /// The one gate of a provider with these limits.
    pub(super) fn gate(&self, provider: &str, limits: Limits) -> Arc<Gate> {
        let mut gates = self.gates.lock().unwrap_or_else(PoisonError::into_inner);
        let gate = gates
            .entry((provider.to_owned(), limits))
            .or_insert_with(|| Arc::new(Gate::new(limits)));
        Arc::clone(gate)
    }

    /// Whether this model of the provider has refused a part of requests.
    pub(super) fn has_refused(&self, provider: &str, model: &str, part: Dispensable) -> bool {
        let refused = self.refused.lock().unwrap_or_else(PoisonError::into_inner);
        refused.contains(&(provider.to_owned(), model.to_owned(), part))
    }

    /// It has refused it, and is asked without it from now on.
    pub(super) fn refuses(&self, provider: &str, model: &str, part: Dispensable) {
        let mut refused = self.refused.lock().unwrap_or_else(PoisonError::into_inner);
        refused.insert((provider.to_owned(), model.to_owned(), part));
    }

    /// The key that a command prints; it is run once.
    pub(super) async fn key(&self, command: &KeyCommand) -> Result<SecretString, String> {
        if let Some(key) = self.kept_key(command) {
            return Ok(key);
        }
        let key = command.run().await?;
        let mut keys = self.keys.lock().unwrap_or_else(PoisonError::into_inner);
        keys.insert(command.clone(), key.clone());
        Ok(key)
    }

    /// The key that a command has printed.
    pub(super) fn kept_key(&self, command: &KeyCommand) -> Option<SecretString> {
        let keys = self.keys.lock().unwrap_or_else(PoisonError::into_inner);
        keys.get(command).cloned()
    }

    /// A key was refused, so the command is run again next time.
    pub(super) fn forget_key(&self, command: &KeyCommand) {
        let mut keys = self.keys.lock().unwrap_or_else(PoisonError::into_inner);
        keys.remove(command);
    }
}

fn builder(connect: Duration, direct: bool) -> reqwest::ClientBuilder {
    let builder = reqwest::Client::builder()
        .user_agent(concat!("nearmiss/", env!("CARGO_PKG_VERSION")))
        .connect_timeout(connect)
        .redirect(reqwest::redirect::Policy::none());
    if direct { builder.no_proxy() } else { builder }
}

// Written by hand because reqwest's own would print proxies, which may hold passwords.
impl fmt::Debug for Client {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Client")
            .field("direct", &self.direct)
            .finish_non_exhaustive()
    }
}

/// The innermost cause: the outer ones repeat the URL, or say only that a request failed.
pub(super) fn deepest(error: &(dyn StdError + 'static)) -> String {
    let last = chain(error).last();
    last.map_or_else(String::new, |e| match e.downcast_ref() {
        Some(error) => system::error_text(error),
        None => e.to_string(),
    })
}

fn chain<'a>(
    error: &'a (dyn StdError + 'static),
) -> impl Iterator<Item = &'a (dyn StdError + 'static)> {
    std::iter::successors(Some(error), |&error| {
        // An I/O error reports the source of the error it wraps, which hides the wrapped error itself.
        match error
            .downcast_ref::<io::Error>()
            .and_then(io::Error::get_ref)
        {
            Some(wrapped) => Some(wrapped as &(dyn StdError + 'static)),
            None => error.source(),
        }
    })
}

/// Whether an I/O error of this kind is among the causes.
pub(super) fn has_io_kind(error: &(dyn StdError + 'static), kind: io::ErrorKind) -> bool {
    chain(error).any(|e| {
        e.downcast_ref::<io::Error>()
            .is_some_and(|io| io.kind() == kind)
    })
}

/// Whether encryption is among the causes.
pub(super) fn is_tls(error: &(dyn StdError + 'static)) -> bool {
    chain(error).any(|e| e.is::<rustls::Error>())
}
