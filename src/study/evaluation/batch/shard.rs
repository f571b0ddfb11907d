//! Shards of the scenarios for several machines: each scenario belongs to one, by its name alone.

use sha2::{Digest, Sha256};

/// The part of the scenarios that one machine works on: its number from 1, and how many there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    number: u32,
    of: u32,
}

impl Shard {
    /// Whether a scenario belongs to this part. It depends on the scenario's name alone, so that every machine comes to
    /// the same, whatever lies where.
    #[must_use]
    pub fn has(&self, scenario: &str) -> bool {
        spread(scenario) % u64::from(self.of) == u64::from(self.number - 1)
    }

    /// The whole, as one part.
    #[must_use]
    pub fn whole() -> Self {
        Self { number: 1, of: 1 }
    }

    /// The part in names of files and folders: `2-of-8`.
    #[must_use]
    pub fn file_word(&self) -> String {
        format!("{}-of-{}", self.number, self.of)
    }
}

/// The first eight bytes of the SHA-256 of a name as a number: the same on every machine.
pub(super) fn spread(name: &str) -> u64 {
    let digest = Sha256::digest(name.as_bytes());
    let first = digest.iter().take(8);
    first.fold(0, |hash, byte| hash << 8 | u64::from(*byte))
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text
            .split_once('/')
            .and_then(|(n, of)| Some((n.parse().ok()?, of.parse().ok()?)));
        match parts {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => Err("expected a part I/N, from 1/N to N/N, such as 2/8".into()),
        }
    }
}
