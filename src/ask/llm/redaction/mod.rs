//! The secrets sent to an endpoint, what counts as one, its encoded forms, and their redaction from responses.
//!
//! Some servers echo what they were sent: in errors, in answers, as a model's name. So every text of a server passes
//! through [`Secrets`] before anything else of the program sees it. A secret is found verbatim and in the forms it may
//! take on the way: percent-encoded, with JSON or HTML escapes (of all or some letters, also escaped again), in base64
//! (also as part of a longer text, such as `Bearer …`), in hexadecimal, in other case.

mod escapes;
pub(super) mod redactor;

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use base64::Engine;
use base64::engine::general_purpose::{STANDARD, STANDARD_NO_PAD};
use reqwest::Url;
use secrecy::{ExposeSecret, SecretString};

use super::client::Client;
use super::endpoint::Endpoint;
use super::error::Error;
use escapes::taken_back;
use redactor::{Finder, LAYERS};

pub(super) use redactor::Redactor;

/// The secrets of an endpoint. It prints none of them.
#[derive(Clone, Default)]
pub struct Secrets {
    search: Option<Arc<Search>>,
}

/// Every secret since the program began.
static MET: Mutex<Vec<SecretString>> = Mutex::new(Vec::new());

fn remember(secrets: &[String]) {
    let mut met = MET.lock().unwrap_or_else(PoisonError::into_inner);
    for secret in secrets {
        if !met.iter().any(|known| known.expose_secret() == secret) {
            met.push(SecretString::from(secret.as_str()));
        }
    }
}

/// The patterns to find.
struct Search {
    /// The secrets themselves, in any case.
    plain: Finder,
    /// The fixed parts of their base64, in either alphabet.
    coded: Finder,
    /// Whether a secret or an escape can begin with a byte.
    begins: [bool; 256],
}

impl Secrets {
    /// These secrets, and no others.
    fn new(secrets: &[String]) -> Self {
        if secrets.is_empty() {
            return Self::default();
        }
        remember(secrets);
        Self::looking_for(secrets)
    }

    /// Everything that was a secret of some endpoint since the program began, and these: for a report on a failure,
    /// which belongs to no endpoint.
    pub(super) fn all_and(mut secrets: Vec<String>) -> Self {
        // A report is written while anything may hold the lock.
        if let Ok(met) = MET.try_lock() {
            secrets.extend(met.iter().map(|secret| secret.expose_secret().to_string()));
        }
        Self::looking_for(&secrets)
    }

    fn looking_for(secrets: &[String]) -> Self {
        if secrets.is_empty() {
            return Self::default();
        }
        let plain: Vec<Vec<u8>> = secrets.iter().flat_map(|s| plain(s)).collect();
        let coded: Vec<Vec<u8>> = secrets.iter().flat_map(|s| base64(s)).collect();
        let plain = Finder::new(plain.iter().map(Vec::as_slice), |b| b.to_ascii_lowercase());
        let coded = Finder::new(coded.iter().map(Vec::as_slice), same_alphabet);
        let begins = std::array::from_fn(|byte| {
            let byte = u8::try_from(byte).unwrap_or_default();
            plain.begins(byte) || coded.begins(byte) || escapes::begins(byte)
        });
        Self {
            search: Some(Arc::new(Search {
                plain,
                coded,
                begins,
            })),
        }
    }

    /// A whole text without the secrets, each of which becomes `[key]`.
    #[must_use]
    pub fn redact(&self, text: &str) -> String {
        let mut redactor = Redactor::new(self);
        redactor.push(text) + &redactor.end()
    }

    /// The same for a text that may have been cut anywhere: the larger part of a secret at its end goes, too.
    #[must_use]
    pub fn redact_cut(&self, text: &str) -> String {
        let mut redactor = Redactor::new(self);
        redactor.push(text) + &redactor.cut()
    }

    /// Whether a text holds a secret.
    #[must_use]
    pub fn are_in(&self, text: &str) -> bool {
        self.search.is_some() && self.redact(text) != text
    }
}

