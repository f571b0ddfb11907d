//! Sources of secrets, what counts as one, and where it may be sent.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use reqwest::Url;

use super::super::client::Client;
use super::super::endpoint::Endpoint;
use super::super::error::Error;
use super::Secrets;
use super::escapes::taken_back;

/// Shortest value, in characters, from a secret source that counts as a secret.
const LONG: usize = 8;

/// Parameters of addresses that are no secrets.
const HARMLESS: [&str; 4] = ["api-version", "api_version", "version", "alt"];

impl Endpoint {
    /// Every secret that is sent to this endpoint: the key, values of headers, and what its address holds.
    #[must_use]
    pub fn secrets(&self) -> Secrets {
        let mut found = Vec::new();
        if let Some(key) = self.usable_key() {
            add(&mut found, key, is_key(key));
        }
        for (_, value) in &self.headers {
            add(&mut found, value.trim(), is_secret(value.trim()));
        }
        found.extend(self.url().ok().into_iter().flat_map(|url| in_address(&url)));
        found.sort();
        found.dedup();
        Secrets::of(&found)
    }

    /// Whether the address holds a password or anything else that is to be kept secret.
    #[must_use]
    pub fn has_secret_address(&self) -> bool {
        let secret = |url: Url| has_user(&url) || !in_address(&url).is_empty();
        self.url().is_ok_and(secret)
    }

    /// Fails where a secret would be sent unencrypted to another machine.
    ///
    /// # Errors
    /// [`Error::Setup`] with what would be sent, and what to do; or the address is none.
    pub(in crate::llm) fn keeps_secrets(&self) -> Result<(), Error> {
        let url = self.url()?;
        if url.scheme() != "http" || self.allow_http || is_loopback(&url) {
            return Ok(());
        }
        let source = self.key_source.as_deref();
        let what = if self.usable_key().is_some() || self.key_command.is_some() {
            format!("the key from {}", source.unwrap_or("the configuration"))
        } else if let Some((name, _)) = self.headers.iter().find(|(_, v)| !v.trim().is_empty()) {
            format!("the value of the header `{name}`")
        } else if self.has_secret_address() {
            "the password or key in the address".to_owned()
        } else {
            return Ok(());
        };
        let name = &self.name;
        Err(Error::Setup {
            place: self.place(),
            why: format!(
                "{what} would be sent unencrypted over http://, where others can read it; use https://, or set allow_http = true for [provider.{name}] in config.toml if the network is closed"
            ),
        })
    }
}

impl Secrets {
    /// The secrets of an endpoint, with the key that a command has printed for this client.
    #[must_use]
    pub fn sent(client: &Client, endpoint: &Endpoint) -> Self {
        let kept = endpoint.key_command.as_ref();
        match kept.and_then(|command| client.kept_key(command)) {
            Some(key) if endpoint.usable_key().is_none() => {
                let key = Some(key);
                let endpoint = endpoint.clone();
                Endpoint { key, ..endpoint }.secrets()
            }
            _ => endpoint.secrets(),
        }
    }
}

/// Whether an address leads to this machine.
pub(in crate::llm) fn is_loopback(url: &Url) -> bool {
    let host = url.host_str().unwrap_or_default();
    let bare = host.trim_matches(['[', ']']);
    let address = bare.parse::<std::net::IpAddr>();
    bare == "localhost" || address.is_ok_and(|address| address.to_canonical().is_loopback())
}

/// A secret, and the parts of it that are: `Bearer KEY`, `Basic …`, `session=KEY`.
fn add(found: &mut Vec<String>, value: &str, whole: bool) {
    if whole {
        found.push(value.to_owned());
    }
    if let Some(password) = basic_password(value) {
        found.extend(Some(password).filter(|p| is_key(p)));
    }
    let words = value.split([' ', '\t', ';', ',']);
    let parts = words.flat_map(|word| [Some(word), word.split_once('=').map(|(_, value)| value)]);
    for part in parts.flatten().filter(|part| *part != value) {
        if is_secret(part) && (is_mixed(part) || part.len() >= 2 * LONG) {
            found.push(part.to_owned());
        }
    }
}

/// The password of a value for basic authentication.
fn basic_password(value: &str) -> Option<String> {
    let (scheme, coded) = value.split_once(' ')?;
    let basic = scheme.eq_ignore_ascii_case("basic");
    let bytes = STANDARD.decode(coded.trim()).ok().filter(|_| basic)?;
    let text = String::from_utf8(bytes).ok()?;
    text.split_once(':')
        .map(|(_, password)| password.to_owned())
}

/// The secrets in an address: password, user, and values of its query.
fn in_address(url: &Url) -> Vec<String> {
    // As it is written, and as it is sent.
    let both = |written: &str| {
        let meant = taken_back(written.as_bytes(), b"%");
        let meant = String::from_utf8_lossy(&meant).into_owned();
        [written.to_owned(), meant]
    };
    let password = url.password().into_iter().flat_map(both);
    // A user is often a token, with an empty password or none.
    let user = both(url.username()).into_iter();
    let mut found: Vec<String> = password.filter(|p| is_key(p)).collect();
    found.extend(user.filter(|user| is_secret(user)));
    for (name, value) in url.query_pairs() {
        if is_secret(&value) && !HARMLESS.contains(&name.to_ascii_lowercase().as_str()) {
            found.push(value.into_owned());
        }
    }
    found
}

fn has_user(url: &Url) -> bool {
    !url.username().is_empty() || url.password().is_some()
}

/// Whether a key is more than a placeholder such as `EMPTY`.
fn is_key(key: &str) -> bool {
    key.len() >= LONG || (key.len() >= 4 && is_mixed(key))
}

/// Whether a value that need not be one is a secret: it is long, and no number, date or version.
fn is_secret(value: &str) -> bool {
    let digits = value.strip_prefix('v').unwrap_or(value);
    let plain = |c: char| c.is_ascii_digit() || "+-.,:/_".contains(c);
    let number = value.len() < 2 * LONG && digits.chars().all(plain);
    value.len() >= LONG && !number
}

/// Whether letters and digits are mixed.
fn is_mixed(text: &str) -> bool {
    text.contains(|c: char| c.is_ascii_digit()) && text.contains(char::is_alphabetic)
}

#[cfg(test)]
#[path = "collect_tests.rs"]
mod tests;
