//! The secrets sent to an endpoint, and their redaction from its responses.
//!
//! Some servers echo what they were sent: in errors, in answers, as a model's name. So every text of a server passes
//! through [`Secrets`] before anything else of the program sees it. A secret is found verbatim and in the forms it may
//! take on the way: percent-encoded, with JSON or HTML escapes (of all or some letters, also escaped again), in base64
//! (also as part of a longer text, such as `Bearer …`), in hexadecimal, in other case.

mod collect;
mod escapes;
mod finder;
mod forms;
mod redactor;

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use secrecy::{ExposeSecret, SecretString};

pub(super) use collect::is_loopback;
use finder::Finder;
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
    fn of(secrets: &[String]) -> Self {
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
        let plain: Vec<Vec<u8>> = secrets.iter().flat_map(|s| forms::plain(s)).collect();
        let coded: Vec<Vec<u8>> = secrets.iter().flat_map(|s| forms::base64(s)).collect();
        let plain = Finder::new(plain.iter().map(Vec::as_slice), |b| b.to_ascii_lowercase());
        let coded = Finder::new(coded.iter().map(Vec::as_slice), forms::same_alphabet);
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

#[cfg(test)]
mod tests;