impl fmt::Debug for Secrets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secrets")
    }
}

/// Shortest value, in characters, from a secret source that counts as a secret.
const MIN_SECRET_LENGTH: usize = 8;

/// Parameters of addresses that are no secrets.
const HARMLESS_PARAMETERS: [&str; 4] = ["api-version", "api_version", "version", "alt"];

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
        Secrets::new(&found)
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
        if is_secret(part) && (is_mixed(part) || part.len() >= 2 * MIN_SECRET_LENGTH) {
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
        if is_secret(&value) && !HARMLESS_PARAMETERS.contains(&name.to_ascii_lowercase().as_str()) {
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
    key.len() >= MIN_SECRET_LENGTH || (key.len() >= 4 && is_mixed(key))
}

/// Whether a value that need not be one is a secret: it is long, and no number, date or version.
fn is_secret(value: &str) -> bool {
    let digits = value.strip_prefix('v').unwrap_or(value);
    let plain = |c: char| c.is_ascii_digit() || "+-.,:/_".contains(c);
    let number = value.len() < 2 * MIN_SECRET_LENGTH && digits.chars().all(plain);
    value.len() >= MIN_SECRET_LENGTH && !number
}

/// Whether letters and digits are mixed.
fn is_mixed(text: &str) -> bool {
    text.contains(|c: char| c.is_ascii_digit()) && text.contains(char::is_alphabetic)
}

/// Shortest secret, in bytes, searched in base64 and hexadecimal; shorter ones would match by chance.
const CODED_FROM: usize = 8;

/// A secret as it is written, also with the escapes that it seems to hold itself taken back, and in hexadecimal.
fn plain(secret: &str) -> Vec<Vec<u8>> {
    let mut forms = vec![secret.as_bytes().to_vec()];
    // In forms a space is a plus sign.
    if secret.contains(' ') {
        forms.push(secret.replace(' ', "+").into_bytes());
    }
    // In a text with escapes `a%41b` is read as `aAb`, whether that was meant or not.
    const KINDS: &[u8] = b"%\\&";
    let mut layer = secret.as_bytes().to_vec();
    let mut meant: Vec<Vec<u8>> = Vec::new();
    for _ in 0..LAYERS {
        meant.extend((1..1 << KINDS.len()).map(|chosen| {
            let kinds = KINDS
                .iter()
                .enumerate()
                .filter(|(at, _)| (chosen >> at) & 1 == 1);
            taken_back(&layer, &kinds.map(|(_, kind)| *kind).collect::<Vec<u8>>())
        }));
        layer = taken_back(&layer, KINDS);
    }
    meant.sort();
    meant.dedup();
    forms.extend(
        meant
            .into_iter()
            .filter(|m| m.len() >= 4 && m != secret.as_bytes()),
    );
    if secret.len() >= CODED_FROM {
        let hex = secret.bytes().map(|byte| format!("{byte:02x}"));
        forms.push(hex.collect::<String>().into_bytes());
    }
    forms
}

/// The fixed part of the base64 of any text with the secret, which may begin at each of three places of a group.
fn base64(secret: &str) -> Vec<Vec<u8>> {
    if secret.len() < CODED_FROM {
        return Vec::new();
    }
    let at = |before: usize| {
        let text = [&vec![0; before], secret.as_bytes()].concat();
        let whole = STANDARD_NO_PAD.encode(&text).into_bytes();
        // Each letter stands for six bits: those that hold bits of neighbours, too, can be any.
        let (first, end) = ((before * 8).div_ceil(6), text.len() * 8 / 6);
        whole[first..end].to_vec()
    };
    (0..3).map(at).collect()
}

/// The URL-safe alphabet differs from the standard one in two letters.
fn same_alphabet(byte: u8) -> u8 {
    match byte {
        b'-' => b'+',
        b'_' => b'/',
        other => other,
    }
}

#[cfg(test)]
mod tests;
