//! Content identity: the SHA-256 hash of a file's bytes.

use std::fmt;

use sha2::{Digest, Sha256};

/// The SHA-256 of some contents; prints as 64 hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ContentHash([u8; 32]);

impl ContentHash {
    /// The hash of `bytes`.
    #[must_use]
    pub fn digest(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    /// Its bytes.
    #[must_use]
    pub fn bytes(&self) -> [u8; 32] {
        self.0
    }

    /// The hash of parts one after the other.
    #[must_use]
    pub fn of_parts<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> Self {
        let mut hasher = Sha256::new();
        parts.into_iter().for_each(|part| hasher.update(part));
        Self(hasher.finalize().into())
    }
}

/// Contents that many begin with: hashed once, and gone on from.
#[derive(Clone)]
pub struct HashedBeginning(Sha256);

impl HashedBeginning {
    /// What they begin with.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        let mut hasher = Sha256::new();
        hasher.update(bytes);
        Self(hasher)
    }

    /// The hash of the beginning with these parts after it.
    #[must_use]
    pub fn with<'a>(&self, parts: impl IntoIterator<Item = &'a [u8]>) -> ContentHash {
        let mut hasher = self.0.clone();
        parts.into_iter().for_each(|part| hasher.update(part));
        ContentHash(hasher.finalize().into())
    }
}

impl fmt::Display for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prints_the_known_hash_of_nothing() {
        let text = ContentHash::digest(b"").to_string();
        assert!(text.starts_with("e3b0c44298fc1c14") && text.len() == 64);
    }

    #[test]
    fn parts_have_the_hash_of_the_whole() {
        let parts: [&[u8]; 3] = [b"ma", b"", b"p"];
        assert_eq!(ContentHash::of_parts(parts), ContentHash::digest(b"map"));
        let beginning = HashedBeginning::of(b"ma");
        let [_, rest @ ..] = parts;
        assert_eq!(beginning.with(rest), ContentHash::digest(b"map"));
        assert_eq!(beginning.with([]), ContentHash::digest(b"ma"));
    }
}
